// SPDX-License-Identifier: Apache-2.0
// Emitters with a level: open faces beyond which liquid stands (physics/inlet.hpp). Ids of what comes in are there from the start, as if
// it had been removed, and are used again once it has left; so are those of nozzles that recycle.
#include <algorithm>
#include <cmath>
#include <string>

#include "description/names.hpp"
#include "description/nozzle.hpp"
#include "description/point_grid.hpp"
#include "description/validate.hpp"
#include "engine/text.hpp"
#include "meltsim/physics/heat.hpp"
#include "meltsim/physics/liquid_properties.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

namespace {

/// What a layer of a face consists of: rows of points a spacing apart from the floor up, as many across as there is room for.
struct FaceLayer {
  std::vector<Vec3d> points;  ///< relative to the centre of the opening
  Vec3d center, inwards, up;
  double breadth = 0, height = 0;  ///< of the opening [m]
  double distance = 0;             ///< from layer to layer [m]
};

FaceLayer face_layer(const WorldDesc& d, const EmitterDesc& e) {
  FaceLayer l;
  l.inwards = core::unit(e.axis);
  l.up = core::unit(d.gravity) * -1.0;
  const Vec3d across = cross(l.inwards, l.up), size = d.domain.max - d.domain.min;
  const double dx = d.spacing;
  l.breadth = std::fabs(dot(across, size));
  l.height = e.height > 0 ? e.height : core::height_above_floor(d, *e.level);
  const Vec3d middle = (d.domain.min + d.domain.max) * 0.5;
  l.center = middle - l.inwards * (0.5 * std::fabs(dot(l.inwards, size))) -
             l.up * (0.5 * (std::fabs(dot(l.up, size)) - l.height));
  const int rows = static_cast<int>(std::max(1L, std::lround(l.height / dx)));
  const int columns = static_cast<int>(std::max(1.0, std::floor(l.breadth / dx * (1 + 1e-9))));
  const double pitch = l.breadth / columns;
  for (int b = 0; b < rows; ++b)
    for (int a = 0; a < columns; ++a)
      l.points.push_back(across * (pitch * (a + 0.5) - 0.5 * l.breadth) +
                         l.up * (dx * (b + 0.5) - 0.5 * l.height));
  l.distance = dx * dx / pitch;
  return l;
}

/// Particles that fill the domain to the top of the opening, and a fifth more, as splashes and what moves with the face need.
std::uint64_t reserve_for(const WorldDesc& d, const FaceLayer& l) {
  const double length = std::fabs(dot(l.inwards, d.domain.max - d.domain.min));
  const double volume = l.breadth * l.height * length;
  const double particles = 1.2 * volume / (d.spacing * d.spacing * d.spacing);
  return static_cast<std::uint64_t>(std::min(particles, 9e15)) + l.points.size();
}

}  // namespace

/// Whether liquid can come in there, and what comes.
Status WorldImpl::check_reservoir(const EmitterDesc& e, const std::string& what, Contents& contents) const {
  if (Status s = check_liquid(e, what, contents); !s) return s;
  if (Status s = core::validate_reservoir(e, desc); !s) return s;
  for (const EmitterRecord& other : emitters_)
    if (other.reservoir() && other.face == core::face_behind(e.axis))
      return invalid(
          what, "axis: emitter \"", other.desc.name,
          "\" has a level beyond that face already; drop one of them, or change that one (set_emitter)");
  const double head = core::height_above_floor(desc, *e.level);
  return check_state_of(e, what, contents, Vec3d{std::sqrt(length(desc.gravity) * head), 0, 0});
}

/// Whether a point is where liquid moves with the face of an emitter, or ahead of it within a support radius.
bool WorldImpl::moved_by_face(const EmitterRecord& e, Vec3d x) const {
  const Vec3d inwards = core::unit(e.desc.axis);
  return e.reservoir() && dot(x - e.desc.center, inwards) < 2 * core::support_of(desc);
}

/// Whether nozzles and faces are apart: what one of them holds the other lets go.
Status WorldImpl::check_faces(const EmitterDesc& e, const std::string& what,
                              const std::vector<Vec3d>& points) const {
  for (const EmitterRecord& other : emitters_)
    for (const Vec3d& p : points)
      if (moved_by_face(other, e.center + p))
        return invalid(what, "center: the nozzle is at ", e.center + p,
                       ", less than two support radii from the open face of emitter \"", other.desc.name,
                       "\"; move it ", 2 * core::support_of(desc), " m off");
  return {};
}

/// The same of a face that is to come, and whether bodies leave it free.
Status WorldImpl::check_face(const EmitterRecord& r, const std::string& what,
                             const std::vector<Vec3d>& points) const {
  for (const EmitterRecord& other : emitters_)
    for (const Vec3d& p : other.reservoir() ? std::vector<Vec3d>{} : places_of(other))
      if (moved_by_face(r, p))
        return invalid(what, "axis: the nozzle of emitter \"", other.desc.name, "\" at ", p,
                       " is less than two support radii (", 2 * core::support_of(desc),
                       " m) from that face; use another face or move the nozzle");
  core::PointGrid own(core::same_place * desc.spacing);
  for (const Vec3d& p : points) own.add(r.desc.center + p, 0);
  for (std::size_t i = 0; i < state_.position.size(); ++i)
    if (is_solid(state_.tag[i]) && own.near(state_.position[i] + origin_, [](std::uint32_t) { return true; }))
      return invalid(what, "axis: body \"", bodies_[body_of(state_.tag[i]) - 1].desc.name,
                     "\" lies in that face at ", state_.position[i] + origin_,
                     "; keep it a spacing inside, or leave the level out");
  return {};
}

Result<EmitterId> WorldImpl::add_reservoir(const EmitterDesc& e) {
  EmitterRecord r;
  r.desc = e;
  if (r.desc.name.empty()) r.desc.name = core::numbered_name("emitter", emitters_);
  const std::string what = "emitter \"" + r.desc.name + "\": ";
  Contents contents{};
  if (Status s = check_reservoir(r.desc, what, contents); !s) return s.error();
  if (Status s = check_layer_of_face(r.desc, what); !s) return s.error();
  const FaceLayer layer = face_layer(desc, e);
  r.contents = contents;
  r.face = core::face_behind(e.axis);
  r.layer_distance = layer.distance;
  r.points = static_cast<std::uint32_t>(layer.points.size());
  r.first_point = static_cast<std::uint32_t>(emitter_points_.size());
  r.desc.center = layer.center;
  r.desc.up = layer.up;
  r.desc.width = layer.breadth;
  r.desc.height = layer.height;
  r.desc.speed = 2.0 / 3 * std::sqrt(length(desc.gravity) * layer.height);  // at most
  const std::uint64_t ids = e.max_particles != 0 ? e.max_particles : reserve_for(desc, layer);
  if (Status s = check_reserve(r, ids, what); !s) return s.error();
  r.ids = static_cast<std::uint32_t>(ids);
  fetch_state();
  if (Status s = check_face(r, what, layer.points); !s) return s.error();
  Vec3d origin;
  if (Status s = origin_for({layer.center}, what.c_str(), origin); !s) return s.error();
  if (Status s = check_memory(r, what); !s) return s.error();
  emitters_.reserve(emitters_.size() + 1);
  emitter_points_.reserve(emitter_points_.size() + layer.points.size());
  pass_over_particles();
  put_in_reserve(r, layer.center - layer.inwards * (8 * desc.spacing) - origin);
  emitters_.push_back(r);
  emitter_points_.insert(emitter_points_.end(), layer.points.begin(), layer.points.end());
  settle_at(origin);
  return EmitterId{static_cast<std::uint32_t>(emitters_.size() - 1), number_};
}

/// Whether a layer fits into memory, before it is laid out.
Status WorldImpl::check_layer_of_face(const EmitterDesc& e, const std::string& what) const {
  EmitterDesc opening = e;
  const Vec3d across = cross(core::unit(e.axis), core::unit(desc.gravity));
  opening.width = std::fabs(dot(across, desc.domain.max - desc.domain.min));
  opening.height = e.height > 0 ? e.height : core::height_above_floor(desc, *e.level);
  return check_layer(opening, what);
}

/// Whether so many particles are enough, and can be numbered.
Status WorldImpl::check_reserve(const EmitterRecord& r, std::uint64_t ids, const std::string& what) const {
  if (ids < r.points)
    return invalid(what, "max_particles: ", ids, " is less than one layer of the ",
                   r.reservoir() ? "face" : "nozzle", " (", r.points,
                   " particles); raise it, or leave it out");
  if (ids + state_.position.size() >= core::none)
    return invalid(what, "max_particles: ", ids,
                   " particles are more than 32-bit ids can number; lower it, or use a larger spacing");
  return {};
}

/// What a nozzle that recycles has in reserve: what it may have in the World at a time.
Status WorldImpl::plan_reserve(EmitterRecord& r, const std::string& what) const {
  r.nozzle = static_cast<std::uint32_t>(
      std::count_if(emitters_.begin(), emitters_.end(), [](const EmitterRecord& e) { return e.recycles(); }));
  if (r.nozzle >= core::most_recycling)
    return Error{ErrorCode::capacity,
                 core::text(what, "recycle: this World has ", core::most_recycling,
                            " nozzles that recycle, which is the most; let one of them pour where this one "
                            "would (set_emitter), or give this one max_particles or until instead")};
  if (r.desc.max_particles == 0 && !desc.domain.bounded)
    return invalid(
        what,
        "max_particles: a nozzle that recycles in a domain without bounds needs a limit, got 0; set "
        "how many particles of it there may be at a time");
  const Vec3d size = desc.domain.max - desc.domain.min;
  const double fill = size.x * size.y * size.z / (desc.spacing * desc.spacing * desc.spacing);
  const std::uint64_t ids = r.desc.max_particles != 0
                                ? r.desc.max_particles
                                : static_cast<std::uint64_t>(std::min(fill * (1 + 1e-9), 9e15));
  if (Status s = check_reserve(r, ids, what); !s) return s;
  r.ids = static_cast<std::uint32_t>(ids);
  return {};
}

/// Ids for what is to come in, beyond the face or in the nozzle as yet.
void WorldImpl::put_in_reserve(EmitterRecord& r, Vec3d at) {
  r.first_id = static_cast<std::uint32_t>(state_.position.size());
  const auto row = material_rows()[r.desc.material.index];
  const double h = physics::enthalpy_of(row, r.desc.temperature);
  const double density = mixed_density(physics::rest_density(row, h), r.contents);
  reserve(r.ids, 0, 0);
  for (std::uint32_t k = 0; k < r.ids; ++k)
    append(state_, at, {}, density, h, r.desc.material.index | tag_removed, core::none, r.contents, cube());
  state_.removed += r.ids;
}

/// How many ids there are in reserve.
std::uint64_t WorldImpl::reserved_ids() const {
  std::uint64_t n = 0;
  for (const EmitterRecord& e : emitters_) n += e.ids;
  return n;
}

/// Particles that have left, of those that were ever there.
std::uint64_t WorldImpl::left_of(std::uint64_t removed, std::uint64_t entered, std::uint64_t reserve) {
  return removed + entered - reserve;
}

/// Which points and ids a face or nozzle has.
core::Inlet<double> WorldImpl::span_of(const EmitterRecord& e) const {
  core::Inlet<double> r;
  r.first_point = e.first_point;
  r.points = e.points;
  r.first_id = e.first_id;
  r.ids = e.ids;
  return r;
}

core::Inlet<double> WorldImpl::inlet_row(const EmitterRecord& e) const {
  const auto material = material_rows()[e.desc.material.index];
  core::Inlet<double> r = span_of(e);
  r.center = e.desc.center - origin_;
  r.inwards = core::unit(e.desc.axis);
  r.up = e.desc.up;
  r.middle = 0.5 * e.desc.height;
  r.distance = e.layer_distance;
  r.layer = desc.spacing;
  r.area = e.desc.width * core::support_of(desc);
  r.head = core::height_above_floor(desc, *e.desc.level);
  const double h = physics::enthalpy_of(material, e.desc.temperature);
  r.volume = desc.spacing * desc.spacing * desc.spacing;
  r.mass = mixed_density(physics::rest_density(material, h), e.contents) * r.volume;
  round_to_precision(r.mass);
  r.enthalpy = h * r.mass;
  for (std::size_t k = 0; k < species_.size(); ++k) r.solute[k] = e.contents[k] * r.mass;
  r.tag = e.desc.material.index;
  r.on = e.on ? 1u : 0u;
  return r;
}

/// What comes in to ids in reserve.
void WorldImpl::fill_inlets(core::SceneConstants& c) const {
  for (const EmitterRecord& e : emitters_) {
    if (e.reservoir()) {
      c.inlet_faces |= 1u << e.face;
      c.inlets.row[e.inlet()] = inlet_row(e);
    } else if (e.recycles()) {
      ++c.nozzles;
      c.inlets.row[e.inlet()] = span_of(e);
    }
  }
}

/// A setting of an emitter with a level.
Status WorldImpl::set_reservoir(EmitterId id, const EmitterSetting& setting, const std::string& what) {
  EmitterRecord r = emitters_[id.index];
  if (setting.speed) return invalid(what, "speed: follows from the level; set level instead");
  if (setting.center)
    return invalid(what, "center: an open face of the domain stays where it is; leave it out");
  if (setting.level) {
    r.desc.level = *setting.level;
    if (Status s = core::validate_level(what, *setting.level, desc); !s) return s;
    const double head = core::height_above_floor(desc, *setting.level);
    if (head > r.desc.height * (1 + 1e-9))
      return invalid(what, "level: ", *setting.level, " m is ", head,
                     " m above the floor, more than the opening's ", r.desc.height,
                     " m; add the emitter with that height");
  }
  if (setting.temperature) {
    r.desc.temperature = *setting.temperature;
    if (Status s = core::validate_state(what.c_str(), r.desc.temperature, Vec3d{}); !s) return s;
    if (Status s = check_state_of(r.desc, what, r.contents, {}); !s) return s;
  }
  if (setting.on) r.on = *setting.on;
  if (Status s = prepare(); !s) return s;
  emitters_[id.index] = r;
  if (setting.temperature && !keeps_level(r)) {
    fetch_state();
    dirty_ = measure_ = true;
  } else if (!dirty_) {
    engine->set_inlet(static_cast<std::uint32_t>(r.face), inlet_row(r));
  }
  look_now_ = true;
  return {};
}

}  // namespace v0
}  // namespace meltsim
