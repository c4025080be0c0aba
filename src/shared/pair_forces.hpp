// SPDX-License-Identifier: Apache-2.0
// Forces on one particle of a body, for the step and for probes of kind `force`.
#pragma once

#include "frame/frame.hpp"
#include "meltsim/physics/contact.hpp"
#include "spatial/lanes.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// mu of liquid particle i [Pa s]; 0 where sph.diffuse takes viscosity in place of the caller.
template <class T>
MELTSIM_HD T viscosity_of(const Frame<T>& w, std::uint64_t i, const MaterialRow<T>& m) {
  if (w.inviscid) return T(0);
  return w.f.viscosity != nullptr ? w.f.viscosity[i] : m.viscosity;
}

/// visit(face, distance) of every wall within reach of x.
template <class T, class Visit>
MELTSIM_HD void for_each_near_wall(const Frame<T>& w, Vec3<T> x, const Visit& visit) {
  const auto& b = w.c.walls;
  const physics::FaceDistances<T> d = physics::face_distances(b, x);
  for (int k = 0; k < 6; ++k)
    if (((b.faces >> k) & 1u) != 0u && d[k] < b.support) visit(k, d[k]);
}

/// visit(conductance, velocity) of every no-slip wall within reach of a liquid particle at x.
template <class T, class Visit>
MELTSIM_HD void for_each_sticky_wall(const Frame<T>& w, Vec3<T> x, T mu, T volume, const Visit& visit) {
  for_each_near_wall(w, x, [&](int k, T distance) {
    visit(physics::wall_viscous_factor(w.c.wall_exchange, mu, volume, distance), w.c.wall_velocity[k]);
  });
}

template <class T>
struct ForceSum {
  Vec3<T> force{};
  MELTSIM_HD void add(const ForceSum& o) { force += o.force; }
  struct Lanes {
    spatial::LaneVectorSum<T> force;
    ForceSum at(std::size_t l) const { return {force.at(l)}; }
    void put(std::size_t l, const ForceSum& s) { force.put(l, s.force); }
    ForceSum total() const { return {force.total()}; }
  };
  /// Adds the force of an image.
  MELTSIM_HD void add_mirrored(const Vec3<T>& f) { force += f; }
};

/// leak_force on liquid particle i from k of a body.
template <class T>
MELTSIM_HD Vec3<T> leak_force_of(const Frame<T>& w, std::uint64_t i, std::uint64_t k, const Vec3<T>& x_ik,
                                 const Vec3<T>& v_ik, T r2) {
  return physics::leak_force(w.c.spacing, w.f.clock->spring_dt, w.f.mass[i], w.f.mass[k], x_ik, v_ik, r2) *
         w.f.leak_share[i];
}

/// The liquid's force on a solid particle [N]: the negatives of what sph.forces gives the liquid, the images in walls
/// included (spatial/sweep.hpp).
template <class T>
struct LiquidOnSolid {
  Frame<T> w;
  using Sum = ForceSum<T>;
  struct Own {
    T volume, tau;
    Vec3<T> v;
    physics::WallView<T> walls;
  };
  struct Stored {
    Vec3<T> v;
    T terms, viscosity;  ///< terms: P/phi^2 of both ends
  };
  MELTSIM_HD bool takes_part(std::uint64_t) const { return true; }
  MELTSIM_HD Own own(std::uint64_t k) const {
    const Vec4<T> v = w.f.velocity[k], x = w.f.position[k];
    return {x.w, -v.w, xyz(v), physics::wall_view(w.c.walls, xyz(x))};
  }
  MELTSIM_HD bool skips(std::uint32_t i) const { return !is_fluid(w.f.tag[i]); }
  MELTSIM_HD Stored stored(const Own& own, std::uint32_t i) const {
    const MaterialRow<T>& m = w.f.materials[material_of(w.f.tag[i])];
    const Vec4<T> v = w.f.velocity[i];
    return {xyz(v), v.w + m.tait_stiffness * own.tau, viscosity_of(w, i, m)};
  }
  MELTSIM_HD Stored other(const Own&, const Stored& s) const { return s; }
  template <class Along>
  MELTSIM_HD void add(Sum& sum, const Own& own, const Stored& i, const spatial::Pair<T>& pair, Along) const {
    const physics::CouplingPair<T> p{pair.volume, own.volume, i.terms, i.viscosity, -pair.x_ij, i.v - own.v};
    sum.force += -physics::coupling_force(w.c.kernel, p, pair.r2);
  }
  MELTSIM_HD T mirrored(const Own& own, const Stored& i, T volume) const {
    return physics::pressure_factor(volume, own.volume, i.terms, T(0), w.c.kernel.grad_scale);
  }
  MELTSIM_HD static T mirrored_shape(const physics::SphKernel<T>& kernel, T r) {
    return physics::kernel_gradient_shape(kernel, r);
  }
  MELTSIM_HD void add_images(Sum& sum, const spatial::Pair<T>& pair,
                             const physics::ImageForce<T>& force) const {
    sum.force += pair.x_ij * force.along + force.normal;
  }
  MELTSIM_HD bool may_be_rare(const Stored&) const { return true; }
  /// Whether the pair is so near that liquid could slip through.
  MELTSIM_HD bool rare(const Own&, const Stored&, const spatial::Pair<T>& pair) const {
    return pair.r2 < w.c.leak_distance2;
  }
  MELTSIM_HD void add_rare(Sum& sum, const Own& own, const Stored& i, std::uint64_t k, std::uint32_t slot,
                           const spatial::Pair<T>& pair) const {
    sum.force += -leak_force_of(w, slot, k, -pair.x_ij, i.v - own.v, pair.r2);
  }
  /// Neighbours that are no liquid have no weight.
  struct Lanes {
    spatial::LaneVectors<T> v, of;
    Stored at(std::size_t k) const { return {{v.x[k], v.y[k], v.z[k]}, v.w[k], of.x[k]}; }
    void load(const LiquidOnSolid& body, const Own& own, std::uint64_t, const std::uint32_t* slots,
              std::uint32_t n, T* volume) {
      if (body.w.one_liquid && body.w.f.viscosity == nullptr && !(body.w.c.lowest_phi < T(1)))
        return load_alike(body, own, slots, n, volume);
      for (std::uint32_t k = 0; k < spatial::whole_lanes(n); ++k) {
        const bool none = body.skips(slots[k]);
        const Stored s = none ? Stored{} : body.stored(own, slots[k]);
        v.put(k, with_w(s.v, s.terms));
        of.x[k] = s.viscosity;
        if (none) volume[k] = T(0);
      }
    }
    /// Beside one liquid, which the sign of the terms tells from solids.
    void load_alike(const LiquidOnSolid& body, const Own& own, const std::uint32_t* slots, std::uint32_t n,
                    T* volume) {
      std::uint32_t first = 0;
      while (first < n && body.skips(slots[first])) ++first;
      MaterialRow<T> liquid;
      if (first < n) liquid = body.w.f.materials[material_of(body.w.f.tag[slots[first]])];
      const T mu = body.w.inviscid ? T(0) : liquid.viscosity;
      const T of_solid = liquid.tait_stiffness * own.tau;
      v.load(body.w.f.velocity, slots, n);
      spatial::in_lanes(n, [&](std::size_t, std::size_t k) {
        volume[k] = sign_bit(v.w[k]) != 0u ? T(0) : volume[k];
        v.w[k] += of_solid;
        of.x[k] = mu;
      });
    }
  };
};

/// Its part without viscosity.
template <class T>
struct PressureOnSolid : LiquidOnSolid<T> {
  using Base = LiquidOnSolid<T>;
  template <class Along>
  MELTSIM_HD void add(typename Base::Sum& sum, const typename Base::Own& own, const typename Base::Stored& i,
                      const spatial::Pair<T>& pair, Along) const {
    const physics::CouplingPair<T> p{pair.volume, own.volume, i.terms, T(0), -pair.x_ij, i.v - own.v};
    sum.force += -physics::coupling_force(this->w.c.kernel, p, pair.r2);
  }
};

/// Slip of a solid particle along its contacts [m].
template <class T>
MELTSIM_HD Vec3<T> slip_of(const Frame<T>& w, std::uint64_t i) {
  return w.f.contact_slip == nullptr ? Vec3<T>{} : w.f.contact_slip[w.f.vertex_of_id[w.f.id[i]]];
}

/// Radius of a solid particle in contact [m]; half a spacing where there are no lattices.
template <class T>
MELTSIM_HD T contact_radius_of(const Frame<T>& w, std::uint64_t i) {
  if (w.f.contact_shape == nullptr) return T(physics::largest_contact_radius) * w.c.spacing;
  return std::fabs(w.f.contact_shape[w.f.vertex_of_id[w.f.id[i]]].w);
}

/// Contact of solid particle i, of velocity v, with a wall. The smaller of both friction coefficients holds.
template <class T>
struct WallContact {
  physics::ContactResponse<T> response;
  bool touches = false;
};
template <class T>
MELTSIM_HD WallContact<T> wall_contact(const Frame<T>& w, std::uint64_t i, std::uint32_t tag, Vec3<T> x,
                                       Vec3<T> v, Vec3<T> slip, int face) {
  const T most = T(physics::largest_contact_radius) * w.c.spacing;
  if (((w.c.walls.faces >> face) & 1u) == 0u || !(physics::wall_overlap(w.c.walls, most, x, face) > T(0)))
    return {};
  const T depth = physics::wall_overlap(w.c.walls, contact_radius_of(w, i), x, face);
  if (!(depth > T(0))) return {};
  const T friction = minimum(w.f.materials[material_of(tag)].friction, w.c.wall_friction);
  return {physics::contact_response(physics::body_contact<T>(), depth, physics::wall_normal<T>(face),
                                    v - w.c.wall_velocity[face], slip, w.f.mass[i], friction, w.f.clock->dt,
                                    w.f.clock->spring_dt),
          true};
}

/// Whether liquid may seep between a particle and a wall, so that it pushes the body off: bodies that forces move.
MELTSIM_HD bool can_seep(std::uint32_t tag) {
  return is_solid(tag) && (tag & (tag_fixed | tag_kinematic)) == 0u;
}

/// Force of the gap between solid particle i and the walls near x (physics/seepage.hpp) [N]. Component a is of the near wall of
/// axis a.
template <class T>
MELTSIM_HD Vec3<T> seepage_on(const Frame<T>& w, std::uint64_t i, std::uint32_t tag, Vec3<T> x) {
  if (w.f.under == nullptr || !can_seep(tag)) return {};
  const auto walls = physics::wall_view(w.c.walls, x);
  if (walls.axes == 0u) return {};
  const std::uint32_t v = w.f.vertex_of_id[w.f.id[i]];
  const RimSums& rim = w.f.rim_sums[w.f.vertex_piece[v]];
  const Vec3<T> under = w.f.under[v].area, filled = w.f.under[v].force;
  const auto along = [&](int axis, T area, T pressed, T from) {
    if (!(area > T(0))) return T(0);
    const T force =
        seepage_of(rim, w.sum_units, axis, area, pressed, std::fabs(from), w.c.spacing, w.f.clock->dt);
    return from > T(0) ? force : -force;
  };
  return {along(0, under.x, filled.x, walls.from.x), along(1, under.y, filled.y, walls.from.y),
          along(2, under.z, filled.z, walls.from.z)};
}

/// Whether a particle asks for the pressure of the gaps between bodies: one at the surface of a body that forces move.
MELTSIM_HD bool asks_of_gap(std::uint32_t tag) { return can_seep(tag) && (tag & tag_surface) != 0u; }

/// A particle at the surface of a body, beside a gap (physics/gap.hpp).
template <class T>
struct GapSide {
  std::uint32_t piece = 0;
  T volume{}, push{}, sees{};
};
template <class T>
MELTSIM_HD GapSide<T> gap_side(const Frame<T>& w, std::uint64_t i) {
  const Vec4<T> asked = asks_of_gap(w.f.tag[i]) ? w.f.gap_push[i] : Vec4<T>{};
  return {w.f.piece[i], w.f.position[i].w, asked.z, asked.w};
}

/// Force of the gap on a particle of a body from particle j, whose volume this is [N]; 0 but from the surfaces of other pieces.
template <class T>
MELTSIM_HD Vec3<T> gap_force(const Frame<T>& w, const GapSide<T>& own, std::uint32_t j, T volume,
                             Vec3<T> x_ij, T r2) {
  const std::uint32_t other = w.f.piece[j];
  if (other == 0u || other == own.piece || !(r2 > T(0))) return {};
  const std::uint32_t tag = w.f.tag[j];
  if ((tag & tag_surface) == 0u) return {};
  const Vec4<T> asked = asks_of_gap(tag) ? w.f.gap_push[j] : Vec4<T>{};
  const T push = physics::gap_pair_pressure(own.push, own.sees, asked.z, asked.w);
  if (!(push > T(0))) return {};
  return physics::gap_pair_force(w.c.kernel, push, own.volume * volume, x_ij, r2);
}

/// Operands of contact of a particle at the surface of a movable body.
template <class T>
struct Toucher {
  std::uint64_t i = 0;
  std::uint32_t tag = 0, piece = 0;
  Vec3<T> velocity{}, slip{};
  Vec4<T> normal{};
  T radius{};
};
template <class T>
MELTSIM_HD Toucher<T> toucher(const Frame<T>& w, std::uint64_t i) {
  return {i,
          w.f.tag[i],
          w.f.piece[i],
          xyz(w.f.velocity[i]),
          slip_of(w, i),
          w.f.contact_normal[i],
          contact_radius_of(w, i)};
}

/// Contact of a with particle j of another piece; weight 0 if none. The mean of both friction coefficients holds.
template <class T>
struct PairContact {
  physics::ContactResponse<T> response;
  T weight{};
};
template <class T>
MELTSIM_HD PairContact<T> pair_contact(const Frame<T>& w, const Toucher<T>& a, std::uint32_t j, Vec3<T> x_aj,
                                       T r2) {
  const T reach2 = T(2) * w.c.spacing * w.c.spacing;  // overlap and offset both below one spacing
  if (!(r2 < reach2) || !(r2 > T(0))) return {};
  const std::uint32_t other = w.f.piece[j];
  if (other == 0u || other == a.piece) return {};
  const std::uint32_t tag_j = w.f.tag[j];
  if ((tag_j & tag_surface) == 0u) return {};
  physics::ContactGeometry<T> g =
      physics::contact_geometry(a.normal, w.f.contact_normal[j], x_aj, r2, w.c.spacing);
  if (!(g.overlap > T(0)) || !(g.weight > T(0))) return {};
  g.overlap = physics::overlap_of_radii(g.overlap, w.c.spacing, a.radius, contact_radius_of(w, j));
  if (!(g.overlap > T(0))) return {};
  const bool held = (tag_j & tag_fixed) != 0u;
  const T m = held ? w.f.mass[a.i] : physics::reduced_mass(w.f.mass[a.i], w.f.mass[j]);
  const Vec3<T> slip = held ? a.slip : (a.slip - slip_of(w, j)) * T(0.5);
  const T friction =
      T(0.5) * (w.f.materials[material_of(a.tag)].friction + w.f.materials[material_of(tag_j)].friction);
  return {physics::contact_response(physics::body_contact<T>(), g.overlap, g.normal,
                                    a.velocity - xyz(w.f.velocity[j]), slip, m * g.weight, friction,
                                    w.f.clock->dt, w.f.clock->spring_dt),
          g.weight};
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
