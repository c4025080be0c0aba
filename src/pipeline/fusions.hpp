// SPDX-License-Identifier: Apache-2.0
// Fusions: work of one stage that another does in passing. Rows beside the stage table, and the conditions under which they hold in a sub-step
// with certain stages (a bit each).
#pragma once

#include "pipeline/pipeline.hpp"
#include "pipeline/schedule.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Two stages of which one does the other's work.
struct FusionInfo {
  const char* name;
  std::uint64_t stages;  ///< all of them are in the sub-step
  std::uint64_t breaks;  ///< none of them is
  FactSet never;         ///< facts of scenes in which it never holds
  const char* why;
  const char* why_not;
};

enum Fusion : int { fusion_advance, fusion_count_ahead, fusion_count };

inline constexpr FusionInfo fusion_table[fusion_count] = {
    {"sph.advance", stage_bit(stage_sph_forces) | stage_bit(stage_step_integrate),
     // No stage runs between the two or after them.
     ~((stage_bit(stage_sph_forces) << 1) - 1) & ~stage_bit(stage_step_integrate) &
         ((std::uint64_t{1} << (stage_count - 1) << 1) - 1),
     fact_solid | fact_melt | fact_shifting | fact_viscosity | fact_implicit | fact_heat_enthalpy |
         fact_heat_paper | fact_heat_iwasaki | fact_events | fact_species | fact_tension | fact_fields |
         fact_isotropic,
     "a liquid is alone: sph.forces and step.integrate are one sweep",
     "on a GPU, where one liquid is alone and stages of the host's only read, and are recorded"},
    {"step.count_ahead", stage_bit(stage_spatial_cells) | stage_bit(stage_step_integrate),
     stage_bit(stage_topology_freeze) | stage_bit(stage_step_enter),  // move particles behind step.integrate
     0, "step.integrate counts the cells of the next sub-step's spatial.cells",
     "where cells are counted, nothing freezes or comes in to a reserve and stages of the host's move "
     "nothing, and are recorded"}};

inline bool has_stage(std::uint64_t stages, int stage) { return ((stages >> stage) & 1u) != 0; }

/// Whether a fusion may hold in a sub-step of these stages.
inline bool can_fuse_stages(Fusion f, std::uint64_t stages) {
  const FusionInfo& row = fusion_table[f];
  return (stages & row.stages) == row.stages && (stages & row.breaks) == 0;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
