// SPDX-License-Identifier: Apache-2.0
// Rays against the triangles and balls of a frame: a tree of boxes, split where the surface area heuristic
// says (Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies", binned).
#pragma once

#include <cstdint>
#include <vector>

#include "show/shapes.hpp"

namespace runner {

struct Ray {
  meltsim::Vec3f from, along;  ///< `along` has length 1
  float least = 0, most = 1e30f;
};

struct Hit {
  float distance = 1e30f;
  std::uint32_t primitive = 0xffffffffu;  ///< triangles first, then balls
  float u = 0, v = 0;                     ///< of a triangle
  bool any() const { return primitive != 0xffffffffu; }
};

/// What rays are asked to see; paint and the tank count as solid, as light does not pass them.
enum class Seen { all, liquid, solid };

class Bvh {
 public:
  explicit Bvh(const FrameShapes& shapes);

  Hit nearest(const Ray& ray, Seen seen = Seen::all) const;
  /// Whether anything of `seen` stands between the ray's ends.
  bool blocked(const Ray& ray, Seen seen) const;

  bool is_ball(std::uint32_t primitive) const { return primitive >= triangles_.size(); }
  bool is_solid(std::uint32_t primitive) const;
  const Ball& ball(std::uint32_t primitive) const { return shapes_.balls[primitive - triangles_.size()]; }
  const Mesh& mesh(std::uint32_t primitive) const {
    return primitive < solid_triangles_    ? shapes_.solid
           : primitive < tank_triangles_   ? shapes_.tank
           : primitive < opaque_triangles_ ? shapes_.paint
                                           : shapes_.liquid;
  }
  bool is_tank(std::uint32_t primitive) const {
    return primitive >= solid_triangles_ && primitive < tank_triangles_;
  }
  bool is_paint(std::uint32_t primitive) const {
    return primitive >= tank_triangles_ && primitive < opaque_triangles_;
  }
  /// First of the triangle's three entries in mesh().triangles.
  std::size_t triangle(std::uint32_t primitive) const;

 private:
  struct Node {
    meltsim::Vec3f low, high;
    std::uint32_t first;  ///< of its primitives in order_; of its two children when count is 0
    std::uint32_t count;
  };
  struct Triangle {
    meltsim::Vec3f a, ab, ac;
  };
  struct Bounds {
    meltsim::Vec3f low{1e30f, 1e30f, 1e30f}, high{-1e30f, -1e30f, -1e30f};
    void add(const meltsim::Vec3f& x);
    void add(const Bounds& other);
    float area() const;  ///< half of it
  };

  template <class Visit>
  void walk(const Ray& ray, Visit visit) const;
  bool meets(const Ray& ray, std::uint32_t primitive, Hit& hit) const;
  void split(std::uint32_t node, const std::vector<Bounds>& bounds);

  const FrameShapes& shapes_;
  std::size_t solid_triangles_;      ///< they come first
  std::size_t tank_triangles_;       ///< those and the tank's
  std::size_t opaque_triangles_;     ///< those and the ones of paint
  std::vector<Triangle> triangles_;  ///< solid, tank, paint, liquid
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace runner
