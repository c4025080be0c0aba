// SPDX-License-Identifier: Apache-2.0
// Walking a body's lattice: direct neighbours (arrayN) and regions (arrayR) as bit masks.
#pragma once

#include "core/frame.hpp"
#include "core/gather.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

inline constexpr std::uint32_t self_bit = 13;         ///< offset (0,0,0) among 27
inline constexpr std::uint32_t full_neighbours = 27;  ///< an IBP has all of them

MELTSIM_HD std::uint32_t neighbour_bit(int dx, int dy, int dz) {
  return static_cast<std::uint32_t>((dx + 1) + 3 * (dy + 1) + 9 * (dz + 1));
}

MELTSIM_HD std::uint32_t region_bit(int w, int dx, int dy, int dz) {
  const int side = 2 * w + 1;
  return static_cast<std::uint32_t>((dx + w) + side * ((dy + w) + side * (dz + w)));
}

MELTSIM_HD std::uint32_t words_for(int w) {
  const std::uint32_t side = static_cast<std::uint32_t>(2 * w + 1);
  return (side * side * side + 31u) / 32u;
}

MELTSIM_HD std::uint32_t site_at(std::uint32_t site, const BodyRow& b, int dx, int dy, int dz) {
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(site) + dx +
                                    static_cast<std::int64_t>(dy) * b.stride_y +
                                    static_cast<std::int64_t>(dz) * b.stride_z);
}

/// Bits [bit, bit + side) of a mask of `words` words; side <= 17.
MELTSIM_HD std::uint32_t mask_bits(const std::uint32_t* mask, std::uint32_t words, std::uint32_t bit,
                                   std::uint32_t side) {
  const std::uint32_t word = bit >> 5, shift = bit & 31u;
  std::uint64_t pair = mask[word];
  if (shift + side > 32u && word + 1u < words) pair |= static_cast<std::uint64_t>(mask[word + 1u]) << 32;
  return static_cast<std::uint32_t>(pair >> shift) & ((1u << side) - 1u);
}

/// Walks layers [first, last) in z of v's region. Half: w where the compiler may know it, so that it can
/// unroll rows; 0: any.
template <int Half, class T, class Visit>
MELTSIM_HD void walk_region(const Frame<T>& w, std::uint32_t v, const BodyRow& b, int first, int last,
                            const Visit& visit) {
  const int h = Half != 0 ? Half : b.region_half_width;
  const std::uint32_t side = static_cast<std::uint32_t>(2 * h + 1);
  const std::uint32_t site = w.f.vertex_site[v];
  const std::uint32_t* mask = w.f.region_mask + static_cast<std::uint64_t>(v) * w.region_words;
  std::uint32_t bit = region_bit(h, -h, -h, first);
  for (int dz = first; dz < last; ++dz)
    for (int dy = -h; dy <= h; ++dy, bit += side) {
      const std::uint32_t row = mask_bits(mask, w.region_words, bit, side);
      const std::uint32_t* vertices = w.f.site_vertex + site_at(site, b, 0, dy, dz);
      for (int dx = -h; dx <= h; ++dx)
        if (((row >> (dx + h)) & 1u) != 0u) visit(vertices[dx], dx, dy, dz);
    }
}

/// First layer in z of a part of a region's 2h+1, relative to its vertex.
MELTSIM_HD int layer_of_part(int h, std::uint32_t part, std::uint32_t parts) {
  return (2 * h + 1) * static_cast<int>(part) / static_cast<int>(parts) - h;
}

/// visit(vertex, dx, dy, dz) for the members of v's region in one of `parts` parts, x fastest.
template <class T, class Visit>
MELTSIM_HD void for_each_member(const Frame<T>& w, std::uint32_t v, std::uint32_t part, std::uint32_t parts,
                                const Visit& visit) {
  const BodyRow b = w.f.bodies[w.f.vertex_body[v]];
  const int h = b.region_half_width;
  const int first = layer_of_part(h, part, parts), last = layer_of_part(h, part + 1u, parts);
  if (h == 1) walk_region<1>(w, v, b, first, last, visit);
  else if (h == 2) walk_region<2>(w, v, b, first, last, visit);
  else walk_region<0>(w, v, b, first, last, visit);
}

/// All members of v's region, v included.
template <class T, class Visit>
MELTSIM_HD void for_each_member(const Frame<T>& w, std::uint32_t v, const Visit& visit) {
  for_each_member(w, v, 0u, 1u, visit);
}

/// A region's fit and where its vertex is.
template <class T>
struct PlacedFit {
  physics::RegionFit<T> fit;
  Vec3<T> position{};
};

/// region_fit holds four planes of one entry per vertex, so that neighbouring threads meet neighbouring
/// words.
template <class T>
MELTSIM_HD void put_fit(const Frame<T>& w, std::uint64_t v, const PlacedFit<T>& p) {
  const std::uint64_t n = w.vertices;
  const Quat<T>& q = p.fit.rotation;
  w.f.region_fit[v] = {q.x, q.y, q.z, q.w};
  w.f.region_fit[n + v] = with_w(p.fit.anchor, p.position.x);
  w.f.region_fit[2 * n + v] = with_w(p.fit.velocity, p.position.y);
  w.f.region_fit[3 * n + v] = with_w(p.fit.spin, p.position.z);
}

template <class T>
MELTSIM_HD Quat<T> fitted_rotation(const Frame<T>& w, std::uint64_t v) {
  const Vec4<T> q = w.f.region_fit[v];
  return {q.w, q.x, q.y, q.z};
}

template <class T>
MELTSIM_HD PlacedFit<T> get_fit(const Frame<T>& w, std::uint64_t v) {
  const std::uint64_t n = w.vertices;
  const Vec4<T> a = w.f.region_fit[n + v], b = w.f.region_fit[2 * n + v], c = w.f.region_fit[3 * n + v];
  return {{fitted_rotation(w, v), xyz(a), xyz(b), xyz(c)}, {a.w, b.w, c.w}};
}

/// Half-width from which whole regions are summed by rows. sm_90 code takes 10,300 instructions for 125 members
/// and 3,600 for their rows, 9,900 and 2,300 for goals; at w = 1 it would save 2,000 of 7,800, fits included,
/// which what is kept per row takes back. On a GPU rows come out of the L2 cache, and ragged regions need kernels
/// of their own: regions and goals of 333,000 vertices took an H200 0.22 and 0.14 ms by rows, 0.19 and 0.15 by
/// members at w = 2, 0.38 and 0.32 against 0.50 and 0.49 at w = 3, 4.2 and 4.3 against 5.8 and 6.4 at w = 8; of
/// 20,000 vertices 0.09 and 0.08 against 0.06 and 0.06 at w = 3, 0.43 and 0.59 against 0.52 and 0.58 at w = 8.
/// as_gpu: also where a CPU is to have a GPU's bits.
constexpr int least_row_width(bool as_gpu, std::uint64_t vertices) {
  return !as_gpu ? 2 : vertices >= gather_few ? 3 : 8;
}

/// Members of v's region: |R_v|.
template <class T>
MELTSIM_HD std::uint32_t region_size(const Frame<T>& w, std::uint32_t v) {
  std::uint32_t n = 0;
  const std::uint32_t* mask = w.f.region_mask + static_cast<std::uint64_t>(v) * w.region_words;
  for (std::uint32_t k = 0; k < w.region_words; ++k) n += popcount(mask[k]);
  return n;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
