// SPDX-License-Identifier: Apache-2.0
#include "show/bvh.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace runner {

namespace {

using meltsim::Vec3f;

constexpr int bins = 12;
constexpr std::uint32_t leaf = 4;  ///< primitives that are not worth splitting

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

Bvh::Bvh(const FrameShapes& shapes)
    : shapes_(shapes),
      solid_triangles_(shapes.solid.triangles.size() / 3),
      tank_triangles_(solid_triangles_ + shapes.tank.triangles.size() / 3),
      opaque_triangles_(tank_triangles_ + shapes.paint.triangles.size() / 3) {
  std::vector<Bounds> bounds;
  for (const Mesh* mesh : {&shapes.solid, &shapes.tank, &shapes.paint, &shapes.liquid}) {
    for (std::size_t i = 0; i + 2 < mesh->triangles.size(); i += 3) {
      const Vec3f a = mesh->position[mesh->triangles[i]], b = mesh->position[mesh->triangles[i + 1]],
                  c = mesh->position[mesh->triangles[i + 2]];
      triangles_.push_back({a, b - a, c - a});
      bounds.emplace_back();
      for (const Vec3f& x : {a, b, c}) bounds.back().add(x);
    }
  }
  for (const Ball& ball : shapes.balls) {
    const Vec3f r{ball.radius, ball.radius, ball.radius};
    bounds.emplace_back();
    bounds.back().add(ball.center - r);
    bounds.back().add(ball.center + r);
  }
  for (std::uint32_t i = 0; i < bounds.size(); ++i) order_.push_back(i);
  nodes_.reserve(2 * bounds.size() + 1);
  nodes_.push_back({{}, {}, 0, static_cast<std::uint32_t>(bounds.size())});
  for (std::uint32_t node = 0; node < nodes_.size(); ++node) split(node, bounds);
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

void Bvh::split(std::uint32_t index, const std::vector<Bounds>& bounds) {
  const std::uint32_t first = nodes_[index].first, count = nodes_[index].count;
  Bounds whole, centers;
  for (std::uint32_t i = first; i < first + count; ++i) {
    const Bounds& b = bounds[order_[i]];
    whole.add(b);
    centers.add((b.low + b.high) * 0.5f);
  }
  nodes_[index].low = whole.low;
  nodes_[index].high = whole.high;
  if (count <= leaf) return;
  const Vec3f size = centers.high - centers.low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const float extent = axis_of(size, axis), start = axis_of(centers.low, axis);
  const auto bin = [&](std::uint32_t primitive) {
    const Bounds& b = bounds[primitive];
    const float center = 0.5f * (axis_of(b.low, axis) + axis_of(b.high, axis));
    return std::min(bins - 1, static_cast<int>(static_cast<float>(bins) * (center - start) / extent));
  };
  std::uint32_t middle = first + count / 2;
  if (extent > 0) {
    std::array<Bounds, bins> box;
    std::array<std::uint32_t, bins> inside{};
    for (std::uint32_t i = first; i < first + count; ++i) {
      const auto b = static_cast<std::size_t>(bin(order_[i]));
      box[b].add(bounds[order_[i]]);
      ++inside[b];
    }
    int best = 0;
    float least = 1e38f;
    for (int cut = 1; cut < bins; ++cut) {
      Bounds left, right;
      std::uint32_t n_left = 0, n_right = 0;
      for (int b = 0; b < bins; ++b) {
        const auto k = static_cast<std::size_t>(b);
        (b < cut ? left : right).add(box[k]);
        (b < cut ? n_left : n_right) += inside[k];
      }
      const float cost =
          left.area() * static_cast<float>(n_left) + right.area() * static_cast<float>(n_right);
      if (n_left > 0 && n_right > 0 && cost < least) {
        least = cost;
        best = cut;
      }
    }
    const auto begin = order_.begin() + first;
    middle =
        first +
        static_cast<std::uint32_t>(
            std::partition(begin, begin + count, [&](std::uint32_t p) { return bin(p) < best; }) - begin);
    // The first and the last bin are never empty, but rounding may say otherwise.
    if (middle == first || middle == first + count) middle = first + count / 2;
  }
  const auto children = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({{}, {}, first, middle - first});
  nodes_.push_back({{}, {}, middle, first + count - middle});
  nodes_[index].first = children;
  nodes_[index].count = 0;
}

bool Bvh::meets(const Ray& ray, std::uint32_t primitive, Hit& hit) const {
  if (is_ball(primitive)) {
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
  // Moeller & Trumbore 1997.
  const Triangle& tri = triangles_[primitive];
  const Vec3f p = cross(ray.along, tri.ac);
  const float det = dot(tri.ab, p);
  if (det == 0) return false;
  const float inverse = 1 / det;
  const Vec3f s = ray.from - tri.a;
  const float u = dot(s, p) * inverse;
  if (u < 0 || u > 1) return false;
  const Vec3f q = cross(s, tri.ab);
  const float v = dot(ray.along, q) * inverse;
  if (v < 0 || u + v > 1) return false;
  const float t = dot(tri.ac, q) * inverse;
  if (t <= ray.least || t >= std::min(ray.most, hit.distance)) return false;
  hit = {t, primitive, u, v};
  return true;
}

/// Visits primitives in boxes the ray meets, nearer boxes first; `visit` returns how far it is worth to look.
template <class Visit>
void Bvh::walk(const Ray& ray, Visit visit) const {
  if (order_.empty()) return;
  const Vec3f inverse{1 / ray.along.x, 1 / ray.along.y, 1 / ray.along.z};
  float most = ray.most;
  const auto entry = [&](const Node& node) {
    const float ax = (node.low.x - ray.from.x) * inverse.x, bx = (node.high.x - ray.from.x) * inverse.x;
    const float ay = (node.low.y - ray.from.y) * inverse.y, by = (node.high.y - ray.from.y) * inverse.y;
    const float az = (node.low.z - ray.from.z) * inverse.z, bz = (node.high.z - ray.from.z) * inverse.z;
    const float in = std::max({std::min(ax, bx), std::min(ay, by), std::min(az, bz), ray.least});
    const float out = std::min({std::max(ax, bx), std::max(ay, by), std::max(az, bz)});
    return out >= in && in < most ? in : 1e30f;
  };
  std::array<std::uint32_t, 128> stack;
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const Node& node = nodes_[stack[--depth]];
    if (entry(node) >= most) continue;
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) most = visit(order_[i], most);
      continue;
    }
    const float left = entry(nodes_[node.first]), right = entry(nodes_[node.first + 1]);
    const std::uint32_t nearer = node.first + (right < left ? 1u : 0u),
                        farther = node.first + (right < left ? 0u : 1u);
    if (std::max(left, right) < most && depth + 2 < stack.size()) stack[depth++] = farther;
    if (std::min(left, right) < most) stack[depth++] = nearer;
  }
}

Hit Bvh::nearest(const Ray& ray, Seen seen) const {
  Hit hit;
  walk(ray, [&](std::uint32_t primitive, float most) {
    if (seen != Seen::all && is_solid(primitive) != (seen == Seen::solid)) return most;
    return meets(ray, primitive, hit) ? hit.distance : most;
  });
  return hit;
}

bool Bvh::blocked(const Ray& ray, Seen seen) const {
  bool found = false;
  walk(ray, [&](std::uint32_t primitive, float most) {
    Hit hit;
    if (seen != Seen::all && is_solid(primitive) != (seen == Seen::solid)) return most;
    found = found || meets(ray, primitive, hit);
    return found ? -1.0f : most;
  });
  return found;
}

}  // namespace runner
