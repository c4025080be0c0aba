// SPDX-License-Identifier: Apache-2.0
// Saved Worlds: a snapshot and the bodies that it is of, for a World that does not have them.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "description/validate.hpp"
#include "engine/text.hpp"
#include "shape/mesh_chords.hpp"
#include "snapshot/bytes.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

namespace {

constexpr std::uint32_t saved_format = 2;

Error unusable(const char* why) {
  return Error{ErrorCode::corrupt_data,
               core::text("load_saved: ", why, "; the World is unchanged, use another saved World")};
}

/// Goes through what a saved World holds of a body, in its order: an Archive writes it, or reads it and says whether it was there.
template <class Archive>
class BodyFields {
 public:
  BodyFields(Archive& archive, StoredBody& body, Box& bounds, TriangleMesh& mesh)
      : a_(archive), b_(body), bounds_(bounds), mesh_(mesh) {}

  bool each() {
    return identity() && motion() && heat() && vector(bounds_.min) && vector(bounds_.max) &&
           a_.array(mesh_.vertices) && a_.array(mesh_.indices) && sites();
  }

 private:
  bool identity() {
    std::vector<char> name(b_.desc.name.begin(), b_.desc.name.end());
    if (!a_.array(name)) return false;
    b_.desc.name.assign(name.begin(), name.end());
    return whole(b_.row) && whole(b_.watched) && whole(b_.forgotten) && whole(b_.vertices) &&
           whole(b_.longest) && whole(b_.desc.material.index);
  }
  bool motion() {
    SolidDesc& d = b_.desc;
    bool there = whole(d.motion) && optional(d.pivot) && a_.value(d.mass) && a_.value(d.max_speed);
    there = there && a_.array(d.path) && vector(d.path_axis);
    for (auto& row : d.inertia.m)
      for (double& v : row) there = there && a_.value(v);
    return there;
  }
  bool heat() {
    SolidDesc& d = b_.desc;
    return a_.value(d.temperature) && optional(d.surface.temperature) && a_.value(d.surface.flux) &&
           a_.array(d.surface.temperature_points) && a_.array(d.surface.flux_points) &&
           a_.value(d.surface.convection) && a_.value(d.surface.emissivity) && a_.value(d.surface.ambient) &&
           a_.value(d.heat_source) && whole(d.growth);
  }
  bool sites() {
    bool there = true;
    for (int k = 0; k < 3; ++k) there = there && a_.value(b_.box.low[k]) && a_.value(b_.box.high[k]);
    return there && a_.array(b_.points) && a_.array(b_.free) && a_.array(b_.surface);
  }

  /// A whole number, a truth value or one of an enumeration, in 64 bits.
  template <class V>
  bool whole(V& v) {
    auto stored = static_cast<std::int64_t>(v);
    if (!a_.value(stored)) return false;
    v = static_cast<V>(stored);
    return static_cast<std::int64_t>(v) == stored;
  }
  bool vector(Vec3d& v) { return a_.value(v.x) && a_.value(v.y) && a_.value(v.z); }
  bool value(double& v) { return a_.value(v); }
  bool value(Vec3d& v) { return vector(v); }
  template <class V>
  bool optional(std::optional<V>& v) {
    bool given = v.has_value();
    V stored = v.value_or(V{});
    if (!whole(given) || !value(stored)) return false;
    v = given ? std::optional<V>(stored) : std::nullopt;
    return true;
  }

  Archive& a_;
  StoredBody& b_;
  Box& bounds_;
  TriangleMesh& mesh_;
};

class Writing {
 public:
  template <class V>
  bool value(const V& v) {
    w.value(v);
    return true;
  }
  template <class V>
  bool array(const std::vector<V>& v) {
    w.array(v);
    return true;
  }
  core::Writer w;
};

bool is_usable(const Box& b) {
  return finite(b.min) && finite(b.max) && b.min.x < b.max.x && b.min.y < b.max.y && b.min.z < b.max.z;
}

/// The mesh that a body's particles may follow.
TriangleMesh followed_mesh(const SolidDesc& d) {
  return d.motion == Motion::kinematic && d.growth == 0 ? mesh_of(d.shape) : TriangleMesh{};
}

/// What of a nozzle or an open face no state holds.
std::uint64_t setting_of(const EmitterRecord& e) {
  const EmitterDesc& d = e.desc;
  core::Hash h;
  for (const double v :
       {d.radius, d.width, d.height, d.axis.x, d.axis.y, d.axis.z, d.up.x, d.up.y, d.up.z, d.until,
        double(d.material.index), double(d.max_particles), d.recycle ? 1.0 : 0.0, d.level ? 1.0 : 0.0}) {
    const double number = v + 0.0;  // -0 is 0
    h.add(&number, sizeof number);
  }
  h.add(e.contents.data(), sizeof e.contents);
  return h.value();
}

/// Whether bytes are a saved World, of this version and as they were written.
Status check_whole(const std::uint8_t* data, std::size_t bytes) {
  if (bytes < 28 || !core::begins_with(core::saved_world_magic, data, bytes))
    return unusable(core::begins_with(core::snapshot_magic, data, bytes)
                        ? "this is a snapshot, which restore() takes"
                        : "not a saved World");
  std::uint32_t version = 0;
  std::memcpy(&version, data + 8, sizeof version);
  if (version != saved_format)
    return Error{ErrorCode::version_mismatch,
                 core::text("load_saved: format version ", version, ", this library reads ", saved_format,
                            "; save it again with this version")};
  core::Hash h;
  h.add(data, bytes - 8);
  std::uint64_t checksum = 0;
  std::memcpy(&checksum, data + bytes - 8, sizeof checksum);
  return checksum == h.value() ? Status{} : unusable("checksum does not match: truncated or changed");
}

template <class Reader>
Status read_body(Reader& r, StoredBody& b) {
  Box bounds;
  TriangleMesh mesh;
  if (!BodyFields<Reader>(r, b, bounds, mesh).each()) return unusable("truncated, or a number is not usable");
  if (!is_usable(bounds)) return unusable("the place of a body is not usable");
  b.desc.shape = Shape::box(bounds.min, bounds.max);
  if (mesh.indices.empty()) return {};
  b.desc.shape = Shape::mesh(std::move(mesh));
  return b.desc.shape.validate() ? Status{} : unusable("the mesh of a body is not usable");
}

}  // namespace

StoredBody WorldImpl::stored_body(std::uint32_t row) const {
  const BodyRecord& body = bodies_[row];
  StoredBody b;
  b.desc = body.desc;
  b.row = row;
  b.watched = body.watched;
  b.forgotten = forgotten(body);
  b.vertices = body.vertices;
  b.longest = body.longest;
  b.box = body.box;
  const auto of = [&](const auto& array, std::uint32_t first, std::uint32_t end) {
    return std::remove_cv_t<std::remove_reference_t<decltype(array)>>(array.begin() + first,
                                                                      array.begin() + end);
  };
  if (b.forgotten) return b;
  const std::uint32_t first = body.first_vertex, free = first + body.vertices;
  b.points = of(lattice_.vertex_coordinates, first, free);
  b.free = of(lattice_.vertex_coordinates, free, body.end_vertex());
  b.surface = of(lattice_.contact_shape, first, free);
  return b;
}

Result<std::vector<std::uint8_t>> WorldImpl::save() {
  auto state = snapshot();
  if (!state) return state.error();
  Writing to;
  for (const char c : core::saved_world_magic) to.value(c);
  to.value(saved_format);
  to.value(static_cast<std::uint64_t>(bodies_.size()));
  for (const std::uint32_t row : rows_by_vertex()) {
    StoredBody b = stored_body(row);
    Box bounds = b.desc.shape.bounds();
    TriangleMesh mesh = followed_mesh(b.desc);
    BodyFields<Writing>(to, b, bounds, mesh).each();
  }
  std::vector<std::uint8_t> pipes;  // of nozzles: whether there was room behind them when they came
  std::vector<std::uint64_t> settings;
  for (const EmitterRecord& e : emitters_) {
    pipes.push_back(e.lead > 0 ? 1 : 0);
    settings.push_back(setting_of(e));
  }
  to.array(pipes);
  to.array(settings);
  to.array(*state);
  core::Hash h;
  h.add(to.w.bytes);
  to.value(h.value());
  return std::move(to.w.bytes);
}

/// Whether the World has something that is of its present bodies and that nothing could say of others.
Status WorldImpl::check_loadable() const {
  for (const ProbeRecord& p : probes_)
    if (p.desc.body)
      return core::invalid(
          "load_saved: probe \"", p.desc.name,
          "\" is on a body, which would go; remove() it, and add probes on bodies after load_saved()");
  for (const OpenReading& r : readings_)
    if (r.ticket.value != 0)
      return core::invalid(
          "load_saved: a reading is open, which names bodies that would go; take() it first");
  return {};
}

Status WorldImpl::load_saved(const std::uint8_t* data, std::size_t bytes) {
  if (Status s = check_loadable(); !s) return s;
  if (Status s = check_whole(data, bytes); !s) return s;
  std::uint64_t count = 0;
  core::Reader r(data + 12, bytes - 20);
  if (!r.value(count) || count > 65535) return unusable("the number of bodies is not usable");
  std::vector<StoredBody> all(static_cast<std::size_t>(count));
  std::vector<char> there(all.size(), 0);
  for (StoredBody& b : all) {
    if (Status s = read_body(r, b); !s) return s;
    if (b.row >= all.size() || there[b.row]++ != 0) return unusable("two bodies have the same row");
    b.desc.material.generation = number_;
  }
  std::vector<std::uint8_t> pipes, state;
  std::vector<std::uint64_t> settings;
  if (!r.array(pipes) || !r.array(settings) || !r.array(state) || r.left() != 0) return unusable("truncated");
  if (event_watch_)
    if (Status s = check_touching(event_watch_->kinds, all.size(), "load_saved"); !s) return s;
  for (std::size_t k = 0; k < emitters_.size() && k < settings.size(); ++k)
    if (settings[k] != setting_of(emitters_[k]))
      return core::invalid(
          "load_saved: emitter \"", emitters_[k].desc.name,
          "\" has another opening, axis, liquid, end or limit than in the World that was saved; add "
          "the same emitters in the same order");
  if (Status s = restore_state(state.data(), state.size(), &all); !s)
    return Error{s.error().code, core::text("load_saved: ", s.error().message)};
  for (std::size_t k = 0; k < emitters_.size() && k < pipes.size(); ++k)
    emitters_[k].lead = pipes[k] != 0 ? emitters_[k].held_layers * emitters_[k].layer_distance : 0;
  return {};
}

}  // namespace v0
}  // namespace meltsim
