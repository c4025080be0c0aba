// SPDX-License-Identifier: Apache-2.0
#include "show/bvh.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace runner {

namespace {

using meltsim::Vec3f;

constexpr int bins = 12;
constexpr std::uint32_t leaf_bit = 0x80000000u;
constexpr std::uint8_t has_solid = 1, has_liquid = 2;

float axis_of(const Vec3f& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
Vec3f lower(const Vec3f& a, const Vec3f& b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
Vec3f upper(const Vec3f& a, const Vec3f& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

}  // namespace

void Bvh::Bounds::add(const Vec3f& x) {
  low = lower(low, x);
  high = upper(high, x);
}

void Bvh::Bounds::add(const Bounds& other) {
  low = lower(low, other.low);
  high = upper(high, other.high);
}

float Bvh::Bounds::area() const {
  const Vec3f d = high - low;
  return d.x < 0 ? 0 : d.x * d.y + d.y * d.z + d.z * d.x;
}

/// The tree as it is built: binary, from the root down, then four grandchildren to a node.
struct Bvh::Builder {
  struct Branch {
    std::uint32_t first = 0, count = 0;  ///< of order
    std::uint32_t left = 0, right = 0;   ///< branches; 0 where it is a leaf
    Bounds box;
    std::uint8_t holds = 0;
  };

  Bvh& bvh;
  std::vector<Bounds> bounds;  ///< of primitives
  std::vector<std::uint32_t> order;
  std::vector<Branch> branches;

  void add(const Mesh& mesh) {
    for (std::size_t i = 0; i + 2 < mesh.triangles.size(); i += 3) {
      bounds.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) bounds.back().add(mesh.position[mesh.triangles[i + k]]);
    }
  }

  void add(const Ball& ball) {
    const Vec3f r{ball.radius, ball.radius, ball.radius};
    bounds.emplace_back();
    bounds.back().add(ball.center - r);
    bounds.back().add(ball.center + r);
  }

  void build() {
    for (std::uint32_t i = 0; i < bounds.size(); ++i) order.push_back(i);
    if (order.empty()) return;
    branches.reserve(bounds.size());
    branches.push_back({0, static_cast<std::uint32_t>(order.size()), 0, 0, {}, 0});
    for (std::uint32_t b = 0; b < branches.size(); ++b) split(b);
    for (auto b = branches.rbegin(); b != branches.rend(); ++b) b->holds = contents(*b);
    gather(0);
  }

  std::uint8_t contents(const Branch& b) const {
    if (b.left != 0) return branches[b.left].holds | branches[b.right].holds;
    std::uint8_t holds = 0;
    for (std::uint32_t i = b.first; i < b.first + b.count; ++i)
      holds |= bvh.is_solid(order[i]) ? has_solid : has_liquid;
    return holds;
  }

  /// Whether one leaf takes them: four of a kind at most.
  bool is_leaf(const Branch& b) const {
    if (b.count > lanes) return false;
    for (std::uint32_t i = b.first; i < b.first + b.count; ++i)
      if (bvh.is_ball(order[i]) != bvh.is_ball(order[b.first])) return false;
    return true;
  }

  void split(std::uint32_t index) {
    const std::uint32_t first = branches[index].first, count = branches[index].count;
    Bounds whole, centers;
    for (std::uint32_t i = first; i < first + count; ++i) {
      const Bounds& b = bounds[order[i]];
      whole.add(b);
      centers.add((b.low + b.high) * 0.5f);
    }
    branches[index].box = whole;
    if (is_leaf(branches[index])) return;
    const std::uint32_t middle = first + cut(first, count, centers);
    const auto left = static_cast<std::uint32_t>(branches.size());
    branches.push_back({first, middle - first, 0, 0, {}, 0});
    branches.push_back({middle, first + count - middle, 0, 0, {}, 0});
    branches[index].left = left;
    branches[index].right = left + 1;
  }

  /// Orders `count` primitives from `first` on into two parts, neither empty; returns the size of the first.
  std::uint32_t cut(std::uint32_t first, std::uint32_t count, const Bounds& centers) {
    const auto begin = order.begin() + first;
    const Vec3f size = centers.high - centers.low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const float extent = axis_of(size, axis), start = axis_of(centers.low, axis);
    if (!(extent > 0) || count <= lanes) {  // few are of two kinds
      std::stable_partition(begin, begin + count, [&](std::uint32_t p) { return !bvh.is_ball(p); });
      std::uint32_t triangles = 0;
      while (triangles < count && !bvh.is_ball(order[first + triangles])) ++triangles;
      return triangles == 0 || triangles == count ? count / 2 : triangles;
    }
    const auto bin = [&](std::uint32_t primitive) {
      const Bounds& b = bounds[primitive];
      const float center = 0.5f * (axis_of(b.low, axis) + axis_of(b.high, axis));
      return std::min(bins - 1, static_cast<int>(static_cast<float>(bins) * (center - start) / extent));
    };
    const int best = best_bin(first, count, bin);
    const auto left = static_cast<std::uint32_t>(
        std::partition(begin, begin + count, [&](std::uint32_t p) { return bin(p) < best; }) - begin);
    // The first and the last bin are never empty, but rounding may say otherwise.
    return left == 0 || left == count ? count / 2 : left;
  }

  /// The bin before which cutting costs least.
  template <class Bin>
  int best_bin(std::uint32_t first, std::uint32_t count, const Bin& bin) const {
    std::array<Bounds, bins> box;
    std::array<std::uint32_t, bins> inside{};
    for (std::uint32_t i = first; i < first + count; ++i) {
      const auto b = static_cast<std::size_t>(bin(order[i]));
      box[b].add(bounds[order[i]]);
      ++inside[b];
    }
    int best = 0;
    float least = 1e38f;
    for (int at = 1; at < bins; ++at) {
      Bounds left, right;
      std::uint32_t n_left = 0, n_right = 0;
      for (int b = 0; b < bins; ++b) {
        const auto k = static_cast<std::size_t>(b);
        (b < at ? left : right).add(box[k]);
        (b < at ? n_left : n_right) += inside[k];
      }
      const float cost =
          left.area() * static_cast<float>(n_left) + right.area() * static_cast<float>(n_right);
      if (n_left > 0 && n_right > 0 && cost < least) {
        least = cost;
        best = at;
      }
    }
    return best;
  }

  /// A node of the branches that `root` comes apart into: the largest is opened first. Returns its index.
  std::uint32_t gather(std::uint32_t root) {
    std::array<std::uint32_t, lanes> parts{root};
    std::size_t count = 1;
    const auto area = [&](std::uint32_t b) { return branches[b].left == 0 ? -1.0f : branches[b].box.area(); };
    while (count < lanes) {
      std::size_t largest = 0;
      for (std::size_t i = 1; i < count; ++i)
        if (area(parts[i]) > area(parts[largest])) largest = i;
      const Branch& opened = branches[parts[largest]];
      if (opened.left == 0) break;
      parts[count++] = opened.right;
      parts[largest] = opened.left;
    }
    const auto index = static_cast<std::uint32_t>(bvh.nodes_.size());
    Node node;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      node.low[axis] = Lane{} + 1e30f;
      node.high[axis] = Lane{} - 1e30f;
    }
    bvh.nodes_.push_back(node);
    for (std::size_t i = 0; i < count; ++i) {
      const Branch& part = branches[parts[i]];
      node.low[0][i] = part.box.low.x, node.low[1][i] = part.box.low.y, node.low[2][i] = part.box.low.z;
      node.high[0][i] = part.box.high.x, node.high[1][i] = part.box.high.y, node.high[2][i] = part.box.high.z;
      node.holds[i] = part.holds;
      node.child[i] = part.left == 0 ? leaf(part) : gather(parts[i]);
    }
    bvh.nodes_[index] = node;
    return index;
  }

  std::uint32_t leaf(const Branch& part) {
    Leaf leaf;
    leaf.count = part.count;
    leaf.balls = bvh.is_ball(order[part.first]);
    for (std::uint32_t i = 0; i < part.count; ++i) {
      const std::uint32_t primitive = order[part.first + i];
      leaf.primitive[i] = primitive;
      if (leaf.balls) continue;
      const Mesh& mesh = bvh.mesh(primitive);
      const std::uint32_t* corner = &mesh.triangles[bvh.triangle(primitive)];
      const Vec3f a = mesh.position[corner[0]], ab = mesh.position[corner[1]] - a,
                  ac = mesh.position[corner[2]] - a;
      leaf.a[0][i] = a.x, leaf.a[1][i] = a.y, leaf.a[2][i] = a.z;
      leaf.ab[0][i] = ab.x, leaf.ab[1][i] = ab.y, leaf.ab[2][i] = ab.z;
      leaf.ac[0][i] = ac.x, leaf.ac[1][i] = ac.y, leaf.ac[2][i] = ac.z;
    }
    bvh.leaves_.push_back(leaf);
    return static_cast<std::uint32_t>(bvh.leaves_.size() - 1) | leaf_bit;
  }
};

Bvh::Bvh(const FrameShapes& shapes)
    : shapes_(shapes),
      solid_triangles_(shapes.solid.triangles.size() / 3),
      tank_triangles_(solid_triangles_ + shapes.tank.triangles.size() / 3),
      opaque_triangles_(tank_triangles_ + shapes.paint.triangles.size() / 3),
      all_triangles_(opaque_triangles_ + shapes.liquid.triangles.size() / 3) {
  Builder builder{*this, {}, {}, {}};
  for (const Mesh* mesh : {&shapes.solid, &shapes.tank, &shapes.paint, &shapes.liquid}) builder.add(*mesh);
  for (const Ball& ball : shapes.balls) builder.add(ball);
  builder.build();
}

bool Bvh::is_solid(std::uint32_t primitive) const {
  return is_ball(primitive) ? ball(primitive).solid : primitive < opaque_triangles_;
}

std::size_t Bvh::triangle(std::uint32_t primitive) const {
  const std::size_t before = primitive < solid_triangles_    ? 0
                             : primitive < tank_triangles_   ? solid_triangles_
                             : primitive < opaque_triangles_ ? tank_triangles_
                                                             : opaque_triangles_;
  return 3 * (primitive - before);
}

bool Bvh::meets_ball(const Ray& ray, std::uint32_t primitive, Hit& hit) const {
  const Ball& b = ball(primitive);
  const Vec3f to = b.center - ray.from;
  const float along = dot(to, ray.along);
  const Vec3f off = to - ray.along * along;  // stays exact far away, where |to|^2 - along^2 would not
  const float inside = b.radius * b.radius - dot(off, off);
  if (inside < 0) return false;
  const float half = std::sqrt(inside);
  const float t = along - half > ray.least ? along - half : along + half;
  if (t <= ray.least || t >= std::min(ray.most, hit.distance)) return false;
  hit.distance = t;
  hit.primitive = primitive;
  return true;
}

bool Bvh::meets(const Ray& ray, Seen seen, const Leaf& leaf, Hit& hit) const {
  bool met = false;
  if (leaf.balls) {
    for (std::uint32_t i = 0; i < leaf.count; ++i)
      if (shows(seen, leaf.primitive[i])) met = meets_ball(ray, leaf.primitive[i], hit) || met;
    return met;
  }
  // Moeller & Trumbore 1997, four triangles at a time.
  using Vec = std::array<Lane, 3>;
  const auto cross = [](const Vec& a, const Vec& b) {
    return Vec{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const auto dot = [](const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  const auto all = [](const Vec3f& x) { return Vec{Lane{} + x.x, Lane{} + x.y, Lane{} + x.z}; };
  const float most = std::min(ray.most, hit.distance);
  const Vec d = all(ray.along), from = all(ray.from);
  const Vec s{from[0] - leaf.a[0], from[1] - leaf.a[1], from[2] - leaf.a[2]};
  const Vec p = cross(d, leaf.ac), q = cross(s, leaf.ab);
  const Lane inverse = 1 / dot(leaf.ab, p);
  const Lane u = dot(s, p) * inverse, v = dot(d, q) * inverse, t = dot(leaf.ac, q) * inverse;
  // Not met where the triangle is seen from its side: comparisons with what is no number are false.
  const auto within = (u >= 0) & (u <= 1) & (v >= 0) & (u + v <= 1) & (t > ray.least) & (t < most);
  const Lane distance = within ? t : Lane{} + 1e30f;
  for (std::uint32_t i = 0; i < leaf.count; ++i) {
    if (distance[i] >= std::min(most, hit.distance) || !shows(seen, leaf.primitive[i])) continue;
    hit = {distance[i], leaf.primitive[i], u[i], v[i]};
    met = true;
  }
  return met;
}

struct Bvh::Slabs {
  explicit Slabs(const Ray& r) : ray(r) {
    // A ray along a side of a box: a number that is nearly none keeps 0 times infinity out.
    const auto over = [](float x) { return 1 / (std::abs(x) < 1e-20f ? std::copysign(1e-20f, x) : x); };
    inverse = {over(ray.along.x), over(ray.along.y), over(ray.along.z)};
  }

  /// How far it is into each box; `missed` where the ray does not meet it before `most`.
  Lane enter(const Node& node, float most) const {
    const auto larger = [](const Lane& a, const Lane& b) { return a > b ? a : b; };
    const auto less = [](const Lane& a, const Lane& b) { return a < b ? a : b; };
    Lane in = Lane{} + ray.least, out = Lane{} + most;
    const auto cut = [&](std::size_t axis, float from, float by) {
      in = larger(in, ((by < 0 ? node.high : node.low)[axis] - from) * by);
      out = less(out, ((by < 0 ? node.low : node.high)[axis] - from) * by);
    };
    cut(0, ray.from.x, inverse.x);
    cut(1, ray.from.y, inverse.y);
    cut(2, ray.from.z, inverse.z);
    return out >= in ? in : Lane{} + missed;
  }

  static constexpr float missed = 2e30f;  ///< farther than any ray goes
  Ray ray;
  Vec3f inverse;
};

/// Visits the leaves in boxes that the ray meets, nearer boxes first; `visit` returns how far it is worth to look.
template <class Visit>
void Bvh::walk(const Ray& ray, Seen seen, Visit visit) const {
  if (nodes_.empty()) return;
  struct Wait {
    std::uint32_t child;
    float distance;
  };
  const Slabs slabs(ray);
  const std::uint8_t wanted = seen == Seen::all     ? has_solid | has_liquid
                              : seen == Seen::solid ? has_solid
                                                    : has_liquid;
  float most = ray.most;
  std::array<Wait, 256> stack;
  std::size_t depth = 0;
  stack[depth++] = {0, 0};
  while (depth > 0) {
    const Wait next = stack[--depth];
    if (next.distance >= most) continue;
    if ((next.child & leaf_bit) != 0) {
      most = visit(leaves_[next.child & ~leaf_bit], most);
      continue;
    }
    const Node& node = nodes_[next.child];
    const Lane in = slabs.enter(node, most);
    const std::size_t bottom = depth;
    for (std::size_t i = 0; i < lanes; ++i) {
      if (in[i] == Slabs::missed || (node.holds[i] & wanted) == 0 || depth == stack.size()) continue;
      std::size_t at = depth++;
      for (; at > bottom && stack[at - 1].distance < in[i]; --at) stack[at] = stack[at - 1];
      stack[at] = {node.child[i], in[i]};
    }
  }
}

Hit Bvh::nearest(const Ray& ray, Seen seen) const {
  Hit hit;
  walk(ray, seen,
       [&](const Leaf& leaf, float most) { return meets(ray, seen, leaf, hit) ? hit.distance : most; });
  return hit;
}

bool Bvh::blocked(const Ray& ray, Seen seen) const {
  Hit hit;
  walk(ray, seen, [&](const Leaf& leaf, float most) { return meets(ray, seen, leaf, hit) ? -1.0f : most; });
  return hit.any();
}

}  // namespace runner
