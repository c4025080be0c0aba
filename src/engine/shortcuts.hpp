// SPDX-License-Identifier: Apache-2.0
// Which work of a sub-step may be done in passing, by the stages that it has (a bit each).
#pragma once

#include "engine/pipeline.hpp"
#include "engine/schedule.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

inline bool has_stage(std::uint64_t stages, int stage) { return ((stages >> stage) & 1u) != 0; }

/// Whether no stage moves particles behind step.integrate, and cells are counted.
inline bool can_count_ahead(std::uint64_t stages) {
  return has_stage(stages, stage_spatial_cells) && has_stage(stages, stage_step_integrate) &&
         !has_stage(stages, stage_topology_freeze);
}

/// Scenes in which sph.advance never runs.
inline constexpr std::uint32_t not_advancing =
    fact_solid | fact_melt | fact_shifting | fact_viscosity | fact_implicit | fact_heat_enthalpy |
    fact_heat_paper | fact_heat_iwasaki | fact_events | fact_species | fact_tension | fact_fields;

/// Whether sph.advance may take the place of sph.forces and step.integrate: nothing runs between them or behind.
inline bool can_advance(std::uint64_t stages) {
  return (stages >> stage_sph_forces) ==
         (std::uint64_t{1} | stage_bit(stage_step_integrate - stage_sph_forces));
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
