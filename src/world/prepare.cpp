// SPDX-License-Identifier: Apache-2.0
// Prepares a scene for the backend: constants, limits of a sub-step, the upload.
#include <algorithm>
#include <bitset>
#include <cmath>

#include "description/validate.hpp"
#include "engine/text.hpp"
#include "meltsim/physics/artificial_viscosity.hpp"
#include "meltsim/physics/contact.hpp"
#include "meltsim/physics/fluid.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/integrate.hpp"
#include "meltsim/physics/isotropic_pressure.hpp"
#include "meltsim/physics/phase_change.hpp"
#include "meltsim/physics/sph_kernels.hpp"
#include "meltsim/physics/surface_tension.hpp"
#include "meltsim/physics/viscous_diffusion.hpp"
#include "pipeline/pipeline.hpp"
#include "world/trial.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

namespace {
/// Crowded neighbourhoods (splashes, a melted particle beside a larger one) exchange faster than the lattice;
/// this head room keeps the heat stages stable. Exceeding it raises StepResult::heat_bound_exceeded.
constexpr double heat_margin = 1.5;

double largest_consistency(const MaterialDesc& m) {
  double mu = m.viscosity_points.empty() ? m.viscosity : 0;
  for (const PropertyPoint& p : m.viscosity_points) mu = std::max(mu, p.value);
  return mu;
}

double least_consistency(const MaterialDesc& m) {
  double mu = m.viscosity_points.empty() ? m.viscosity : infinity;
  for (const PropertyPoint& p : m.viscosity_points) mu = std::min(mu, p.value);
  return mu;
}

double least_conductivity(const core::MaterialRow<double>& m) {
  double k = m.plateau != 0u ? std::min(m.conductivity, m.liquid_conductivity) : m.conductivity;
  if (m.tables == nullptr) return k;
  for (const auto* t : {&m.tables->conductivity, &m.tables->liquid_conductivity})
    for (std::uint32_t p = 0; p < t->points; ++p) k = std::min(k, t->value[p]);
  return k;
}

double largest_conductivity(const core::MaterialRow<double>& m) {
  double k = std::max(m.conductivity, m.liquid_conductivity);
  if (m.tables == nullptr) return k;
  for (const auto* t : {&m.tables->conductivity, &m.tables->liquid_conductivity})
    for (std::uint32_t p = 0; p < t->points; ++p) k = std::max(k, t->value[p]);
  return k;
}
}  // namespace

/// At any temperature and shear rate [Pa s].
double WorldImpl::largest_viscosity(const MaterialDesc& m) const {
  const double mu = largest_consistency(m);
  return shears(m) ? physics::largest_flow_viscosity(flow_of(m), mu) : mu;
}

/// At any temperature, and at shear rates as high as a scene of this sound speed should have [Pa s].
double WorldImpl::least_viscosity(const MaterialDesc& m) const {
  const double mu = least_consistency(m);
  return shears(m) ? physics::least_flow_viscosity(flow_of(m), mu, 0.1 * sound_speed_ / desc.spacing) : mu;
}

/// Something was added at x.
void WorldImpl::see(Vec3d x, Vec3d up) { seen_.see(x, up); }

/// Particles that were added since the last look.
void WorldImpl::see_particles(Vec3d up) {
  struct Seen {
    Extremes extremes;
    std::bitset<tag_material_mask + 1> liquid;  // by material
  };
  const std::size_t first = seen_particles_;
  const auto parts = loops().of_pieces<Seen>(
      std::max(state_.position.size(), first) - first, [&](std::size_t begin, std::size_t end) {
        Seen seen;
        for (std::size_t i = first + begin; i < first + end; ++i) {
          if (is_removed(state_.tag[i])) continue;
          if (!is_solid(state_.tag[i])) seen.liquid.set(material_of(state_.tag[i]));
          seen.extremes.see(state_.position[i] + origin_, up);
          seen.extremes.speed = std::max(seen.extremes.speed, length(state_.velocity[i]));
        }
        return seen;
      });
  for (const Seen& part : parts) {
    seen_.see(part.extremes);
    for (std::size_t m = 0; m < materials.size(); ++m)
      if (part.liquid[m]) note_liquid(m);
  }
  seen_particles_ = state_.position.size();
}

/// Speeds that walls, outlets and the bodies from number `first` on may have.
void WorldImpl::see_driven(std::size_t first) {
  if (desc.domain.bounded)
    for (std::size_t f = 0; f < 6; ++f)
      seen_.speed =
          std::max({seen_.speed, length(desc.domain.velocity[f]), desc.domain.outlets[f].speed.value_or(0)});
  for (std::size_t b = first; b < bodies_.size(); ++b)
    seen_.speed = std::max(seen_.speed, bodies_[b].desc.max_speed);
}

/// Height and speed of all that was added, as it was added: of what moves by then nothing is asked, so that what follows
/// from them depends on neither when a scene is read nor where a splash is.
void WorldImpl::look_at_added() {
  if (sound_speed_ > 0 && !added_) return;
  const double g = length(desc.gravity);
  const Vec3d up = g > 0 ? desc.gravity * (-1.0 / g) : Vec3d{};
  if (steps == 0) {  // nothing was stepped: all there is, is as it was added
    seen_ = {};
    seen_particles_ = seen_emitters_ = seen_bodies_ = 0;
  }
  liquid_there_.resize(materials.size(), 0);
  liquid_used_.resize(materials.size(), 0);
  see_particles(up);
  for (std::size_t e = seen_emitters_; e < emitters_.size(); ++e) {
    see(emitters_[e].desc.center + up * (emitters_[e].reservoir() ? 0.5 * emitters_[e].desc.height : 0.0),
        up);
    seen_.speed = std::max(seen_.speed, emitters_[e].desc.speed);
  }
  see_driven(seen_bodies_);
  seen_bodies_ = bodies_.size();
  seen_emitters_ = emitters_.size();
  added_ = false;
  look_now_ = true;
  derive_sound_speed();
}

/// Ahead of a change by which what was added may fall less, or differ less in temperature: a snapshot in between looks at it, too,
/// sound only gets faster, and heat that flows comes to rest in a sub-step.
void WorldImpl::see_added() {
  if (steps == 0 || !dirty_) return;
  look_at_added();
  look_at_heat();
}

/// Ahead of an addition by way of the host: what has come from nozzles meanwhile was not added.
void WorldImpl::pass_over_particles() {
  if (!added_) seen_particles_ = state_.position.size();
}

/// Before the first step, whether the World was prepared in between or not.
void WorldImpl::see_all_anew() {
  if (!dirty_) fetch_state();
  added_ = dirty_ = true;
}

/// How far what was added may fall [m]: to the lowest corner of a bounded domain, however gravity is tilted, else to the lowest
/// place where something was added.
double WorldImpl::fall_height() const { return seen_.high >= seen_.low ? seen_.high - lowest_place() : 0; }

/// Of that the part over which all weighs in full: ahead of the level of a hydrostatic field that is everywhere and for ever [m].
double WorldImpl::weighed_height() const {
  const double all = fall_height(), g = length(desc.gravity);
  double part = all;
  for (const ForceFieldRecord& r : force_fields_)
    if (g > 0 && always_hydrostatic(r))
      part = std::min(part, seen_.high + dot(*r.desc.center, desc.gravity) / g + field_row(r).radius);
  return std::max(part, 0.0);
}

/// Square of the speed that bodies and liquids may come to below such levels, where differences of density drive them against the liquid that
/// they take along, half of what they displace [m^2/s^2].
double WorldImpl::buoyant_speed2() const {
  double square = 0;
  for (const ForceFieldRecord& r : force_fields_) {
    if (!always_hydrostatic(r)) continue;
    const double rho = r.desc.density, fall = 2 * length(desc.gravity) * (fall_height() - weighed_height());
    const auto see = [&](double density) {
      square = std::max(square, fall * std::fabs(density - rho) / (density + 0.5 * rho));
    };
    for (std::size_t i = 0; i < materials.size(); ++i)
      if (may_be_liquid(i)) see(materials[i].density);
    for (const BodyRecord& b : bodies_) see(materials[b.desc.material.index].density);
  }
  return square;
}

bool WorldImpl::always_hydrostatic(const ForceFieldRecord& r) {
  return r.used && r.desc.kind == ForceFieldKind::hydrostatic && !r.desc.shape && r.desc.center &&
         r.desc.from <= 0 && r.desc.until == infinity;
}

/// Along "up" [m].
double WorldImpl::lowest_place() const {
  const double g = length(desc.gravity);
  double low = seen_.low;
  if (desc.domain.bounded && seen_.high >= low) {
    const Vec3d up = g > 0 ? desc.gravity * (-1.0 / g) : Vec3d{};
    const Vec3d a = desc.domain.min, b = desc.domain.max;
    const double floor = std::min(a.x * up.x, b.x * up.x) + std::min(a.y * up.y, b.y * up.y) +
                         std::min(a.z * up.z, b.z * up.z);
    if (std::isfinite(floor) && floor < low) low = floor;
  }
  return low;
}

/// Whether there is liquid of it, or may be: from a nozzle, or of what bodies melt into. Does not ask whether heat flows.
bool WorldImpl::may_be_liquid(std::size_t material) const {
  const auto is = [material](MaterialId id) { return id && id.index == material; };
  return (material < liquid_used_.size() && liquid_used_[material] != 0u) ||
         std::any_of(emitters_.begin(), emitters_.end(),
                     [&](const EmitterRecord& e) { return is(e.desc.material); }) ||
         std::any_of(bodies_.begin(), bodies_.end(),
                     [&](const BodyRecord& b) { return is(materials[b.desc.material.index].melts_into); });
}

/// c = 10 v_max, v_max the larger of the fall through the scene's height and the speeds it starts with. Once the
/// simulation runs it only rises, as pressures depend on it.
void WorldImpl::derive_sound_speed() {
  if (desc.sound_speed > 0) {
    sound_speed_ = desc.sound_speed;
    return;
  }
  const double depth = seen_.high >= seen_.low ? weighed_height() + desc.spacing : 0;
  double speed = std::sqrt(seen_.speed * seen_.speed + buoyant_speed2());
  if (any_field()) {
    const FieldReach fields = reach_of_fields();
    speed = std::sqrt(std::pow(std::max(speed, fields.wind), 2) + fields.squared);
  }
  double c =
      physics::sound_speed_for(speed, length(desc.gravity), depth,
                               desc.density_error > 0 ? desc.density_error : physics::usual_density_error);
  for (std::size_t i = 0; i < materials.size(); ++i)
    if (materials[i].surface_tension > 0 && may_be_liquid(i))
      c = std::max(
          c, physics::tension_sound_speed(materials[i].surface_tension, least_density(i), desc.spacing));
  if (!(c > 0)) c = 10 * desc.spacing;  // nothing moves: any stable value will do
  sound_speed_ = steps == 0 ? c : std::max(sound_speed_, c);
}

/// Whether anything sets what is at rest in motion. Else sub-steps are as long as the host steps, as where nothing can move.
bool WorldImpl::driven() const {
  bool tension = false;
  for (std::size_t i = 0; i < materials.size(); ++i)
    tension = tension || (materials[i].surface_tension > 0 && may_be_liquid(i));
  return tension || length(desc.gravity) > 0 || seen_.speed > 0 || any_field();
}

/// Whether steps are to be refused, by what the scene holds now. After derive_sound_speed().
void WorldImpl::look_for_refusal() {
  Status s = check_sound_speed();
  if (s) s = check_damping();
  refusal_ = s ? std::optional<Error>{} : s.error();
}

/// A liquid that neither its own viscosity nor artificial viscosity damps enough for isotropic pressure; null if there is none.
const MaterialDesc* WorldImpl::undamped_liquid() const {
  for (std::size_t i = 0; i < materials.size(); ++i) {
    if (liquid_used_[i] == 0u) continue;
    const double own = least_viscosity(materials[i]) / largest_density(i) /
                       physics::artificial_kinematic_viscosity(1, sound_speed_, core::support_of(desc));
    if (desc.artificial_viscosity + own < physics::least_artificial_viscosity) return &materials[i];
  }
  return nullptr;
}

/// Refuses isotropic pressure in such a liquid.
Status WorldImpl::check_damping() const {
  const MaterialDesc* const thin = desc.isotropic_pressure.value_or(false) ? undamped_liquid() : nullptr;
  if (thin == nullptr) return {};
  return core::invalid("isotropic_pressure: needs an artificial_viscosity of ",
                       physics::least_artificial_viscosity, " or more, got ", desc.artificial_viscosity,
                       "; liquid \"", thin->name,
                       "\" is too thin to do without and would gain motion. Set artificial_viscosity, or "
                       "isotropic_pressure to false");
}

/// Refuses a sound speed at which the surface tension of a liquid would compress it.
Status WorldImpl::check_tension_speed() const {
  // Liquids that bodies will melt into count, too: otherwise a run would be refused only when its first particle melts.
  const auto comes = [this](std::size_t i) {
    return desc.heat.model != HeatModel::none && desc.heat.time_scale > 0 &&
           std::any_of(bodies_.begin(), bodies_.end(), [&](const BodyRecord& b) {
             const MaterialId liquid = materials[b.desc.material.index].melts_into;
             return !b.gone && liquid && liquid.index == i;
           });
  };
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const MaterialDesc& m = materials[i];
    if (!(m.surface_tension > 0) || !(liquid_used_[i] != 0u || comes(i))) continue;
    const double least = physics::tension_sound_speed(m.surface_tension, least_density(i), desc.spacing);
    if (desc.sound_speed < least)
      return core::invalid("sound_speed: ", desc.sound_speed, " m/s is too low for the surface_tension of \"",
                           m.name, "\", ", m.surface_tension, " N/m, at a spacing of ", desc.spacing,
                           " m, which would compress the liquid; use at least ", least,
                           ", or 0 to derive it");
  }
  return {};
}

/// Refuses a sound speed that what falls onto the floor of the domain outruns: it would pass through liquid, in sub-steps that
/// are too long for it. Liquid without movable bodies that creeps is no faster than its viscosity allows. Where no wall is
/// below, how far things fall is not known.
Status WorldImpl::check_sound_speed() const {
  if (desc.sound_speed <= 0) return {};
  if (Status s = check_tension_speed(); !s) return s;
  if (!desc.domain.bounded || !any_liquid()) return {};
  const Vec3d pull = desc.gravity;
  const auto& faces = desc.domain.faces;
  const double along[3] = {pull.x, pull.y, pull.z};
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (along[axis] != 0 && faces[2 * axis + (along[axis] > 0 ? 1 : 0)] != Face::wall) return {};
  const double g = length(pull), height = weighed_height();
  double speed = std::sqrt(seen_.speed * seen_.speed + buoyant_speed2() + 2 * g * height);
  if (std::none_of(bodies_.begin(), bodies_.end(), [](const BodyRecord& b) { return !b.desc.fixed; })) {
    double creep = 0;  // of a layer of that height on a slope
    for (std::size_t i = 0; i < materials.size(); ++i)
      if (liquid_used_[i] != 0u)
        creep = std::max(
            creep, physics::creep_speed(g, height, least_viscosity(materials[i]) / materials[i].density));
    speed = std::min(speed, seen_.speed + creep);
  }
  if (desc.sound_speed >= speed) return {};
  return core::invalid("sound_speed: ", desc.sound_speed, " m/s is slower than what falls ", height, " m, ",
                       speed, " m/s: it would pass through liquid; use ", 10 * speed,
                       ", or 0 to derive it (at least ", speed,
                       ", with liquid squeezed to part of its volume)");
}

/// Of a particle of the scene as built, in the largest cells that liquid may have [kg].
double WorldImpl::largest_mass() const {
  double mass = 0;
  const Vec3d cell = cell_of({desc.domain.min, desc.domain.max});
  const double dx = desc.spacing,
               larger = std::max(cell.x / dx, 1.0) * std::max(cell.y / dx, 1.0) * std::max(cell.z / dx, 1.0);
  for (std::size_t m = 0; m < materials.size(); ++m)
    if (used(m)) mass = std::max(mass, materials[m].density * dx * dx * dx * larger);
  for (const BodyRecord& b : bodies_) mass = std::max(mass, b.density * dx * dx * dx);
  return mass;
}

/// Tables of properties; those of materials that nothing is made of stay on the host.
void WorldImpl::fill_properties(core::SceneConstants& c) const {
  if (std::any_of(c.materials.begin(), c.materials.end(), [&c, this](const auto& row) {
        return row.tables != nullptr && used(static_cast<std::size_t>(&row - c.materials.data()));
      }))
    c.properties = properties_;
  for (std::size_t m = 0; m < c.properties.size();
       ++m)  // what follows from the sound speed was not known before
    c.properties[m].flow = flow_of(materials[m]);
}

core::SceneConstants WorldImpl::constants() const {
  core::SceneConstants c;
  c.spacing = desc.spacing;
  c.support = core::support_of(desc);
  c.sound_speed = sound_speed_;
  c.spring_dt = spring_dt_;
  if (desc.stray == Stray::remove && !desc.domain.bounded) c.stray_speed = sound_speed_;
  c.level_tolerance = desc.heat.level_tolerance;
  c.artificial_viscosity = desc.artificial_viscosity;
  c.tension = desc.tension;
  c.one_liquid = one_liquid_;
  c.courant = desc.courant;
  c.domain = desc.domain;
  c.domain.min = desc.domain.min - origin_;
  c.domain.max = desc.domain.max - origin_;
  for (std::size_t f = 0; f < 6; ++f) c.outlet_head[f] = core::outlet_head(desc, f);
  c.materials = material_rows();
  fit_rows(c.materials);
  if (desc.heat.model == HeatModel::none)  // a body that dissolves may run the stage that melts
    for (core::MaterialRow<double>& row : c.materials) row.melts = 0;
  if (species_used_) c.species = species_rows();
  fill_properties(c);
  fill_heat_boundary(c);
  c.force_fields.count = field_rows();
  for (std::uint32_t k = 0; k < physics::most_force_fields; ++k)
    c.force_fields.row[k] = field_row(force_fields_[k]);
  c.emitter_points = emitter_points_;
  fill_inlets(c);
  if ((disabled_facts_ & core::fact_fluid) !=
      0) {  // nothing finds what is beyond a level: liquid leaves as it comes
    for (OutletDesc& outlet : c.domain.outlets) outlet.level.reset();
    c.inlet_faces = 0;
  }
  c.largest_mass = largest_mass();
  if (event_watch_) {
    c.event_kinds = event_watch_->kinds;
    c.event_capacity = event_watch_->capacity;
  }
  return c;
}

std::uint64_t WorldImpl::planned_emission() const {
  std::uint64_t n = 0;
  for (const EmitterRecord& e : emitters_) n += to_come(e);
  return n;
}

/// Stages and channels for these facts.
core::EngineSetup WorldImpl::setup_of(core::FactSet facts) const {
  core::EngineSetup setup;
  setup.facts = facts;
  setup.channels = channels_of(facts);
  setup.particle_capacity = capacity_;
  setup.searched = searched_;
  setup.room = room_;
  setup.threads = desc.threads;
  if ((facts & core::fact_particles) != 0) {
    setup.channels |= core::copied_channels | core::FieldSet{1} << core::field_vertex_of_id;
    if (!emitters_.empty()) setup.channels |= core::FieldSet{1} << core::field_emitter_points;
  }
  // Regions are filled along arrayN when the scene is uploaded, also where nothing melts later.
  if ((facts & core::fact_mobile) != 0) setup.channels |= core::FieldSet{1} << core::field_neighbour_mask;
  if (setup.channels.has(core::field_neighbour_mask))  // is made from it then
    setup.channels |= core::FieldSet{1} << core::field_site_live;
  // Pieces are read on the device, those of fixed bodies, too.
  if ((facts & core::fact_solid) != 0)
    for (const int field : {core::field_vertex_id, core::field_vertex_state, core::field_vertex_piece,
                            core::field_vertex_site, core::field_vertex_body, core::field_bodies})
      setup.channels |= core::FieldSet{1} << field;
  if ((facts & core::fact_kinematic) != 0) setup.channels |= core::FieldSet{1} << core::field_slot_of_id;
  if ((facts & core::fact_kinematic) != 0 && lattice_.mesh_points != 0)
    for (const int field : {core::field_mesh_points, core::field_site_vertex, core::field_carried_volume})
      setup.channels |= core::FieldSet{1} << field;
  if ((facts & core::fact_mobile) != 0) setup.channels |= core::FieldSet{1} << core::field_push;
  if ((facts & core::fact_solid) == 0) setup.channels &= ~(core::FieldSet{1} << core::field_vertex_of_id);
  return setup;
}

/// Whether temperatures are level, by the state, which the host holds. Once heat flows, the backend finds that out.
void WorldImpl::look_at_heat() {
  regions_act(time, std::max(time, plan_until_));
  if (measure_ && (steps == 0 || state_.heat_level)) state_.heat_level = temperatures_level();
  if (heat_from_outside() || host_heats() || solution_heats()) state_.heat_level = false;
  if (!state_.heat_level) level_.reset();
}

/// What the state, which the host holds, says of the scene.
void WorldImpl::look_at_scene() {
  look_at_added();
  was_emitting_ = emitting();
  species_used_ = species_present();
  contents_level_ = contents_level();
  look_at_heat();
  take_census();
  searched_ = state_.position.size() + planned_emission();
}

/// Room for the particles of the scene and those in reserve. Room that is there is kept, so that an upload changes nothing that
/// follows from it.
Status WorldImpl::make_particle_room() {
  const std::uint64_t capacity = desc.reserved_particles != 0 && searched_ <= capacity_
                                     ? capacity_
                                     : searched_ + desc.reserved_particles;
  constexpr std::uint64_t most_ids = 1u << 31;  // topology.freeze keeps a bit of its own beside them
  if (capacity >= most_ids)
    return Error{ErrorCode::capacity,
                 core::text("particles: ", capacity, " are more than ids can number (", most_ids,
                            "); use a larger spacing, shorter emitters or fewer reserved_particles")};
  capacity_ = static_cast<std::uint32_t>(capacity);
  make_lattice_room();
  return {};
}

/// Limits, stages, and the sizes of what a step needs, from the scene that was looked at.
void WorldImpl::derive_plan() {
  search_ = core::choose_search(desc, core::support_of(desc), searched_);
  find_materials();
  derive_limits();
  look_for_refusal();
  facts_ = facts();
  fit_regions();
  place_forces();
  fit_events();
}

/// States saved before are of another layout.
void WorldImpl::lose_saved_states() {
  ++layout_;
  if (std::any_of(saved_.begin(), saved_.end(), [](const SavedState& s) { return s.layout != 0; }))
    engine->forget_saved();
}

Status WorldImpl::prepare() {
  if (!dirty_) return probes_stale_ ? place_probes() : Status{};
  fetch_state();
  collect_samples();  // a halt that ends with the upload says which of them count
  lay_out();
  look_at_scene();
  Trial room_before(capacity_, room_);  // of an upload that fails: asked for no more
  if (Status s = make_particle_room(); !s) return s;
  born_ = state_.position.size();
  noted_step_ = steps + 1;
  derive_plan();
  press_liquid();
  lose_saved_states();
  ++uploads_;
  if (Status s = engine->upload(constants(), lattice_, state_, setup_of(facts_)); !s) return s;
  room_before.keep();
  tell_sound();
  engine->set_custom_stages(&custom_);
  engine->enable_timings(timings_every_);
  places_.reset();
  make_room_for_steps();
  dirty_ = measure_ = plan_changed_ = false;
  return probes_.empty() && !probes_stale_ ? Status{} : place_probes();  // the origin may have moved
}

/// For what step() fills, so that it does not allocate: a layer of each nozzle, and one that it lets go.
void WorldImpl::make_room_for_steps() {
  liquid_used_before_.reserve(liquid_used_.size());
  bursts_.reserve(2 * emitters_.size());
  layers_.reserve(emitters_.size());
}

/// Room for the lattices of as many particles as there is room for, which is kept, too.
void WorldImpl::make_lattice_room() {
  constexpr std::uint64_t sites_per_particle =
      32;  // a cube of 8^3, with the widest regions around it, has 27
  constexpr std::uint64_t more_bodies = 64;
  const bool contacts = event_watch_ && (event_watch_->kinds & core::contact_events) != 0;
  const std::uint64_t most_bodies = contacts ? core::most_touching_bodies : 65535;
  if (fits_lattice_room(0, 0, 0) && room_.bodies <= most_bodies) return;
  room_ = {};
  const std::uint64_t reserved = desc.reserved_particles, bodies = bodies_.size();
  if (reserved == 0 || bodies >= most_bodies) return;
  const core::LatticeRoom room{lattice_.vertex_site.size() + reserved,
                               lattice_.site_vertex.size() + sites_per_particle * reserved,
                               std::min(bodies + more_bodies, most_bodies)};
  if (room.vertices < core::none && room.sites < core::none) room_ = room;
}

/// Whether there is room for so many more.
bool WorldImpl::fits_lattice_room(std::uint64_t vertices, std::uint64_t sites, std::uint64_t bodies) const {
  return room_.vertices != 0 && lattice_.vertex_site.size() + vertices <= room_.vertices &&
         lattice_.site_vertex.size() + sites + core::LatticeRoom::spare_sites <= room_.sites &&
         bodies_.size() + bodies < room_.bodies;
}

/// Which regions act in [from, until); whether those are others than before.
bool WorldImpl::regions_act(double from, double until) {
  bool changed = false;
  for (HeatRegionRecord& r : heat_regions_) {
    const bool now = acts(r, from, until);
    changed = changed || now != r.acts;
    r.acts = now;
  }
  return changed;
}

/// Gives the engine another plan for the scene that it has; particles stay where they are. Whether that happens changes no
/// bit of the state, but where a source of heat begins or ends, and that follows from the time. back: one that a step would have begun,
/// which was refused, has not.
Status WorldImpl::adapt(bool back) {
  plan_changed_ = true;  // until it is done
  weigh_materials();
  const bool outside = heat_from_outside() || host_heats() || solution_heats();
  if (outside) {
    state_.heat_level = false;
    level_.reset();
  }
  derive_limits();
  const core::FactSet wanted = facts(), had = facts_;
  core::EngineSetup setup = setup_of(wanted);
  setup.heat_flows_again = outside;
  setup.heat_rests_again = back && !outside && state_.heat_level;
  // The host keeps the parts of the lattice that are dropped.
  if ((had & core::fact_solid) != 0) engine->download_lattice(state_);
  facts_ = wanted;
  derive_limits();
  if (!regions_fit()) {  // a modulus needs other widths at the largest sub-step that there is now
    fetch_state();
    dirty_ = true;
    return prepare();
  }
  if (capacity_ == 0) {  // the engine holds nothing
    plan_changed_ = false;
    return {};
  }
  ++layout_;
  if (Status s = engine->adapt(constants(), lattice_, state_, setup); !s) {
    facts_ = had;
    derive_limits();
    return s;
  }
  tell_sound();
  noted_step_ = steps + 1;
  plan_changed_ = false;
  return {};
}

/// Before a step of dt: the plan follows the known state and the time.
Status WorldImpl::follow_plan(double dt) {
  plan_until_ = time + dt;
  const bool others = regions_act(time, plan_until_), emits_now = emitting();
  const bool changed = plan_changed_ || others || emits_now != was_emitting_;
  was_emitting_ = emits_now;
  return changed ? adapt() : Status{};
}

/// The largest viscosity of liquid i, with what may be dissolved in it [Pa s].
double WorldImpl::thickest(std::size_t i) const {
  double mu = largest_viscosity(materials[i]);
  for (const std::uint32_t k : species_)
    if (species_used_ && materials[k].dissolves_in.index == i) mu = std::max(mu, materials[k].viscosity);
  return mu;
}

/// Whether viscosity is implicit, and the limits that follow: of the sub-step, or of what a stage may exchange.
void WorldImpl::limit_viscosity(double laplacian_sum) {
  viscous_dt_ = infinity;
  viscous_lambda_ = 0;
  const double in_stages =
      std::max(laplacian_sum, physics::lattice_central_sum(core::support_of(desc), desc.spacing));
  if (any_liquid()) {
    double lightest_body = infinity;
    for (const BodyRecord& b : bodies_)
      if (!b.desc.fixed) lightest_body = std::min(lightest_body, b.density);
    for (std::size_t i = 0; i < materials.size(); ++i) {
      const double mu = thickest(i), density = least_density(i);
      if (liquid_used_[i] == 0u || !(mu > 0)) continue;
      viscous_dt_ =
          std::min(viscous_dt_, physics::explicit_viscous_dt(mu, density, lightest_body, laplacian_sum));
      double least = std::min(density, lightest_body);
      viscous_lambda_ = std::max(viscous_lambda_, physics::viscous_lambda(mu, least, in_stages));
      // Beside a liquid that is lighter, or more viscous: the pair has a viscosity of its own.
      for (std::size_t j = 0; j < materials.size(); ++j)
        if (liquid_used_[j] != 0u) {
          const bool both_yield =
              largest_yield_stress(materials[i]) > 0 && largest_yield_stress(materials[j]) > 0;
          const double of_pair = physics::pair_viscosity(mu, largest_viscosity(materials[j]), both_yield);
          viscous_lambda_ =
              std::max(viscous_lambda_,
                       physics::viscous_lambda(of_pair, std::min(density, least_density(j)), in_stages));
        }
    }
  }
  diffuses_ =
      std::isfinite(viscous_dt_) && (desc.viscosity == Viscosity::implicit ||
                                     (desc.viscosity == Viscosity::automatic && viscous_dt_ < static_dt_));
  if (!diffuses_) rest_dt_ = std::min(rest_dt_, viscous_dt_);
  static_dt_ = std::min(sound_dt_, rest_dt_);
  strong_pull_ = std::any_of(bodies_.begin(), bodies_.end(), [this](const BodyRecord& b) {
    const MaterialDesc& m = materials[b.desc.material.index];
    return !b.desc.fixed && !b.rigid() && 2 * m.damping + alpha_of(m, spring_dt_) > physics::single_step_pull;
  });
}

/// Height of the highest column in which movable bodies can stand: all of them on each other, but no higher than the scene [m].
/// Bodies count as they were added. A single one without walls stands on nothing.
double WorldImpl::column_height() const {
  const double g = length(desc.gravity);
  double height = 0;
  if (!(g > 0) || (!desc.domain.bounded && bodies_.size() < 2)) return height;
  const Vec3d up = desc.gravity * (-1.0 / g);
  for (const BodyRecord& b : bodies_) {
    if (b.desc.fixed || b.kinematic() || b.proxy()) continue;
    const Box box = b.desc.shape.bounds();
    const Vec3d size = box.max - box.min;
    height += std::abs(size.x * up.x) + std::abs(size.y * up.y) + std::abs(size.z * up.z);
  }
  return std::min(height, fall_height());
}

/// Limits of sound, gravity and speeds.
void WorldImpl::limit_motion(double support) {
  // Bodies count as they were added, not as they are now.
  double lightest = infinity, heaviest = 0;
  for (const BodyRecord& b : bodies_) {
    if (b.desc.fixed) continue;
    lightest = std::min(lightest, b.density);
    heaviest = std::max(heaviest, b.density);
  }
  const bool fluid = any_liquid();
  const double acoustic = physics::acoustic_dt(desc.courant, support, sound_speed_);
  spring_share_ = physics::spring_dt(1.0, lightest, heaviest, fluid ? densest_added_ : 0.0);
  if (const double height = column_height(); height > 0)
    spring_share_ =
        std::min(spring_share_, physics::standing_dt(desc.spacing, length(desc.gravity), height) / acoustic);
  spring_dt_ = acoustic * spring_share_;
  const bool mobile = heaviest > 0 && (disabled_facts_ & core::fact_mobile) == 0;
  if (fluid || mobile) {
    sound_dt_ = mobile ? spring_dt_ : acoustic;
    const FieldReach fields = any_field() ? reach_of_fields() : FieldReach{};
    const double g = length(desc.gravity) + fields.pull;
    if (fields.wind > 0) rest_dt_ = std::min(rest_dt_, desc.courant * support / fields.wind);
    if (g > 0) rest_dt_ = std::min(rest_dt_, physics::force_dt(desc.courant, support, g));
    // Counts what was added, not what was read: results must not depend on readings.
    if (seen_.speed > 0) rest_dt_ = std::min(rest_dt_, desc.courant * support / seen_.speed);
  }
  if (fluid)
    sound_dt_ = std::min(sound_dt_, acoustic * contrast_ * physics::support_factor(support / desc.spacing));
}

void WorldImpl::limit_tension(double sum) {
  if (!any_liquid()) return;
  for (std::size_t i = 0; i < materials.size(); ++i)
    if (liquid_used_[i] != 0u && materials[i].surface_tension > 0)
      rest_dt_ = std::min(
          rest_dt_, physics::tension_dt(materials[i].surface_tension, least_density(i), desc.spacing, sum));
}

/// Whether some of what is in use conducts better than something else that is not its other phase.
bool WorldImpl::uneven_conductors() const {
  constexpr double alike = 1.1;
  for (std::size_t i = 0; i < rows_.size(); ++i)
    for (std::size_t j = 0; j < rows_.size(); ++j)
      if (used(i) && used(j) && !physics::same_matter(rows_[i], i, rows_[j], j) &&
          largest_conductivity(rows_[i]) > alike * least_conductivity(rows_[j]))
        return true;
  return false;
}

/// The bound of the heat operator's spectrum.
void WorldImpl::limit_heat(double support, double sum) {
  std::vector<core::MaterialRow<double>> present;
  for (std::size_t i = 0; i < rows_.size(); ++i)
    if (used(i)) present.push_back(rows_[i]);
  heat_lambda_ = 0;
  changes_phase_ = false;
  for (const auto& i : present) {
    const double capacity = std::min(i.heat_capacity, i.liquid_heat_capacity);
    changes_phase_ = changes_phase_ || i.plateau != 0u;
    for (const auto& j : present) {
      const double k = physics::pair_conductivity(physics::resistivity_of(largest_conductivity(i)),
                                                  physics::resistivity_of(largest_conductivity(j)));
      heat_lambda_ = std::max(heat_lambda_, 2 * heat_margin * k * sum / (i.density * capacity));
    }
  }
  // Particles of a proxy that are lighter than its material store less heat.
  double lighter = 1;
  for (const BodyRecord& b : bodies_)
    lighter = std::max(lighter, materials[b.desc.material.index].density / b.density);
  heat_lambda_ *= lighter;
  if (!heat_from_outside()) return;
  // A surface takes more than the neighbours it stands for gave, where a particle is as close as it gets.
  const auto e = physics::make_wall_exchange<double>(support, desc.spacing);
  const double surface = physics::wall_area(e, e.smallest_distance) / e.smallest_distance;
  double fastest = 0;
  for (const auto& i : present)
    fastest = std::max(fastest, 2 * largest_conductivity(i) * surface /
                                    (i.density * std::min(i.heat_capacity, i.liquid_heat_capacity)));
  heat_lambda_ += fastest * lighter;
}

/// Precomputes what step() needs of the scene, because step() must neither search nor allocate.
void WorldImpl::derive_limits() {
  const double support = core::support_of(desc);
  const double sum = physics::lattice_laplacian_sum(support, desc.spacing);
  sound_dt_ = rest_dt_ = infinity;
  limit_motion(support);
  limit_tension(sum);
  static_dt_ = std::min(sound_dt_, rest_dt_);
  limit_viscosity(sum);
  limit_solute(sum);
  rows_ = material_rows();
  limit_heat(support, sum);
}

}  // namespace v0
}  // namespace meltsim
