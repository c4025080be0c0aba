// SPDX-License-Identifier: Apache-2.0
// Snapshots: State channels in order of id, in double, little-endian, checksummed. Backend and precision
// independent; what is stored is exact in the precision of the World that wrote it.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>

#include "description/validate.hpp"
#include "engine/held.hpp"
#include "engine/text.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/heat_boundary.hpp"
#include "snapshot/bytes.hpp"
#include "snapshot/other_bodies.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::Hash;
using core::hash_byte;
using core::hash_start;
using core::hash_text;

namespace {

// 14: liquid that comes in through faces; 13: how long bodies are held; 12: work of force fields; 11: bodies that deform; 10: heat that is owed; 9: contents of species; 8: settings of emitters,
// bodies that were removed, the box that the sound speed is derived from; 7: motions of bodies; 6: liquid that a nozzle
// holds; 5: whether heat flows; 4: materials, what the sound speed is derived from, strays; layers of nozzles follow from
// the time; 3: what freezes keeps its volume; 2: vertices change their particles
constexpr std::uint32_t format_version = 14;
/// WorldImpl::StoredState::layout() of that version.
constexpr std::uint64_t layout_of_version = 15199253922879274393u;

/// The continuation of a state also depends on these: whether temperatures were found level, whether something could melt.
constexpr std::uint32_t heat_level_bit = 1u, could_melt_bit = 2u;
/// A sound speed that follows the motion is stored at the end.
constexpr std::uint32_t follows_sound_bit = 4u;
/// The next step begins with a look at what moves.
constexpr std::uint32_t look_now_bit = 8u;

Error corrupt(const char* why) {
  return Error{ErrorCode::corrupt_data,
               core::text("snapshot: ", why, "; the World is unchanged, use another snapshot")};
}

/// Bits that a tag may have set.
constexpr std::uint32_t known_tag_bits = tag_material_mask | tag_solid | tag_surface | tag_fixed |
                                         tag_removed | tag_held | tag_kinematic | 0xffffu << tag_body_shift;

bool all_finite(const std::vector<Vec3d>& v) {
  for (const Vec3d& x : v)
    if (!finite(x)) return false;
  return true;
}

bool is_rotation(const Quat<double>& q) {
  return std::fabs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1) < 1e-2;
}

}  // namespace

/// Hash of the bodies' lattices as built, independent of what melted or froze since and of the widths of regions at the length of
/// the last sub-step.
std::uint64_t WorldImpl::lattice_hash() const {
  Hash h;
  h.add(lattice_.vertex_site);
  h.add(lattice_.vertex_body);
  h.add(lattice_.vertex_coordinates);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const core::BodyRow& row = lattice_.bodies[b];
    const std::uint32_t motion = motion_of(bodies_[b], false);  // whether it is held, tags say
    for (const std::uint32_t v : {row.stride_y, row.stride_z, motion, bodies_[b].desc.material.index})
      h.add(&v, sizeof v);
  }
  return h.value();
}

/// The numbers of a material that say what its particles' masses, volumes and enthalpies mean. Others (viscosity,
/// conductivity, stiffness, friction) may change from one run to the next, as may its name.
std::uint64_t WorldImpl::material_hash(const MaterialDesc& m) const {
  Hash h;
  const auto number = [&h](double v) {
    v += 0.0;  // -0 is 0
    h.add(&v, sizeof v);
  };
  for (const double v : {m.density, m.heat_capacity, m.latent_heat, m.melting_point, m.freezes ? 1.0 : 0.0,
                         m.melts_into ? double(m.melts_into.index) : -1.0,
                         m.dissolves_in ? double(m.dissolves_in.index) : -1.0, m.solubility,
                         m.heat_of_solution, desc.heat.model == HeatModel::enthalpy ? 1.0 : 0.0})
    number(v);
  for (const auto* points : {&m.heat_capacity_points, &m.density_points}) {
    number(double(points->size()));
    for (const PropertyPoint& p : *points) {
      number(p.temperature);
      number(p.value);
    }
  }
  if (m.melting_range != 0) number(m.melting_range);
  if (!m.solubility_points.empty()) {  // it says what is crystal
    number(double(m.solubility_points.size()));
    for (const PropertyPoint& p : m.solubility_points) {
      number(p.temperature);
      number(p.value);
    }
  }
  return h.value();
}

Result<std::uint64_t> WorldImpl::state_hash() {
  start_at_rest();
  fetch_state();
  Hash h;
  core::each_held(state_, species_.size(), [&h](auto held, const auto& array, const auto&) {
    if (!held.of_vertex && held.hashed == core::Hashed::always) h.add(array);
  });
  const bool freezing = std::any_of(materials.begin(), materials.end(),
                                    [](const auto& m) { return m.freezes || !m.solubility_points.empty(); });
  // A vertex marked as melted in the last step and one that melted before are the same state.
  for (std::size_t v = 0; v < state_.vertex_state.size(); ++v) {
    const std::uint32_t live = state_.vertex_state[v] == core::vertex_live ? 1u : 0u;
    h.add(&live, sizeof live);
    if (live == 0u) continue;
    core::each_held(state_, 0, [&](auto held, const auto& array, const auto&) {
      const bool included =
          held.hashed == core::Hashed::live || (held.hashed == core::Hashed::freezing && freezing);
      if (held.of_vertex && included) h.add(&array[v], sizeof array[v]);
    });
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (bodies_[b].kinematic() || bodies_[b].proxy()) h.add(&state_.motion[b], sizeof(physics::RigidMotion));
  h.add(state_.mesh_points);
  return h.value();
}

/// Contents of a snapshot beside the arrays of the state.
struct WorldImpl::StoredState {
  std::uint32_t precision = 0;
  std::uint64_t materials = 0, bodies = 0;  ///< how many
  double spacing = 0, time = 0;
  std::uint64_t steps = 0;
  double sound_speed = 0, last_max_speed = 0;
  Extremes seen;
  Vec3d origin;
  std::uint64_t lattice = 0;  ///< lattice_hash()
  double heat_owed = 0;
  std::uint64_t removed = 0;  ///< particles, those that compact() has left out, too
  std::uint64_t flags = 0;    ///< 64 bits, so that what follows stays aligned
  std::vector<std::uint64_t> material_hashes;
  std::vector<EmitterState> emitters;
  std::vector<std::uint64_t>
      taken;  ///< per body: particles that went with it and one, 0: it is there; BodyRecord::before
  std::vector<std::uint64_t> deformed;  ///< per body: 1: mesh_points has its particles
  std::vector<BodyRelease> releases;    ///< per body
  FollowedSound followed;

  /// Particles that bodies were built of, less those removed with them.
  std::uint64_t built(const std::vector<BodyRecord>& records) const {
    std::uint64_t sum = 0;
    for (std::size_t b = 0; b < records.size(); ++b)
      sum += records[b].vertices + static_cast<std::uint64_t>(before(b)) - (gone(b) ? went(b) : 0);
    return sum;
  }
  /// taken[b] holds two numbers, so that older snapshots are read.
  static std::uint64_t pack(const BodyRecord& b) {
    return static_cast<std::uint64_t>(b.before) << 32u | (b.gone ? b.taken + 1 : 0);
  }
  bool gone(std::size_t b) const { return (taken[b] & 0xffffffffu) != 0; }
  std::uint64_t went(std::size_t b) const { return (taken[b] & 0xffffffffu) - 1; }
  std::int64_t before(std::size_t b) const { return static_cast<std::int32_t>(taken[b] >> 32u); }

  /// Visits all parts of a snapshot in its order, until a visit returns false.
  template <class Value, class Array>
  bool each(core::SceneState& s, Value value, Array array) {
    bool there = value(precision) && value(materials) && value(bodies) && value(spacing) && value(time) &&
                 value(steps) && value(sound_speed) && value(last_max_speed) && value(seen) &&
                 value(origin) && value(lattice) && value(s.heat_in) && value(s.field_work) &&
                 value(s.field_impulse) && value(heat_owed) && value(s.melted) && value(s.frozen) &&
                 value(removed) && value(s.strayed) && value(s.entered) && value(flags) &&
                 array(material_hashes) && array(emitters);
    core::each_held(s, most_species, [&](auto, auto& held, const auto&) { there = there && array(held); });
    return there && array(s.motion) && array(taken) && array(deformed) && array(s.mesh_points) &&
           array(releases) && ((flags & follows_sound_bit) == 0 || value(followed));
  }

  /// A number that changes with the State rows of fields.def and with the size of what else is stored.
  static constexpr std::uint64_t layout() {
    std::uint64_t h = hash_start;
#define MELTSIM_HELD(name, host, owner, channel, part, first, hashed) \
  h = hash_text(h, #name " " #host " " #owner " " #channel " " #part);
#define MELTSIM_HELD_PER_SPECIES MELTSIM_HELD
#include "meltsim/fields.def"
    for (const std::size_t size : {sizeof(Extremes), sizeof(EmitterState), sizeof(physics::RigidMotion),
                                   sizeof(physics::MeshPoint), sizeof(BodyRelease), sizeof(FollowedSound)})
      h = hash_byte(h, static_cast<unsigned char>(size));
    return h;
  }
};

/// A state to be restored into a World of the same scene.
class WorldImpl::SnapshotCheck {
 public:
  SnapshotCheck(const WorldImpl& world, const StoredState& stored, const core::SceneState& s)
      : w_(world),
        d_(stored),
        s_(s),
        fixed_(world.fixed_in(s)),
        rows_(world.material_rows()),
        low_(world.desc.domain.min - stored.origin),
        high_(world.desc.domain.max - stored.origin),
        largest_(world.desc.precision == Precision::single_precision ? 1e37 : 1e300) {}

  Status check();

 private:
  Status check_numbers() const;
  Status check_particle(std::size_t i);
  Status check_solid(std::size_t i) const;
  bool is_outside(Vec3d x, std::uint32_t tag) const;
  Status check_motions() const;
  Status check_vertex(std::size_t v) const;

  const WorldImpl& w_;
  const StoredState& d_;
  const core::SceneState& s_;
  std::vector<char> fixed_;  ///< per body
  std::vector<core::MaterialRow<double>> rows_;
  Vec3d low_, high_;  ///< the domain, from the stored origin [m]
  double largest_;    ///< a mass, volume or squared speed
  std::uint64_t removed_ = 0, solid_ = 0;
};

/// Refuses what restore() would refuse: writes of a host's stage behind step.integrate the next sub-step checks.
Status WorldImpl::check_storable() const {
  const auto amiss = [this](std::size_t i) {
    return !finite(state_.position[i])         ? "position"
           : !finite(state_.velocity[i])       ? "velocity"
           : !std::isfinite(state_.volume[i])  ? "volume"
           : std::isfinite(state_.enthalpy[i]) ? nullptr
                                               : "enthalpy";
  };
  for (std::size_t i = 0; i < state_.position.size(); ++i)
    if (const char* const what = amiss(i))
      return Error{ErrorCode::halted,
                   core::text("snapshot: particle ", i, ": its ", what,
                              " is not finite, and no World could go on from it; a stage of the host that "
                              "writes it must come before step.integrate, which checks it. restore() an "
                              "earlier snapshot to go on")};
  return {};
}

Result<std::vector<std::uint8_t>> WorldImpl::snapshot() {
  static_assert(StoredState::layout() == layout_of_version,
                "what a snapshot holds has changed: raise format_version and set layout_of_version anew");
  // Values that follow from added things, such as the sound speed, are stored, too.
  if (Status s = prepare(); !s) return s.error();
  fetch_state();
  if (Status s = check_storable(); !s) return s.error();
  take_sound_work();
  StoredState stored = stored_state();
  core::Writer w;
  w.bytes.insert(w.bytes.end(), std::begin(core::snapshot_magic), std::end(core::snapshot_magic));
  w.value(format_version);
  stored.each(
      state_,
      [&w](const auto& v) {
        w.value(v);
        return true;
      },
      [&w](const auto& v) {
        w.array(v);
        return true;
      });
  Hash h;
  h.add(w.bytes);
  w.value(h.value());
  return w.bytes;
}

WorldImpl::StoredState WorldImpl::stored_state() const {
  StoredState d;
  d.precision = static_cast<std::uint32_t>(desc.precision);
  d.materials = materials.size();
  d.bodies = bodies_.size();
  d.spacing = desc.spacing;
  d.time = time;
  d.steps = steps;
  d.sound_speed = sound_speed_;
  d.last_max_speed = last_max_speed_;
  d.seen = seen_;
  d.origin = origin_;
  d.lattice = lattice_hash();
  d.heat_owed = heat_owed_;
  d.removed = state_.removed + forgotten_;
  const bool heated = heat_from_outside() || host_heats() || solution_heats();  // from the next step on
  d.flags = (state_.heat_level && !heated ? heat_level_bit : 0u) | (could_melt_ ? could_melt_bit : 0u) |
            (follows_sound() ? follows_sound_bit | (look_now_ ? look_now_bit : 0u) : 0u);
  for (const MaterialDesc& m : materials) d.material_hashes.push_back(material_hash(m));
  for (const EmitterRecord& e : emitters_)
    d.emitters.push_back({e.first_layer, e.skipped, e.on ? std::uint64_t{1} : 0, e.desc.from, e.desc.speed,
                          e.desc.temperature, e.desc.center, e.desc.level.value_or(0), e.first_id, e.ids});
  for (const BodyRecord& b : bodies_) d.taken.push_back(StoredState::pack(b));
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    d.deformed.push_back(deforms(static_cast<std::uint32_t>(b)) ? 1 : 0);
  d.releases = releases();
  d.followed = sound_;
  return d;
}

Status WorldImpl::restore(const std::uint8_t* data, std::size_t bytes) {
  return restore_state(data, bytes, nullptr);
}

/// bodies: those that it is of, which come in place of the World's; null: it is of the World's.
Status WorldImpl::restore_state(const std::uint8_t* data, std::size_t bytes,
                                const std::vector<StoredBody>* bodies) {
  StoredState stored;
  core::SceneState s;
  if (Status status = read_snapshot(data, bytes, stored, s); !status) return status;
  // The scene first: a snapshot of another scene is not damaged.
  if (Status status = check_same_setting(stored, s); !status) return status;
  std::optional<OtherBodies> others;
  if (bodies != nullptr) {
    if (!finite(stored.origin)) return corrupt("the origin is not finite");
    others.emplace(*this, stored.origin);
    if (Status status = others->come_back(*bodies); !status) return status;
    stored.lattice = lattice_hash();  // sites around bodies may be more or fewer here
  }
  if (Status status = check_same_bodies(stored, s); !status) return status;
  if (Status status = check_stored(stored, s); !status) return status;
  take_over(stored, std::move(s), others ? &*others : nullptr);
  return {};
}

Status WorldImpl::read_snapshot(const std::uint8_t* data, std::size_t bytes, StoredState& stored,
                                core::SceneState& s) {
  if (bytes < 24 || !core::begins_with(core::snapshot_magic, data, bytes))
    return corrupt(core::begins_with(core::saved_world_magic, data, bytes)
                       ? "this is a saved World, which load_saved() takes"
                       : "not a meltsim snapshot");
  Hash h;
  h.add(data, bytes - 8);
  std::uint64_t checksum = 0;
  std::memcpy(&checksum, data + bytes - 8, 8);
  std::uint32_t version = 0;
  core::Reader r(data + 8, bytes - 16);
  if (!r.value(version)) return corrupt("truncated");
  if (version != format_version)
    return Error{ErrorCode::version_mismatch,
                 core::text("snapshot: format version ", version, ", this library reads ", format_version,
                            "; write it again with this version")};
  if (checksum != h.value()) return corrupt("checksum does not match: truncated or changed");
  if (!stored.each(
          s, [&r](auto& v) { return r.value(v); }, [&r](auto& v) { return r.array(v); }) ||
      r.left() != 0)
    return corrupt("truncated");
  const std::size_t n = s.position.size(), nv = s.vertex_state.size();
  bool alike = stored.material_hashes.size() == stored.materials && s.motion.size() == stored.bodies &&
               stored.taken.size() == stored.bodies && stored.deformed.size() == stored.bodies &&
               stored.releases.size() == stored.bodies;
  core::each_held(s, 0, [&](auto held, const auto& array, const auto&) {
    alike = alike && array.size() == (held.of_vertex ? nv : n);
  });
  if (!alike) return corrupt("arrays of different length");
  if (n >= core::none || nv >= core::none) return corrupt("more particles or vertices than 32 bits number");
  return {};
}

namespace {
Error mismatch(const char* what, std::uint64_t have, std::uint64_t want) {
  return core::invalid("snapshot: ", what, ": this World has ", have, ", the snapshot ", want,
                       "; build the World from the same scene first");
}
}  // namespace

/// Whether the World was made as the one that wrote it, but for bodies.
Status WorldImpl::check_same_setting(const StoredState& stored, const core::SceneState& s) const {
  if (stored.spacing != desc.spacing)
    return core::invalid("snapshot: spacing: this World has ", desc.spacing, " m, the snapshot ",
                         stored.spacing, " m; build the World from the same scene first");
  if (stored.materials != materials.size()) return mismatch("materials", materials.size(), stored.materials);
  for (std::size_t m = 0; m < materials.size(); ++m)
    if (stored.material_hashes[m] != material_hash(materials[m]))
      return core::invalid(
          "snapshot: materials: \"", materials[m].name,
          "\" has another density, heat capacity, latent heat or melting point, or melts into "
          "something else, than in the World that wrote it (or heat.model differs); build the World from the "
          "same scene first");
  for (std::size_t k = 0; k < s.solute.size(); ++k)
    if (s.solute[k].size() != (k < species_.size() ? s.position.size() : 0))
      return corrupt("contents of different length");
  if (stored.emitters.size() != emitters_.size())
    return mismatch("emitters", emitters_.size(), stored.emitters.size());
  return {};
}

/// Whether it is of the bodies that there are.
Status WorldImpl::check_same_bodies(const StoredState& stored, const core::SceneState& s) const {
  if (stored.bodies != bodies_.size()) return mismatch("bodies", bodies_.size(), stored.bodies);
  if (s.vertex_state.size() != lattice_.vertex_site.size())
    return mismatch("lattice vertices", lattice_.vertex_site.size(), s.vertex_state.size());
  if (stored.lattice != lattice_hash())
    return core::invalid(
        "snapshot: lattice vertices: numbered differently; build the World from the same scene first");
  return {};
}

/// Checks every value to be restored: in range, and consistent with the others and with the scene.
Status WorldImpl::check_stored(const StoredState& stored, const core::SceneState& s) const {
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if ((stored.gone(b) && stored.went(b) > bodies_[b].vertices + s.frozen) ||
        stored.before(b) > static_cast<std::int64_t>(s.melted) ||
        -stored.before(b) > static_cast<std::int64_t>(s.frozen))
      return corrupt("a body has lost more than it had");
  for (const BodyRelease& r : stored.releases)
    if (!(r.held_until >= 0) || !(length(r.velocity) <= 1e15) || !finite(r.angular_velocity))
      return corrupt("when or how a body is let go is not usable");
  if (Status status = check_reservoirs(stored, s.position.size()); !status) return status;
  if (Status status = SnapshotCheck(*this, stored, s).check(); !status) return status;
  if (Status status = check_mesh_points(stored.deformed, s.mesh_points, stored.time); !status) return status;
  if (Status status = check_speeds(stored); !status) return status;
  for (std::size_t k = 0; k < stored.emitters.size(); ++k)
    if (Status status = check_emitter(k, stored.emitters[k], stored.time); !status) return status;
  return {};
}

/// Levels of emitters, and what they have in reserve of so many particles.
Status WorldImpl::check_reservoirs(const StoredState& stored, std::uint64_t particles) const {
  for (std::size_t k = 0; k < emitters_.size(); ++k) {
    const EmitterState& s = stored.emitters[k];
    const EmitterRecord& e = emitters_[k];
    if (s.ids != e.ids)
      return core::invalid("snapshot: emitters: \"", e.desc.name, "\" may have ", e.ids,
                           " particles in this World, ", s.ids,
                           " in the snapshot; build the World from the same scene first");
    if (std::uint64_t{s.first_id} + s.ids > particles)
      return corrupt("the reserve of an emitter is not usable");
    if (e.reservoir() && (!core::validate_level("", s.level, desc) ||
                          core::height_above_floor(desc, s.level) > e.desc.height * (1 + 1e-9)))
      return corrupt("the level of an emitter is not usable");
  }
  return {};
}

/// Checks the quantities that the sound speed was derived from, and its value.
Status WorldImpl::check_speeds(const StoredState& d) {
  const Extremes& seen = d.seen;
  // Both are infinite while nothing was seen.
  if (seen.high >= seen.low && !(finite(seen.min) && finite(seen.max)))
    return corrupt("a height is not usable");
  if (std::isnan(seen.low) || std::isnan(seen.high) || seen.speed < 0 || d.sound_speed < 0 ||
      d.last_max_speed < 0 || d.heat_owed < 0)
    return corrupt("a speed or height is not usable");
  const auto usable = [](double v) { return v >= 0 && std::isfinite(v); };
  const FollowedSound& f = d.followed;
  const double most = d.sound_speed * (1 + 1e-9);
  if (!usable(f.now) || f.now > most || !usable(f.told) || !usable(f.level) || f.level > most ||
      !std::isfinite(f.head) || !std::isfinite(f.work) || f.elastic > 1)
    return corrupt("a sound speed is not usable");
  return {};
}

/// Which bodies are held in a snapshot.
std::vector<char> WorldImpl::held_in(const StoredState& d, const core::SceneState& s) const {
  // Of a body without a particle, all of which have melted, no tag says whether it is held: it is until it is due to be let go.
  std::vector<char> held = fixed_in(s), there(bodies_.size(), 0);
  for (const std::uint32_t tag : s.tag)
    if (is_solid(tag) && body_of(tag) != 0u && body_of(tag) <= there.size()) there[body_of(tag) - 1u] = 1;
  for (std::size_t b = 0; b < held.size(); ++b) {
    if (there[b] == 0 && d.releases[b].held_until > d.time) held[b] = 1;
    if (d.gone(b)) held[b] = 0;
  }
  return held;
}

/// others: bodies that come along; null: the World's. What could be without memory comes first, so that nothing changes then.
void WorldImpl::take_over(const StoredState& d, core::SceneState&& s, OtherBodies* others) {
  const std::vector<char> held = held_in(d, s);
  s.forces.assign(bodies_.size(), {});
  s.events.assign(event_watch_ ? event_watch_->capacity : 0, {});
  collect_samples();
  drop_samples_from(d.time);
  if (capacity_ != 0) take_sound_work();  // of what is undone
  if (others != nullptr) others->stay();
  state_ = std::move(s);
  state_.removed =
      static_cast<std::uint64_t>(std::count_if(state_.tag.begin(), state_.tag.end(), is_removed));
  forgotten_ = d.removed - state_.removed;
  state_stale_ = false;
  laid_out_ = {};
  fills_ = {};  // it may hold other liquid than was added here
  pressed_ = true;
  state_.heat_level = (d.flags & heat_level_bit) != 0u;
  could_melt_ = (d.flags & could_melt_bit) != 0u && d.steps > 0;
  measure_ = false;
  plan_until_ = 0;
  heat_owed_ = d.heat_owed;
  forget_what_followed();
  time = d.time;
  steps = d.steps;
  take_over_sound(d);
  origin_ = d.origin;
  origin_set_ = true;
  for (std::size_t k = 0; k < d.emitters.size(); ++k) {
    put_emitter(d.emitters[k], emitters_[k]);
    limit_layers(emitters_[k]);
  }
  take_over_bodies(d, held);
  if (d.sound_speed > 0) fit_sound_to_settings(d.sound_speed);
  dirty_ = true;
}

void WorldImpl::take_over_sound(const StoredState& d) {
  sound_speed_ = d.sound_speed;
  last_max_speed_ = d.last_max_speed;
  seen_ = d.seen;
  seen_particles_ = state_.position.size();
  seen_emitters_ = emitters_.size();
  seen_bodies_ = bodies_.size();
  added_ = !(d.sound_speed > 0);
  sound_ = d.followed;
  look_now_ = !(d.followed.now > 0) || (d.flags & look_now_bit) != 0u;
}

/// Gravity, fields, tension, density_error and a sound speed that is set are the World's, and may be others than then. A sound speed that is
/// derived is not slower than the stored one, which pressures follow from.
void WorldImpl::fit_sound_to_settings(double stored) {
  see_driven(0);
  derive_sound_speed();
  if (!(desc.sound_speed > 0)) sound_speed_ = std::max(sound_speed_, stored);
  look_now_ = look_now_ || sound_speed_ != stored;
}

void WorldImpl::take_over_bodies(const StoredState& d, const std::vector<char>& held) {
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    lattice_.rests[b].first_point = d.deformed[b] != 0 ? 0 : core::none;
  place_mesh_points();
  state_.forces.assign(bodies_.size(), {});
  forget_events();
  solids_built_ = d.built(bodies_);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    bodies_[b].gone = d.gone(b);
    bodies_[b].taken = d.gone(b) ? d.went(b) : 0;
    bodies_[b].before = d.before(b);
    bodies_[b].since = 0;
    hold_as(b, held[b] != 0);
  }
  set_releases(d.releases);
}

void WorldImpl::put_emitter(const EmitterState& s, EmitterRecord& e) {
  e.first_layer = s.first_layer;
  e.skipped = s.skipped;
  e.on = s.on != 0;
  e.desc.from = s.from;
  e.desc.speed = s.speed;
  e.desc.temperature = s.temperature;
  e.desc.center = s.center;
  e.first_id = s.first_id;
  if (e.reservoir()) e.desc.level = s.level;
}

/// Whether a nozzle can be in that state.
Status WorldImpl::check_emitter(std::size_t k, const EmitterState& s, double new_time) const {
  EmitterRecord e = emitters_[k];
  put_emitter(s, e);
  if (!std::isfinite(s.from) || !(s.speed > 0 && s.speed <= 1e15) || !std::isfinite(s.temperature) ||
      !(s.temperature >= absolute_zero) || s.on > 1 || !finite(s.center))
    return corrupt("a nozzle's setting is not usable");
  // Also of a nozzle that has ended: a speed set since moves where its layers count from.
  if (s.first_layer > layers_due(e, new_time) || s.skipped > layers_due(e, new_time))
    return corrupt("a nozzle's first layer is yet to come");
  return {};
}

/// Whether bodies can deform so.
Status WorldImpl::check_mesh_points(const std::vector<std::uint64_t>& deformed,
                                    const std::vector<physics::MeshPoint>& points, double new_time) const {
  std::uint64_t count = 0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (deformed[b] > 1 || (deformed[b] != 0 && (!bodies_[b].kinematic() || bodies_[b].desc.growth > 0)))
      return corrupt("a body deforms that cannot");
    count += deformed[b] != 0 ? bodies_[b].vertices : 0;
  }
  if (points.size() != count) return corrupt("arrays of different length");
  for (const physics::MeshPoint& p : points)
    if (!finite(p.first) || !finite(p.then) || !finite(p.velocity) || !std::isfinite(p.from) ||
        !std::isfinite(p.until) || !(p.until > p.from || p.until <= new_time))
      return corrupt("how a body deforms is not usable");
  return {};
}

Status WorldImpl::SnapshotCheck::check() {
  if (Status status = check_numbers(); !status) return status;
  for (std::size_t i = 0; i < s_.position.size(); ++i)
    if (Status status = check_particle(i); !status) return status;
  if (Status status = check_motions(); !status) return status;
  constexpr std::uint64_t most = std::uint64_t{1} << 62;
  if (removed_ > d_.removed || d_.removed > most || s_.strayed > most || s_.entered > most ||
      d_.removed + s_.entered < w_.reserved_ids() + s_.strayed)
    return corrupt("the number of removed particles is wrong");
  if (solid_ + s_.melted != d_.built(w_.bodies_) + s_.frozen)
    return corrupt("the number of solid particles is wrong");
  for (std::size_t v = 0; v < s_.vertex_state.size(); ++v)
    if (Status status = check_vertex(v); !status) return status;
  return {};
}

Status WorldImpl::SnapshotCheck::check_numbers() const {
  if (!(std::isfinite(d_.time) && d_.time >= 0)) return corrupt("the time is not usable");
  for (const double v : {d_.sound_speed, d_.last_max_speed, d_.seen.speed, s_.heat_in, s_.field_work,
                         s_.field_impulse.x, s_.field_impulse.y, s_.field_impulse.z, d_.heat_owed})
    if (!std::isfinite(v)) return corrupt("a speed or the heat that came in is not finite");
  if (!finite(d_.origin)) return corrupt("the origin is not finite");
  if (Status status = w_.check_origin(d_.origin); !status) return status;
  if (!all_finite(s_.position) || !all_finite(s_.velocity) || !all_finite(s_.contact_slip))
    return corrupt("a position, velocity or slip is not finite");
  return {};
}

Status WorldImpl::SnapshotCheck::check_particle(std::size_t i) {
  if (!(s_.mass[i] > 1 / largest_ && s_.mass[i] < largest_) ||
      !(s_.volume[i] > 1 / largest_ && s_.volume[i] < largest_) || !std::isfinite(s_.enthalpy[i]))
    return corrupt("a mass, volume or enthalpy is not usable");
  for (std::size_t k = 0; k < w_.species_.size(); ++k)
    // Contents stay within 0 and the mass but for rounding, and for liquid so crowded that a flag is raised.
    if (!(s_.solute[k][i] >= -s_.mass[i] && s_.solute[k][i] <= 2 * s_.mass[i]))
      return corrupt("a content is not usable");
  if (!(dot(s_.velocity[i], s_.velocity[i]) < largest_)) return corrupt("a velocity is not usable");
  const std::uint32_t tag = s_.tag[i], v = s_.vertex_of_id[i];
  if (material_of(tag) >= w_.materials.size() || body_of(tag) > w_.bodies_.size() ||
      (tag & ~known_tag_bits) != 0u)
    return corrupt("a tag names a material or body this World does not have");
  if (v >= s_.vertex_state.size() && v != core::none) return corrupt("a lattice vertex is out of range");
  if (is_removed(tag)) {
    ++removed_;
    return {};
  }
  // A thousandth of a degree for rounding.
  if (physics::temperature_of(rows_[material_of(tag)], s_.enthalpy[i] / s_.mass[i]) <
      -physics::kelvin_offset - 0.001)
    return corrupt("a temperature is below 0 K");
  if (is_outside(s_.position[i], tag)) return corrupt("a particle is outside the domain of this World");
  if (is_solid(tag)) {
    ++solid_;
    return check_solid(i);
  }
  if (w_.leaves_lattice(material_of(tag))) return corrupt("a liquid particle is of a solid material");
  return {};
}

bool WorldImpl::SnapshotCheck::is_outside(Vec3d x, std::uint32_t tag) const {
  const DomainDesc& domain = w_.desc.domain;
  // Rounded to single precision, a coordinate at a wall may be this far beyond it.
  const double slack = 1e-2 * w_.desc.spacing;
  // A corner of a rigid body that hits a wall does not give way, and the wall's spring is soft.
  const bool rigid = is_solid(tag) && body_of(tag) != 0u && w_.bodies_[body_of(tag) - 1u].rigid();
  const double beyond[] = {low_.x - x.x,  x.x - high_.x, low_.y - x.y,
                           x.y - high_.y, low_.z - x.z,  x.z - high_.z};
  for (std::size_t face = 0; face < 6 && domain.bounded; ++face)
    if (beyond[face] > (rigid ? core::support_of(w_.desc) : slack) &&
        (is_fluid(tag) || domain.faces[face] != Face::open))
      return true;
  return false;
}

Status WorldImpl::SnapshotCheck::check_solid(std::size_t i) const {
  const std::uint32_t tag = s_.tag[i], body = body_of(tag), v = s_.vertex_of_id[i];
  if (v == core::none || s_.vertex_id[v] != i || s_.vertex_state[v] != core::vertex_live)
    return corrupt("a solid particle has no lattice vertex");
  if (body != w_.lattice_.vertex_body[v] + 1u ||
      material_of(tag) != w_.bodies_[body - 1u].desc.material.index ||
      ((tag & tag_fixed) != 0u) != (fixed_[body - 1u] != 0) ||
      ((tag & tag_kinematic) != 0u) != w_.bodies_[body - 1u].kinematic())
    return corrupt("a solid particle is not of the body it is in");
  return {};
}

Status WorldImpl::SnapshotCheck::check_motions() const {
  for (const physics::RigidMotion& m : s_.motion)
    for (const physics::RigidPlace* p : {&m.first, &m.then})
      if (!finite(p->position) || !finite(p->velocity) || !finite(p->angular_velocity) ||
          !is_rotation(p->orientation) || !std::isfinite(m.from) || !(std::fabs(m.until) < infinity))
        return corrupt("the motion of a body is not usable");
  return {};
}

Status WorldImpl::SnapshotCheck::check_vertex(std::size_t v) const {
  const std::size_t n = s_.position.size(), nv = s_.vertex_state.size();
  const std::uint32_t i = s_.vertex_id[v];
  if (s_.vertex_state[v] > core::vertex_melted) return corrupt("the state of a lattice vertex is unknown");
  if (i >= n && (i != core::none || s_.vertex_state[v] == core::vertex_live))
    return corrupt("a lattice vertex has no particle");
  if (s_.vertex_state[v] == core::vertex_live && (!is_solid(s_.tag[i]) || s_.vertex_of_id[i] != v))
    return corrupt("a lattice vertex names a particle that is not its own");
  const std::uint32_t label = s_.vertex_piece[v];
  if (label >= nv || w_.lattice_.vertex_body[label] != w_.lattice_.vertex_body[v])
    return corrupt("a piece label is out of range");
  if (!is_rotation(s_.region_rotation[v])) return corrupt("a region's rotation is none");
  return {};
}

}  // namespace v0
}  // namespace meltsim
