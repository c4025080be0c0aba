// SPDX-License-Identifier: Apache-2.0
// Sums over neighbours, one particle in one thread or in one part of several. A body states once what a pair adds;
// this file and, for a CPU's vectors, lanes.hpp state how pairs are traversed. A body has
//
//   Sum                                 with add(Sum), and Sum::Lanes for a CPU
//   takes_part(i)                       whether particle i has a sum
//   own(i)                              operands of particle i, loaded once
//   stored(own, j)                      operands of a neighbour; Lanes for a CPU: of several
//   other(own, stored)                  these as they enter the sum; without branches
//   add(sum, own, other, pair, along)   what a neighbour adds, without branches; along: what its images add to the
//                                       factor of x_ij, or NoImages
//
// and, where they are needed,
//
//   skips(j)                            neighbours that add nothing
//   settle(own, stored, i, j)           operands that only few neighbours need
//   rare(own, other, pair), add_rare(sum, own, other, i, j, pair)
//                                       terms of few pairs only; rare() has no branches, may_be_rare(other) is
//                                       the part of rare() that does not depend on the distance
//   mirrored(own, other, volume)        what multiplies mirrored_shape(r_m) x_m, summed over the images in own.walls
//   add_normal(sum, force)              what images add along the walls' normals; add() takes the rest
//   add_images(sum, pair, force)        instead of both, if images come after rare terms
//   each_image = true,                  instead of all three, if images add more than a multiple of x_m: what the image
//   add_image(sum, own, other, image, mask)   mirrored in the planes of `mask` adds, image being its pair; without branches
#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

#include "exec/lane_positions.hpp"
#include "meltsim/physics/walls.hpp"
#include "spatial/neighbours.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

using core::lanes;

/// One number per lane; total() adds them up in one order.
template <class T>
struct LaneSum {
  T lane[lanes] = {};
  T at(std::size_t l) const { return lane[l]; }
  void put(std::size_t l, T v) { lane[l] = v; }
  T total() const {
    return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
  }
};

/// A vector per lane.
template <class T>
struct LaneVectorSum {
  LaneSum<T> x, y, z;
  Vec3<T> at(std::size_t l) const { return {x.lane[l], y.lane[l], z.lane[l]}; }
  void put(std::size_t l, const Vec3<T>& v) {
    x.lane[l] = v.x;
    y.lane[l] = v.y;
    z.lane[l] = v.z;
  }
  Vec3<T> total() const { return {x.total(), y.total(), z.total()}; }
};

/// A neighbour j of i.
template <class T>
struct Pair {
  Vec3<T> x_ij{};  ///< x_i - x_j [m]
  T r2{};          ///< its square
  T volume{};      ///< V0 of j [m^3]
};

/// Placeholder for the term of images along x_ij where images are added elsewhere.
struct NoImages {};

template <class Body, class = void>
inline constexpr bool settles = false;
template <class Body>
inline constexpr bool settles<Body, std::void_t<decltype(&Body::settle)>> = true;
template <class Body, class = void>
inline constexpr bool has_rare = false;
template <class Body>
inline constexpr bool has_rare<Body, std::void_t<decltype(&Body::rare)>> = true;
template <class Body, class = void>
inline constexpr bool skips_some = false;
template <class Body>
inline constexpr bool skips_some<Body, std::void_t<decltype(&Body::skips)>> = true;
template <class Body, class = void>
inline constexpr bool is_mirrored = false;
template <class Body>
inline constexpr bool is_mirrored<Body, std::void_t<decltype(&Body::mirrored)>> = true;

template <class Body, class = void>
inline constexpr bool adds_each_image = false;
template <class Body>
inline constexpr bool adds_each_image<Body, std::void_t<decltype(Body::each_image)>> = Body::each_image;

template <class Body, class = void>
inline constexpr bool is_listed = false;
template <class Body>
inline constexpr bool is_listed<Body, std::void_t<decltype(&Body::wanted)>> = true;
template <class Body, class = void>
inline constexpr bool adds_images_last = false;
template <class Body>
inline constexpr bool adds_images_last<Body, std::void_t<decltype(&Body::add_images)>> = true;

/// The components along the axes of `mask`: of an image's place or force, those across the planes that mirror it.
template <class T>
MELTSIM_HD Vec3<T> across(Vec3<T> v, std::uint32_t mask) {
  const Vec3<T> on = physics::axes_of<T>(mask);
  return {v.x * on.x, v.y * on.y, v.z * on.z};
}

/// Force of the images of a neighbour in own.walls.
template <class T, class Body, class Own, class Other>
MELTSIM_HD physics::ImageForce<T> images_of(const core::Frame<T>& w, const Body& body, const Own& own,
                                            const Other& other, const Pair<T>& pair) {
  const auto sums = physics::image_sums(own.walls, w.c.kernel.support2, pair.x_ij, pair.r2, [&](T square) {
    return Body::mirrored_shape(w.c.kernel, std::sqrt(square));
  });
  return physics::image_force(own.walls, pair.x_ij, sums, body.mirrored(own, other, pair.volume));
}

/// Part k of the sum of particle i, one neighbour after the other.
template <bool Periodic, class T, class Body>
MELTSIM_HD typename Body::Sum sum_part(const core::Frame<T>& w, const Body& body, std::uint64_t i,
                                       std::uint32_t k, std::uint32_t parts) {
  typename Body::Sum sum;
  if (!body.takes_part(i)) return sum;
  const auto own = body.own(i);
  sweep_part<Periodic>(w, i, k, parts, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& x_ij, T r2) {
    if constexpr (skips_some<Body>)
      if (body.skips(j)) return;
    auto stored = body.stored(own, j);
    if constexpr (settles<Body>) body.settle(own, stored, i, j);
    const auto other = body.other(own, stored);
    const Pair<T> pair{x_ij, r2, xj.w};
    constexpr bool images_first = is_mirrored<Body> && !adds_images_last<Body>;
    std::conditional_t<images_first, T, NoImages> along{};
    // At once: a vector that waits for the end of add() takes registers that a GPU lacks there.
    if constexpr (images_first)
      if (own.walls.axes != 0u) {
        const physics::ImageForce<T> force = images_of(w, body, own, other, pair);
        body.add_normal(sum, force.normal);
        along = force.along;
      }
    body.add(sum, own, other, pair, along);
    if constexpr (adds_each_image<Body>)
      physics::for_each_masked_image(
          own.walls, w.c.kernel.support2, x_ij, r2, [&](std::uint32_t mask, const Vec3<T>& x_m, T square) {
            body.add_image(sum, own, other, Pair<T>{x_m, square, pair.volume}, mask);
          });
    if constexpr (has_rare<Body>)
      if (body.rare(own, other, pair)) body.add_rare(sum, own, other, i, j, pair);
    if constexpr (adds_images_last<Body>)
      if (own.walls.axes != 0u) body.add_images(sum, pair, images_of(w, body, own, other, pair));
  });
  return sum;
}

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
