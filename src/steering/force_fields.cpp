// SPDX-License-Identifier: Apache-2.0
// Force fields: their descriptions, rows for the backend, and their effect on the sound speed and the sub-step.
#include <algorithm>
#include <cmath>
#include <string>

#include "description/names.hpp"
#include "description/validate.hpp"
#include "engine/text.hpp"
#include "shape/box_ops.hpp"
#include "shape/shape_node.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

namespace {
/// Whether a shape is a box, a sphere or a cylinder.
Status place_shape(const std::string& what, const Shape& shape, PlacedPrimitive& to) {
  if (shape.empty())
    return invalid(
        what,
        "shape: contains nothing; give a box, a sphere or a cylinder, or leave the shape out: everywhere");
  if (Status s = shape.validate(); !s)
    return Error{s.error().code, core::text(what, "shape: ", s.error().message)};
  if (!ShapeAccess::node(shape)->primitive({}, to))
    return invalid(
        what,
        "shape: must be a box, a sphere or a cylinder, which may be moved, turned and scaled; for others "
        "add a field per part");
  return {};
}
}  // namespace

const ForceFieldRecord* WorldImpl::field_of(ForceFieldId id) const {
  if (id.generation != number_) return nullptr;
  for (const ForceFieldRecord& r : force_fields_)
    if (r.used && r.serial == id.index) return &r;
  return nullptr;
}

bool WorldImpl::any_field() const {
  return std::any_of(force_fields_.begin(), force_fields_.end(), [](const auto& r) { return r.used; });
}

/// All checks of a description.
Status WorldImpl::check_field(const char* call, ForceFieldDesc& f, PlacedPrimitive& place,
                              const ForceFieldRecord* own) const {
  const std::string what = std::string(call) + "force field \"" + f.name + "\": ";
  for (const ForceFieldRecord& other : force_fields_)
    if (other.used && &other != own && other.desc.name == f.name)
      return invalid(what, "a force field of this name exists; choose another name");
  if (Status s = core::validate(f); !s) return Error{s.error().code, call + s.error().message};
  if (f.shape)
    if (Status s = place_shape(what, *f.shape, place); !s) return s;
  ForceFieldRecord r;
  r.desc = f;
  r.place = place;
  const double wind = reach_of(r).wind;
  if (desc.sound_speed > 0 && wind > 0.5 * desc.sound_speed)
    return invalid(what, "velocity: a wind of up to ", wind, " m/s is faster than half the sound_speed of ",
                   desc.sound_speed, " m/s; slow it down, or let sound_speed be derived (0)");
  return {};
}

/// The part of space in which a field acts: within the walls; without walls, where something was added.
Box WorldImpl::box_of(const ForceFieldRecord& r) const {
  if (r.desc.shape) return reachable(r.desc.shape->bounds());
  if (desc.domain.bounded) return {desc.domain.min, desc.domain.max};
  return {seen_.min, seen_.max};
}

/// Where the point of a field is [m].
Vec3d WorldImpl::point_of(const ForceFieldRecord& r) {
  return r.desc.center.value_or(r.desc.shape ? r.place.center : Vec3d{});
}

namespace {

/// How far corners of a box are from a point, or from the line through it along an axis of length 1.
double farthest_corner(const Box& box, Vec3d point, Vec3d axis) {
  double far = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d d =
        Vec3d{(corner & 1) != 0 ? box.min.x : box.max.x, (corner & 2) != 0 ? box.min.y : box.max.y,
              (corner & 4) != 0 ? box.min.z : box.max.z} -
        point;
    far = std::max(far, length(d - axis * dot(d, axis)));
  }
  return far;
}

}  // namespace

/// Bounds of the motion that a field may cause.
WorldImpl::FieldReach WorldImpl::reach_of(const ForceFieldRecord& r) const {
  FieldReach out;
  const Box box = box_of(r);
  if (inverted(box) || !finite(box.min) || !finite(box.max)) return out;
  const ForceFieldDesc& f = r.desc;
  const Vec3d point = point_of(r), size = box.max - box.min;
  const bool vortex = f.kind == ForceFieldKind::vortex;
  const Vec3d axis = vortex ? f.axis * (1 / length(f.axis)) : Vec3d{};
  const double far = farthest_corner(box, point, axis);
  if (!(far > 0)) return out;
  constexpr double turn = 6.283185307179586;
  switch (f.kind) {
    case ForceFieldKind::uniform: {
      const Vec3d a = f.acceleration;
      out.pull = length(a);
      out.squared = 2 * (std::fabs(a.x) * size.x + std::fabs(a.y) * size.y + std::fabs(a.z) * size.z);
      break;
    }
    case ForceFieldKind::hydrostatic:  // takes weight away
      break;
    case ForceFieldKind::drag:
      if (f.rate > 0) out.wind = length(f.velocity) + length(f.angular_velocity) * far;
      break;
    default: {
      const double strength = std::fabs(f.strength), core = std::min(f.radius, far);
      out.pull = strength * (f.power == 1 ? std::max(1.0, far / f.radius) : 1.0);
      if (f.power == 1) out.squared = strength * far * far / f.radius * (vortex ? 2 * turn : 1.0);
      // Once around where that gives the most, for f falls off as fast as circles grow, or faster; or along a ray.
      else if (vortex) out.squared = 2 * turn * strength * (f.power == 0 ? far : core);
      else if (f.power == 0) out.squared = 2 * strength * far;
      else if (f.power == -1)
        out.squared = strength * core * (1 + 2 * std::log(std::max(1.0, far / f.radius)));
      else out.squared = strength * core * (1 + 2 * (1 - core / std::max(core, far)));
    }
  }
  return out;
}

/// All of them together; accelerations add up as if they had the same direction.
WorldImpl::FieldReach WorldImpl::reach_of_fields() const {
  FieldReach all;
  for (const ForceFieldRecord& r : force_fields_) {
    if (!r.used) continue;
    const FieldReach one = reach_of(r);
    all.pull += one.pull;
    all.squared += one.squared;
    all.wind += one.wind;
  }
  return all;
}

physics::ForceField<double> WorldImpl::field_row(const ForceFieldRecord& r) const {
  physics::ForceField<double> row;
  if (!r.used) return row;
  const ForceFieldDesc& f = r.desc;
  row.on = 1;
  row.kind = static_cast<physics::ForceKind>(f.kind);
  row.liquid = f.liquid ? 1u : 0u;
  row.bodies = f.bodies ? 1u : 0u;
  row.power = f.power;
  if (f.shape) {
    switch (r.place.kind) {
      case PlacedPrimitive::Kind::box:
        row.region = physics::ForceRegion::box;
        break;
      case PlacedPrimitive::Kind::sphere:
        row.region = physics::ForceRegion::sphere;
        break;
      default:
        row.region = physics::ForceRegion::cylinder;
    }
    row.center = r.place.center - origin_;
    for (int k = 0; k < 3; ++k) row.axes[k] = r.place.axes[k];
    row.half = r.place.half;
  }
  row.about = point_of(r) - origin_;
  if (f.kind == ForceFieldKind::vortex) row.axis = f.axis * (1 / length(f.axis));
  row.vector = f.kind == ForceFieldKind::drag ? f.velocity : f.acceleration;
  row.spin = f.angular_velocity;
  row.strength = f.strength;
  row.radius = f.radius;
  if (f.kind == ForceFieldKind::hydrostatic && !(f.radius > 0)) row.radius = core::support_of(desc);
  row.rate = f.rate;
  row.density = f.density;
  row.from = f.from;
  row.until = f.until;
  return row;
}

std::uint32_t WorldImpl::field_rows() const {
  std::uint32_t n = 0;
  for (std::uint32_t k = 0; k < physics::most_force_fields; ++k)
    if (force_fields_[k].used) n = k + 1;
  return n;
}

/// Those that act now.
std::vector<physics::ForceField<double>> WorldImpl::acting_fields() const {
  std::vector<physics::ForceField<double>> fields;
  for (const ForceFieldRecord& r : force_fields_)
    if (r.used && time >= r.desc.from && time < r.desc.until) fields.push_back(field_row(r));
  return fields;
}

/// Pressure at rest that hydrostatic fields take out of liquid at a stored position [Pa]: core::at_rest().
double WorldImpl::rest_pressure_at(const std::vector<physics::ForceField<double>>& fields, Vec3d x) const {
  const Vec3d size = desc.domain.max - desc.domain.min;
  const auto across = [&](Vec3d d) {  // from the nearest image
    if (core::is_periodic(desc.domain, 0)) d.x = std::remainder(d.x, size.x);
    if (core::is_periodic(desc.domain, 1)) d.y = std::remainder(d.y, size.y);
    if (core::is_periodic(desc.domain, 2)) d.z = std::remainder(d.z, size.z);
    return d;
  };
  double pressure = 0;
  for (const physics::ForceField<double>& f : fields)
    if (f.kind == physics::ForceKind::hydrostatic && physics::in_force_region(f, across(x - f.center)))
      pressure +=
          physics::rest_pressure(f, physics::depth_below(across(x - f.about), desc.gravity), desc.gravity);
  return pressure;
}

/// After a field has changed: to the engine, and what follows from it.
void WorldImpl::field_changed(std::uint32_t row) {
  if (steps == 0) {
    see_all_anew();
    return;
  }
  const double sound = sound_speed_;
  if (sound > 0) derive_sound_speed();
  if (dirty_) return;  // prepare() does the rest
  engine->set_force_field(row, field_row(force_fields_[row]), field_rows());
  derive_limits();  // also ahead of another plan: stable_dt() tells what the next step will be
  if (sound_speed_ != sound || facts() != facts_) plan_changed_ = true;
}

Result<ForceFieldId> WorldImpl::add_force_field(const ForceFieldDesc& f) {
  ForceFieldDesc field = f;
  if (field.name.empty())
    field.name = core::numbered_name("field", next_field_, [&](const std::string& name) {
      return std::any_of(force_fields_.begin(), force_fields_.end(),
                         [&](const auto& r) { return r.used && r.desc.name == name; });
    });
  PlacedPrimitive place;
  if (Status s = check_field("", field, place, nullptr); !s) return s.error();
  std::uint32_t row = 0;
  while (row < physics::most_force_fields && force_fields_[row].used) ++row;
  if (row == physics::most_force_fields)
    return Error{ErrorCode::capacity,
                 core::text("force field \"", field.name, "\": there are ", physics::most_force_fields,
                            " force fields, the most that there may be; remove one, or replace one by "
                            "set_force_field")};
  see_added();
  ForceFieldRecord& r = force_fields_[row];
  r.desc = std::move(field);
  r.place = place;
  r.serial = next_field_++;
  r.used = true;
  field_changed(row);
  return ForceFieldId{r.serial, number_};
}

Status WorldImpl::set_force_field(ForceFieldId id, const ForceFieldDesc& f) {
  const ForceFieldRecord* const is = field_of(id);
  if (is == nullptr) return no_such_field("set_force_field", id);
  ForceFieldDesc field = f;
  if (field.name.empty()) field.name = is->desc.name;
  PlacedPrimitive place;
  if (Status s = check_field("set_force_field: ", field, place, is); !s) return s;
  see_added();
  const auto row = static_cast<std::uint32_t>(is - force_fields_.data());
  force_fields_[row].desc = std::move(field);
  force_fields_[row].place = place;
  field_changed(row);
  return {};
}

Result<ForceFieldDesc> WorldImpl::force_field(ForceFieldId id) const {
  const ForceFieldRecord* const is = field_of(id);
  if (is == nullptr) return no_such_field("force_field", id).error();
  return is->desc;
}

Status WorldImpl::remove_force_field(ForceFieldId id) {
  const ForceFieldRecord* const is = field_of(id);
  if (is == nullptr) return no_such_field("remove", id);
  see_added();
  const auto row = static_cast<std::uint32_t>(is - force_fields_.data());
  force_fields_[row] = {};
  field_changed(row);
  return {};
}

Status WorldImpl::no_such_field(const char* call, ForceFieldId id) {
  return invalid(call, ": field: no force field of this World has index ", id.index, " and generation ",
                 id.generation,
                 "; pass what add_force_field() of this World returned, and nothing that was removed");
}

}  // namespace v0
}  // namespace meltsim
