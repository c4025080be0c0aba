// SPDX-License-Identifier: Apache-2.0
// probes.
#include <fmt/format.h>

#include <algorithm>

#include "failure.hpp"
#include "load_parts.hpp"
#include "scene_keys.hpp"
#include "suggest.hpp"

namespace runner {

namespace {

using meltsim::ProbeKind;

/// Of the keys that only some kinds have, those that this kind has.
keys::List keys_of(ProbeKind kind) {
  switch (kind) {
    case ProbeKind::point:
      return {"at", "fields"};
    case ProbeKind::level:
      return {"at"};
    case ProbeKind::force:
      return {"body", "wall", "about", "fields"};
    case ProbeKind::heat:
      return {"body", "wall"};
    case ProbeKind::flux:
      return {"at", "normal", "radius", "along", "size", "fields"};
  }
  return {};
}

/// What a kind has no use for would be passed over in silence.
void check_keys(const Node& item, ProbeKind kind, const std::string& kind_name) {
  const keys::List own = keys_of(kind);
  for (const std::string& key : keys::probe) {
    if (key == "name" || key == "kind" || key == "every") continue;
    const auto value = item.find(key);
    if (!value || std::find(own.begin(), own.end(), key) != own.end()) continue;
    const std::string what = kind == ProbeKind::level ? "a level" : "kind " + kind_name;
    const std::string instead = kind == ProbeKind::level && key == "fields" ? ", or write kind: point" : "";
    value->fail(
        fmt::format("{} has no {}; leave {} out{}", what, key, key == "fields" ? "them" : "it", instead));
  }
}

std::vector<std::string> load_fields(const Node& item, ProbeKind kind) {
  if (kind == ProbeKind::level || kind == ProbeKind::heat) return {};
  const keys::List& known = kind == ProbeKind::force  ? keys::force_field
                            : kind == ProbeKind::flux ? keys::flux_field
                                                      : keys::probe_field;
  const auto given = item.find("fields");
  if (!given && kind != ProbeKind::point) return {known.front()};
  std::vector<std::string> fields;
  for (const Node& field : item.require("fields", "a list of " + either_of(known)).items("fields"))
    fields.push_back(field.choice(known));
  return fields;
}

/// The body or wall of a force or of heat.
void load_side(const Node& item, const Scene& scene, SceneProbe& probe) {
  const auto body = item.find("body"), wall = item.find("wall");
  if (body && wall) wall->fail("the probe has a body already; give either a body or a wall");
  if (!body && !wall)
    item.fail("expected body: the name of one, or wall: " + either_of(keys::one_face) + ", got neither");
  if (wall) {
    const std::string name = wall->choice(keys::one_face);
    const auto at = std::find(keys::one_face.begin(), keys::one_face.end(), name);
    probe.desc.wall = static_cast<int>(at - keys::one_face.begin());
    return;
  }
  probe.body = body->text("the name of a body");
  std::vector<std::string> names;
  for (const SceneBody& other : scene.bodies) names.push_back(other.desc.name);
  const auto at = std::find(names.begin(), names.end(), probe.body);
  if (at == names.end())
    body->fail(fmt::format("no body is named {}{}", body->found(), suggestion(probe.body, names, "bodies")));
  probe.desc.body = {static_cast<std::uint32_t>(at - names.begin()), 1};
}

void load_opening(const Node& item, meltsim::ProbeDesc& desc) {
  desc.normal =
      item.require("normal", "the direction that counts as positive, [x, y, z]").vector("any length");
  const auto radius = item.find("radius"), size = item.find("size");
  if (radius && size) size->fail("a disc has a radius and no size; give one of the two");
  if (!radius && !size)
    item.fail("expected radius: of a disc (m), or size: [a, b] of a rectangle (m), got neither");
  if (radius) {
    desc.radius = radius->positive("m");
    if (const auto along = item.find("along")) along->fail("a disc has no sides; leave it out");
    return;
  }
  const std::vector<Node> sides = size->items("2 numbers (m)");
  if (sides.size() != 2) size->fail(fmt::format("expected 2 numbers (m), got {}", size->found()));
  for (std::size_t k = 0; k < 2; ++k) desc.size[k] = sides[k].positive("m");
  desc.along = item.require("along", "the direction of the first side, [x, y, z]").vector("any length");
}

}  // namespace

void load_probes(const Node& node, Scene& scene) {
  for (const Node& item : node.items("probes")) {
    item.allow_keys(keys::probe);
    SceneProbe probe;
    probe.source = item.source();
    meltsim::ProbeDesc& desc = probe.desc;
    const auto name = item.find("name");
    desc.name = name ? name->text("a name") : fmt::format("probe{}", scene.probes.size() + 1);
    if (desc.name.find_first_of(",\"\n\r") != std::string::npos) {
      name->fail(fmt::format("expected a name without commas, quotes or line breaks, got {}", name->found()));
    }
    std::string kind_name = "point";
    if (const auto kind = item.find("kind")) kind_name = kind->choice(keys::probe_kind);
    const auto at = std::find(keys::probe_kind.begin(), keys::probe_kind.end(), kind_name);
    desc.kind = static_cast<ProbeKind>(at - keys::probe_kind.begin());
    check_keys(item, desc.kind, kind_name);
    const bool sides = desc.kind == ProbeKind::force || desc.kind == ProbeKind::heat;
    if (sides) load_side(item, scene, probe);
    else desc.points = {item.require("at", "3 numbers [x, y, z] (m)").vector("m")};
    if (const auto about = item.find("about")) desc.points = {about->vector("m")};
    if (desc.kind == ProbeKind::flux) load_opening(item, desc);
    desc.fields = load_fields(item, desc.kind);
    const auto every = item.find("every");
    if (!every) desc.every = 1 / scene.time.fps;
    else if (!every->is_word("step")) desc.every = every->positive("s");
    scene.probes.push_back(probe);
  }
}

}  // namespace runner
