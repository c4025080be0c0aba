// SPDX-License-Identifier: Apache-2.0
// Kernels of species: liquid of the solvent and bodies of the species exchange it; everything else keeps out.
#pragma once

#include "frame/frame.hpp"
#include "shared/heat_operand.hpp"
#include "shared/solute_state.hpp"
#include "spatial/exchange_sum.hpp"
#include "spatial/lanes.hpp"

namespace meltsim {
inline namespace v0 {
namespace species {

using core::Frame;
using core::HeatOperand;
using core::SpeciesRow;

/// Whether a particle can hold a species.
template <class T>
MELTSIM_HD bool holds(const SpeciesRow<T>& s, std::uint32_t tag) {
  return is_solid(tag) ? material_of(tag) == s.solute : is_fluid(tag) && material_of(tag) == s.solvent;
}

/// Whether a body of species k lies beside the liquid at slot i.
template <class T>
MELTSIM_HD bool beside_body(const Frame<T>& w, std::uint32_t k, std::uint64_t i) {
  const T reach = T(physics::crystal_reach) * w.c.spacing;
  bool beside = false;
  spatial::for_each_neighbour(w, i, [&](std::uint32_t j, const Vec4<T>&, const Vec3<T>&, T r2) {
    beside = beside || (r2 <= reach * reach && is_solid(w.f.tag[j]) &&
                        material_of(w.f.tag[j]) == w.f.species[k].solute);
  });
  return beside;
}

/// Species k at slot i, of a particle that can hold it.
struct Content {
  double fraction{}, saturation{};  ///< w, w_s
  bool crystal{};                   ///< of a body, or supersaturated beside one
  physics::SoluteDrive drive;
};

/// Heat above 0 K at slot i [J/kg].
template <class T>
MELTSIM_HD double heat_at(const Frame<T>& w, std::uint64_t i) {
  return w.f.enthalpy[i] / static_cast<double>(w.f.mass[i]) - w.f.materials[material_of(w.f.tag[i])].coldest;
}

template <class T>
MELTSIM_HD Content content_at(const Frame<T>& w, std::uint32_t k, std::uint64_t i, std::uint32_t tag) {
  const SpeciesRow<T>& s = w.f.species[k];
  Content c{core::fraction_at(w, k, i), core::saturation_at(w, k, i), is_solid(tag), {}};
  if (!c.crystal && physics::precipitates(s) && c.fraction > c.saturation) c.crystal = beside_body(w, k, i);
  c.drive.potential = physics::solute_potential(c.fraction, c.saturation, c.crystal);
  if (c.crystal && physics::precipitates(s)) c.drive.room = physics::crystal_room(c.fraction);
  if (s.heat_of_solution != 0.0)
    physics::limit_by_heat(s, c.fraction, is_solid(tag), heat_at(w, i), w.solute_share, c.drive);
  return c;
}

/// r of slot i, where it counts for any species.
template <class T>
MELTSIM_HD void set_room(const Frame<T>& w, std::uint64_t i, double room) {
  if (w.solute_rooms) w.f.solute_room[i] = static_cast<T>(room);
}

/// Potential and resistivity of slot i, which holds species k. Along surfaces the sum over neighbours lacks those beyond: the
/// resistivity is corrected as that of heat is, with walls and everything that cannot hold the species counted as empty. That of crystals is
/// of the whole pair, and marked; a transfer coefficient is of a plane face in full, so that only walls are missing there.
template <class T>
MELTSIM_HD HeatOperand<T> solute_operand(const Frame<T>& w, std::uint32_t k, std::uint64_t i,
                                         const Content& content) {
  const SpeciesRow<T>& s = w.f.species[k];
  const T potential = static_cast<T>(content.drive.potential);
  if (content.crystal && s.surface_resistivity > T(0))
    return {potential,
            core::marked(s.surface_resistivity *
                         physics::conduction_share(
                             w.c.conduction_share,
                             T(1) - physics::wall_cover(w.c.walls, w.c.kernel, xyz(w.f.position[i]))))};
  T phi = 0;
  spatial::for_each_neighbour(w, i, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>&, T r2) {
    if (holds(s, w.f.tag[j])) phi += xj.w * physics::kernel_value(w.c.kernel, std::sqrt(r2));
  });
  const T share = physics::conduction_share(w.c.conduction_share, phi);
  if (!content.crystal)
    return {potential, share * static_cast<T>(physics::solute_resistivity(s, content.fraction))};
  return {potential, core::marked(share * static_cast<T>(physics::front_resistivity(s, content.fraction,
                                                                                    content.saturation)))};
}

/// Potential and resistivity of every particle.
template <class T>
struct SoluteOperandsBody {
  static constexpr bool wide = true;
  Frame<T> w;
  std::uint32_t k;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    if (!holds(w.f.species[k], tag)) {
      w.f.solute_operand[i] = {T(0), physics::resistivity_of(T(0))};
      return set_room(w, i, 1.0);
    }
    const Content content = content_at(w, k, i, tag);
    set_room(w, i, content.drive.room);
    w.f.solute_operand[i] = solute_operand(w, k, i, content);
  }
};

/// Exchange of a particle with its neighbours [kg/s], and its conductance [kg/s].
template <class T>
using ExchangeSum = spatial::ExchangeSum<double, T>;

/// One explicit step of species k. What each pair exchanges is the same number at both ends; sums are double, so that the
/// species is conserved to rounding in double. Only its own particle reads a content, so it is changed in place.
/// Limited: a species precipitates or has a heat of solution, and particles take in what they have room for.
template <class T, bool Periodic, bool Limited>
struct ExchangeBody {
  Frame<T> w;
  std::uint32_t k;
  double dt;    ///< [s]
  bool begins;  ///< the first of the sub-step
  static constexpr bool shared = true;
  static constexpr std::uint32_t resident_warps(std::uint32_t) {
    return sizeof(T) != sizeof(float) ? 24u : 48u;
  }
  using Sum = ExchangeSum<T>;
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t part, std::uint32_t parts) const {
    return spatial::sum_part<Periodic>(w, *this, i, part, parts);
  }

  // One pair (spatial/sweep.hpp).
  struct Own {
    HeatOperand<T> operand;
    T volume, room;
    T saturated;  ///< 1/(rho D) [m s/kg]; 0 where a transfer coefficient says what crosses a front
  };
  struct Stored {
    T potential, resistivities;  ///< of the neighbour; of both ends, or marked, across a front
    T room;                      ///< of the neighbour
  };
  MELTSIM_HD bool takes_part(std::uint64_t i) const { return holds(w.f.species[k], w.f.tag[i]); }
  MELTSIM_HD T room_at(std::uint64_t i) const { return Limited ? w.f.solute_room[i] : T(1); }
  MELTSIM_HD Own own(std::uint64_t i) const {
    const SpeciesRow<T>& s = w.f.species[k];
    const T saturated = static_cast<T>(physics::solute_resistivity(s, s.solubility));
    return {w.f.solute_operand[i], w.f.position[i].w, room_at(i),
            s.surface_resistivity > T(0) ? T(0) : saturated};
  }
  MELTSIM_HD Stored stored(const Own& own, std::uint32_t j) const {
    const HeatOperand<T> other = w.f.solute_operand[j];
    return {other.temperature, own.operand.resistivity + other.resistivity, room_at(j)};
  }
  MELTSIM_HD Stored other(const Own&, const Stored& s) const { return s; }
  template <class Along>
  MELTSIM_HD void add(Sum& sum, const Own& own, const Stored& other, const spatial::Pair<T>& pair,
                      Along) const {
    const T r = std::sqrt(pair.r2), both = core::unmarked(other.resistivities);
    const T front =
        physics::across_front(both, own.saturated, w.c.spacing, r, own.operand.temperature, other.potential);
    const T g = physics::pair_conductance(own.volume, pair.volume,
                                          physics::laplacian_quotient(w.c.kernel, r, pair.r2),
                                          own.saturated > T(0) && other.resistivities < T(0) ? front : both);
    T drive = other.potential - own.operand.temperature;
    if constexpr (Limited)
      drive = physics::limited_drive(own.operand.temperature, own.room, other.potential, other.room);
    sum.rate += static_cast<double>(g * drive);
    sum.conductance += g;
  }
  struct Lanes {
    spatial::LanePairs<T> pairs;
    T room[Limited ? spatial::batch + spatial::lanes : 1];
    Stored at(std::size_t n) const { return {pairs.first[n], pairs.second[n], Limited ? room[n] : T(1)}; }
    void load(const ExchangeBody& body, const Own& own, std::uint64_t, const std::uint32_t* slots,
              std::uint32_t n, const T*) {
      pairs.load(body.w.f.solute_operand, slots, n);
      T* const resistivity = pairs.second;
      spatial::in_lanes(n, [&](std::size_t, std::size_t l) { resistivity[l] += own.operand.resistivity; });
      if constexpr (Limited)
        for (std::uint32_t l = 0; l < spatial::whole_lanes(n); ++l) room[l] = body.w.f.solute_room[slots[l]];
    }
  };
  template <class Add>
  MELTSIM_HD void finish(std::uint64_t i, const Sum& sum, const Add& add) const {
    if (!takes_part(i)) return;
    const auto mass = static_cast<double>(w.f.mass[i]);
    if (begins && static_cast<double>(sum.conductance) > w.solute_bound * mass)
      add(&w.f.status->solute_bound_exceeded, 1);
    double& content = core::solute_at(w, k, i);
    const double before = content, after = before + sum.rate * dt;
    content = after;
    if constexpr (Limited)
      if (w.f.species[k].heat_of_solution != 0.0) take_heat(i, before, after, add);
  }
  /// Heat of solution as a content changes. Only crowds that exchange more in a sweep than it is meant for could still cool below 0 K:
  /// they are held there.
  template <class Add>
  MELTSIM_HD void take_heat(std::uint64_t i, double before, double after, const Add& add) const {
    const SpeciesRow<T>& s = w.f.species[k];
    const bool solid = is_solid(w.f.tag[i]);
    const auto mass = static_cast<double>(w.f.mass[i]);
    physics::SoluteDrive drive{physics::solute_potential(before / mass, s.solubility, solid)};
    const bool lasts = physics::limit_by_heat(s, before / mass, solid, heat_at(w, i), w.solute_share, drive);
    double& enthalpy = w.f.enthalpy[i];
    enthalpy += s.heat_of_solution *
                (physics::undissolved(s, after, mass, solid) - physics::undissolved(s, before, mass, solid));
    const double coldest = mass * w.f.materials[material_of(w.f.tag[i])].coldest;
    const bool held = enthalpy < coldest;
    if (held) enthalpy = coldest;
    if (held || !lasts) add(&w.f.status->cooled_to_zero, 1);
  }
};

/// Potentials, resistivities of crystals and room from the present contents, for the next step.
template <class T>
struct PotentialBody {
  static constexpr bool wide = true;
  Frame<T> w;
  std::uint32_t k;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t tag = w.f.tag[i];
    if (!holds(w.f.species[k], tag)) return;
    const Content content = content_at(w, k, i, tag);
    set_room(w, i, content.drive.room);
    if (content.crystal) w.f.solute_operand[i] = solute_operand(w, k, i, content);
    else w.f.solute_operand[i].temperature = static_cast<T>(content.drive.potential);
  }
};

}  // namespace species
}  // namespace v0
}  // namespace meltsim
