// SPDX-License-Identifier: Apache-2.0
// Facts of a scene, which decide the stages of a step.
#include <algorithm>
#include <bitset>
#include <cmath>

#include "description/validate.hpp"
#include "engine/text.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/integrate.hpp"
#include "meltsim/physics/phase_change.hpp"
#include "pipeline/pipeline.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

namespace {
bool insulated(const SurfaceHeatDesc& s) {
  return core::condition_of(s).kind == physics::SurfaceHeat::insulated;
}
}  // namespace

/// Whether layers of it are still to come.
bool WorldImpl::emits(const EmitterRecord& e) const { return e.reservoir() || next_layer(e) < e.layers; }

bool WorldImpl::emitting() const {
  return std::any_of(emitters_.begin(), emitters_.end(), [this](const auto& e) { return emits(e); });
}

/// Whether liquid is or was there, is to be emitted, or can come to be by melting; not whether some is left.
bool WorldImpl::any_liquid() const {
  return (disabled_facts_ & core::fact_fluid) == 0 &&
         std::any_of(liquid_used_.begin(), liquid_used_.end(), [](auto used) { return used != 0u; });
}

/// Whether a region acts at some time in [from, until), or at `from`.
bool WorldImpl::acts(const HeatRegionRecord& r, double from, double until) {
  return (r.desc.from <= from || r.desc.from < until) && r.desc.until > from;
}

/// Whether walls, bodies or regions that act now give off or take heat. Bodies count as they were built: what this decides
/// must not depend on when the host reads what has melted.
bool WorldImpl::heat_from_outside() const {
  if (desc.heat.model != HeatModel::enthalpy) return false;
  const auto& walls = desc.domain.heat;
  return !insulated(desc.heat.free_surface) ||
         std::any_of(heat_regions_.begin(), heat_regions_.end(), [](const auto& r) { return r.acts; }) ||
         std::any_of(bodies_.begin(), bodies_.end(),
                     [](const BodyRecord& b) {
                       return !b.gone && (b.desc.heat_source != 0 || !insulated(b.desc.surface));
                     }) ||
         (desc.domain.bounded &&
          std::any_of(walls.begin(), walls.end(), [](const auto& w) { return !insulated(w); }));
}

bool WorldImpl::host_heats() const {
  return std::any_of(custom_.begin(), custom_.end(), [](const core::PlacedStage& c) {
    return std::find(c.stage.writes.begin(), c.stage.writes.end(), "enthalpy") != c.stage.writes.end();
  });
}

/// Whether temperatures of what is there, and of what is to be emitted, differ by no more than the tolerance.
bool WorldImpl::temperatures_level() {
  LevelRange range;
  const auto rows = material_rows();
  const auto ranges = loops().of_pieces<LevelRange>(state_.position.size(), [&](std::size_t i,
                                                                                std::size_t end) {
    LevelRange r;
    for (; i < end; ++i)
      if (!is_removed(state_.tag[i]))
        r.see(physics::temperature_of(rows[material_of(state_.tag[i])], state_.enthalpy[i] / state_.mass[i]));
    return r;
  });
  for (const LevelRange& r : ranges) {
    range.low = std::min(range.low, r.low);
    range.high = std::max(range.high, r.high);
  }
  for (const EmitterRecord& e : emitters_)
    if (emits(e)) range.see(e.desc.temperature);
  const bool level = is_level(range);
  level_ = level ? std::optional<LevelRange>(range) : std::nullopt;
  return level;
}

bool WorldImpl::is_level(const LevelRange& range) const {
  return !(range.high - range.low > std::max(desc.heat.level_tolerance, range.rounding()));
}

/// Empty when heat flows; otherwise why it does not.
std::string WorldImpl::heat_reason() const {
  if (desc.heat.model == HeatModel::none) return "heat.model is none";
  if (desc.heat.time_scale == 0) return "heat.time_scale is 0";
  if (heat_from_outside() || host_heats() || solution_heats()) return {};
  if (state_.heat_level) {
    const double next = next_region();
    return core::text("temperatures are level to ", desc.heat.level_tolerance, " K and ",
                      std::isfinite(next) ? core::text("no heat region acts before ", next, " s")
                                          : std::string("there is no source"));
  }
  const auto rows = material_rows();
  if (std::none_of(rows.begin(), rows.end(),
                   [](const auto& r) { return r.conductivity > 0 || r.tables != nullptr; }))
    return "no material conducts";
  return {};
}

/// Materials that limits of a sub-step and bounds of heat follow from: all that are or were in the scene, so that limits change when
/// something is added, and do not depend on when the host reads the state.
void WorldImpl::find_materials() {
  liquid_there_.assign(materials.size(), 0);
  solid_used_.assign(materials.size(), 0);
  densest_added_ = 0;
  const auto added = [this](std::size_t m) { densest_added_ = std::max(densest_added_, largest_density(m)); };
  struct Found {
    std::bitset<tag_material_mask + 1> solid, liquid, added;  // by material
  };
  const auto parts = loops().of_pieces<Found>(state_.tag.size(), [this](std::size_t i, std::size_t end) {
    Found found;
    for (; i < end; ++i) {
      const std::uint32_t tag = state_.tag[i];
      ((tag & tag_solid) != 0u ? found.solid : found.liquid).set(material_of(tag));
      if ((tag & tag_solid) == 0u && body_of(tag) == 0)
        found.added.set(material_of(tag));  // melt keeps its body
    }
    return found;
  });
  Found all;
  for (const Found& part : parts) {
    all.solid |= part.solid;
    all.liquid |= part.liquid;
    all.added |= part.added;
  }
  for (std::size_t m = 0; m < materials.size(); ++m) {
    solid_used_[m] = all.solid[m] ? 1 : 0;
    liquid_there_[m] = all.liquid[m] ? 1 : 0;
    if (all.added[m]) added(m);
  }
  for (EmitterRecord& e : emitters_) {
    e.brings = e.brings || emits(e);
    if (e.brings) liquid_there_[e.desc.material.index] = 1;
    added(e.desc.material.index);
  }
  for (const BodyRecord& b : bodies_) solid_used_[b.desc.material.index] = 1;
  weigh_materials();
}

/// Liquid of it is in the scene, or is to be emitted.
void WorldImpl::note_liquid(std::size_t material) { liquid_there_[material] = liquid_used_[material] = 1; }

/// Adds materials that can arise by melting, and what follows from all of them.
void WorldImpl::weigh_materials() {
  liquid_there_.resize(materials.size(), 0);
  liquid_used_ = liquid_there_;
  may_melt_ = could_melt_ || (facts() & core::fact_melt) != 0;
  for (const BodyRecord& b : bodies_) {
    const MaterialDesc& m = materials[b.desc.material.index];
    const MaterialId liquid = m.melts_into ? m.melts_into : m.dissolves_in;
    if (liquid && may_melt_) liquid_used_[liquid.index] = 1;
  }
  double lightest = infinity;
  double densest_liquid = 0;
  int liquids = 0;
  for (std::size_t m = 0; m < materials.size(); ++m) {
    if (!used(m)) continue;
    lightest = std::min(lightest, least_density(m));
    if (liquid_used_[m] == 0u) continue;
    densest_liquid = std::max(densest_liquid, largest_density(m));
    ++liquids;
  }
  for (const BodyRecord& b : bodies_)
    if (b.proxy()) lightest = std::min(lightest, b.density);
  one_liquid_ = liquids <= 1;
  contrast_ = densest_liquid > 0 ? physics::contrast_factor(lightest, densest_liquid) : 1.0;
}

/// Goes through the state, which the host holds.
void WorldImpl::take_census() {
  Census c;
  c.removed = state_.removed;
  c.live.assign(bodies_.size(), 0);
  const auto rows = material_rows();
  const core::HostLoops shared = loops();
  const auto parts = shared.of_pieces<Census>(state_.tag.size(), [&](std::size_t i, std::size_t end) {
    Census part;
    for (; i < end; ++i)
      if (!is_removed(state_.tag[i]))
        count(state_.tag[i], rows, state_.enthalpy[i] / state_.mass[i], part, c.live);
    return part;
  });
  for (const Census& part : parts) {
    c.fluid = c.fluid || part.fluid;
    c.supercooled = c.supercooled || part.supercooled;
    c.molten = c.molten || part.molten;
    c.meltable += part.meltable;
  }
  // A body whose shape already consists of several pieces.
  c.apart = !shared.all_of(state_.vertex_piece.size(), [this](std::size_t v) {
    return state_.vertex_state[v] != core::vertex_live ||
           state_.vertex_piece[v] == state_.vertex_piece[bodies_[lattice_.vertex_body[v]].first_vertex];
  });
  census_ = std::move(c);
}

/// A particle that is there, of this specific enthalpy. live: of all, which several threads set.
void WorldImpl::count(std::uint32_t tag, const std::vector<physics::MaterialRow<double>>& rows, double h,
                      Census& c, std::vector<std::uint8_t>& live) const {
  const auto& m = rows[material_of(tag)];
  if (is_fluid(tag)) {
    c.fluid = true;
    c.supercooled = c.supercooled || physics::freezes(m, h);
  }
  if (!is_solid(tag)) return;
  __atomic_store_n(&live[body_of(tag) - 1], std::uint8_t{1}, __ATOMIC_RELAXED);
  if (!leaves_lattice(material_of(tag))) return;
  ++c.meltable;
  c.molten = c.molten || (m.melts != 0u && physics::liquid_fraction(m, h) >= 1.0);
}

/// The same from the counts of the device, without the state.
void WorldImpl::note(const core::WorldStatus& s) {
  // A reading may be of before the plan was made, or of before one that was taken already.
  if (s.halted != 0 || s.ledger_step < noted_step_) return;
  noted_step_ = s.ledger_step;
  recount(s);
  if ((s.heat_idle & core::idle_level) != 0u && !state_.heat_level) {
    state_.heat_level = true;
    level_.reset();
    census_.molten = (s.heat_pending & core::pending_melt) != 0u;
    census_.supercooled = (s.heat_pending & core::pending_freeze) != 0u;
  }
  // Regions and pieces have yet to follow what melted or froze.
  census_.unsettled = census_.meltable != 0 && (s.pieces_stale != 0u || s.died != 0 || s.born != 0u);
  plan_changed_ = plan_changed_ || facts() != facts_;
}

/// How much there is of what, as the device has counted.
void WorldImpl::recount(const core::WorldStatus& s) {
  const std::uint64_t melted = static_cast<std::uint64_t>(s.melted),
                      removed = static_cast<std::uint64_t>(s.removed);
  const std::uint64_t solid = solids_built_ + s.frozen - melted;
  census_.removed = removed;
  if (s.particles == born_) census_.fluid = s.particles - removed > solid;  // else more is on its way
  std::uint64_t built = 0;
  for (const BodyRecord& b : bodies_)
    if (leaves_lattice(b.desc.material.index)) built += b.vertices - b.taken;
  for (const BodyRecord& b : bodies_) built += static_cast<std::uint64_t>(b.before);
  census_.meltable = built + s.frozen - melted;
  if (census_.meltable == 0)
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      if (leaves_lattice(bodies_[b].desc.material.index)) census_.live[b] = 0;
}

/// Whether liquid is driven by differences that are small beside its pressure, or turns at bodies: by what was described, not by what is
/// left of it, so that results do not depend on when the census is taken.
bool WorldImpl::flows_slowly() const {
  if (species_used_) return true;
  if (!bodies_.empty()) return true;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const MaterialDesc& m = materials[i];
    if (liquid_used_[i] != 0u && (shears(m) || m.surface_tension > 0 || !m.density_points.empty()))
      return true;
  }
  double density = 0;  // [kg/m^3] of the first liquid; another one rises or sinks in it
  for (std::size_t i = 0; i < materials.size(); ++i) {
    if (materials[i].density == density || !may_be_liquid(i)) continue;
    if (density > 0) return true;
    density = materials[i].density;
  }
  return false;
}

bool WorldImpl::has_walls() const {
  const auto& faces = desc.domain.faces;
  return desc.domain.bounded && std::find(faces.begin(), faces.end(), Face::wall) != faces.end();
}

bool WorldImpl::isotropic() const {
  return desc.isotropic_pressure.value_or(flows_slowly() && undamped_liquid() == nullptr);
}

/// Material that can freeze can melt again.
bool WorldImpl::may_freeze() const {
  if (may_precipitate()) return true;
  if (desc.heat.model == HeatModel::none || !(heat_reason().empty() || census_.supercooled)) return false;
  for (std::size_t b = 0; b < census_.live.size(); ++b)
    if (census_.live[b] != 0u && materials[bodies_[b].desc.material.index].freezes) return true;
  return false;
}

/// A melting solid makes liquid that may freeze onto it later.
bool WorldImpl::may_melt(bool freezes) const {
  const bool heat = heat_reason().empty(), model = desc.heat.model != HeatModel::none;
  if (freezes || (census_.meltable != 0 && ((model && (heat || census_.molten)) || dissolves()))) return true;
  return census_.unsettled && (facts_ & core::fact_melt) != 0;
}

core::FactSet WorldImpl::facts_of_bodies(bool melts) const {
  core::FactSet f = 0;
  int bodies = 0, mobile = 0, rigid = 0, deforming = 0;  // held bodies are fixed for the time being
  for (std::size_t b = 0; b < census_.live.size(); ++b) {
    if (census_.live[b] == 0u) continue;
    ++bodies;
    if (!bodies_[b].desc.fixed) ++mobile;
    if (bodies_[b].rigid()) ++rigid;
    else if (!bodies_[b].desc.fixed) ++deforming;
    if (bodies_[b].kinematic()) f |= core::fact_kinematic;
    if (bodies_[b].watched) f |= core::fact_forces;
  }
  if (bodies > 0) f |= core::fact_solid;
  if (mobile > 0) f |= core::fact_mobile;
  if (deforming > 0) f |= core::fact_lattice;
  if (rigid > 0) f |= core::fact_rigid;
  if (mobile > 0 && (bodies > 1 || melts || census_.apart)) f |= core::fact_contact;
  return f;
}

/// Viscosities that are not one number.
core::FactSet WorldImpl::facts_of_viscosity() const {
  core::FactSet f = 0;
  for (std::size_t m = 0; m < materials.size(); ++m) {
    if (liquid_used_[m] == 0u) continue;
    if (!materials[m].viscosity_points.empty()) f |= core::fact_viscosity;
    if (shears(materials[m])) f |= core::fact_viscosity | core::fact_strain;
  }
  for (const std::uint32_t k : species_)
    if (species_used_ && materials[k].viscosity != materials[materials[k].dissolves_in.index].viscosity)
      f |= core::fact_viscosity;
  return f;
}

/// Where there is liquid, or may be.
core::FactSet WorldImpl::facts_of_liquid() const {
  core::FactSet f = core::fact_fluid;
  if (species_used_ && !contents_level_ && desc.solute.time_scale > 0) f |= core::fact_species;
  for (std::size_t m = 0; m < materials.size(); ++m)
    if (liquid_used_[m] != 0u && materials[m].surface_tension > 0) f |= core::fact_tension;
  for (const OutletDesc& outlet : desc.domain.outlets)
    if (outlet.level) f |= core::fact_outlets;
  for (const EmitterRecord& e : emitters_) {
    if (e.reservoir()) f |= core::fact_inlets;
    if (e.ids != 0) f |= core::fact_reserves;
  }
  if (isotropic()) f |= core::fact_isotropic;
  if (desc.particle_shifting) f |= core::fact_shifting;
  if (diffuses_) f |= core::fact_implicit;
  return f;
}

/// Where heat flows.
core::FactSet WorldImpl::facts_of_heat() const {
  core::FactSet f = 0;
  if (desc.heat.model == HeatModel::enthalpy) f |= core::fact_heat_enthalpy;
  if (desc.heat.model == HeatModel::paper) f |= core::fact_heat_paper;
  if (desc.heat.model == HeatModel::iwasaki) f |= core::fact_heat_iwasaki;
  if (heat_from_outside()) f |= core::fact_heat_boundary;
  if ((f & core::fact_heat_enthalpy) != 0 && (f & core::fact_heat_boundary) == 0 && !host_heats() &&
      !solution_heats() && !emitting() && desc.heat.level_tolerance > 0)
    f |= core::fact_levels;
  return f;
}

/// Which stages the census asks for.
core::FactSet WorldImpl::facts() const {
  const bool freezes = may_freeze(), melts = may_melt(freezes);
  core::FactSet f = facts_of_bodies(melts) | facts_of_viscosity();
  if (capacity_ != 0) f |= core::fact_particles;
  if (census_.fluid || emitting() || melts) f |= facts_of_liquid();
  if (heat_reason().empty()) f |= facts_of_heat();
  if (event_watch_) f |= core::fact_events;
  if (melts) f |= core::fact_melt;
  if (freezes) f |= core::fact_freeze;
  f &= ~disabled_facts_;
  if ((f & (core::fact_fluid | core::fact_mobile)) != 0 && any_field()) f |= core::fact_fields;
  if ((f & core::fact_particles) == 0) return f;
  if (has_walls()) f |= core::fact_walls;
  if ((f & core::fact_fluid) == 0) f |= core::fact_dry;
  return f | search_.facts;
}

}  // namespace v0
}  // namespace meltsim
