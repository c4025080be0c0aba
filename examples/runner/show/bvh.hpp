// SPDX-License-Identifier: Apache-2.0
// Rays against the triangles and balls of a frame: a tree of boxes, split where the surface area heuristic
// says (Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies", binned), four to a node and four triangles
// to a leaf, so that a processor takes four at a time (Dammertz, Hanika & Keller 2008, "Shallow Bounding Volume Hierarchies").
#pragma once

#include <array>
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

  bool is_ball(std::uint32_t primitive) const { return primitive >= all_triangles_; }
  bool is_solid(std::uint32_t primitive) const;
  const Ball& ball(std::uint32_t primitive) const { return shapes_.balls[primitive - all_triangles_]; }
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
  static constexpr int lanes = 4;
  /// Four numbers that a processor takes at once; an extension of GCC and Clang.
  using Lane = float __attribute__((vector_size(4 * sizeof(float))));
  struct Bounds {
    meltsim::Vec3f low{1e30f, 1e30f, 1e30f}, high{-1e30f, -1e30f, -1e30f};
    void add(const meltsim::Vec3f& x);
    void add(const Bounds& other);
    float area() const;  ///< half of it
  };
  /// Up to four primitives: triangles, or balls.
  struct Leaf {
    std::array<Lane, 3> a{}, ab{},
        ac{};  ///< of triangles: a corner, and what leads from it to the others, by axis
    std::array<std::uint32_t, lanes> primitive{};
    std::uint32_t count = 0;
    bool balls = false;
  };
  /// Up to four boxes, by axis. A box that is not there has its lower side above its upper one, so that nothing meets it.
  struct Node {
    std::array<Lane, 3> low, high;
    std::array<std::uint32_t, lanes> child{};  ///< a node, or a leaf and leaf_bit
    std::array<std::uint8_t, lanes> holds{};   ///< has_solid, has_liquid
  };
  /// A ray as boxes want it.
  struct Slabs;
  struct Builder;

  template <class Visit>
  void walk(const Ray& ray, Seen seen, Visit visit) const;
  bool meets(const Ray& ray, Seen seen, const Leaf& leaf, Hit& hit) const;
  bool meets_ball(const Ray& ray, std::uint32_t primitive, Hit& hit) const;
  bool shows(Seen seen, std::uint32_t primitive) const {
    return seen == Seen::all || is_solid(primitive) == (seen == Seen::solid);
  }

  const FrameShapes& shapes_;
  std::size_t solid_triangles_;   ///< they come first
  std::size_t tank_triangles_;    ///< those and the tank's
  std::size_t opaque_triangles_;  ///< those and the ones of paint
  std::size_t all_triangles_;     ///< those and the liquid's; balls follow
  std::vector<Leaf> leaves_;
  std::vector<Node> nodes_;  ///< the first is the root; none where there is nothing
};

}  // namespace runner
