// SPDX-License-Identifier: Apache-2.0
// Walking a body's lattice: direct neighbours (arrayN) and regions (arrayR) as bit masks.
#pragma once

#include "exec/gather.hpp"
#include "frame/frame.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

inline constexpr std::uint32_t self_bit = 13;         ///< offset (0,0,0) among 27
inline constexpr std::uint32_t full_neighbours = 27;  ///< an IBP has all of them

MELTSIM_HD std::uint32_t neighbour_bit(int dx, int dy, int dz) {
  return static_cast<std::uint32_t>((dx + 1) + 3 * (dy + 1) + 9 * (dz + 1));
}

/// visit(dx, dy, dz) for the 27 sites around one, itself included, x fastest: in the order of neighbour_bit.
template <class Visit>
MELTSIM_HD void each_direct(const Visit& visit) {
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) visit(dx, dy, dz);
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

/// A step along an axis on which a body has `around` sites from `pad` on: the last meets the first.
MELTSIM_HD int step_around(std::uint32_t at, int step, std::uint32_t around, std::uint32_t pad) {
  if (around == 0u) return step;
  const int to = static_cast<int>(at) - static_cast<int>(pad) + step, n = static_cast<int>(around);
  return to < 0 ? step + n : to >= n ? step - n : step;
}

/// The site of a direct neighbour, also across a periodic face.
MELTSIM_HD std::uint32_t site_beside(std::uint32_t site, const BodyRow& b, int dx, int dy, int dz) {
  if ((b.around[0] | b.around[1] | b.around[2]) == 0u) return site_at(site, b, dx, dy, dz);
  const std::uint32_t at = site - b.first_site, layer = at % b.stride_z;
  return site_at(site, b, step_around(layer % b.stride_y, dx, b.around[0], b.pad),
                 step_around(layer / b.stride_y, dy, b.around[1], b.pad),
                 step_around(at / b.stride_z, dz, b.around[2], b.pad));
}

/// Where site_live says whether there is a live vertex at a site.
template <class T>
MELTSIM_HD std::uint32_t* site_word(const Frame<T>& w, std::uint32_t site) {
  return w.f.site_live + (site >> 5);
}
MELTSIM_HD std::uint32_t site_bit(std::uint32_t site) { return 1u << (site & 31u); }

/// Live vertices among n <= 32 sites from `first` on: bit k, at first + k.
template <class T>
MELTSIM_HD std::uint32_t live_sites(const Frame<T>& w, std::uint32_t first, std::uint32_t n) {
  const std::uint32_t* word = site_word(w, first);
  const std::uint64_t pair = word[0] | static_cast<std::uint64_t>(word[1]) << 32;
  return static_cast<std::uint32_t>(pair >> (first & 31u)) &
         static_cast<std::uint32_t>((std::uint64_t{1} << n) - 1u);
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

/// Whether a vertex moves with a kinematic body.
template <class T>
MELTSIM_HD bool is_carried(const Frame<T>& w, std::uint64_t v) {
  return w.f.vertex_state[v] == vertex_live && w.f.bodies[w.f.vertex_body[v]].motion == body_kinematic;
}

/// Steps of a vertex from site (0, 0, 0) of its body's box.
template <class T>
MELTSIM_HD Vec3<double> steps_in_box(const Frame<T>& w, std::uint64_t v, std::uint32_t body) {
  const BodyRow b = w.f.bodies[body];
  const std::uint32_t site = w.f.vertex_site[v] - b.first_site, layer = site % b.stride_z;
  return {static_cast<double>(layer % b.stride_y), static_cast<double>(layer / b.stride_y),
          static_cast<double>(site / b.stride_z)};
}

/// d less as many periods as bring it nearest to `near`.
MELTSIM_HD double nearest_image(double d, double near, double period) {
  return period > 0 ? d - period * std::rint((d - near) / period) : d;
}
MELTSIM_HD Vec3<double> nearest_image(Vec3<double> d, Vec3<double> near, Vec3<double> period) {
  return {nearest_image(d.x, near.x, period.x), nearest_image(d.y, near.y, period.y),
          nearest_image(d.z, near.z, period.z)};
}

/// Within 0.4 periods as built a vertex is in the nearest image, however its piece is turned and strained: squared.
inline constexpr double square_of_near = 0.16;

/// Position of a vertex relative to another of its piece, of which d is one image [m]: a piece may be longer than half a period. Meant is the
/// image nearest to where the lattice as built has it, turned by what turn(vertex) says, in the mean of both. Of a piece that reaches around
/// an axis, d there.
template <class T, class Turn>
MELTSIM_HD Vec3<double> offset_in_piece(const Frame<T>& w, Vec3<double> d, std::uint64_t v,
                                        std::uint64_t from, const Turn& turn) {
  if (w.grid.periodic == 0u) return d;
  const std::uint32_t body = w.f.vertex_body[v];
  const Vec3<double> q =
      (steps_in_box(w, v, body) - steps_in_box(w, from, body)) * static_cast<double>(w.c.spacing);
  const Vec3<double> period = cast<double>(w.grid.period);
  const auto reach = [](double p) { return p > 0 ? p : 1e300; };  // 0: not periodic
  const double least = minimum(minimum(reach(period.x), reach(period.y)), reach(period.z));
  if (dot(q, q) < square_of_near * least * least) return d;
  const auto turned = [&](std::uint64_t vertex) {
    const Quat<T> r = turn(vertex);
    return rotate(Quat<double>{static_cast<double>(r.w), static_cast<double>(r.x), static_cast<double>(r.y),
                               static_cast<double>(r.z)},
                  q);
  };
  const Vec3<double> image = nearest_image(d, (turned(v) + turned(from)) * 0.5, period);
  const std::uint32_t* around = w.f.bodies[body].around;
  return {around[0] != 0u ? d.x : image.x, around[1] != 0u ? d.y : image.y, around[2] != 0u ? d.z : image.z};
}

/// Place and velocity of a vertex of a body that deforms, relative to the pivot in the frame of the body as built, at a time [s].
template <class T>
MELTSIM_HD physics::RigidPoint deformed_point(const Frame<T>& w, std::uint64_t v, const BodyMotionRow& row,
                                              double time) {
  return physics::mesh_point_at(w.f.mesh_points[row.first_point + (v - row.first_vertex)], time);
}

/// Whether the host moves the mesh of a body.
template <class T>
MELTSIM_HD bool deforms(const Frame<T>& w, std::uint32_t body) {
  return w.f.mesh_points != nullptr && w.f.body_motion[body].first_point != none;
}

/// V/dx^3 of a vertex of a kinematic body at a time [s].
template <class T>
MELTSIM_HD double carried_volume_ratio(const Frame<T>& w, std::uint64_t v, double time) {
  const std::uint32_t body = w.f.vertex_body[v];
  if (!deforms(w, body)) return 1;
  const BodyMotionRow& row = w.f.body_motion[body];
  const BodyRow b = w.f.bodies[body];
  Vec3<double> columns[3];
  std::uint32_t known = 0;
  for (std::uint32_t axis = 0; axis < 3u; ++axis) {
    Vec3<double> ends[2];
    int steps = 0;
    for (int side = 0; side < 2; ++side) {
      const int step = 2 * side - 1;
      const std::uint32_t n = w.f.site_vertex[site_at(w.f.vertex_site[v], b, axis == 0u ? step : 0,
                                                      axis == 1u ? step : 0, axis == 2u ? step : 0)];
      ends[side] = deformed_point(w, is_vertex(n) ? n : v, row, time).position;
      steps += is_vertex(n) ? 1 : 0;
    }
    if (steps != 0) known |= 1u << axis;
    if (steps != 0) columns[axis] = (ends[1] - ends[0]) * (1 / (steps * row.spacing));
  }
  return physics::volume_ratio(columns[0], columns[1], columns[2], known);
}

/// Position (stored coordinates, not wrapped) and velocity of a vertex of a kinematic body at a time [s].
template <class T>
MELTSIM_HD physics::RigidPoint carried_point(const Frame<T>& w, std::uint64_t v, double time) {
  const std::uint32_t body = w.f.vertex_body[v];
  const BodyMotionRow& row = w.f.body_motion[body];
  if (row.first_point != none)
    return physics::moved_point_of(physics::place_at(row.motion, time), deformed_point(w, v, row, time));
  return physics::point_of(physics::place_at(row.motion, time),
                           row.low + steps_in_box(w, v, body) * row.spacing);
}

/// The same of a vertex of a proxy, at the beginning of a sub-step.
template <class T>
MELTSIM_HD physics::RigidPoint proxy_point(const Frame<T>& w, std::uint64_t v) {
  const std::uint32_t body = w.f.vertex_body[v];
  const BodyMotionRow& row = w.f.body_motion[body];
  return physics::point_of(row.motion.first, row.low + steps_in_box(w, v, body) * row.spacing);
}

/// Orientation of a kinematic body at a time [s].
template <class T>
MELTSIM_HD Quat<T> carried_rotation(const Frame<T>& w, std::uint32_t body, double time) {
  const Quat<double> q = physics::place_at(w.f.body_motion[body].motion, time).orientation;
  return {static_cast<T>(q.w), static_cast<T>(q.x), static_cast<T>(q.y), static_cast<T>(q.z)};
}

/// Rotation of the lattice about a vertex at the beginning of the sub-step.
template <class T>
MELTSIM_HD Quat<T> turn_of(const Frame<T>& w, std::uint64_t v) {
  if (w.f.body_motion != nullptr && w.f.bodies[w.f.vertex_body[v]].motion == body_kinematic)
    return carried_rotation(w, w.f.vertex_body[v], w.f.clock->time);
  return w.f.region_rotation[v];
}

/// The same where a World may keep no rotations, because nothing in it turns by itself.
template <class T>
MELTSIM_HD Quat<T> lattice_turn(const Frame<T>& w, std::uint64_t v) {
  const bool carried = w.f.body_motion != nullptr && w.f.bodies[w.f.vertex_body[v]].motion == body_kinematic;
  return carried || w.f.region_rotation != nullptr ? turn_of(w, v) : Quat<T>{};
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

/// Half-width from which regions are summed by rows and planes (lsm/boxes.hpp). On a CPU regions and goals take two
/// thirds of the time so at w = 1, a third at w = 2, a 26th at w = 8. On a GPU rows and planes come out of the L2 cache
/// and take six launches instead of two: regions and goals of 333,000 vertices took an H200 0.15 and 0.10 ms so, 0.19 and
/// 0.17 member by member at w = 2; of 20,000 vertices 0.039 and 0.033 against 0.028 and 0.025 at w = 2, 0.045 and 0.041
/// against 0.060 and 0.062 at w = 3. as_gpu: also where a CPU is to have a GPU's bits.
constexpr int least_row_width(bool as_gpu, std::uint64_t vertices) {
  return !as_gpu ? 1 : vertices >= gather_few ? 2 : 3;
}

/// Set in region_members where a region is made of planes of rows.
inline constexpr std::uint32_t boxed_region = 0x80000000u;
/// Set in row_live where the row has changed since the sub-step before.
inline constexpr std::uint32_t row_changed = 0x80000000u;

}  // namespace core
}  // namespace v0
}  // namespace meltsim
