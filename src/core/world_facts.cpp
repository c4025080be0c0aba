// SPDX-License-Identifier: Apache-2.0
// What a scene contains, and so which stages a step needs.
#include <algorithm>
#include <cmath>

#include "core/pipeline.hpp"
#include "core/text.hpp"
#include "core/validate.hpp"
#include "core/world_impl.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/integrate.hpp"
#include "meltsim/physics/phase_change.hpp"

namespace meltsim {
inline namespace v0 {

namespace {
bool insulated(const SurfaceHeatDesc& s) {
  return core::condition_of(s).kind == physics::SurfaceHeat::insulated;
}
}  // namespace

bool WorldImpl::heat_from_outside() const {
  if (desc.heat.model != HeatModel::enthalpy) return false;
  const auto& walls = desc.domain.heat;
  return !heat_regions_.empty() || std::any_of(bodies_.begin(), bodies_.end(), [](const BodyRecord& b) {
    return b.desc.heat_source != 0 || !insulated(b.desc.surface);
  }) || (desc.domain.bounded && std::any_of(walls.begin(), walls.end(), [](const auto& w) {
           return !insulated(w);
         }));
}

/// Empty when heat flows; otherwise why it does not.
std::string WorldImpl::heat_reason() const {
  if (desc.heat.model == HeatModel::none) return "heat.model is none";
  if (desc.heat.time_scale == 0) return "heat.time_scale is 0";
  if (heat_from_outside()) return {};
  bool first = true, differs = false, conducts = false;
  double low = 0, high = 0;
  const auto see = [&](double t) {
    low = first ? t : std::min(low, t);
    high = first ? t : std::max(high, t);
    first = false;
  };
  const auto rows = material_rows();
  for (std::size_t i = 0; i < state_.position.size(); ++i) {
    if (is_removed(state_.tag[i])) continue;
    see(physics::temperature_of(rows[material_of(state_.tag[i])], state_.enthalpy[i] / state_.mass[i]));
  }
  for (const EmitterRecord& e : emitters_)
    if (emits(e)) see(e.desc.temperature);
  for (const auto& r : rows) conducts = conducts || r.conductivity > 0 || r.tables != nullptr;
  // Equal temperatures that went through mass * c * T and back may differ in the last bits.
  differs = high - low > 1e-9 * std::max({1.0, std::fabs(low), std::fabs(high)});
  if (!differs) return "temperatures are uniform and there is no source";
  if (!conducts) return "no material conducts";
  return {};
}

/// Whether layers of it are still to come.
bool WorldImpl::emits(const EmitterRecord& e) const {
  return e.next_layer < e.layers &&
         e.desc.from + double(e.next_layer) * desc.spacing / e.desc.speed < e.desc.until;
}

/// What limits of a sub-step and bounds of heat follow from. Of everything that is or was there, so that they change when
/// something is added, and not with what has melted or left by the time that the host looks.
void WorldImpl::find_materials() {
  liquid_used_.assign(materials.size(), 0);
  solid_used_.assign(materials.size(), 0);
  for (const std::uint32_t tag : state_.tag)
    ((tag & tag_solid) != 0u ? solid_used_ : liquid_used_)[material_of(tag)] = 1;
  for (const EmitterRecord& e : emitters_)
    if (emits(e)) liquid_used_[e.desc.material.index] = 1;
  for (const BodyRecord& b : bodies_) {
    solid_used_[b.desc.material.index] = 1;
    const MaterialId liquid = materials[b.desc.material.index].melts_into;
    if (liquid && may_melt_) liquid_used_[liquid.index] = 1;
  }
  double lightest = infinity, densest_liquid = 0;
  int liquids = 0;
  for (std::size_t m = 0; m < materials.size(); ++m) {
    if (!used(m)) continue;
    lightest = std::min(lightest, materials[m].density);
    if (liquid_used_[m] == 0u) continue;
    densest_liquid = std::max(densest_liquid, materials[m].density);
    ++liquids;
  }
  one_liquid_ = liquids <= 1;
  contrast_ = densest_liquid > 0 ? physics::contrast_factor(lightest, densest_liquid) : 1.0;
}

std::uint32_t WorldImpl::facts() {
  std::uint32_t f = 0;
  bool fluid = std::any_of(emitters_.begin(), emitters_.end(), [this](const auto& e) { return emits(e); });
  bool melts = false, freezing_body = false, supercooled = false;
  std::vector<std::uint8_t> live(bodies_.size(), 0);
  const auto rows = material_rows();
  const bool heat = heat_reason().empty();
  for (std::size_t i = 0; i < state_.tag.size(); ++i) {
    const std::uint32_t tag = state_.tag[i];
    if (is_removed(tag)) continue;
    if (is_fluid(tag)) {
      fluid = true;
      supercooled =
          supercooled || physics::freezes(rows[material_of(tag)], state_.enthalpy[i] / state_.mass[i]);
    }
    if (!is_solid(tag)) continue;
    live[body_of(tag) - 1] = 1;
    const auto& m = rows[material_of(tag)];
    freezing_body = freezing_body || materials[material_of(tag)].freezes;
    if (m.melts != 0u && desc.heat.model != HeatModel::none &&
        (heat || physics::liquid_fraction(m, state_.enthalpy[i] / state_.mass[i]) >= 1.0))
      melts = true;
  }
  // What can freeze can melt again, and the solid makes the liquid that may freeze onto it later.
  const bool freezes = freezing_body && desc.heat.model != HeatModel::none && (heat || supercooled);
  melts = melts || freezes;
  may_melt_ = may_melt_ || melts;
  find_materials();
  int bodies = 0, mobile = 0;
  for (std::size_t b = 0; b < live.size(); ++b)
    if (live[b]) {
      ++bodies;
      if (!bodies_[b].desc.fixed) ++mobile;
    }
  bool apart = false;  // a body whose shape already consists of several pieces
  for (std::size_t v = 0; v < state_.vertex_piece.size(); ++v)
    apart = apart ||
            (state_.vertex_state[v] == 1u &&
             state_.vertex_piece[v] != state_.vertex_piece[bodies_[lattice_.vertex_body[v]].first_vertex]);
  if (!state_.tag.empty() || fluid) f |= core::fact_particles;
  if (fluid || melts) f |= core::fact_fluid;
  if (bodies > 0) f |= core::fact_solid;
  if (mobile > 0) f |= core::fact_mobile;
  if (mobile > 0 && (bodies > 1 || melts || apart)) f |= core::fact_contact;
  if (melts) f |= core::fact_melt;
  if (freezes) f |= core::fact_freeze;
  if (heat && desc.heat.model == HeatModel::enthalpy) f |= core::fact_heat_enthalpy;
  if (heat && desc.heat.model == HeatModel::paper) f |= core::fact_heat_paper;
  if (heat && desc.heat.model == HeatModel::iwasaki) f |= core::fact_heat_iwasaki;
  for (std::size_t m = 0; m < materials.size(); ++m)
    if (liquid_used_[m] != 0u && !materials[m].viscosity_points.empty()) f |= core::fact_viscosity;
  if (desc.particle_shifting) f |= core::fact_shifting;
  if (heat && heat_from_outside()) f |= core::fact_heat_boundary;
  f &= ~disabled_facts_;
  if ((f & core::fact_particles) == 0) return f;
  if ((f & core::fact_fluid) == 0) f |= core::fact_dry;
  const std::uint64_t particles = state_.position.size() + planned_emission();
  search_ = core::choose_search(desc, core::support_of(desc), particles);
  return f | search_.facts;
}

}  // namespace v0
}  // namespace meltsim
