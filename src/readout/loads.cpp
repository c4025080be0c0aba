// SPDX-License-Identifier: Apache-2.0
// Probes of forces, heat and fluxes: their checks, and the sums over particles that they are made of.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "description/load_fields.hpp"
#include "description/validate.hpp"
#include "engine/text.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;
using core::LoadKind;

namespace {

constexpr const char* faces[6] = {"-x", "+x", "-y", "+y", "-z", "+z"};

const char* name_of(ProbeKind kind) {
  return kind == ProbeKind::force ? "force" : kind == ProbeKind::heat ? "heat" : "flux";
}

std::string choices_of(ProbeKind kind) {
  std::string all;
  for (const core::LoadField& f : core::load_fields)
    if (f.kind == kind) all += (all.empty() ? "" : ", ") + std::string(f.name);
  return all;
}

/// Lists the sums of a probe of this kind, in the order of its values.
Status check_fields(const std::string& what, const ProbeDesc& p, std::uint32_t& width) {
  width = p.kind == ProbeKind::heat ? 1u : 0u;
  if (p.kind == ProbeKind::heat) {
    if (p.fields.empty()) return {};
    return invalid(what, "fields: of heat there is one value, got \"", p.fields.front(),
                   "\"; leave them out");
  }
  for (std::size_t k = 0; k < p.fields.size(); ++k) {
    const core::LoadField* const known = core::find_load_field(p.kind, p.fields[k]);
    if (known == nullptr)
      return invalid(what, "fields: unknown \"", p.fields[k], "\"; of kind ", name_of(p.kind), " there are ",
                     choices_of(p.kind));
    if (std::find(p.fields.begin(), p.fields.begin() + static_cast<std::ptrdiff_t>(k), p.fields[k]) !=
        p.fields.begin() + static_cast<std::ptrdiff_t>(k))
      return invalid(what, "fields: \"", p.fields[k], "\" is listed twice; list it once");
    width += known->width;
  }
  if (p.fields.empty())
    return invalid(what, "fields: none is given; list at least one of ", choices_of(p.kind));
  return {};
}

Status check_opening(const std::string& what, const ProbeDesc& p) {
  if (p.body || p.wall)
    return invalid(what, p.body ? "body" : "wall",
                   ": a flux has none; leave it out, or use kind force or heat");
  if (p.points.size() != 1)
    return invalid(what, "points: a flux has one, the centre of its opening, got ",
                   std::uint64_t{p.points.size()});
  const double normal = length(p.normal);
  if (!finite(p.normal) || !(normal > 0) || !std::isfinite(normal))
    return invalid(what, "normal: must be finite and not 0, got ", p.normal,
                   "; it is the direction that counts as positive");
  if (!(std::isfinite(p.radius) && p.radius >= 0))
    return invalid(what, "radius: must be finite and >= 0 m, got ", p.radius, "; 0 is a rectangle");
  const bool sized = p.size[0] != 0 || p.size[1] != 0;
  if (p.radius > 0 && sized)
    return invalid(what, "size: a disc of radius ", p.radius, " m has none; leave one of the two out");
  if (p.radius > 0) return {};
  if (!(std::isfinite(p.size[0]) && std::isfinite(p.size[1]) && p.size[0] > 0 && p.size[1] > 0))
    return invalid(what, "size: must be finite and > 0 m both ways, got ", p.size[0], " and ", p.size[1],
                   "; or give a radius");
  if (!finite(p.along) || !(length(cross(p.along, p.normal)) > 1e-6 * length(p.along) * normal))
    return invalid(what, "along: must be finite and not along the normal ", p.normal, ", got ", p.along,
                   "; it is the direction of the side of length ", p.size[0], " m");
  return {};
}

}  // namespace

/// Checks of kinds force, heat and flux; points, times and names are checked for all kinds alike.
Status WorldImpl::check_load(const std::string& what, const ProbeDesc& p, ProbeRecord& record) const {
  record.points = 1;
  if (Status s = check_fields(what, p, record.width); !s) return s;
  if (p.kind == ProbeKind::flux) return check_opening(what, p);
  if (length(p.normal) != 0 || p.radius != 0 || p.size[0] != 0 || p.size[1] != 0)
    return invalid(what,
                   length(p.normal) != 0 ? "normal"
                   : p.radius != 0       ? "radius"
                                         : "size",
                   ": kind ", name_of(p.kind), " has none; leave it out, or use kind flux");
  if (static_cast<bool>(p.body) == p.wall.has_value())
    return invalid(what, "body: give either a body or a wall, ", p.wall ? "not both" : "got neither");
  const std::size_t most = p.kind == ProbeKind::force ? 1 : 0;
  if (p.points.size() > most)
    return invalid(what, "points: kind ", name_of(p.kind), " has ",
                   most == 0 ? "none" : "one, where moments are about", ", got ",
                   std::uint64_t{p.points.size()});
  if (Status s = p.body ? check_body(("probe \"" + p.name + "\"").c_str(), p.body) : Status{}; !s) return s;
  if (!p.wall) return {};
  if (*p.wall < 0 || *p.wall > 5)
    return invalid(what, "wall: must be 0 to 5, in the order of domain.faces, got ", *p.wall);
  if (!desc.domain.bounded) return invalid(what, "wall: the domain is not bounded and has none; use a body");
  const auto face = static_cast<std::size_t>(*p.wall);
  if (desc.domain.faces[face] != Face::wall)
    return invalid(what, "wall: face ", faces[face], " is ",
                   desc.domain.faces[face] == Face::open ? "open" : "periodic", "; only walls have a ",
                   name_of(p.kind));
  return {};
}

/// Where the moments of a probe on a wall are about, unless it says so: the middle of the wall.
Vec3d WorldImpl::middle_of_wall(std::uint32_t face) const {
  const DomainDesc& d = desc.domain;
  Vec3d middle = (d.min + d.max) * 0.5;
  double* const at[3] = {&middle.x, &middle.y, &middle.z};
  const double low[3] = {d.min.x, d.min.y, d.min.z}, high[3] = {d.max.x, d.max.y, d.max.z};
  *at[face / 2] = face % 2 == 0 ? low[face / 2] : high[face / 2];
  return middle;
}

namespace {

/// The opening that a probe of kind flux looks through.
void place_opening(const ProbeDesc& p, core::LoadRow& row) {
  row.opening.normal = p.normal * (1 / length(p.normal));
  const Vec3d n = row.opening.normal;
  const Vec3d seen = p.radius > 0 ? (std::fabs(n.x) < 0.8 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}) : p.along;
  const Vec3d along = seen - n * dot(seen, n);
  row.opening.along = along * (1 / length(along));
  row.opening.across = cross(n, row.opening.along);
  row.opening.radius = p.radius;
  row.opening.half_along = 0.5 * p.size[0];
  row.opening.half_across = 0.5 * p.size[1];
}

}  // namespace

/// The sums of a probe of kind force, heat or flux, as one of the setup's.
void WorldImpl::place_load(const ProbeRecord& record, std::uint32_t number, core::ProbeSetup& s) const {
  const ProbeDesc& p = record.desc;
  core::LoadRow row;
  row.probe = number;
  row.body = p.body ? p.body.index + 1 : 0;
  row.face = p.wall.value_or(0);
  row.heat_scale = desc.heat.time_scale;
  const auto add = [&](LoadKind kind) {
    row.kind = kind;
    s.loads[static_cast<std::size_t>(kind)].push_back(row);
  };
  if (p.kind == ProbeKind::heat) return add(p.body ? LoadKind::heat_of_body : LoadKind::heat_of_wall);
  if (!p.points.empty()) {
    row.about = p.points.front() - origin_;
  } else if (p.body) {
    row.about_center = true;
  } else {
    row.about = middle_of_wall(row.face) - origin_;
  }
  std::uint32_t at[4] = {core::none, core::none, core::none, core::none}, next = 0;
  for (const std::string& name : p.fields) {
    const core::LoadField* const field = core::find_load_field(p.kind, name);
    at[field->slot] = next;
    next += field->width;
  }
  if (p.kind == ProbeKind::flux) {
    row.force = at[0];
    row.moment = at[1];
    place_opening(p, row);
    return add(LoadKind::flux);
  }
  const auto sum = [&](std::size_t first, LoadKind of_body, LoadKind of_wall) {
    if (at[first] == core::none && at[first + 1] == core::none) return;
    row.force = at[first];
    row.moment = at[first + 1];
    add(p.body ? of_body : of_wall);
  };
  sum(0, LoadKind::liquid_on_body, LoadKind::liquid_on_wall);
  sum(2, LoadKind::contact_on_body, LoadKind::contact_on_wall);
}

}  // namespace v0
}  // namespace meltsim
