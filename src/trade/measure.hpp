// SPDX-License-Identifier: Apache-2.0
// The knobs of a World, and a probe whose multiples refer to those of another World.
#pragma once

#include "meltsim/trade.hpp"

namespace meltsim {
inline namespace v0 {
namespace trade {

/// Why a probe that met its wall limit is not complete.
inline constexpr const char* too_long = "it took longer than allowed";

/// The settings of a World that the knobs are multiples of.
struct Reference {
  double spacing = 0;      ///< [m]
  double support = 0;      ///< over the spacing
  double sound_speed = 0;  ///< [m/s]
  double courant = 0;
  double stable_dt = 0;  ///< [s] at the start
};

Reference reference_of(World& world);
/// Of the World that the problem makes of Knobs{}; nothing where it runs its probes itself. Errors: those of build.
Result<Reference> reference_to(const Problem& problem);

/// Settings `here` as multiples of those `of` another World; the knobs that no World has stay as asked for.
Knobs multiples(const Reference& here, const Reference& of, const Knobs& asked);

/// Work of a sub-step of this World.
double work_of_substep(World& world, double particles, double dt, double diffusivity);

/// measure(), with multiples of `reference`; null: of the World itself.
Result<Measurement> measure_from(const Problem& problem, const Knobs& knobs, double wall_limit,
                                 const Reference* reference);

}  // namespace trade
}  // namespace v0
}  // namespace meltsim
