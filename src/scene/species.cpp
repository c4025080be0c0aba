// SPDX-License-Identifier: Apache-2.0
// Species: materials that dissolve or mix, and the liquids that hold them.
#include <algorithm>
#include <cmath>
#include <string>

#include "description/density_range.hpp"
#include "description/validate.hpp"
#include "engine/text.hpp"
#include "meltsim/physics/solute.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

namespace {
/// Head room of the sweeps over the lattice's exchange, as that of heat. Exceeding it raises StepResult::solute_bound_exceeded.
constexpr double solute_margin = 1.5;
constexpr int most_supersteps = 1000000;
}  // namespace

std::vector<MaterialId> WorldImpl::species_ids() const {
  std::vector<MaterialId> ids;
  for (const std::uint32_t m : species_) ids.push_back({m, number_});
  return ids;
}

/// Index of the species that a material is; species().size() if it is none.
std::size_t WorldImpl::species_of(std::size_t material) const {
  return static_cast<std::size_t>(
      std::find(species_.begin(), species_.end(), static_cast<std::uint32_t>(material)) - species_.begin());
}

/// Whether particles of a body of this material may become liquid.
bool WorldImpl::leaves_lattice(std::size_t material) const {
  return materials[material].melts_into || materials[material].dissolves_in;
}

std::vector<core::SpeciesRow<double>> WorldImpl::species_rows() const {
  std::vector<core::SpeciesRow<double>> rows;
  for (const std::uint32_t i : species_) {
    const MaterialDesc &m = materials[i], &solvent = materials[m.dissolves_in.index];
    core::SpeciesRow<double> r;
    r.solute = i;
    r.solvent = m.dissolves_in.index;
    r.solubility = largest_solubility(m);
    r.saturation = table(m.solubility_points);
    r.volume = 1 / m.density;
    r.solvent_volume = 1 / solvent.density;
    r.diffusivity = m.diffusivity_in;
    r.heat_of_solution = desc.heat.model == HeatModel::enthalpy ? m.heat_of_solution : 0;
    r.log_viscosity = std::log(m.viscosity);
    if (m.transfer_coefficient)
      r.surface_resistivity =
          physics::surface_resistivity(*m.transfer_coefficient, 1 / physics::solution_volume(r, r.solubility),
                                       core::support_of(desc), desc.spacing);
    rows.push_back(r);
  }
  return rows;
}

/// Checks of a species that depend on the rest of the World.
Status WorldImpl::check_species(const MaterialDesc& m) const {
  if (!m.dissolves_in) return {};
  const std::string p = "material \"" + m.name + "\": ";
  if (!valid(m.dissolves_in))
    return invalid(p, "dissolves_in: no such material in this World; add the liquid first and pass its id");
  const MaterialDesc& solvent = materials[m.dissolves_in.index];
  if (solvent.melts_into || solvent.dissolves_in)
    return invalid(p, "dissolves_in: \"", solvent.name, "\" ",
                   solvent.melts_into ? "is a solid (it melts)" : "is a species itself",
                   "; name a liquid, or the liquid that it becomes");
  if (freezes_into(m.dissolves_in.index) < materials.size())
    return invalid(p, "dissolves_in: \"", solvent.name, "\" freezes into \"",
                   materials[freezes_into(m.dissolves_in.index)].name,
                   "\", and a solution cannot freeze; use a liquid that does not");
  if (desc.particle_shifting)
    return invalid(p,
                   "dissolves_in: species need particle_shifting off, since it moves liquid without what "
                   "is dissolved in it; set particle_shifting to false");
  if (species_.size() >= static_cast<std::size_t>(most_species))
    return Error{ErrorCode::capacity, core::text(p, "dissolves_in: a World holds at most ", most_species,
                                                 " species; leave one out")};
  // As check_expansion(): a particle that leaves its body takes the room of the saturated solution.
  constexpr double most = 4;
  const double least = least_solubility(m),
               ratio = least + (1 - least) * m.density / core::least_density(solvent);
  if (least < 1 && ratio > most * (1 + 1e-9))
    return invalid(p, "density: ", m.density, " kg/m^3 is so far above that of \"", solvent.name,
                   "\" that a particle would take ", ratio, " times its room once it is dissolved; at most ",
                   most, " times, or a body bursts");
  return {};
}

/// Mass fractions per species; refuses species that the liquid cannot hold.
Status WorldImpl::check_fractions(const std::string& what, MaterialId liquid,
                                  const std::vector<MassFraction>& fractions, Contents& contents) const {
  const MaterialDesc& solvent = materials[liquid.index];
  if (solvent.dissolves_in) {
    const std::string& of = materials[solvent.dissolves_in.index].name;
    return invalid(what, "material: \"", solvent.name, "\" is a species, which liquid holds; fill with \"",
                   of, "\" and give fractions of \"", solvent.name, "\"");
  }
  contents = {};
  double sum = 0;
  for (const MassFraction& f : fractions) {
    if (!valid(f.material))
      return invalid(what, "fractions: no such material in this World; pass an id from add_material");
    const MaterialDesc& m = materials[f.material.index];
    if (f.material.index == liquid.index)
      return invalid(what, "fractions: \"", solvent.name,
                     "\" is the solvent itself, which is what the fractions leave; leave it out");
    if (!m.dissolves_in || m.dissolves_in.index != liquid.index)
      return invalid(what, "fractions: \"", solvent.name, "\" cannot hold \"", m.name, "\", which ",
                     m.dissolves_in ? "dissolves in \"" + materials[m.dissolves_in.index].name + "\""
                                    : std::string("dissolves in nothing"),
                     "; set its dissolves_in to \"", solvent.name, "\"");
    const double most = largest_solubility(m);
    if (!(f.value >= 0 && f.value <= most))
      return invalid(what, "fractions: \"", m.name, "\": must be in 0..", most, " kg per kg, ",
                     m.solubility_points.empty() ? "its solubility" : "the largest of its solubility_points",
                     ", got ", f.value, "; use less, or raise ",
                     m.solubility_points.empty() ? "solubility" : "solubility_points");
    double& content = contents[species_of(f.material.index)];
    if (content != 0) return invalid(what, "fractions: \"", m.name, "\" is given twice; give it once");
    content = f.value;
    sum += f.value;
  }
  if (sum > 1 + 1e-12)
    return invalid(what, "fractions: they add up to ", sum, " kg per kg, more than there is; lower them");
  return {};
}

/// rho [kg/m^3] of a mixture in a solvent of that density: volumes add up.
double WorldImpl::mixed_density(double solvent, const Contents& fractions) const {
  double rest = 1, volume = 0;
  for (std::size_t k = 0; k < species_.size(); ++k) {
    if (fractions[k] == 0) continue;
    rest -= fractions[k];
    volume += fractions[k] / materials[species_[k]].density;
  }
  return rest == 1 ? solvent : 1 / (rest / solvent + volume);
}

/// 1/rho at its largest (sign 1) or least (sign -1) over all that a solvent may hold [m^3/kg].
double WorldImpl::extreme_volume(std::size_t material, double of_solvent, double sign) const {
  if (!species_used_) return of_solvent;
  double mixed = of_solvent, furthest = of_solvent;
  for (const std::uint32_t k : species_) {
    if (materials[k].dissolves_in.index != material) continue;
    const double own = 1 / materials[k].density, more = (own - of_solvent) * largest_content(materials[k]);
    if (more * sign <= 0) continue;
    mixed += more;
    furthest = sign * std::max(sign * furthest, sign * own);
  }
  return sign * std::min(sign * mixed, sign * furthest);
}

/// Rest densities that a liquid may have, whatever is dissolved in it [kg/m^3].
double WorldImpl::least_density(std::size_t material) const {
  return 1 / extreme_volume(material, 1 / core::least_density(materials[material]), 1);
}
double WorldImpl::largest_density(std::size_t material) const {
  return 1 / extreme_volume(material, 1 / core::largest_density(materials[material]), -1);
}

/// Whether something is dissolved or dissolves, or will be emitted so, according to the state on the host.
bool WorldImpl::species_present() const {
  const auto some = [](double content) { return content != 0; };
  for (std::size_t k = 0; k < species_.size(); ++k)
    if (std::any_of(state_.solute[k].begin(), state_.solute[k].end(), some)) return true;
  return std::any_of(emitters_.begin(), emitters_.end(), [&](const EmitterRecord& e) {
    return emits(e) && std::any_of(e.contents.begin(), e.contents.end(), some);
  });
}

/// Whether all particles that can hold a species hold the same fraction, in the World's precision, and nothing to come differs: an
/// exchange would then change no bit. According to the state on the host.
bool WorldImpl::contents_level() const {
  for (std::size_t k = 0; k < species_.size(); ++k) {
    const std::uint32_t solvent = materials[species_[k]].dissolves_in.index;
    double low = infinity, high = -infinity;
    const auto see = [&](double fraction) {
      round_to_precision(fraction);
      low = std::min(low, fraction);
      high = std::max(high, fraction);
    };
    for (std::size_t i = 0; i < state_.tag.size(); ++i) {
      if (is_solid(state_.tag[i]) && material_of(state_.tag[i]) == species_[k]) return false;
      if (is_fluid(state_.tag[i]) && material_of(state_.tag[i]) == solvent)
        see(state_.solute[k][i] / state_.mass[i]);
    }
    for (const EmitterRecord& e : emitters_)
      if (emits(e) && e.desc.material.index == solvent) see(e.contents[k]);
    for (const BodyRecord& b : bodies_)  // melt without any of it
      if (!b.gone && materials[b.desc.material.index].melts_into == materials[species_[k]].dissolves_in)
        see(0);
    if (high > low) return false;
  }
  return true;
}

/// Whether a body may change temperatures by dissolving. Bodies count as they were built, as in heat_from_outside().
bool WorldImpl::solution_heats() const {
  return desc.heat.model == HeatModel::enthalpy && desc.solute.time_scale > 0 &&
         (disabled_facts_ & core::fact_species) == 0 &&
         std::any_of(bodies_.begin(), bodies_.end(), [this](const BodyRecord& b) {
           const MaterialDesc& m = materials[b.desc.material.index];
           return !b.gone && m.dissolves_in && m.heat_of_solution != 0;
         });
}

/// Whether a body is dissolving, according to the state on the host.
bool WorldImpl::dissolves() const {
  if (!species_used_ || !(desc.solute.time_scale > 0) || (disabled_facts_ & core::fact_species) != 0)
    return false;
  for (std::size_t b = 0; b < census_.live.size(); ++b)
    if (census_.live[b] != 0u && materials[bodies_[b].desc.material.index].dissolves_in) return true;
  return false;
}

/// Whether liquid of a supersaturated solution may become part of a body that is left.
bool WorldImpl::may_precipitate() const {
  if (!dissolves()) return false;
  for (std::size_t b = 0; b < census_.live.size(); ++b)
    if (census_.live[b] != 0u && !materials[bodies_[b].desc.material.index].solubility_points.empty())
      return true;
  return false;
}

/// Contents of a state that the engine holds none of.
void WorldImpl::fill_contents() {
  for (std::size_t k = 0; k < species_.size(); ++k) state_.solute[k].resize(state_.position.size(), 0.0);
}

/// The fastest exchange of a species.
void WorldImpl::limit_solute(double laplacian_sum) {
  solute_lambda_ = 0;
  if (!species_used_) return;
  for (const auto& r : species_rows()) {
    const double most = physics::solution_volume(r, largest_content(materials[r.solute]));
    const double thinnest = std::max(r.solvent_volume, most), densest = std::min(r.solvent_volume, most);
    double a = r.diffusivity / densest;  // rho D
    double margin = solute_margin;
    if (r.surface_resistivity > 0) a = std::max(a, 2 / r.surface_resistivity);
    else if (std::any_of(bodies_.begin(), bodies_.end(),
                         [&](const BodyRecord& b) { return !b.gone && b.desc.material.index == r.solute; }))
      margin = physics::most_front_exchange;
    solute_lambda_ = std::max(solute_lambda_, 2 * margin * a * laplacian_sum * std::max(thinnest, r.volume));
  }
}

/// Explicit steps of at most a weighted mean each: tau lambda = 2.
void WorldImpl::solute_plan(double dt, core::SubstepArguments& a) const {
  const double tau = dt * desc.solute.time_scale;
  a.solute_supersteps = 0;
  a.solute_dt = tau;
  a.solute_bound = infinity;
  a.solute_share = 1;
  if ((facts_ & core::fact_species) == 0) return;
  const double reach = physics::stage_reach(1);
  a.solute_supersteps =
      static_cast<int>(std::clamp(std::ceil(tau * solute_lambda_ / reach), 1.0, double(most_supersteps) + 1));
  a.solute_dt = tau / a.solute_supersteps;
  a.solute_bound = reach / (2 * a.solute_dt);
  a.solute_share = std::clamp(0.5 * a.solute_dt * solute_lambda_, 1e-30, 1.0);
}

/// Refuses a step that would take too long, as for heat: a sub-step cannot be interrupted.
Status WorldImpl::check_solute_work(double dt, const core::SubstepArguments& a) const {
  if (a.solute_supersteps <= desc.solute.max_supersteps) return {};
  const double needed = std::ceil(dt * desc.solute.time_scale * solute_lambda_ / physics::stage_reach(1));
  return Error{ErrorCode::step_too_large,
               core::text("step: dt: species need ", needed, " sweeps in every sub-step of ", dt,
                          " s, more than solute.max_supersteps ", desc.solute.max_supersteps,
                          "; lower solute.time_scale by a factor of ", needed / desc.solute.max_supersteps,
                          " or step by at most ", 0.999 * dt * desc.solute.max_supersteps / needed,
                          " s, or raise solute.max_supersteps")};
}

}  // namespace v0
}  // namespace meltsim
