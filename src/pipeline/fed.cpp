// SPDX-License-Identifier: Apache-2.0
// The compile-time check of the stage table: in every kind of scene, a stage reads only channels that are State, Static, or were
// written by an earlier stage that runs in that scene. Here alone, since it takes compilers a second.
#include "pipeline/pipeline.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {
namespace {

/// Channels that exist before the first stage.
constexpr FieldSet fed_before_stages() {
  FieldSet available = 0;
  for (int i = 0; i < field_count; ++i)
    if (field_table[i].lifetime == Lifetime::State || field_table[i].lifetime == Lifetime::Static ||
        // Kept up to date by topology, built at upload.
        i == field_neighbour_mask || i == field_region_mask || i == field_region_members ||
        i == field_row_live || i == field_site_live)
      available |= FieldSet{1} << i;
  return available;
}

/// Index of the first stage that reads a channel no stage produced in a scene with these facts, or -1.
constexpr int first_unfed_stage(FactSet facts, FieldSet available) {
  for (int i = 0; i < stage_count; ++i) {
    const StageInfo& stage = stage_table[i];
    if ((stage.need & facts) != stage.need) continue;
    if ((stage.reads & ~available) != 0) return i;
    available |= stage.writes;
  }
  return -1;
}

/// mobile: what can move where something can.
constexpr bool pipeline_is_fed(FactSet search, FactSet mobile) {
  constexpr FieldSet before = fed_before_stages();
  for (FactSet facts = 0; facts < fact_packed; ++facts) {
    if (!consistent(facts)) continue;
    const FactSet bodies = (facts & fact_mobile) != 0 ? mobile : 0u;
    constexpr FactSet host = fact_probes | fact_loads | fact_kinematic | fact_implicit | fact_forces |
                             fact_events | fact_species | fact_strain | fact_fields;
    if (first_unfed_stage(facts | bodies | search | host, before) >= 0) return false;
  }
  return true;
}
// Each alone: compilers bound the work of one constant expression.
static_assert(pipeline_is_fed(search_facts[0], fact_lattice | fact_rigid),
              "a stage reads a channel that no earlier stage of that scene produced");
static_assert(pipeline_is_fed(search_facts[1], fact_lattice),
              "a stage reads a channel that no earlier stage of that scene produced");
static_assert(pipeline_is_fed(search_facts[1], fact_rigid),
              "a stage reads a channel that no earlier stage of that scene produced");
static_assert(pipeline_is_fed(search_facts[2], fact_lattice | fact_rigid),
              "a stage reads a channel that no earlier stage of that scene produced");
static_assert(sizeof search_facts / sizeof *search_facts == 3);

}  // namespace
}  // namespace core
}  // namespace v0
}  // namespace meltsim
