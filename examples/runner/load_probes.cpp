// SPDX-License-Identifier: Apache-2.0
// probes: what depends on their kind, and on the bodies of the scene.
#include <fmt/format.h>

#include <algorithm>

#include "failure.hpp"
#include "load_parts.hpp"
#include "suggest.hpp"

namespace runner {

namespace {

using meltsim::ProbeKind;

/// The body or wall of a force or of heat.
void check_side(const Node& item, const Scene& scene, SceneProbe& probe) {
  const auto body = item.find("body"), wall = item.find("wall");
  if (body && wall) wall->fail("the probe has a body already; give either a body or a wall");
  if (!body && !wall)
    item.fail("expected body: the name of one, or wall: " + either_of(keys::one_face) + ", got neither");
  if (wall) return;
  std::vector<std::string> names;
  for (const SceneBody& other : scene.bodies) names.push_back(other.desc.name);
  const auto at = std::find(names.begin(), names.end(), probe.body);
  if (at == names.end())
    body->fail(fmt::format("no body is named {}{}", body->found(), suggestion(probe.body, names, "bodies")));
  // Its place in the scene; add_probes() has the World's handle.
  probe.desc.body = {static_cast<std::uint32_t>(at - names.begin()), 1};
}

void check_opening(const Node& item) {
  const auto radius = item.find("radius"), size = item.find("size"), along = item.find("along");
  if (radius && size) size->fail("a disc has a radius and no size; give one of the two");
  if (!radius && !size)
    item.fail("expected radius: of a disc (m), or size: [a, b] of a rectangle (m), got neither");
  if (radius && along) along->fail("a disc has no sides; leave it out");
  if (size) item.require("along", "the direction of the first side, [x, y, z]");
}

}  // namespace

void load_probes(const Node& node, Scene& scene) {
  load_list(node, probe_options(), scene.probes, [&](const Node& item, SceneProbe& probe) {
    if (probe.desc.kind == ProbeKind::force || probe.desc.kind == ProbeKind::heat)
      check_side(item, scene, probe);
    if (probe.desc.kind == ProbeKind::flux) check_opening(item);
    take_default_fields(item, probe);
    if (!item.find("every")) probe.desc.every = 1 / scene.time.fps;
  });
  number_names(scene.probes, "probe");
}

}  // namespace runner
