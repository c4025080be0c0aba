// SPDX-License-Identifier: Apache-2.0
// force_fields: what accelerates liquid and bodies in a part of space.
#include "load_parts.hpp"
#include "load_shape.hpp"
#include "scene_keys.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace runner {

void load_force_fields(const Node& node, Scene& scene) {
  for (const Node& item : node.items("force_fields")) {
    item.allow_keys(keys::field);
    SceneForceField field;
    field.source = item.source();
    meltsim::ForceFieldDesc& desc = field.desc;
    desc.name = fmt::format("field{}", scene.force_fields.size() + 1);
    if (const auto value = item.find("name")) desc.name = value->text("a name");
    const std::string kind = item.require("kind", "uniform, radial, vortex or drag").choice(keys::field_kind);
    desc.kind = static_cast<meltsim::ForceFieldKind>(
        std::find(keys::field_kind.begin(), keys::field_kind.end(), kind) - keys::field_kind.begin());
    if (const auto shape = item.find("shape")) {
      field.shape = load_shape(*shape);
      desc.shape = field.shape->shape;
    }
    if (const auto value = item.find("acceleration")) desc.acceleration = value->vector("m/s^2");
    if (const auto value = item.find("center")) desc.center = value->vector("m");
    if (const auto value = item.find("axis")) desc.axis = value->vector("any length");
    if (const auto value = item.find("strength")) desc.strength = value->number("m/s^2");
    if (const auto value = item.find("radius")) desc.radius = value->number("m");
    if (const auto value = item.find("power")) desc.power = value->small_integer();
    if (const auto value = item.find("velocity")) desc.velocity = value->vector("m/s");
    if (const auto value = item.find("angular_velocity")) desc.angular_velocity = value->vector("rad/s");
    if (const auto value = item.find("rate")) desc.rate = value->number("1/s");
    if (const auto value = item.find("liquid")) desc.liquid = value->boolean();
    if (const auto value = item.find("bodies")) desc.bodies = value->boolean();
    if (const auto value = item.find("from")) desc.from = value->number("s");
    if (const auto value = item.find("until")) desc.until = value->number_or_infinite("s");
    scene.force_fields.push_back(field);
  }
}

}  // namespace runner
