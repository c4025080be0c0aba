// SPDX-License-Identifier: Apache-2.0
// probes and output.
#include <fmt/format.h>

#include <algorithm>

#include "echo.hpp"
#include "failure.hpp"
#include "load_parts.hpp"
#include "scene_keys.hpp"
#include "suggest.hpp"

namespace runner {

void load_probes(const Node& node, Scene& scene) {
  for (const Node& item : node.items("probes")) {
    item.allow_keys(keys::probe);
    SceneProbe probe;
    const auto name = item.find("name");
    probe.name = name ? name->text("a name") : fmt::format("probe{}", scene.probes.size() + 1);
    if (probe.name.find_first_of(",\"\n\r") != std::string::npos) {
      name->fail(fmt::format("expected a name without commas, quotes or line breaks, got {}", name->found()));
    }
    probe.at = item.require("at", "3 numbers [x, y, z] (m)").vector("m");
    const Node fields = item.require("fields", "a list of " + either_of(keys::probe_field));
    for (const Node& field : fields.items("fields")) probe.fields.push_back(field.choice(keys::probe_field));
    const auto every = item.find("every");
    probe.every = every ? every->positive("s") : 1 / scene.time.fps;
    scene.probes.push_back(probe);
  }
}

void load_output(const Node& node, Scene& scene) {
  node.allow_keys(keys::output);
  SceneOutput& output = scene.output;
  if (const auto formats = node.find("export")) {
    output.formats.clear();
    for (const Node& item : formats->items("formats")) {
      const std::string format = item.text("a format");
      const bool later = std::count(keys::later_formats.begin(), keys::later_formats.end(), format) > 0;
      if (later) {
        item.fail(fmt::format("\"{}\" is not available in this version; available: {}", format,
                              either_of(keys::formats)));
      }
      output.formats.push_back(item.choice(keys::formats));
    }
  }
  if (const auto surface = node.find("surface")) {
    surface->allow_keys(keys::surface);
    output.surface = Json::object();
    if (const auto cell = surface->find("cell")) output.surface["cell"] = cell->positive("m");
  }
  if (const auto camera = node.find("camera")) {
    camera->allow_keys(keys::camera);
    output.camera = Json::object();
    for (const char* key : {"eye", "look_at", "up"}) {
      if (const auto value = camera->find(key)) output.camera[key] = echo(value->vector("m"));
    }
    if (const auto value = camera->find("fov")) output.camera["fov"] = value->positive("degrees");
  }
}

}  // namespace runner
