// SPDX-License-Identifier: Apache-2.0
// From a scene to the work of a step: facts, constants, sub-steps, heat stages.
#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/pipeline.hpp"
#include "core/text.hpp"
#include "core/validate.hpp"
#include "core/world_impl.hpp"
#include "meltsim/physics/fluid.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/integrate.hpp"
#include "meltsim/physics/phase_change.hpp"
#include "meltsim/physics/shape_matching.hpp"
#include "meltsim/physics/sph_kernels.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

namespace {
/// Crowded neighbourhoods (splashes, a melted particle beside a larger one) exchange faster than the lattice;
/// this head room keeps the heat stages stable. Exceeding it raises StepResult::heat_bound_exceeded.
constexpr double heat_margin = 1.5;

double largest_viscosity(const MaterialDesc& m) {
  double mu = m.viscosity_points.empty() ? m.viscosity : 0;
  for (const PropertyPoint& p : m.viscosity_points) mu = std::max(mu, p.value);
  return mu;
}

double least_density(const MaterialDesc& m) {
  double rho = m.density;
  for (const PropertyPoint& p : m.density_points) rho = std::min(rho, p.value);
  return rho;
}

double largest_conductivity(const core::MaterialRow<double>& m) {
  double k = std::max(m.conductivity, m.liquid_conductivity);
  if (m.tables == nullptr) return k;
  for (const auto* t : {&m.tables->conductivity, &m.tables->liquid_conductivity})
    for (std::uint32_t p = 0; p < t->points; ++p) k = std::max(k, t->value[p]);
  return k;
}
}  // namespace

bool WorldImpl::heat_from_outside() const {
  if (desc.heat.model != HeatModel::enthalpy) return false;
  core::SceneConstants c;
  fill_heat_boundary(c);
  return !c.heat_regions.empty() || !c.body_heat.empty() ||
         std::any_of(c.wall_heat.begin(), c.wall_heat.end(),
                     [](const auto& w) { return w.kind != physics::SurfaceHeat::insulated; });
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
  for (const EmitterRecord& e : emitters_) see(e.desc.temperature);
  for (const auto& r : rows) conducts = conducts || r.conductivity > 0 || r.tables != nullptr;
  // Equal temperatures that went through mass * c * T and back may differ in the last bits.
  differs = high - low > 1e-9 * std::max({1.0, std::fabs(low), std::fabs(high)});
  if (!differs) return "temperatures are uniform and there is no source";
  if (!conducts) return "no material conducts";
  return {};
}

std::uint32_t WorldImpl::facts() {
  std::uint32_t f = 0;
  bool fluid = !emitters_.empty(), melts = false, freezing_body = false, supercooled = false;
  std::vector<std::uint8_t> live(bodies_.size(), 0);
  const auto rows = material_rows();
  const bool heat = heat_reason().empty();
  double lightest = infinity, densest_liquid = 0;
  std::uint32_t some_liquid = core::none;
  one_liquid_ = true;
  const auto meets = [&](std::uint32_t material, bool liquid) {
    lightest = std::min(lightest, rows[material].density);
    if (!liquid) return;
    densest_liquid = std::max(densest_liquid, rows[material].density);
    one_liquid_ = one_liquid_ && (some_liquid == core::none || some_liquid == material);
    some_liquid = material;
  };
  for (const EmitterRecord& e : emitters_) meets(e.desc.material.index, true);
  for (std::size_t i = 0; i < state_.tag.size(); ++i) {
    const std::uint32_t tag = state_.tag[i];
    if (is_removed(tag)) continue;
    if (is_fluid(tag)) {
      fluid = true;
      supercooled =
          supercooled || physics::freezes(rows[material_of(tag)], state_.enthalpy[i] / state_.mass[i]);
    }
    meets(material_of(tag), is_fluid(tag));
    if (rows[material_of(tag)].melts != 0u) meets(rows[material_of(tag)].liquid, true);
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
  if (!state_.tag.empty() || !emitters_.empty()) f |= core::fact_particles;
  contrast_ = densest_liquid > 0 ? physics::contrast_factor(lightest, densest_liquid) : 1.0;
  if (fluid || melts) f |= core::fact_fluid;
  if (bodies > 0) f |= core::fact_solid;
  if (mobile > 0) f |= core::fact_mobile;
  if (mobile > 0 && (bodies > 1 || melts || apart)) f |= core::fact_contact;
  if (melts) f |= core::fact_melt;
  if (freezes) f |= core::fact_freeze;
  if (heat && desc.heat.model == HeatModel::enthalpy) f |= core::fact_heat_enthalpy;
  if (heat && desc.heat.model == HeatModel::paper) f |= core::fact_heat_paper;
  if (heat && desc.heat.model == HeatModel::iwasaki) f |= core::fact_heat_iwasaki;
  for (const MaterialDesc& m : materials)
    if (!m.viscosity_points.empty()) f |= core::fact_viscosity;
  if (desc.particle_shifting) f |= core::fact_shifting;
  if (heat && heat_from_outside()) f |= core::fact_heat_boundary;
  f &= ~disabled_facts_;
  if ((f & core::fact_particles) == 0) return f;
  if ((f & core::fact_fluid) == 0) f |= core::fact_dry;
  const std::uint64_t particles = state_.position.size() + planned_emission();
  search_ = core::choose_search(desc, core::support_of(desc), particles);
  return f | search_.facts;
}

/// c = 10 v_max, v_max the larger of the fall through the scene's height and the speeds it starts with.
void WorldImpl::derive_sound_speed() {
  if (desc.sound_speed > 0) {
    sound_speed_ = desc.sound_speed;
    return;
  }
  if (sound_speed_ > 0 && steps > 0) return;  // fixed once the simulation runs: pressure depends on it
  const double g = length(desc.gravity);
  const Vec3d up = g > 0 ? desc.gravity * (-1.0 / g) : Vec3d{};
  double low = infinity, high = -infinity, speed = 0;
  const auto see = [&](Vec3d x) {
    low = std::min(low, dot(x, up));
    high = std::max(high, dot(x, up));
  };
  for (std::size_t i = 0; i < state_.position.size(); ++i) {
    if (is_removed(state_.tag[i])) continue;
    see(state_.position[i]);
    speed = std::max(speed, length(state_.velocity[i]));
  }
  for (const EmitterRecord& e : emitters_) {
    see(e.desc.center - origin_);
    speed = std::max(speed, e.desc.speed);
  }
  if (desc.domain.bounded)
    for (const Vec3d& v : desc.domain.velocity) speed = std::max(speed, length(v));
  if (desc.domain.bounded && high >= low) {
    // What stands above a floor may fall to it.
    const Vec3d corner = desc.domain.min - origin_;
    const double floor = dot(corner, up);
    if (std::isfinite(floor) && floor < low) low = floor;
  }
  const double depth = high >= low ? high - low + desc.spacing : 0;
  sound_speed_ = physics::sound_speed_for(speed, g, depth);
  if (!(sound_speed_ > 0)) sound_speed_ = 10 * desc.spacing;  // nothing moves: any stable value will do
}

core::SceneConstants WorldImpl::constants() const {
  core::SceneConstants c;
  c.spacing = desc.spacing;
  c.support = core::support_of(desc);
  c.sound_speed = sound_speed_;
  c.spring_reference = spring_reference_;
  c.artificial_viscosity = desc.artificial_viscosity;
  c.tension = desc.tension;
  c.one_liquid = one_liquid_;
  c.courant = desc.courant;
  c.gravity = desc.gravity;
  c.domain = desc.domain;
  c.domain.min = desc.domain.min - origin_;
  c.domain.max = desc.domain.max - origin_;
  c.materials = material_rows();
  c.properties = properties_;
  fill_heat_boundary(c);
  c.emitter_points = emitter_points_;
  for (const MaterialDesc& m : materials)
    c.largest_mass = std::max(c.largest_mass, m.density * desc.spacing * desc.spacing * desc.spacing);
  return c;
}

std::uint64_t WorldImpl::planned_emission() const {
  std::uint64_t n = 0;
  for (const EmitterRecord& e : emitters_)
    if (e.layers > e.next_layer) n += (e.layers - e.next_layer) * e.points;
  return n;
}

Status WorldImpl::prepare() {
  if (!dirty_) return {};
  fetch_state();
  derive_sound_speed();
  core::EngineSetup setup;
  setup.facts = facts_ = facts();
  setup.channels = core::channels_for(setup.facts);
  if ((setup.facts & core::fact_particles) != 0) {
    setup.channels |= core::FieldSet{1} << core::field_vertex_of_id;
    if (!emitters_.empty()) setup.channels |= core::FieldSet{1} << core::field_emitter_points;
  }
  // Regions are filled along arrayN when the scene is uploaded, also where nothing melts later.
  if ((setup.facts & core::fact_mobile) != 0)
    setup.channels |= core::FieldSet{1} << core::field_neighbour_mask;
  if (((setup.channels >> core::field_neighbour_mask) & 1u) != 0)  // is made from it then
    setup.channels |= core::FieldSet{1} << core::field_site_live;
  if ((setup.facts & core::fact_solid) == 0)
    setup.channels &= ~(core::FieldSet{1} << core::field_vertex_of_id);
  derive_limits();
  fit_regions(substep_ > 0 ? substep_ : static_dt_);
  modulus_unreachable_ = modulus_unreachable_ || modulus_out_of_reach(substep_);
  const std::uint64_t capacity = state_.position.size() + planned_emission();
  if (capacity >= core::none)
    return Error{ErrorCode::capacity,
                 core::text("particles: ", capacity, " are more than 32-bit ids can number (", core::none,
                            "); use a larger spacing or shorter emitters")};
  setup.particle_capacity = static_cast<std::uint32_t>(capacity);
  if (Status s = engine->upload(constants(), lattice_, state_, setup); !s) return s;
  engine->set_custom_stages(&custom_);
  engine->enable_timings(timed_);
  dirty_ = false;
  return {};
}

/// What step() needs of the scene, worked out once: it must not search or allocate per step.
void WorldImpl::derive_limits() {
  static_dt_ = infinity;
  heat_lambda_ = 0;
  const double support = core::support_of(desc);
  // Of the scene alone, not of what has melted by now: static_dt_ also follows densities and viscosities.
  const bool loaded = length(desc.gravity) > 0 || (facts_ & core::fact_fluid) != 0;
  spring_reference_ = loaded ? physics::acoustic_dt(desc.courant, support, sound_speed_) : 0;
  const double sum = physics::lattice_laplacian_sum(support, desc.spacing);
  if ((facts_ & core::fact_fluid) != 0) {
    static_dt_ = physics::acoustic_dt(desc.courant, support, sound_speed_) * contrast_;
    for (const MaterialDesc& m : materials)
      if (!m.melts_into && largest_viscosity(m) > 0)
        static_dt_ = std::min(static_dt_, physics::viscous_dt(largest_viscosity(m) / least_density(m), sum));
  }
  rows_ = material_rows();
  for (const auto& i : rows_) {
    const double capacity = std::min(i.heat_capacity, i.liquid_heat_capacity);
    for (const auto& j : rows_) {
      const double k = physics::pair_conductivity(physics::resistivity_of(largest_conductivity(i)),
                                                  physics::resistivity_of(largest_conductivity(j)));
      heat_lambda_ = std::max(heat_lambda_, 2 * heat_margin * k * sum / (i.density * capacity));
    }
  }
  if ((facts_ & core::fact_heat_boundary) == 0) return;
  // A surface takes more than the neighbours it stands for gave, where a particle is as close as it gets.
  const auto e = physics::make_wall_exchange<double>(support, desc.spacing);
  const double surface = physics::wall_area(e, e.smallest_distance) / e.smallest_distance;
  double fastest = 0;
  for (const auto& i : rows_)
    fastest = std::max(fastest, 2 * largest_conductivity(i) * surface /
                                    (i.density * std::min(i.heat_capacity, i.liquid_heat_capacity)));
  heat_lambda_ += fastest;
}

/// What a material's modulus comes to at sub-steps of dt, infinite while none is known. A function of dt
/// alone, not of history, so that a restored World goes on with the same bits.
Stiffness WorldImpl::stiffness_of(const MaterialDesc& m, double dt) const {
  Stiffness s;
  s.region_half_width = m.region_half_width;
  s.stiffness = m.stiffness;
  if (!(dt > 0 && std::isfinite(dt))) return s;
  const double rate = m.youngs_modulus / (m.density * desc.spacing * desc.spacing);
  if (rate > 0) {
    s.region_half_width =
        physics::modulus_half_width(rate, m.region_half_width, physics::most_half_width, dt);
    s.stiffness = std::min(1.0, physics::modulus_stiffness(rate, s.region_half_width, dt));
  } else s.stiffness = physics::stiffness_of_step(s.stiffness, dt, physics::spring_dt(dt, spring_reference_));
  s.youngs_modulus = physics::shape_modulus(s.stiffness, s.region_half_width, m.density, desc.spacing, dt);
  return s;
}

int WorldImpl::half_width_for(const BodyRecord& b, double dt) const {
  const MaterialDesc& m = materials[b.desc.material.index];
  return b.desc.fixed ? m.region_half_width : stiffness_of(m, dt).region_half_width;
}

/// Whether the regions are as wide as moduli ask for at sub-steps of dt.
bool WorldImpl::regions_fit(double dt) const {
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (lattice_.bodies[b].region_half_width != half_width_for(bodies_[b], dt)) return false;
  return true;
}

void WorldImpl::fit_regions(double dt) {
  lattice_.max_half_width = 0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const int w = half_width_for(bodies_[b], dt);
    lattice_.bodies[b].region_half_width = w;
    lattice_.max_half_width = std::max(lattice_.max_half_width, w);
  }
}

bool WorldImpl::modulus_out_of_reach(double dt) const {
  if ((facts_ & core::fact_mobile) == 0 || !(dt > 0)) return false;
  for (const BodyRecord& b : bodies_) {
    const MaterialDesc& m = materials[b.desc.material.index];
    if (!b.desc.fixed && stiffness_of(m, dt).youngs_modulus < m.youngs_modulus * (1 - 1e-9)) return true;
  }
  return false;
}

/// Before sub-steps of dt: makes the regions as wide as moduli ask for at that length.
Status WorldImpl::follow_modulus(double dt) {
  if (dt == substep_) return {};
  const bool fits = (facts_ & core::fact_mobile) == 0 || regions_fit(dt);
  if (!fits && steps > 0) {  // what was enqueued must have gone well before it is sent anew
    const StepResult r = synchronize();
    if (r.halted)
      return Error{ErrorCode::halted,
                   "step: the World halted: " + halt_reason_ + "; restore a snapshot to go on"};
    carried_ = r;
  }
  substep_ = dt;
  dirty_ = dirty_ || !fits;
  modulus_unreachable_ = modulus_unreachable_ || modulus_out_of_reach(dt);
  return prepare();
}

double WorldImpl::stable_dt() const {
  const double dt = static_dt_;
  // A particle may cross courant H per sub-step before a flag is raised.
  return last_max_speed_ > 0 ? std::min(dt, desc.courant * core::support_of(desc) / last_max_speed_) : dt;
}

void WorldImpl::heat_plan(double dt, int& stages, int& supersteps, double& heat_dt, double& bound) const {
  const double tau = dt * desc.heat.time_scale * thermal_interval_;
  stages = supersteps = 0;
  heat_dt = tau;
  bound = infinity;
  if ((facts_ & (core::fact_heat_enthalpy | core::fact_heat_paper | core::fact_heat_iwasaki)) == 0) return;
  stages = supersteps = 1;
  if ((facts_ & core::fact_heat_enthalpy) == 0) return;
  const double lambda = heat_lambda_;
  stages = physics::heat_stage_count(tau * lambda);
  const int given = desc.heat.max_stages, most = given == 2 || given % 2 == 1 ? given : given - 1;
  if (stages > most) {
    supersteps = static_cast<int>(std::min(std::ceil(tau * lambda / physics::heat_stage_reach(most)), 1e6));
    stages = physics::heat_stage_count(tau * lambda / supersteps);
  }
  heat_dt = tau / supersteps;
  bound = physics::heat_stage_reach(stages) / (2 * heat_dt);
}

std::uint64_t WorldImpl::stage_bits(std::uint64_t index) const {
  std::uint64_t bits = 0;
  for (int s = 0; s < core::stage_count; ++s) {
    const core::StageInfo& info = core::stage_table[static_cast<std::size_t>(s)];
    if (!core::runs(info, facts_)) continue;
    const std::string_view module = info.module;
    if (module == "thermal" && index % static_cast<std::uint64_t>(thermal_interval_) != 0) continue;
    if (s == core::stage_topology_pieces) {
      if (index % static_cast<std::uint64_t>(desc.pieces_interval) != 0) continue;
    } else if (module == "topology" && s != core::stage_topology_regions &&
               index % static_cast<std::uint64_t>(topology_interval_) != 0) {
      continue;  // regions follow whatever melted in the sub-step before
    }
    bits |= std::uint64_t{1} << s;
  }
  return bits;
}

/// Layers whose time comes in [from, until): known to the host, so emission needs no word from the device.
const std::vector<core::BurstArguments>* WorldImpl::due_bursts(double from, double until) {
  bursts_.clear();
  for (EmitterRecord& e : emitters_) {
    const Vec3d axis = e.desc.axis * (1.0 / length(e.desc.axis));
    for (;;) {
      const double due = e.desc.from + double(e.next_layer) * desc.spacing / e.desc.speed;
      if (due >= until || due >= e.desc.until) break;
      if (e.next_layer >= e.layers) {
        emitter_exhausted_ = true;
        break;
      }
      const auto& row = rows_[e.desc.material.index];
      core::BurstArguments b;
      b.first_point = e.first_point;
      b.points = e.points;
      b.center = e.desc.center - origin_ + axis * (e.desc.speed * (from - due));
      b.velocity = axis * e.desc.speed;
      b.mass = physics::rest_density(row, physics::enthalpy_of(row, e.desc.temperature)) * desc.spacing *
               desc.spacing * desc.spacing;
      round_to_precision(b.mass);
      b.volume = desc.spacing * desc.spacing * desc.spacing;
      b.enthalpy = physics::enthalpy_of(row, e.desc.temperature) * b.mass;
      b.tag = e.desc.material.index;
      bursts_.push_back(b);
      ++e.next_layer;
    }
  }
  return bursts_.empty() ? nullptr : &bursts_;
}

Status WorldImpl::step(double dt) {
  if (!(std::isfinite(dt) && dt >= 0))
    return invalid("step: dt: must be finite and >= 0 s, got ", dt, "; 0 does nothing");
  if (dt == 0) return {};
  if (halted_)
    return Error{ErrorCode::halted,
                 "step: the World halted: " + halt_reason_ + "; restore a snapshot to go on"};
  if (Status s = prepare(); !s) return s;
  const double largest = static_dt_;
  const double wanted = std::ceil(dt / largest * (1 - 1e-9));
  if (wanted > desc.max_substeps)
    return Error{ErrorCode::step_too_large,
                 core::text("step: dt: ", dt, " s needs ", wanted, " sub-steps of at most ", largest,
                            " s, more than max_substeps ", desc.max_substeps, "; step by at most ",
                            largest * desc.max_substeps, " s, or raise max_substeps")};
  const int n = std::max(1, static_cast<int>(wanted));
  core::SubstepArguments a;
  a.dt = dt / n;
  if (Status s = follow_modulus(a.dt); !s) return s;
  heat_plan(a.dt, a.heat_stages, a.heat_supersteps, a.heat_dt, a.heat_bound);
  const double start = time;
  for (int k = 0; k < n; ++k) {
    a.time = start + dt * k / n;
    const double end = k + 1 == n ? start + dt : start + dt * (k + 1) / n;
    a.index = ++steps;
    a.stages = stage_bits(steps);
    a.bursts = emitters_.empty() ? nullptr : due_bursts(a.time, end);
    engine->substep(a);
    time = end;
  }
  state_stale_ = true;
  return {};
}

std::string WorldImpl::halt_text(const core::WorldStatus& s) {
  fetch_state();
  std::string body;
  if (s.halt_particle < state_.tag.size()) {
    const std::uint32_t b = body_of(state_.tag[s.halt_particle]);
    if (b != 0 && is_solid(state_.tag[s.halt_particle]))
      body = " (body \"" + bodies_[b - 1].desc.name + "\")";
  }
  const char* what = "";
  switch (static_cast<core::Halt>(s.halted)) {
    case core::Halt::position:
      what = "position is not finite after the search for neighbours";
      break;
    case core::Halt::density:
      what = "density is not finite after sph.density";
      break;
    case core::Halt::force:
      what = "acceleration is not finite after sph.forces";
      break;
    case core::Halt::shape:
      what = "velocity is not finite after lsm.balance";
      break;
    case core::Halt::heat:
      what = "enthalpy is not finite after thermal.exchange";
      break;
    default:
      break;
  }
  if (static_cast<core::Halt>(s.halted) == core::Halt::speed)
    return core::text("sub-step ", s.halt_step, ": particle ", s.halt_particle, body, ": speed ",
                      s.halt_value, " m/s crosses its neighbourhood in one sub-step (step.integrate)");
  return core::text("sub-step ", s.halt_step, ": particle ", s.halt_particle, body, ": ", what);
}

namespace {
std::string fault_text(const std::string& fault) {
  return fault.compare(0, 7, "checked") == 0 ? fault : "device: " + fault;
}
}  // namespace

StepResult WorldImpl::synchronize() {
  StepResult r = collect();
  r.max_speed = std::max(r.max_speed, carried_.max_speed);
  r.max_density_ratio = std::max(r.max_density_ratio, carried_.max_density_ratio);
  r.courant_exceeded = r.courant_exceeded || carried_.courant_exceeded;
  r.heat_bound_exceeded = r.heat_bound_exceeded || carried_.heat_bound_exceeded;
  r.modulus_unreachable = modulus_unreachable_ || carried_.modulus_unreachable;
  carried_ = {};
  modulus_unreachable_ = modulus_out_of_reach(substep_);  // what it is until the sub-step changes
  return r;
}

/// What the engine and the host know of the steps since the last call.
StepResult WorldImpl::collect() {
  const core::WorldStatus s = engine->synchronize();
  StepResult r;
  r.steps = steps;
  r.time = time;
  r.max_speed = s.max_speed;
  r.max_density_ratio = s.max_density;
  r.courant_exceeded = s.courant_exceeded != 0;
  r.heat_bound_exceeded = s.heat_bound_exceeded != 0;
  r.emitter_exhausted = emitter_exhausted_;
  const std::string fault = engine->fault();
  if (s.halted != 0 || !fault.empty()) {
    if (!halted_) halt_reason_ = fault.empty() ? halt_text(s) : fault_text(fault);
    halted_ = true;
    r.halted = true;
    r.halt_reason = halt_reason_;
    r.halt_step = s.halt_step;
    if (s.halt_step != 0) {  // the clock goes back with the state
      r.steps = steps = s.halt_step - 1;
      r.time = time = s.time;
    }
  }
  last_max_speed_ = s.max_speed > 0 ? s.max_speed : last_max_speed_;
  if (dirty_) {  // nothing was stepped since the last change: the host knows
    r.melted = state_.melted;
    r.frozen = state_.frozen;
    r.removed = state_.removed;
    for (const std::uint32_t tag : state_.tag) {
      r.fluid += is_fluid(tag) ? 1u : 0u;
      r.solid += is_solid(tag) ? 1u : 0u;
    }
    return r;
  }
  r.melted = static_cast<std::uint64_t>(s.melted);
  r.frozen = s.frozen;
  r.removed = static_cast<std::uint64_t>(s.removed);
  r.solid = solids_built_ + s.frozen - r.melted;
  const std::uint64_t live = s.particles - r.removed;
  r.fluid = live - r.solid;
  // Everything has melted: from here on the plan needs no lattice, and its memory goes back.
  if (r.solid == 0 && (facts_ & core::fact_solid) != 0 && !halted_) {
    fetch_state();
    dirty_ = true;
    static_cast<void>(prepare());  // smaller than what was there; a failure shows at the next step
  }
  return r;
}

double WorldImpl::heat_efficiency(double dt) const {
  if ((facts_ & core::fact_heat_paper) == 0) return 1;
  double K = 0;
  for (const auto& row : rows_) K = std::max(K, row.diffusivity);
  const double tau = dt * desc.heat.time_scale * thermal_interval_;
  return K > 0 && tau > 0
             ? physics::paper_effective_diffusivity(K, tau, core::support_of(desc), desc.spacing) / K
             : 1;
}

Resolved WorldImpl::resolved() {
  Resolved r;
  static_cast<void>(prepare());
  r.backend = engine->backend();
  r.backend_reason = backend_reason;
  r.device_name = engine->device_name();
  r.neighbour_search = search_.search;
  r.neighbour_reason = search_.reason;
  r.support_radius = core::support_of(desc);
  r.sound_speed = (facts_ & core::fact_particles) != 0 ? sound_speed_ : 0;
  r.stable_dt = static_dt_;
  r.origin = origin_;
  const double dt = substep_ > 0 ? substep_ : static_dt_;
  for (const MaterialDesc& m : materials) r.stiffness.push_back(stiffness_of(m, dt));
  int supersteps = 0;
  double heat_dt = 0, bound = 0;
  if (std::isfinite(r.stable_dt)) heat_plan(r.stable_dt, r.heat_stages, supersteps, heat_dt, bound);
  if (std::isfinite(r.stable_dt)) r.heat_efficiency = heat_efficiency(r.stable_dt);
  return r;
}

}  // namespace v0
}  // namespace meltsim
