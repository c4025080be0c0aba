// SPDX-License-Identifier: Apache-2.0
// Kernels of heat. Every particle, liquid or solid, exchanges with every neighbour.
#pragma once

#include "frame/frame.hpp"
#include "frame/lattice.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/phase_change.hpp"
#include "shared/heat_operand.hpp"
#include "spatial/exchange_sum.hpp"
#include "spatial/lanes.hpp"

namespace meltsim {
inline namespace v0 {
namespace thermal {

using core::exposed;
using core::Frame;
using core::HeatBoundary;
using core::HeatOperand;
using core::operand_at;
using core::unmarked;
using physics::MaterialRow;

/// 1/k of particle i toward a particle of another temperature, times its conduction share [m K/W].
template <class T>
MELTSIM_HD T toward(const Frame<T>& w, std::uint64_t i, const HeatOperand<T>& own, T other) {
  if (!(own.resistivity < T(0))) return own.resistivity;
  return w.f.heat_share[i] * physics::resistivity_of(physics::conductivity_toward(
                                 w.f.materials[material_of(w.f.tag[i])], own.temperature, other));
}

/// Temperature, share and resistivity of every particle.
template <class T>
struct HeatOperandsBody {
  static constexpr bool wide = true;
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    const T share = is_removed(tag) ? T(1) : share_of(i, tag);
    w.f.heat_share[i] = share;
    const MaterialRow<T>& m = w.f.materials[material_of(tag)];
    w.f.heat_operand[i] =
        operand_at(m, w.f.enthalpy[i], w.f.mass[i], share, exposed(tag) || may_freeze(i, tag, m));
  }
  /// Whether a particle of liquid is beside a body of what it freezes to.
  MELTSIM_HD bool may_freeze(std::uint64_t i, std::uint32_t tag, const MaterialRow<T>& m) const {
    if (!is_fluid(tag) || m.freezes == 0u) return false;
    bool beside = false;
    spatial::for_each_neighbour(w, i, [&](std::uint32_t j, const Vec4<T>&, const Vec3<T>&, T) {
      const std::uint32_t other = w.f.tag[j];
      beside = beside || (is_solid(other) && material_of(other) == m.solid);
    });
    return beside;
  }
  /// Walls count as filled as far as they conduct. sph.density counts the images in all walls, and all matter alike.
  MELTSIM_HD T share_of(std::uint64_t i, std::uint32_t tag) const {
    const bool at_surface = exposed(tag);
    const Vec3<T> x = xyz(w.f.position[i]);
    const auto filled = [&](int face) { return wall_filled(face, tag); };
    if (w.f.density != nullptr && !(at_surface && w.f.clock->uneven_conductors != 0u)) {
      const auto empty = [&](int face) { return T(1) - filled(face); };
      return physics::conduction_share(
          w.c.conduction_share,
          w.f.heat_share[i] * (T(1) - physics::wall_cover(w.c.walls, w.c.kernel, x, empty)));
    }
    if (!at_surface) return T(1);  // all direct neighbours are there
    T phi = 0;
    spatial::for_each_neighbour(w, i, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>&, T r2) {
      phi += xj.w * physics::kernel_value(w.c.kernel, std::sqrt(r2)) * neighbour_filled(tag, w.f.tag[j]);
    });
    return physics::conduction_share(w.c.conduction_share,
                                     phi / (T(1) - physics::wall_cover(w.c.walls, w.c.kernel, x, filled)));
  }
  /// What counts here is how conductivities compare, so that of tables is taken at 0 degrees.
  MELTSIM_HD T conductivity(std::uint32_t tag) const {
    return physics::conductivity_at(w.f.materials[material_of(tag)], T(0), T(0));
  }
  MELTSIM_HD T wall_filled(int face, std::uint32_t tag) const {
    if (((w.f.clock->heated_walls >> face) & 1u) == 0u) return T(0);
    return physics::filled_by_wall(w.f.clock->wall_heat[face], conductivity(tag) / (T(0.5) * w.c.spacing));
  }
  MELTSIM_HD T neighbour_filled(std::uint32_t tag, std::uint32_t other) const {
    if (material_of(tag) == material_of(other) || w.f.clock->uneven_conductors == 0u) return T(1);
    if (physics::same_matter(w.f.materials[material_of(tag)], material_of(tag),
                             w.f.materials[material_of(other)], material_of(other)))
      return T(1);
    return physics::filled_by(conductivity(tag), conductivity(other));
  }
};

/// Temperature and resistivity of every particle, for models that do not correct sums.
template <class T>
struct PlainOperandsBody {
  static constexpr bool wide = true;
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    w.f.heat_operand[i] =
        operand_at(w.f.materials[material_of(w.f.tag[i])], w.f.enthalpy[i], w.f.mass[i], T(1), false);
  }
};

/// Heat into particle i from outside at the temperature and conductivity of its operand.
template <class T>
MELTSIM_HD physics::SurfaceRate<T> boundary_heat(const Frame<T>& w, std::uint64_t i,
                                                 const HeatOperand<T>& operand) {
  const std::uint32_t tag = w.f.tag[i];
  const T conductivity = w.f.heat_share[i] / unmarked(operand.resistivity);
  physics::SurfaceRate<T> sum;
  const auto add = [&](const physics::SurfaceCondition<T>& c, T area, T depth) {
    const auto r = core::heat_through(c, area, depth, w.f.materials[material_of(tag)], operand, conductivity);
    sum.rate += r.rate;
    sum.conductance += r.conductance;
  };
  const std::uint32_t walls = w.f.clock->heated_walls;
  if (walls != 0u) {
    const Vec4<T> x = w.f.position[i];
    const physics::FaceDistances<T> d = physics::face_distances(w.c.walls, xyz(x));
    for (int face = 0; face < 6; ++face)
      if (((walls >> face) & 1u) != 0u && d[face] < w.c.wall_exchange.support)
        add(w.f.clock->wall_heat[face], x.w * physics::wall_area(w.c.wall_exchange, d[face]),
            physics::wall_depth(w.c.wall_exchange, d[face]));
  }
  const HeatBoundary<T> b = w.f.heat_boundary[i];
  if (b.area > T(0))
    add(is_solid(tag) ? w.f.body_heat[body_of(tag) - 1u].surface : w.f.clock->free_surface, b.area, b.depth);
  sum.rate += b.source;
  return sum;
}

/// Heat into a particle from its neighbours [W] and its conductance [W/K].
template <class T>
using ExchangeSum = spatial::ExchangeSum<double, T>;

/// Stage j of a super-step: d_j from d_{j-1}, d_{j-2} and the exchange at stage j-1. What each pair exchanges
/// is the same number at both ends; sums are double, so that energy is conserved to rounding in double. The last
/// stage takes the increment into the state: only its own particle reads an enthalpy.
template <class T, bool Boundary, bool Periodic>
struct StageBody {
  Frame<T> w;
  physics::StageFactors<double> stage;
  static constexpr bool shared = true;
  static constexpr std::uint32_t resident_warps(std::uint32_t) {
    return sizeof(T) != sizeof(float) ? 24u : 48u;  // left alone, a compiler takes 32 registers and spills
  }
  using Sum = ExchangeSum<T>;
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    return spatial::sum_part<Periodic>(w, *this, i, k, parts);
  }

  // One pair (spatial/sweep.hpp).
  struct Own {
    HeatOperand<T> operand;
    T volume;
  };
  struct Stored {
    T temperature, resistivities;  ///< of the neighbour; of both ends
  };
  MELTSIM_HD bool takes_part(std::uint64_t i) const { return !is_removed(w.f.tag[i]); }
  MELTSIM_HD Own own(std::uint64_t i) const { return {w.f.heat_operand[i], w.f.position[i].w}; }
  MELTSIM_HD Stored stored(const Own& own, std::uint32_t j) const {
    const HeatOperand<T> other = w.f.heat_operand[j];
    return {other.temperature, own.operand.resistivity + other.resistivity};
  }
  /// The conductivity of a particle that changes phase depends on the particle at the other end.
  MELTSIM_HD void settle(const Own& own, Stored& s, std::uint64_t i, std::uint32_t j) const {
    if (s.resistivities < T(0))
      s.resistivities = toward(w, i, own.operand, s.temperature) +
                        toward(w, j, w.f.heat_operand[j], own.operand.temperature);
  }
  MELTSIM_HD Stored other(const Own&, const Stored& s) const { return s; }
  template <class Along>
  MELTSIM_HD void add(Sum& sum, const Own& own, const Stored& other, const spatial::Pair<T>& pair,
                      Along) const {
    const T g = physics::pair_conductance(
        own.volume, pair.volume, physics::laplacian_quotient(w.c.kernel, std::sqrt(pair.r2), pair.r2),
        other.resistivities);
    sum.rate += static_cast<double>(g * (other.temperature - own.operand.temperature));
    sum.conductance += g;
  }
  struct Lanes {
    spatial::LanePairs<T> pairs;
    Stored at(std::size_t k) const { return {pairs.first[k], pairs.second[k]}; }
    /// settle() of what changes its phase itself for many at a time: one by one they took a fifth of the exchange.
    void load(const StageBody& body, const Own& own, std::uint64_t i, const std::uint32_t* slots,
              std::uint32_t n, const T*) {
      pairs.load(body.w.f.heat_operand, slots, n);
      T *const temperature = pairs.first, *const resistivity = pairs.second;
      if (spatial::any_in_lanes(n, [&](std::size_t k) { return resistivity[k] < T(0); }))
        for (std::uint32_t k = 0; k < n; ++k)
          resistivity[k] = toward(body.w, slots[k], HeatOperand<T>{temperature[k], resistivity[k]},
                                  own.operand.temperature);
      if (!(own.operand.resistivity < T(0)))
        return spatial::in_lanes(
            n, [&](std::size_t, std::size_t k) { resistivity[k] += own.operand.resistivity; });
      const T share = body.w.f.heat_share[i];
      const auto toward_other = physics::toward_neighbour(body.w.f.materials[material_of(body.w.f.tag[i])],
                                                          own.operand.temperature);
      spatial::in_lanes(n, [&](std::size_t, std::size_t k) {
        resistivity[k] += share * physics::resistivity_of(toward_other(temperature[k]));
      });
    }
  };
  template <class Add>
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s, const Add& add) const {
    const std::uint32_t tag = w.f.tag[i];
    if (is_removed(tag)) return pass_over(i);
    const MaterialRow<T>& m = w.f.materials[material_of(tag)];
    const T mass = w.f.mass[i];
    double rate = s.rate, in = 0;
    T conductance = s.conductance;
    if (Boundary) in = add_boundary(i, rate, conductance);
    if (stage.first) {
      const double capacity = static_cast<double>(mass) * minimum(m.heat_capacity, m.liquid_heat_capacity);
      if (static_cast<double>(conductance) > w.c.heat_bound * capacity)
        add(&w.f.status->heat_bound_exceeded, 1);
    }
    double d = physics::next_increment(
        stage, rate, [&] { return w.f.heat_increment[i]; }, [&] { return w.f.heat_increment_old[i]; },
        [&] { return w.f.heat_rate0[i]; });
    double enthalpy = w.f.enthalpy[i] + d;
    // No particle is cooled below 0 K: the missing heat did not leave through the boundary, and the account is corrected.
    // Without a boundary only exchange beyond its stage bound leads there, which sets a flag as well.
    const double coldest = static_cast<double>(mass) * m.coldest, missing = coldest - enthalpy;
    if (missing > 0.0 && std::isfinite(missing) && (Boundary || stage.last)) {
      add(&w.f.status->cooled_to_zero, 1);
      enthalpy = coldest;
      d = coldest - w.f.enthalpy[i];
      in += missing / stage.rate;
      rate += missing / stage.rate;
    }
    if (Boundary) w.f.heat_boundary_rate[i] = in;
    if (stage.first && !stage.last) w.f.heat_rate0[i] = rate;
    if (stage.last) w.f.enthalpy[i] = enthalpy;
    else w.f.heat_increment_old[i] = d;
    if (!stage.ends) w.f.heat_operand_next[i] = operand_after(i, m, enthalpy, mass);
  }
  /// A removed particle exchanges nothing.
  MELTSIM_HD void pass_over(std::uint64_t i) const {
    if (!stage.last) w.f.heat_increment_old[i] = 0.0;
    if (!stage.ends) w.f.heat_operand_next[i] = w.f.heat_operand[i];
    if (Boundary) w.f.heat_boundary_rate[i] = 0.0;
  }
  /// Adds what comes from outside to the rate [W] and the conductance [W/K]. Returns its rate.
  MELTSIM_HD double add_boundary(std::uint64_t i, double& rate, T& conductance) const {
    const auto outside = boundary_heat(w, i, w.f.heat_operand[i]);
    const bool held = w.f.heat_boundary[i].held != 0u;
    const double in = held ? -rate : static_cast<double>(outside.rate);
    conductance = held ? T(0) : conductance + outside.conductance;
    rate += in;
    return in;
  }
  /// Operand of the next stage. Resistivities are those of the beginning of the super-step: the order of the scheme requires
  /// one operator. Those that are marked follow the temperatures at both ends.
  MELTSIM_HD HeatOperand<T> operand_after(std::uint64_t i, const MaterialRow<T>& m, double enthalpy,
                                          T mass) const {
    const std::uint32_t tag = w.f.tag[i];
    const bool beside = is_fluid(tag) && w.f.heat_operand[i].resistivity < T(0);
    if (stage.last) return operand_at(m, enthalpy, mass, w.f.heat_share[i], exposed(tag) || beside);
    return {static_cast<T>(physics::temperature_of(m, enthalpy / static_cast<double>(mass))),
            w.f.heat_operand[i].resistivity};
  }
};

/// A sum in double; the executor's order is fixed.
struct HeatSum {
  double value = 0;
  MELTSIM_HD static HeatSum combine(HeatSum a, HeatSum b) { return {a.value + b.value}; }
};

template <class T>
struct BoundarySumBody {
  Frame<T> w;
  MELTSIM_HD HeatSum operator()(std::uint64_t i) const { return {w.f.heat_boundary_rate[i]}; }
};

/// The recurrence of StageBody for the sum of heat from outside.
template <class T>
struct AccountBody {
  Frame<T> w;
  physics::StageFactors<double> stage;
  MELTSIM_HD void operator()(std::uint64_t) const {
    core::HeatAccount& a = *w.f.heat_account;
    if (stage.first) a.rate0 = a.rate;
    const double d = physics::next_increment(
        stage, a.rate, [&] { return a.increment; }, [&] { return a.increment_old; }, [&] { return a.rate0; });
    a.increment_old = stage.first ? 0.0 : a.increment;
    a.increment = d;
    if (stage.last) a.step += d;
  }
};

/// Dry and free surface, sources and held temperatures of this sub-step. A held particle is set to its temperature
/// here.
template <class T>
struct BoundaryBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    HeatBoundary<T> b;
    w.f.heat_boundary_rate[i] = 0.0;
    const std::uint32_t tag = w.f.tag[i];
    if (is_removed(tag)) {
      w.f.heat_boundary[i] = b;
      return;
    }
    const Vec4<T> x = w.f.position[i];
    if (w.f.body_heat != nullptr && is_solid(tag)) {
      const core::BodyHeat<T>& body = w.f.body_heat[body_of(tag) - 1u];
      b.source = body.source * x.w;
      if ((tag & tag_surface) != 0u && body.surface.kind != physics::SurfaceHeat::insulated) {
        const auto s = surface(i);
        b.area = s.area;
        b.depth = s.depth;
      }
    } else if (is_fluid(tag) && w.f.clock->free_surface.kind != physics::SurfaceHeat::insulated) {
      const auto s = free_surface(i);
      b.area = s.area;
      b.depth = s.depth;
    }
    regions(i, xyz(x), x.w, b);
    w.f.heat_boundary[i] = b;
  }
  /// What heat regions do to the particle.
  MELTSIM_HD void regions(std::uint64_t i, Vec3<T> x, T volume, HeatBoundary<T>& b) const {
    const std::uint32_t tag = w.f.tag[i];
    for (std::uint32_t r = 0; r < w.c.heat_regions; ++r) {
      const core::HeatRegionRow<T>& region = w.f.heat_regions[r];
      if (!w.f.clock->within(region.from, region.until)) continue;
      if (region.moves == core::region_rests) {
        if (!inside(region, x - region.min)) continue;
        b.source += region.source * volume;
      } else {
        const double share = share_inside(region, x);
        if (share == 0) continue;
        b.source += region.source * volume * static_cast<T>(share);
      }
      if (region.held == 0u) continue;
      b.held = 1u;
      const double mass = static_cast<double>(w.f.mass[i]);
      const double target = mass * physics::enthalpy_of(w.f.materials[material_of(tag)], region.temperature);
      w.f.heat_boundary_rate[i] += target - w.f.enthalpy[i];
      w.f.enthalpy[i] = target;
    }
  }
  /// Dry surface of the particle: the part that no liquid, wall or other body covers.
  MELTSIM_HD physics::ParticleSurface<T> surface(std::uint64_t i) const {
    const std::uint32_t body = body_of(w.f.tag[i]), v = w.f.vertex_of_id[w.f.id[i]];
    const Vec3<T> x = xyz(w.f.position[i]);
    const auto flush = physics::flush_walls(w.c.wall_exchange, physics::wall_view(w.c.walls, x),
                                            core::lattice_turn(w, v), w.f.neighbour_mask[v]);
    physics::BodySums<T> s;
    spatial::for_each_neighbour(w, i, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& x_ij, T r2) {
      const std::uint32_t tag = w.f.tag[j];
      s.add(w.c.kernel, flush.view, xj.w, x_ij, r2, is_solid(tag) && body_of(tag) == body);
    });
    s.everything += physics::wall_cover(w.c.walls, w.c.kernel, x, [&](int face) {
      return ((flush.view.axes >> (face / 2)) & 1u) != 0u ? T(0) : T(1);
    });
    auto surface = physics::particle_surface(w.c.wall_exchange, w.f.position[i].w, length(s.G), flush.direct);
    surface.area *= physics::dry_share(s.own, s.everything);
    return surface;
  }
  /// Free surface of a particle of liquid. What sph.density summed is in heat_share until thermal.operands makes a share of it.
  MELTSIM_HD physics::ParticleSurface<T> free_surface(std::uint64_t i) const {
    const Vec4<T> x = w.f.position[i];
    const auto walls = physics::wall_view(w.c.walls, xyz(x));
    Vec3<T> G = physics::walls_part(w.c.wall_exchange, walls);
    spatial::for_each_neighbour(w, i, [&](std::uint32_t, const Vec4<T>& xj, const Vec3<T>& x_ij, T r2) {
      G += physics::opening_part(w.c.kernel, walls, xj.w, x_ij, r2);
    });
    return physics::free_surface(w.c.wall_exchange, w.c.free_layer, x.w, length(G), w.f.heat_share[i],
                                 x.w * physics::kernel_value(w.c.kernel, T(0)));
  }
  /// Share of the sub-step that a region which moves has x in it. It is as in all periods of periodic axes, in which it is looked for.
  MELTSIM_HD double share_inside(const core::HeatRegionRow<T>& r, Vec3<T> x) const {
    double inside_for = 0;
    const auto see = [&](const Vec3d& displacement, double share) {
      Vec3<T> d = x - r.min - cast<T>(displacement);
      d.x -= w.grid.period.x * std::floor(d.x * w.grid.inv_period.x);
      d.y -= w.grid.period.y * std::floor(d.y * w.grid.inv_period.y);
      d.z -= w.grid.period.z * std::floor(d.z * w.grid.inv_period.z);
      if (inside(r, d)) inside_for += share;
    };
    constexpr double apart = 0.25;  // cells
    const double begin = w.f.clock->time, end = w.f.clock->end,
                 length = apart / static_cast<double>(r.inv_cell);
    if (r.moves == core::region_on_path)
      physics::for_each_place(w.f.heat_region_path + r.first_point, r.points, begin, end, length, see);
    else
      physics::for_each_place_between(r.displacement + r.velocity * (begin - r.since),
                                      r.velocity * (end - begin), 1, length, see);
    return inside_for;
  }
  /// d: from the lowest corner of its box.
  MELTSIM_HD bool inside(const core::HeatRegionRow<T>& r, Vec3<T> d) const {
    const auto cell = [&](T d, std::int32_t n) {  // -1 and n stand for all that is outside
      return static_cast<std::int32_t>(clamp(std::floor(d * r.inv_cell), T(-1), static_cast<T>(n)));
    };
    const std::int32_t a = cell(d.x, r.nx), b = cell(d.y, r.ny), c = cell(d.z, r.nz);
    if (a < 0 || b < 0 || c < 0 || a >= r.nx || b >= r.ny || c >= r.nz) return false;
    const std::uint64_t bit =
        (static_cast<std::uint64_t>(c) * static_cast<std::uint64_t>(r.ny) + static_cast<std::uint64_t>(b)) *
            static_cast<std::uint64_t>(r.nx) +
        static_cast<std::uint64_t>(a);
    return ((w.f.heat_region_cells[r.first_word + (bit >> 5)] >> (bit & 31u)) & 1u) != 0u;
  }
};

/// Temperature of a particle, and whether it will change phase without heat flow.
template <class T>
struct SpreadBody {
  Frame<T> w;
  MELTSIM_HD core::HeatSpread operator()(std::uint64_t i) const {
    core::HeatSpread s;
    const std::uint32_t tag = w.f.tag[i];
    if (is_removed(tag)) return s;
    const MaterialRow<T>& m = w.f.materials[material_of(tag)];
    const double h = w.f.enthalpy[i] / static_cast<double>(w.f.mass[i]);
    s.low = s.high = physics::temperature_of(m, h);
    if (is_solid(tag) && m.melts != 0u && physics::liquid_fraction(m, h) >= 1.0)
      s.pending |= core::pending_melt;
    if (is_fluid(tag) && physics::freezes(m, h)) s.pending |= core::pending_freeze;
    return s;
  }
};

/// Ends heat where temperatures are level.
template <class T>
struct LevelBody {
  Frame<T> w;
  MELTSIM_HD void operator()(const core::HeatSpread& s) const {
    core::WorldStatus& status = *w.f.status;
    if (!(s.high - s.low <= w.c.level_tolerance)) return;
    status.heat_idle |= core::idle_level;
    status.heat_pending = s.pending;
  }
};

/// One sweep of eq. (4): T_i runs along the neighbours, T_j stays as it was before the sweep.
template <class T, bool Upwards, bool Periodic>
struct PaperBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    if (is_removed(tag)) {
      w.f.heat_operand_next[i] = w.f.heat_operand[i];
      return;
    }
    const MaterialRow<T>& m = w.f.materials[material_of(tag)];
    const HeatOperand<T> own = w.f.heat_operand[i];
    const T volume = w.f.position[i].w, mass = w.f.mass[i], half = T(0.5) * w.heat_dt;
    T change = 0;
    const auto visit = [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>&, T r2) {
      const HeatOperand<T> other = w.f.heat_operand[j];
      change += physics::paper_pair_update(m.diffusivity, w.f.materials[material_of(w.f.tag[j])].diffusivity,
                                           physics::kernel_laplacian(w.c.kernel, std::sqrt(r2), r2), half,
                                           volume, xj.w, own.temperature + change, other.temperature);
    };
    spatial::for_each_in_row_order<Periodic, Upwards>(w, i, visit);
    const double before = physics::temperature_of(m, w.f.enthalpy[i] / static_cast<double>(mass));
    if (change != T(0))  // a step that changes nothing changes no bit
      w.f.enthalpy[i] =
          static_cast<double>(mass) *
          physics::enthalpy_of(m, physics::not_below_zero(before + static_cast<double>(change)));
    w.f.heat_operand_next[i] = operand_at(m, w.f.enthalpy[i], mass, T(1), false);
  }
};

/// One explicit step of every temperature at once, from the old ones.
template <class T, bool Periodic>
struct IwasakiBody {
  Frame<T> w;
  static constexpr bool shared = true;
  static constexpr std::uint32_t resident_warps(std::uint32_t) { return 0u; }
  using Sum = ExchangeSum<T>;  ///< degrees per second, and 1/s
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    return spatial::sum_part<Periodic>(w, *this, i, k, parts);
  }

  // One pair (spatial/sweep.hpp).
  struct Own {
    T temperature, diffusivity;
  };
  using Stored = Own;
  MELTSIM_HD bool takes_part(std::uint64_t i) const { return !is_removed(w.f.tag[i]); }
  MELTSIM_HD Own own(std::uint64_t i) const {
    return {w.f.heat_operand[i].temperature, w.f.materials[material_of(w.f.tag[i])].diffusivity};
  }
  MELTSIM_HD Stored stored(const Own&, std::uint32_t j) const { return own(j); }
  MELTSIM_HD Stored other(const Own&, const Stored& s) const { return s; }
  template <class Along>
  MELTSIM_HD void add(Sum& sum, const Own& own, const Stored& other, const spatial::Pair<T>& pair,
                      Along) const {
    const T share = physics::explicit_pair_rate(
        own.diffusivity, other.diffusivity,
        physics::kernel_laplacian(w.c.kernel, std::sqrt(pair.r2), pair.r2), pair.volume);
    sum.rate += static_cast<double>(share * (other.temperature - own.temperature));
    sum.conductance += share;
  }
  struct Lanes {
    spatial::LanePairs<T> pairs;
    Stored at(std::size_t k) const { return {pairs.first[k], pairs.second[k]}; }
    void load(const IwasakiBody& body, const Own&, std::uint64_t, const std::uint32_t* slots, std::uint32_t n,
              const T*) {
      for (std::uint32_t k = 0; k < spatial::whole_lanes(n); ++k) {
        const Stored s = body.own(slots[k]);
        pairs.first[k] = s.temperature;
        pairs.second[k] = s.diffusivity;
      }
    }
  };
  template <class Add>
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s, const Add& add) const {
    if (!takes_part(i)) return;
    const MaterialRow<T>& m = w.f.materials[material_of(w.f.tag[i])];
    const T mass = w.f.mass[i];
    if (s.conductance * w.heat_dt > T(1)) add(&w.f.status->heat_bound_exceeded, 1);
    const double before = physics::temperature_of(m, w.f.enthalpy[i] / static_cast<double>(mass));
    const T change = w.heat_dt * static_cast<T>(s.rate);
    const double after = before + static_cast<double>(change);
    if (after < -physics::kelvin_offset) add(&w.f.status->cooled_to_zero, 1);
    if (change != T(0))
      w.f.enthalpy[i] = static_cast<double>(mass) * physics::enthalpy_of(m, physics::not_below_zero(after));
  }
};

}  // namespace thermal
}  // namespace v0
}  // namespace meltsim
