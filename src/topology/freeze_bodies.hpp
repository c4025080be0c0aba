// SPDX-License-Identifier: Apache-2.0
// Kernels of freezing: choosing the liquid particle at a free site of a body, and adding it to the body.
#pragma once

#include "spatial/neighbours.hpp"
#include "topology/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace topology {

/// Number of vertices that melted, or froze.
struct Count {
  std::uint32_t n = 0;
  MELTSIM_HD static Count combine(Count a, Count b) { return {a.n + b.n}; }
};

/// A free site next to a live vertex.
template <class T>
struct Site {
  Vec3<T> position{};  ///< p, stored coordinates [m]
  std::uint32_t donor =
      none;  ///< the face neighbour that hands on body, piece and rotation; none: no site now
};

/// Whether what a site holds is a live vertex.
template <class T>
MELTSIM_HD bool is_live(const Frame<T>& w, std::uint32_t n) {
  return core::is_vertex(n) && w.f.vertex_state[n] == vertex_live;
}

/// Vertex at an offset from v if it is live, else none.
template <class T>
MELTSIM_HD std::uint32_t live_at(const Frame<T>& w, std::uint32_t v, const BodyRow& b, int dx, int dy,
                                 int dz) {
  const std::uint32_t n = w.f.site_vertex[core::site_at(w.f.vertex_site[v], b, dx, dy, dz)];
  return is_live(w, n) ? n : none;
}

/// Offset of face k = 0..5: -x, +x, -y, +y, -z, +z.
MELTSIM_HD int face_step(int k, int axis) { return k / 2 == axis ? 2 * (k % 2) - 1 : 0; }

/// p_n - x_n of site v. carried: orientation of a kinematic body.
template <class T>
MELTSIM_HD Vec3<T> wanted_offset(const Frame<T>& w, std::uint32_t v, std::uint32_t n, const BodyRow& b,
                                 const Quat<T>& carried, int dx, int dy, int dz) {
  if (core::deforms(w, w.f.vertex_body[v]))
    return cast<T>(core::carried_point(w, v, w.f.clock->end).position -
                   core::carried_point(w, n, w.f.clock->end).position);
  const Vec3<T> q = Vec3<T>{T(-dx), T(-dy), T(-dz)} * w.c.spacing;
  if (b.motion == core::body_kinematic) return physics::site_offset(carried, q);
  return b.motion == core::body_fixed || w.f.region_rotation == nullptr
             ? q
             : physics::site_offset(w.f.region_rotation[n], q);
}

template <class T>
MELTSIM_HD Vec3<T> vertex_place(const Frame<T>& w, std::uint32_t n) {
  return xyz(w.f.position[w.f.slot_of_id[w.f.vertex_id[n]]]);
}

/// Whether a site is clear of the faces along one axis; faces: bit 0 the low one, bit 1 the high one.
template <class T>
MELTSIM_HD bool clear_of(T x, T low, T high, T margin, std::uint32_t faces) {
  return !((faces & 1u) != 0u && x < low + margin) && !((faces & 2u) != 0u && x > high - margin);
}

/// Whether a site at x is clear of walls and open faces.
template <class T>
MELTSIM_HD bool clear_of_faces(const Frame<T>& w, Vec3<T> x) {
  const std::uint32_t faces = w.c.walls.faces | w.c.open_faces;
  const T margin = T(physics::site_margin) * w.c.spacing;
  return clear_of(x.x, w.c.domain_min.x, w.c.domain_max.x, margin, faces) &&
         clear_of(x.y, w.c.domain_min.y, w.c.domain_max.y, margin, faces >> 2) &&
         clear_of(x.z, w.c.domain_min.z, w.c.domain_max.z, margin, faces >> 4);
}

/// Place of a free vertex according to its live neighbours, if they agree and it lies in the domain.
template <class T>
MELTSIM_HD Site<T> locate_site(const Frame<T>& w, std::uint32_t v) {
  const BodyRow b = w.f.bodies[w.f.vertex_body[v]];
  Site<T> s;
  for (int k = 0; k < 6 && s.donor == none; ++k)
    s.donor = live_at(w, v, b, face_step(k, 0), face_step(k, 1), face_step(k, 2));
  if (s.donor == none) return s;
  Quat<T> carried;
  if (b.motion == core::body_kinematic)
    carried = core::carried_rotation(w, w.f.vertex_body[v], w.f.clock->end);
  // Relative to the donor: a lattice may lie across a periodic face.
  const Vec3<T> origin = vertex_place(w, s.donor);
  Vec3<T> sum{};
  T count = 0;
  core::each_direct([&](int dx, int dy, int dz) {
    const std::uint32_t n = live_at(w, v, b, dx, dy, dz);
    if (n == none) return;
    sum += spatial::separation(w.grid, vertex_place(w, n), origin) +
           wanted_offset(w, v, n, b, carried, dx, dy, dz);
    count += T(1);
  });
  const Vec3<T> mean = sum * (T(1) / count);
  const T tolerance = T(physics::site_agreement) * w.c.spacing;
  bool agreed = true;
  core::each_direct([&](int dx, int dy, int dz) {
    const std::uint32_t n = live_at(w, v, b, dx, dy, dz);
    if (n == none) return;
    const Vec3<T> off = spatial::separation(w.grid, vertex_place(w, n), origin) +
                        wanted_offset(w, v, n, b, carried, dx, dy, dz) - mean;
    agreed = agreed && dot(off, off) <= tolerance * tolerance;
  });
  const Vec3<T> x = core::wrapped(w, origin + mean);
  if (!agreed || !clear_of_faces(w, x)) s.donor = none;
  s.position = x;
  return s;
}

/// visit(j, r2) for every particle j among the neighbours of the live face neighbours of v, r2 from the site;
/// some more than once. Their lists are those of this sub-step's sort, half a drift old.
template <class T, class Visit>
MELTSIM_HD void for_each_near_site(const Frame<T>& w, std::uint32_t v, const Site<T>& s, const Visit& visit) {
  const BodyRow b = w.f.bodies[w.f.vertex_body[v]];
  for (int k = 0; k < 6; ++k) {
    const std::uint32_t n = live_at(w, v, b, face_step(k, 0), face_step(k, 1), face_step(k, 2));
    if (n == none) continue;
    const std::uint32_t from = w.f.slot_of_id[w.f.vertex_id[n]];
    spatial::for_each_neighbour(w, from, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>&, T) {
      const Vec3<T> d = spatial::separation(w.grid, xyz(xj), s.position);
      visit(j, dot(d, d));
    });
  }
}

/// Whether liquid at a slot is crystals of a material that precipitates.
template <class T>
MELTSIM_HD bool crystallises(const Frame<T>& w, std::uint32_t slot, std::uint32_t solid) {
  for (std::uint32_t k = 0; k < w.species; ++k) {
    const core::SpeciesRow<T>& s = w.f.species[k];
    if (s.solute == solid && s.solvent == material_of(w.f.tag[slot]) && physics::precipitates(s))
      return physics::crystallises(core::fraction_at(w, k, slot), core::saturation_at(w, k, slot));
  }
  return false;
}

/// Bit of vertex_pick: the particle is drawn to the site, but does not take it in this sub-step. Ids are below it.
inline constexpr std::uint32_t pick_drawn = 0x80000000u;

/// The liquid particle nearest to a site; of equally near ones, that of the smallest id.
template <class T>
struct Nearest {
  std::uint32_t slot = none;
  T distance2 = 0;
  bool crowded = false;  ///< another one is nearer than site_clearance
  bool blocked = false;  ///< something solid is

  /// A particle within site_clearance; one may come more than once.
  MELTSIM_HD void add(const Frame<T>& w, std::uint32_t j, T r2) {
    if (!is_fluid(w.f.tag[j])) {
      blocked = true;
      return;
    }
    if (j == slot) return;
    crowded = slot != none;
    if (slot != none && (r2 > distance2 || (r2 == distance2 && w.f.id[j] > w.f.id[slot]))) return;
    slot = j;
    distance2 = r2;
  }
};

/// Every free vertex picks the particle nearest to its site, if that is liquid within the capture radius that freezes
/// into the material of its body, or is crystals of it. While another is near, which would be repelled at high speed, and until it is
/// at the site, it is drawn there only.
template <class T>
struct PickBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    w.f.vertex_pick[i] = none;
    if (w.f.vertex_state[i] != vertex_free) return;
    const auto v = static_cast<std::uint32_t>(i);
    const Site<T> s = locate_site(w, v);
    if (s.donor == none) return;
    const std::uint32_t solid = material_of(w.f.tag[w.f.slot_of_id[w.f.vertex_id[s.donor]]]);
    const T clearance = T(physics::site_clearance) * w.c.spacing;
    const T reach = T(physics::capture_radius) * w.c.spacing;
    Nearest<T> found;
    for_each_near_site(w, v, s, [&](std::uint32_t j, T r2) {
      if (r2 < clearance * clearance && !is_removed(w.f.tag[j])) found.add(w, j, r2);
    });
    const std::uint32_t slot = found.slot;
    if (slot == none || found.blocked || found.distance2 > reach * reach) return;
    const physics::MaterialRow<T>& m = w.f.materials[material_of(w.f.tag[slot])];
    if ((m.solid == solid && physics::freezes(m, w.f.enthalpy[slot] / static_cast<double>(w.f.mass[slot]))) ||
        crystallises(w, slot, solid))
      w.f.vertex_pick[i] = w.f.id[slot] | (found.crowded || !at_site(found.distance2) ? pick_drawn : 0u);
  }
  MELTSIM_HD bool at_site(T distance2) const {
    const T far = T(physics::joins_within) * w.c.spacing;
    return distance2 <= far * far;
  }
};

/// A particle that several vertices picked goes to the smallest of them.
template <class T>
struct ClaimBody {
  Frame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t v, const Add& add) const {
    const std::uint32_t id = w.f.vertex_pick[v];
    if (id != none) add.lower(&w.f.claim[id & ~pick_drawn], static_cast<std::uint32_t>(v));
  }
};
/// Those that lost it let go; who is to draw its particle moves it, and no other vertex does.
template <class T>
struct YieldBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const auto v = static_cast<std::uint32_t>(i);
    const std::uint32_t pick = w.f.vertex_pick[v], id = pick & ~pick_drawn;
    if (pick == none) return;
    const bool ours = w.f.claim[id] == v;
    if (ours && (pick & pick_drawn) == 0u) return;
    w.f.vertex_pick[v] = none;
    if (ours) draw(v, w.f.slot_of_id[id]);
  }
  MELTSIM_HD void draw(std::uint32_t v, std::uint32_t slot) const {
    const Vec4<T> x = w.f.position[slot];
    const Site<T> s = locate_site(w, v);
    const Vec3<T> way = spatial::separation(w.grid, s.position, xyz(x));
    const T share =
        physics::drawn_share(std::sqrt(dot(way, way)), w.c.spacing, w.f.clock->dt, w.f.clock->spring_dt);
    w.f.position[slot] = with_w(core::wrapped(w, xyz(x) + way * share), x.w);
    hold(v, slot, s.donor, way);
  }
  /// Of bodies that move freely the particle keeps its momentum until it joins.
  MELTSIM_HD void hold(std::uint32_t v, std::uint32_t slot, std::uint32_t donor, Vec3<T> way) const {
    const std::uint32_t tag = w.f.tag[w.f.slot_of_id[w.f.vertex_id[donor]]];
    if ((tag & (tag_fixed | tag_kinematic)) == 0u) return;
    const bool moves = (tag & tag_kinematic) != 0u;
    const Vec3<T> site = moves ? cast<T>(core::carried_point(w, v, w.f.clock->end).velocity) : Vec3<T>{};
    const Vec4<T> was = w.f.velocity[slot];
    w.f.velocity[slot] = with_w(site + physics::drawn_velocity(xyz(was) - site, way), was.w);
  }
};

template <class T>
struct BornBody {
  Frame<T> w;
  MELTSIM_HD Count operator()(std::uint64_t v) const { return {w.f.vertex_pick[v] != none ? 1u : 0u}; }
};

/// The particle takes the site: it becomes part of the body, stops if that is fixed, and moves
/// with it if that is kinematic. Each vertex writes
/// to itself and to the particle that is its own by now; what it reads of others belongs to vertices that
/// were live before. States change after all of them have joined.
template <class T>
struct JoinBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t id = w.f.vertex_pick[i];
    if (w.f.status->born == 0u || id == none) return;
    const auto v = static_cast<std::uint32_t>(i);
    const Site<T> s = locate_site(w, v);
    const std::uint32_t slot = w.f.slot_of_id[id];
    const std::uint32_t donor_tag = w.f.tag[w.f.slot_of_id[w.f.vertex_id[s.donor]]];
    Vec3<T> velocity = (donor_tag & tag_fixed) != 0u ? Vec3<T>{} : xyz(w.f.velocity[slot]);
    if ((donor_tag & tag_kinematic) != 0u)
      velocity = cast<T>(core::carried_point(w, v, w.f.clock->end).velocity);
    w.f.position[slot] = with_w(s.position, w.c.spacing * w.c.spacing * w.c.spacing);
    w.f.velocity[slot] = with_w(velocity, T(0));
    w.f.tag[slot] = donor_tag | tag_surface;
    w.f.vertex_of_id[id] = v;
    w.f.vertex_id[v] = id;
    w.f.vertex_piece[v] = w.f.vertex_piece[s.donor];
    if (w.f.region_rotation != nullptr) w.f.region_rotation[v] = w.f.region_rotation[s.donor];
    if (w.f.rigid_rotation != nullptr) w.f.rigid_rotation[v] = w.f.rigid_rotation[s.donor];
  }
};
template <class T>
struct BirthBody {
  Frame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t v, const Add& add) const {
    if (w.f.vertex_pick[v] != none) {
      w.f.vertex_state[v] = vertex_live;
      const std::uint32_t site = w.f.vertex_site[v];
      add.set(core::site_word(w, site), core::site_bit(site));
      if (w.f.contact_slip != nullptr) w.f.contact_slip[v] = {};  // not that of the particle before
    }
  }
};

/// Adds the step's count to the running one.
template <class T>
struct FrozenBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t) const {
    w.f.status->frozen += w.f.status->born;
    if (w.f.status->born != 0u) w.f.status->pieces_stale = 1u;
  }
};

}  // namespace topology
}  // namespace v0
}  // namespace meltsim
