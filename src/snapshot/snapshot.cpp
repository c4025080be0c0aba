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
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

namespace {

constexpr char magic[8] = {'M', 'E', 'L', 'T', 'S', 'N', 'A', 'P'};
// 12: work of force fields; 11: bodies that deform; 10: heat that is owed; 9: contents of species; 8: settings of emitters, bodies that were removed, the box that the sound speed is derived from; 7: motions of bodies; 6: liquid that a nozzle holds; 5: whether heat flows; 4: materials, what the sound speed is derived from, strays; layers of nozzles follow from the time; 3: what freezes
// keeps its volume; 2: vertices change their particles
constexpr std::uint32_t format_version = 12;

/// What goes on from a state hangs on these, too: whether temperatures were found level, whether something could melt.
constexpr std::uint32_t heat_level_bit = 1u, may_melt_bit = 2u;
/// The sound speed follows what moves: where it is stands at the end.
constexpr std::uint32_t follows_sound_bit = 4u;

/// FNV-1a, 64 bits.
class Hash {
 public:
  void add(const void* data, std::size_t bytes) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; ++i) value_ = (value_ ^ p[i]) * 1099511628211ull;
  }
  template <class V>
  void add(const std::vector<V>& v) {
    if (!v.empty()) add(v.data(), v.size() * sizeof(V));
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 14695981039346656037ull;
};

class Writer {
 public:
  template <class V>
  void value(const V& v) {
    const auto* p = reinterpret_cast<const std::uint8_t*>(&v);
    bytes.insert(bytes.end(), p, p + sizeof(V));
  }
  template <class V>
  void array(const std::vector<V>& v) {
    value(static_cast<std::uint64_t>(v.size()));
    if (v.empty()) return;
    const auto* p = reinterpret_cast<const std::uint8_t*>(v.data());
    bytes.insert(bytes.end(), p, p + v.size() * sizeof(V));
  }
  std::vector<std::uint8_t> bytes;
};

class Reader {
 public:
  Reader(const std::uint8_t* data, std::size_t bytes) : p_(data), left_(bytes) {}
  template <class V>
  bool value(V& v) {
    if (left_ < sizeof(V)) return false;
    std::memcpy(&v, p_, sizeof(V));
    p_ += sizeof(V);
    left_ -= sizeof(V);
    return true;
  }
  template <class V>
  bool array(std::vector<V>& v) {
    std::uint64_t n = 0;
    if (!value(n) || n > left_ / sizeof(V)) return false;
    v.resize(static_cast<std::size_t>(n));
    if (n != 0) std::memcpy(v.data(), p_, v.size() * sizeof(V));
    p_ += v.size() * sizeof(V);
    left_ -= v.size() * sizeof(V);
    return true;
  }
  std::size_t left() const { return left_; }

 private:
  const std::uint8_t* p_;
  std::size_t left_;
};

/// The arrays of fields.def.
bool read_held(Reader& r, core::SceneState& s) {
  bool there = true;
  core::each_held(s, most_species, [&](auto, auto& array, const auto&) { there = there && r.array(array); });
  return there;
}

Error corrupt(const char* why) {
  return Error{ErrorCode::corrupt_data,
               core::text("snapshot: ", why, "; the World is unchanged, use another snapshot")};
}

/// All that a tag may have set.
constexpr std::uint32_t known_tag_bits = tag_material_mask | tag_solid | tag_surface | tag_fixed |
                                         tag_removed | tag_held | tag_kinematic | 0xffffu << tag_body_shift;

bool all_finite(const std::vector<Vec3d>& v) {
  for (const Vec3d& x : v)
    if (!finite(x)) return false;
  return true;
}

}  // namespace

/// What bodies' lattices are like as built, whatever melted or froze since, and however wide regions are at the length of
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

Result<std::vector<std::uint8_t>> WorldImpl::snapshot() {
  // What follows from something that was added, such as the sound speed, is part of what is stored.
  if (Status s = prepare(); !s) return s.error();
  fetch_state();
  take_sound_work();
  Writer w;
  w.bytes.insert(w.bytes.end(), magic, magic + 8);
  w.value(format_version);
  w.value(static_cast<std::uint32_t>(desc.precision));
  w.value(static_cast<std::uint64_t>(materials.size()));
  w.value(static_cast<std::uint64_t>(bodies_.size()));
  w.value(desc.spacing);
  w.value(time);
  w.value(steps);
  w.value(sound_speed_);
  w.value(last_max_speed_);
  w.value(seen_);
  w.value(origin_);
  w.value(lattice_hash());
  w.value(state_.heat_in);
  w.value(state_.field_work);
  w.value(state_.field_impulse);
  w.value(heat_owed_);
  w.value(state_.melted);
  w.value(state_.frozen);
  w.value(state_.removed);
  w.value(state_.strayed);
  // 64 bits, so that what follows stays aligned.
  w.value(static_cast<std::uint64_t>((state_.heat_level ? heat_level_bit : 0u) |
                                     (may_melt_ ? may_melt_bit : 0u) |
                                     (follows_sound() ? follows_sound_bit : 0u)));
  std::vector<std::uint64_t> hashes;
  std::vector<EmitterState> layers;
  std::vector<std::uint64_t> taken;  // per body: particles that went with it and one; 0: it is there
  for (const BodyRecord& b : bodies_) taken.push_back(b.gone ? b.taken + 1 : 0);
  for (const MaterialDesc& m : materials) hashes.push_back(material_hash(m));
  for (const EmitterRecord& e : emitters_)
    layers.push_back({e.first_layer, e.skipped, e.on ? std::uint64_t{1} : 0, e.desc.from, e.desc.speed,
                      e.desc.temperature, e.desc.center});
  w.array(hashes);
  w.array(layers);
  core::each_held(state_, most_species, [&w](auto, const auto& array, const auto&) { w.array(array); });
  w.array(state_.motion);
  w.array(taken);
  std::vector<std::uint64_t> deformed;  // per body: 1: mesh_points has its particles
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    deformed.push_back(deforms(static_cast<std::uint32_t>(b)) ? 1 : 0);
  w.array(deformed);
  w.array(state_.mesh_points);
  if (follows_sound()) w.value(sound_);
  Hash h;
  h.add(w.bytes);
  w.value(h.value());
  return w.bytes;
}

Status WorldImpl::restore(const std::uint8_t* data, std::size_t bytes) {
  if (data == nullptr || bytes < 24 || std::memcmp(data, magic, 8) != 0)
    return corrupt("not a meltsim snapshot");
  Hash h;
  h.add(data, bytes - 8);
  std::uint64_t checksum = 0;
  std::memcpy(&checksum, data + bytes - 8, 8);
  std::uint32_t version = 0, precision = 0;
  Reader r(data + 8, bytes - 16);
  if (!r.value(version)) return corrupt("truncated");
  if (version != format_version)
    return Error{ErrorCode::version_mismatch,
                 core::text("snapshot: format version ", version, ", this library reads ", format_version,
                            "; write it again with this version")};
  if (checksum != h.value()) return corrupt("checksum does not match: truncated or changed");
  std::uint64_t material_count = 0, body_count = 0, new_steps = 0, lattice = 0;
  double spacing = 0, owed = 0, new_time = 0, sound = 0, speed = 0;
  Extremes seen;
  Vec3d origin;
  core::SceneState s;
  std::uint64_t flags = 0;
  FollowedSound followed;
  std::vector<std::uint64_t> hashes;
  std::vector<EmitterState> layers;
  std::vector<std::uint64_t> taken, deformed;
  if (!(r.value(precision) && r.value(material_count) && r.value(body_count) && r.value(spacing) &&
        r.value(new_time) && r.value(new_steps) && r.value(sound) && r.value(speed) && r.value(seen) &&
        r.value(origin) && r.value(lattice) && r.value(s.heat_in) && r.value(s.field_work) &&
        r.value(s.field_impulse) && r.value(owed) && r.value(s.melted) && r.value(s.frozen) &&
        r.value(s.removed) && r.value(s.strayed) && r.value(flags) && r.array(hashes) && r.array(layers) &&
        read_held(r, s) && r.array(s.motion) && r.array(taken) && r.array(deformed) &&
        r.array(s.mesh_points) && ((flags & follows_sound_bit) == 0 || r.value(followed))) ||
      r.left() != 0)
    return corrupt("truncated");
  const std::size_t n = s.position.size(), nv = s.vertex_state.size();
  bool alike = hashes.size() == material_count && s.motion.size() == body_count &&
               taken.size() == body_count && deformed.size() == body_count;
  core::each_held(s, 0, [&](auto held, const auto& array, const auto&) {
    alike = alike && array.size() == (held.of_vertex ? nv : n);
  });
  if (!alike) return corrupt("arrays of different length");
  if (n >= core::none || nv >= core::none) return corrupt("more particles or vertices than 32 bits number");
  // First what it belongs to: a snapshot of another scene is not damaged.
  const auto mismatch = [](const char* what, std::uint64_t have, std::uint64_t want) {
    return core::invalid("snapshot: ", what, ": this World has ", have, ", the snapshot ", want,
                         "; build the World from the same scene first");
  };
  if (material_count != materials.size()) return mismatch("materials", materials.size(), material_count);
  for (std::size_t m = 0; m < materials.size(); ++m)
    if (hashes[m] != material_hash(materials[m]))
      return core::invalid(
          "snapshot: materials: \"", materials[m].name,
          "\" has another density, heat capacity, latent heat or melting point, or melts into "
          "something else, than in the World that wrote it (or heat.model differs); build the World from the "
          "same scene first");
  for (std::size_t k = 0; k < s.solute.size(); ++k)
    if (s.solute[k].size() != (k < species_.size() ? n : 0)) return corrupt("contents of different length");
  if (body_count != bodies_.size()) return mismatch("bodies", bodies_.size(), body_count);
  if (layers.size() != emitters_.size()) return mismatch("emitters", emitters_.size(), layers.size());
  if (nv != lattice_.vertex_site.size()) return mismatch("lattice vertices", lattice_.vertex_site.size(), nv);
  if (lattice != lattice_hash())
    return core::invalid(
        "snapshot: lattice vertices: numbered differently; build the World from the same scene first");
  if (spacing != desc.spacing)
    return core::invalid("snapshot: spacing: this World has ", desc.spacing, " m, the snapshot ", spacing,
                         " m; build the World from the same scene first");
  std::uint64_t built = 0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (taken[b] > bodies_[b].vertices + s.frozen + 1) return corrupt("a body has lost more than it had");
    built += bodies_[b].vertices - (taken[b] == 0 ? 0 : taken[b] - 1);
  }
  if (Status status = check_snapshot(s, built, origin, new_time,
                                     {sound, speed, seen.speed, s.heat_in, s.field_work, s.field_impulse.x,
                                      s.field_impulse.y, s.field_impulse.z, owed});
      !status)
    return status;
  if (Status status = check_mesh_points(deformed, s.mesh_points, new_time); !status) return status;
  // Both are infinite while nothing was seen.
  if (seen.high >= seen.low && !(finite(seen.min) && finite(seen.max)))
    return corrupt("a height is not usable");
  if (std::isnan(seen.low) || std::isnan(seen.high) || seen.speed < 0 || sound < 0 || speed < 0 || owed < 0)
    return corrupt("a speed or height is not usable");
  const auto usable = [](double v) { return v >= 0 && std::isfinite(v); };
  if (!usable(followed.now) || followed.now > sound * (1 + 1e-9) || !usable(followed.told) ||
      !usable(followed.level) || followed.level > sound * (1 + 1e-9) || !std::isfinite(followed.head) ||
      !std::isfinite(followed.work) || followed.elastic > 1)
    return corrupt("a sound speed is not usable");
  for (std::size_t k = 0; k < layers.size(); ++k)
    if (Status status = check_emitter(k, layers[k], new_time); !status) return status;
  const std::vector<char> held = fixed_in(s);
  collect_samples();
  drop_samples_from(new_time);
  state_ = std::move(s);
  state_stale_ = false;
  state_.heat_level = (flags & heat_level_bit) != 0u;
  may_melt_ = (flags & may_melt_bit) != 0u;
  measure_ = false;
  plan_until_ = 0;
  heat_owed_ = owed;
  places_.reset();
  holes_.clear();
  time = new_time;
  steps = new_steps;
  sound_speed_ = sound;
  last_max_speed_ = speed;
  seen_ = seen;
  seen_particles_ = state_.position.size();
  seen_emitters_ = emitters_.size();
  seen_bodies_ = bodies_.size();
  for (auto& m : motions_) m.reset();
  for (auto& p : proxies_) p.reset();
  for (auto& m : meshes_) m.set = false;
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    lattice_.rests[b].first_point = deformed[b] != 0 ? 0 : core::none;
  place_mesh_points();
  state_.forces.assign(bodies_.size(), {});
  forget_events();
  added_ = !(sound > 0);
  sound_ = followed;
  look_now_ = !(followed.now > 0);
  origin_ = origin;
  origin_set_ = true;
  for (std::size_t k = 0; k < layers.size(); ++k) {
    put_emitter(layers[k], emitters_[k]);
    limit_layers(emitters_[k]);
  }
  solids_built_ = built;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    bodies_[b].gone = taken[b] != 0;
    bodies_[b].taken = taken[b] == 0 ? 0 : taken[b] - 1;
    hold_as(b, held[b] != 0);
  }
  halted_ = false;
  ++restored_;
  halt_step_ = 0;
  halt_reason_.clear();
  carried_ = {};
  if (sound > 0 && any_field()) derive_sound_speed();  // fields are the World's: they may be others than then
  dirty_ = true;
  return {};
}

void WorldImpl::put_emitter(const EmitterState& s, EmitterRecord& e) {
  e.first_layer = s.first_layer;
  e.skipped = s.skipped;
  e.on = s.on != 0;
  e.desc.from = s.from;
  e.desc.speed = s.speed;
  e.desc.temperature = s.temperature;
  e.desc.center = s.center;
}

/// Whether a nozzle can be in that state.
Status WorldImpl::check_emitter(std::size_t k, const EmitterState& s, double new_time) const {
  EmitterRecord e = emitters_[k];
  put_emitter(s, e);
  if (!std::isfinite(s.from) || !(s.speed > 0 && s.speed < 1e15) || !std::isfinite(s.temperature) ||
      !(s.temperature >= absolute_zero) || s.on > 1 || !finite(s.center))
    return corrupt("a nozzle's setting is not usable");
  if (s.first_layer > layers_before(e, new_time) || s.skipped > layers_before(e, new_time))
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

/// Every value of a state that is to be taken over: in range, and consistent with each other and with the scene.
Status WorldImpl::check_snapshot(const core::SceneState& s, std::uint64_t built, Vec3d origin,
                                 double new_time, std::initializer_list<double> numbers) const {
  const std::size_t n = s.position.size(), nv = s.vertex_state.size();
  if (!(std::isfinite(new_time) && new_time >= 0)) return corrupt("the time is not usable");
  for (const double v : numbers)
    if (!std::isfinite(v)) return corrupt("a speed or the heat that came in is not finite");
  if (!finite(origin)) return corrupt("the origin is not finite");
  if (Status status = check_origin(origin); !status) return status;
  if (!all_finite(s.position) || !all_finite(s.velocity) || !all_finite(s.contact_slip))
    return corrupt("a position, velocity or slip is not finite");
  const double largest = desc.precision == Precision::single_precision ? 1e37 : 1e300;
  std::uint64_t removed = 0, solid = 0;
  const std::vector<char> fixed = fixed_in(s);
  const auto rows = material_rows();
  const Vec3d low = desc.domain.min - origin, high = desc.domain.max - origin;
  // Rounded to single precision, a coordinate at a wall may be this far beyond it.
  const double slack = 1e-2 * desc.spacing;
  // A corner of a rigid body that hits a wall does not give way, and the wall's spring is soft.
  const auto is_rigid = [this](std::uint32_t t) {
    return is_solid(t) && body_of(t) != 0u && bodies_[body_of(t) - 1u].rigid();
  };
  for (std::size_t i = 0; i < n; ++i) {
    if (!(s.mass[i] > 1 / largest && s.mass[i] < largest) ||
        !(s.volume[i] > 1 / largest && s.volume[i] < largest) || !std::isfinite(s.enthalpy[i]))
      return corrupt("a mass, volume or enthalpy is not usable");
    for (std::size_t k = 0; k < species_.size(); ++k)
      // Contents stay within 0 and the mass but for rounding, and for liquid so crowded that a flag is raised.
      if (!(s.solute[k][i] >= -s.mass[i] && s.solute[k][i] <= 2 * s.mass[i]))
        return corrupt("a content is not usable");
    if (!(dot(s.velocity[i], s.velocity[i]) < largest)) return corrupt("a velocity is not usable");
    const std::uint32_t tag = s.tag[i], body = body_of(tag);
    if (material_of(tag) >= materials.size() || body > bodies_.size() || (tag & ~known_tag_bits) != 0u)
      return corrupt("a tag names a material or body this World does not have");
    const std::uint32_t v = s.vertex_of_id[i];
    if (v >= nv && v != core::none) return corrupt("a lattice vertex is out of range");
    if (is_removed(tag)) {
      ++removed;
      continue;
    }
    // A thousandth of a degree for rounding.
    if (physics::temperature_of(rows[material_of(tag)], s.enthalpy[i] / s.mass[i]) <
        -physics::kelvin_offset - 0.001)
      return corrupt("a temperature is below 0 K");
    const Vec3d x = s.position[i];
    const double beyond[] = {low.x - x.x, x.x - high.x, low.y - x.y, x.y - high.y, low.z - x.z, x.z - high.z};
    for (std::size_t face = 0; face < 6 && desc.domain.bounded; ++face)
      if (beyond[face] > (is_rigid(tag) ? core::support_of(desc) : slack) &&
          (is_fluid(tag) || desc.domain.faces[face] != Face::open))
        return corrupt("a particle is outside the domain");
    if (!is_solid(tag)) {
      if (leaves_lattice(material_of(tag))) return corrupt("a liquid particle is of a solid material");
      continue;
    }
    ++solid;
    if (v == core::none || s.vertex_id[v] != i || s.vertex_state[v] != core::vertex_live)
      return corrupt("a solid particle has no lattice vertex");
    if (body != lattice_.vertex_body[v] + 1u || material_of(tag) != bodies_[body - 1u].desc.material.index ||
        ((tag & tag_fixed) != 0u) != (fixed[body - 1u] != 0) ||
        ((tag & tag_kinematic) != 0u) != bodies_[body - 1u].kinematic())
      return corrupt("a solid particle is not of the body it is in");
  }
  for (const physics::RigidMotion& m : s.motion)
    for (const physics::RigidPlace* p : {&m.first, &m.then}) {
      const Quat<double>& q = p->orientation;
      const double norm2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
      if (!finite(p->position) || !finite(p->velocity) || !finite(p->angular_velocity) ||
          !(std::fabs(norm2 - 1) < 1e-2) || !std::isfinite(m.from) || !(std::fabs(m.until) < infinity))
        return corrupt("the motion of a body is not usable");
    }
  if (removed != s.removed || s.strayed > s.removed)
    return corrupt("the number of removed particles is wrong");
  if (solid + s.melted != built + s.frozen) return corrupt("the number of solid particles is wrong");
  for (std::size_t v = 0; v < nv; ++v) {
    const std::uint32_t i = s.vertex_id[v];
    if (s.vertex_state[v] > core::vertex_melted) return corrupt("the state of a lattice vertex is unknown");
    if (i >= n && (i != core::none || s.vertex_state[v] == core::vertex_live))
      return corrupt("a lattice vertex has no particle");
    if (s.vertex_state[v] == core::vertex_live && (!is_solid(s.tag[i]) || s.vertex_of_id[i] != v))
      return corrupt("a lattice vertex names a particle that is not its own");
    const std::uint32_t label = s.vertex_piece[v];
    if (label >= nv || lattice_.vertex_body[label] != lattice_.vertex_body[v])
      return corrupt("a piece label is out of range");
    const Quat<double> q = s.region_rotation[v];
    const double norm2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
    if (!(std::fabs(norm2 - 1) < 1e-2)) return corrupt("a region's rotation is none");
  }
  return {};
}

}  // namespace v0
}  // namespace meltsim
