// SPDX-License-Identifier: Apache-2.0
// Kernels of the solids: shape matching per lattice vertex, contact per particle.
#pragma once

#include "frame/lattice.hpp"
#include "lsm/boxes.hpp"
#include "meltsim/physics/contact.hpp"
#include "meltsim/physics/shape_matching.hpp"
#include "shared/pair_forces.hpp"
#include "spatial/neighbours.hpp"

namespace meltsim {
inline namespace v0 {
namespace lsm {

/// Copies particle state into vertex order and clears the sums of pieces, which are stored at their label vertices.
template <class T>
struct GatherBody {
  Frame<T> w;
  static constexpr bool modest = true;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (w.f.vertex_piece[v] == v) w.f.piece_sums[v] = core::PieceSums{};
    // Melted vertices, too: one may still be the label of its piece, and positions are taken relative to
    // that. A vertex that never held a particle is no label.
    if (w.f.vertex_id[v] == none) {
      w.f.vertex_position[v] = Vec4<T>{};
      return;
    }
    const std::uint32_t slot = w.f.slot_of_id[w.f.vertex_id[v]];
    if (!moves(w, v)) {
      w.f.vertex_position[v] = with_w(xyz(w.f.position[slot]), T(0));
      return;
    }
    const bool boxed = (w.f.region_members[v] & core::boxed_region) != 0u && has_boxes(w, v);
    w.f.vertex_position[v] = with_w(xyz(w.f.position[slot]), w.f.mass[slot] / T(region_members(w, v)));
    w.f.vertex_velocity[v] = with_w(xyz(w.f.velocity[slot]), boxed ? T(1) : T(0));
  }
};

/// Lists the vertices whose regions are summed member by member.
template <class T>
struct RaggedBody {
  Frame<T> w;
  MELTSIM_HD bool wanted(std::uint64_t v) const { return moves(w, v) && !is_boxed(w, v); }
};

/// Label of the piece a particle belongs to and, at its surface, its outward normal, in particle order, for contact.
template <class T>
struct NormalsBody {
  static constexpr bool wide = true;
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    w.f.contact_normal[i] = Vec4<T>{};
    w.f.piece[i] = 0u;
    const std::uint32_t tag = w.f.tag[i];
    if (!is_solid(tag)) return;
    const std::uint32_t v = w.f.vertex_of_id[w.f.id[i]];
    w.f.piece[i] = w.f.vertex_piece[v] + 1u;
    if ((tag & tag_surface) == 0u) return;  // no contact
    w.f.contact_normal[i] = normal_at(v, w.f.contact_shape[v], T(popcount(w.f.neighbour_mask[v])));
  }

 private:
  MELTSIM_HD Vec4<T> normal_at(std::uint32_t v, Vec4<T> built, T live) const {
    const Mat3<T> turn = to_matrix(core::turn_of(w, v));
    const bool as_built = physics::is_as_built(built, live);
    if (!core::deforms(w, w.f.vertex_body[v]))
      return as_built ? physics::built_normal(built, live, turn)
                      : physics::surface_normal(w.f.neighbour_mask[v], turn);
    const Deformed d = deformed(v);
    const Vec3<double> n = physics::deformed_normal(d.moved, d.built, cast<double>(xyz(built)));
    const double size = length(n);
    if (!as_built || !(size > 1e-6)) return physics::outward_normal(cast<T>(d.inward), live, turn);
    return physics::built_normal(
        with_w(cast<T>(n * (static_cast<double>(length(xyz(built))) / size)), built.w), live, turn);
  }

  /// Offsets d' of v's live direct neighbours in the frame of its body, which deforms, in units of the spacing, and those as built, d.
  struct Deformed {
    Vec3<double> inward{};          ///< sum of d'
    Mat3<double> moved{}, built{};  ///< sums of d' d^T and d d^T
  };
  MELTSIM_HD Deformed deformed(std::uint32_t v) const {
    const std::uint32_t body = w.f.vertex_body[v], mask = w.f.neighbour_mask[v];
    const core::BodyMotionRow& row = w.f.body_motion[body];
    const double time = w.f.clock->time;
    const Vec3<double> here = core::deformed_point(w, v, row, time).position;
    Deformed sum;
    for (int bit = 0; bit < 27; ++bit) {
      if (((mask >> bit) & 1u) == 0u) continue;
      const int dx = bit % 3 - 1, dy = bit / 3 % 3 - 1, dz = bit / 9 - 1;
      const std::uint32_t n =
          w.f.site_vertex[core::site_at(w.f.vertex_site[v], w.f.bodies[body], dx, dy, dz)];
      if (!core::is_vertex(n)) continue;  // across a periodic face
      const Vec3<double> d{double(dx), double(dy), double(dz)},
          now = (core::deformed_point(w, n, row, time).position - here) * (1 / row.spacing);
      sum.inward += now;
      add_outer(sum.moved, 1.0, now, d);
      add_outer(sum.built, 1.0, d, d);
    }
    return sum;
  }
};

/// Gravity and the walls' contact on every solid particle.
template <class T>
struct LoadsBody {
  static constexpr bool wide = true;
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    if (!is_solid(tag)) return;
    w.f.slip_next[i] = Vec4<T>{};
    if ((tag & tag_fixed) != 0u) {
      w.f.acceleration[i] = Vec3<T>{};
      return;
    }
    const Vec3<T> x = xyz(w.f.position[i]), v = xyz(w.f.velocity[i]);
    const Vec3<T> slip = core::slip_of(w, i);
    Vec3<T> force = core::seepage_on(w, i, tag, x), slips{};
    T touched = 0;
    for (int k = 0; k < 6; ++k) {
      const core::WallContact<T> c = core::wall_contact(w, i, tag, x, v, slip, k);
      if (!c.touches) continue;
      force += c.response.force;
      slips += c.response.slip;
      touched += T(1);
    }
    w.f.slip_next[i] = with_w(slips, touched);
    w.f.acceleration[i] = w.f.clock->gravity + force * (T(1) / w.f.mass[i]);
  }
};

/// Lists the particles that can be in contact: those at the surfaces of movable bodies.
template <class T>
struct MeetingBody {
  Frame<T> w;
  MELTSIM_HD bool wanted(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    return is_solid(tag) && (tag & (tag_surface | tag_fixed)) == tag_surface;
  }
};

template <class T>
struct ContactSum {
  Vec3<T> force{}, slips{};
  T touched{};
  MELTSIM_HD void add(const ContactSum& o) {
    force += o.force;
    slips += o.slips;
    touched += o.touched;
  }
};

/// Contact with particles of other pieces, and what the liquid in the gap to them presses with.
template <class T, bool Periodic>
struct ContactBody {
  static constexpr bool wide = true;
  Frame<T> w;
  using Sum = ContactSum<T>;
  MELTSIM_HD bool wanted(std::uint64_t i) const { return MeetingBody<T>{w}.wanted(i); }
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    Sum s;
    const core::Toucher<T> own = core::toucher(w, i);
    const bool wet = w.f.gap_push != nullptr;
    const core::GapSide<T> side = wet ? core::gap_side(w, i) : core::GapSide<T>{};
    spatial::sweep_part<Periodic>(w, i, k, parts,
                                  [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& x_ij, T r2) {
                                    if (wet) s.force += core::gap_force(w, side, j, xj.w, x_ij, r2);
                                    const core::PairContact<T> c = core::pair_contact(w, own, j, x_ij, r2);
                                    if (!(c.weight > T(0))) return;
                                    s.force += c.response.force;
                                    s.slips += c.response.slip * c.weight;
                                    s.touched += c.weight;
                                  });
    return s;
  }
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const {
    w.f.acceleration[i] += s.force * (T(1) / w.f.mass[i]);
    const Vec4<T> walls = w.f.slip_next[i];
    w.f.slip_next[i] = with_w(xyz(walls) + s.slips, walls.w + s.touched);
  }
};

/// Parts of a listed sum over a region: its layers in z, at the usual half-width of 2.
inline constexpr std::uint32_t ragged_parts = 5;

/// Best rigid placement and motion of every region, member by member.
template <class T>
struct RegionMotionBody {
  static constexpr bool wide = true;
  Frame<T> w;
  static constexpr bool shared = true;
  static constexpr std::uint32_t listed_parts = ragged_parts;
  MELTSIM_HD bool wanted(std::uint64_t v) const { return RaggedBody<T>{w}.wanted(v); }
  struct Sum : physics::RegionSums<T> {
    MELTSIM_HD void add(const Sum& o) { physics::add_sums(*this, o); }
  };
  MELTSIM_HD Sum part(std::uint64_t v, std::uint32_t k, std::uint32_t parts) const {
    Sum sums;
    if (!moves(w, v)) return sums;
    const Vec3<T> x = xyz(w.f.vertex_position[v]), velocity = xyz(w.f.vertex_velocity[v]);
    core::for_each_member(w, static_cast<std::uint32_t>(v), k, parts,
                          [&](std::uint32_t j, int dx, int dy, int dz) {
                            const Vec4<T> xj = w.f.vertex_position[j];
                            const Vec3<T> q = Vec3<T>{T(dx), T(dy), T(dz)} * w.c.spacing;
                            physics::add_member<T>(sums, xj.w, spatial::separation(w.grid, xyz(xj), x), q,
                                                   xyz(w.f.vertex_velocity[j]) - velocity);
                          });
    return sums;
  }
  MELTSIM_HD void finish(std::uint64_t v, const Sum& sums) const {
    if (!moves(w, v)) return;
    physics::RegionFit<T> fit = physics::fit_region<T>(sums, w.f.region_rotation[v]);
    fit.velocity += xyz(w.f.vertex_velocity[v]);
    core::put_fit(w, v, {fit, xyz(w.f.vertex_position[v])});
  }
};

/// alpha of a vertex at this step: as given, or from the modulus of its material.
template <class T>
MELTSIM_HD T stiffness(const Frame<T>& w, std::uint64_t v, const physics::MaterialRow<T>& m) {
  if (!(m.modulus_rate > T(0)))
    return physics::stiffness_of_step(m.shape_stiffness, w.f.clock->dt, w.f.clock->spring_dt);
  const T wave_speed2 = static_cast<T>(w.f.bodies[w.f.vertex_body[v]].wave_speed2);
  return minimum(physics::modulus_stiffness(m.modulus_rate, wave_speed2, w.f.clock->dt), T(1));
}

template <class T>
struct GoalSum {
  Vec3<T> displacement{}, defect{};
  T count{};
  MELTSIM_HD void add(const GoalSum& o) {
    displacement += o.displacement;
    defect += o.defect;
    count += o.count;
  }
};

/// Mean goal of a vertex over its regions, region by region.
template <class T>
struct GoalsBody {
  static constexpr bool wide = true;
  Frame<T> w;
  static constexpr bool shared = true;
  static constexpr std::uint32_t listed_parts = ragged_parts;
  MELTSIM_HD bool wanted(std::uint64_t v) const { return RaggedBody<T>{w}.wanted(v); }
  using Sum = GoalSum<T>;
  MELTSIM_HD Sum part(std::uint64_t v, std::uint32_t k, std::uint32_t parts) const {
    Sum s;
    if (!moves(w, v)) return s;
    const Vec3<T> x = xyz(w.f.vertex_position[v]), velocity = xyz(w.f.vertex_velocity[v]);
    // Membership is symmetric: v is in the region of r exactly if r is in the region of v.
    core::for_each_member(w, static_cast<std::uint32_t>(v), k, parts,
                          [&](std::uint32_t r, int dx, int dy, int dz) {
                            const core::PlacedFit<T> p = core::get_fit(w, r);
                            const Vec3<T> q = Vec3<T>{T(-dx), T(-dy), T(-dz)} * w.c.spacing;
                            const Vec3<T> u = spatial::separation(w.grid, x, p.position);
                            s.displacement += physics::goal_displacement(p.fit, q, u);
                            s.defect += physics::rigid_velocity_defect(p.fit, u, velocity);
                            s.count += T(1);
                          });
    return s;
  }
  MELTSIM_HD void finish(std::uint64_t v, const Sum& s) const {
    if (!moves(w, v)) return;
    const auto& m = w.f.materials[material_of(w.f.tag[w.f.slot_of_id[w.f.vertex_id[v]]])];
    const T damping = m.shape_damping * (w.f.clock->dt / w.f.clock->spring_dt);
    w.f.shape_velocity[v] =
        physics::shape_velocity(stiffness(w, v, m), damping, w.f.clock->dt, s.displacement * (T(1) / s.count),
                                s.defect * (T(1) / s.count));
  }
};

/// Position of a vertex relative to the label of its piece [m].
template <class T>
MELTSIM_HD Vec3<double> place_in_piece(const Frame<T>& w, std::uint64_t v, std::uint32_t label) {
  const Vec3<T> d = spatial::separation(w.grid, xyz(w.f.vertex_position[v]), xyz(w.f.vertex_position[label]));
  return core::offset_in_piece(w, cast<double>(d), v, label,
                               [&w](std::uint64_t of) { return w.f.region_rotation[of]; });
}

/// Adds a vertex to the sums of its piece, exactly. Positions are relative to the piece's label vertex.
template <class T>
struct PieceSumsBody {
  Frame<T> w;
  using Sum = core::PieceSums;
  /// The row of the vertex, or none.
  MELTSIM_HD std::uint32_t operator()(std::uint64_t v, Sum& s) const {
    if (!moves(w, v)) return none;
    const Vec3<double> dv = cast<double>(w.f.shape_velocity[v]);
    if (!finite(dv)) return none;  // step.integrate reports it
    const std::uint32_t label = w.f.vertex_piece[v];
    const double m = static_cast<double>(w.f.mass[w.f.slot_of_id[w.f.vertex_id[v]]]);
    const Vec3<double> u = place_in_piece(w, v, label);
    const Vec3<double> spin = cross(u, dv);
    // Values far beyond the range of the sums are limited to that of an integer; the World then halts anyway.
    constexpr double most = 4e18;
    const auto count = [](double value, const core::SumUnit& unit) {
      return static_cast<std::int64_t>(std::rint(clamp(value * unit.per, -most, most)));
    };
    const core::SumUnits& q = w.sum_units;
    s.mass = count(m, q.mass);
    s.momentum[0] = count(m * dv.x, q.momentum);
    s.momentum[1] = count(m * dv.y, q.momentum);
    s.momentum[2] = count(m * dv.z, q.momentum);
    s.spin[0] = count(m * spin.x, q.spin);
    s.spin[1] = count(m * spin.y, q.spin);
    s.spin[2] = count(m * spin.z, q.spin);
    s.first[0] = count(m * u.x, q.first);
    s.first[1] = count(m * u.y, q.first);
    s.first[2] = count(m * u.z, q.first);
    s.second[0] = count(m * u.x * u.x, q.second);
    s.second[1] = count(m * u.y * u.y, q.second);
    s.second[2] = count(m * u.z * u.z, q.second);
    s.second[3] = count(m * u.y * u.z, q.second);
    s.second[4] = count(m * u.z * u.x, q.second);
    s.second[5] = count(m * u.x * u.y, q.second);
    return label;
  }
};

/// Subtracts the mean motion and mean spin of the piece from the change of velocity.
template <class T>
struct BalanceBody {
  static constexpr bool wide = true;
  Frame<T> w;
  static constexpr bool modest = true;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (!moves(w, v)) return;
    const std::uint32_t label = w.f.vertex_piece[v];
    const physics::RigidResidual r = core::residual_of(w.f.piece_sums[label], w.sum_units);
    const Vec3<double> u = place_in_piece(w, v, label);
    w.f.shape_velocity[v] += cast<T>(physics::residual_correction(r, u));
  }
};

/// Stores rotations and slips as state once the sub-step counts. Vertices may melt meanwhile, so the condition is whether a
/// vertex had a region in this sub-step, not whether it is live.
template <class T>
struct CommitBody {
  Frame<T> w;
  struct Item {
    std::uint32_t members = 0, body = 0, id = 0;
    Quat<T> rotation;
  };
  MELTSIM_HD Item read(std::uint64_t v) const {
    return {w.f.region_members[v], w.f.vertex_body[v], w.f.vertex_id[v], core::fitted_rotation(w, v)};
  }
  MELTSIM_HD void operator()(std::uint64_t v) const { (*this)(v, read(v)); }
  MELTSIM_HD void operator()(std::uint64_t v, const Item& item) const {
    if (item.members == 0u || w.f.bodies[item.body].motion != core::body_free) return;
    w.f.region_rotation[v] = item.rotation;
    const Vec4<T> slip = w.f.slip_next[w.f.slot_of_id[item.id]];
    w.f.contact_slip[v] = slip.w > T(0) ? xyz(slip) * (T(1) / slip.w) : Vec3<T>{};
  }
};

}  // namespace lsm
}  // namespace v0
}  // namespace meltsim
