// SPDX-License-Identifier: Apache-2.0
#include "shape/mesh_shells.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "shape/box_ops.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

bool before(Vec3d a, Vec3d b) {
  if (a.x != b.x) return a.x < b.x;
  if (a.y != b.y) return a.y < b.y;
  return a.z < b.z;
}

/// Per vertex the first one at its place: files repeat vertices where normals or colours jump.
std::vector<std::uint32_t> places_of(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertices.size()), place(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return before(mesh.vertices[a], mesh.vertices[b]); });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && !before(mesh.vertices[order[k - 1]], mesh.vertices[order[k]]);
    place[order[k]] = same ? place[order[k - 1]] : order[k];
  }
  return place;
}

struct Edge {
  std::uint32_t low, high, triangle;
  std::int32_t way;  ///< 1: from low to high, else -1
  bool operator<(const Edge& o) const { return low != o.low ? low < o.low : high < o.high; }
};

std::vector<Edge> edges_of(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> place = places_of(mesh);
  std::vector<Edge> edges;
  edges.reserve(mesh.indices.size());
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const std::size_t next = i % 3 == 2 ? i - 2 : i + 1;
    const std::uint32_t a = place[mesh.indices[i]], b = place[mesh.indices[next]];
    const auto triangle = static_cast<std::uint32_t>(i / 3);
    if (a != b) edges.push_back({std::min(a, b), std::max(a, b), triangle, a < b ? 1 : -1});
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

/// Triangles joined by edges.
class Shells {
 public:
  explicit Shells(std::size_t triangles) : parent_(triangles) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  std::uint32_t of(std::uint32_t t) {
    while (parent_[t] != t) t = parent_[t] = parent_[parent_[t]];
    return t;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t p = of(a), q = of(b);
    parent_[std::max(p, q)] = std::min(p, q);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

struct Shell {
  bool oriented = true;  ///< every edge has as many triangles of either direction
  double volume = 0;     ///< six times it, < 0 where it is inside out
  Box bounds = empty_box();
};

bool holds(const Box& outer, const Box& inner) {
  return outer.min.x <= inner.min.x && outer.min.y <= inner.min.y && outer.min.z <= inner.min.z &&
         outer.max.x >= inner.max.x && outer.max.y >= inner.max.y && outer.max.z >= inner.max.z;
}

void measure(const TriangleMesh& mesh, Shells& shells, std::vector<Shell>& all) {
  const Vec3d origin = mesh.vertices[mesh.indices[0]];  // near the mesh, so that little cancels
  for (std::size_t t = 0; 3 * t < mesh.indices.size(); ++t) {
    Shell& s = all[shells.of(static_cast<std::uint32_t>(t))];
    const Vec3d a = mesh.vertices[mesh.indices[3 * t]] - origin,
                b = mesh.vertices[mesh.indices[3 * t + 1]] - origin,
                c = mesh.vertices[mesh.indices[3 * t + 2]] - origin;
    s.volume += dot(a, cross(b, c));
    for (const Vec3d& p : {a, b, c}) grow(s.bounds, p);
  }
}

/// What the orientation of each shell counts. The largest one says which is outward.
std::vector<std::int8_t> turns_of(const std::vector<Shell>& all) {
  std::vector<std::int8_t> turns(all.size(), 0);
  double largest = 0;
  for (const Shell& s : all)
    if (s.oriented && std::fabs(s.volume) > std::fabs(largest)) largest = s.volume;
  std::vector<const Shell*> outward;
  for (const Shell& s : all)
    if (s.oriented && s.volume * largest > 0) outward.push_back(&s);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Shell& s = all[k];
    if (!s.oriented || s.volume == 0) continue;
    const bool cavity = std::any_of(outward.begin(), outward.end(),
                                    [&](const Shell* o) { return holds(o->bounds, s.bounds); });
    turns[k] = s.volume * largest > 0 || cavity ? 1 : -1;
  }
  return turns;
}

}  // namespace

std::vector<std::int8_t> triangle_turns(const TriangleMesh& mesh) {
  const std::size_t triangles = mesh.indices.size() / 3;
  const std::vector<Edge> edges = edges_of(mesh);
  Shells shells(triangles);
  std::vector<std::uint32_t> unbalanced;
  for (std::size_t from = 0, to = 0; from < edges.size(); from = to) {
    std::int32_t sum = 0;
    for (to = from; to < edges.size() && !(edges[from] < edges[to]); ++to) {
      sum += edges[to].way;
      shells.join(edges[from].triangle, edges[to].triangle);
    }
    if (sum != 0) unbalanced.push_back(edges[from].triangle);
  }
  std::vector<Shell> all(triangles);
  if (triangles > 0) measure(mesh, shells, all);
  for (const std::uint32_t t : unbalanced) all[shells.of(t)].oriented = false;
  const std::vector<std::int8_t> of_shell = turns_of(all);
  std::vector<std::int8_t> turns(triangles);
  for (std::size_t t = 0; t < triangles; ++t) turns[t] = of_shell[shells.of(static_cast<std::uint32_t>(t))];
  return turns;
}

}  // namespace v0
}  // namespace meltsim
