// SPDX-License-Identifier: Apache-2.0
// output.
#include <fmt/format.h>

#include "echo.hpp"
#include "failure.hpp"
#include "load_parts.hpp"
#include "scene_keys.hpp"
#include "suggest.hpp"

namespace runner {

namespace {

int between(const Node& node, int least, int most, const char* unit) {
  const int value = node.small_integer();
  if (value < least || value > most) {
    node.fail(fmt::format("expected {} to {} {}, got {}", least, most, unit, value));
  }
  return value;
}

void load_surface_wish(const Node& node, double spacing, Json& surface) {
  node.allow_keys(keys::surface);
  surface = Json::object();
  if (const auto cell = node.find("cell")) {
    const double edge = cell->positive("m");  // the bounds are those of SurfaceDesc::cell
    if (edge < spacing / 16 || edge > 2 * spacing)
      cell->fail(fmt::format("expected 1/16 to 2 spacings, {:.4g} to {:.4g} (m), got {}", spacing / 16,
                             2 * spacing, cell->found()));
    surface["cell"] = edge;
  }
  if (const auto kernel = node.find("kernel")) surface["kernel"] = kernel->choice(keys::surface_kernel);
  if (const auto smoothing = node.find("smoothing"))
    surface["smoothing"] = between(*smoothing, 0, 100, "passes");
}

void load_camera(const Node& node, Json& camera) {
  node.allow_keys(keys::camera);
  camera = Json::object();
  for (const char* key : {"eye", "look_at", "up"}) {
    if (const auto value = node.find(key)) camera[key] = echo(value->vector("m"));
  }
  if (camera.contains("eye") && camera.contains("look_at") && camera["eye"] == camera["look_at"]) {
    node.find("look_at")->fail("is where the eye is; name the point to look at");
  }
  if (camera.contains("up") && length(node.find("up")->vector("any length")) == 0) {
    node.find("up")->fail("expected a direction, got [0, 0, 0]");
  }
  if (const auto value = node.find("fov")) {
    const double fov = value->positive("degrees");
    if (fov >= 170) value->fail(fmt::format("expected an angle below 170 degrees, got {}", value->found()));
    camera["fov"] = fov;
  }
}

void load_picture(const Node& node, Json& picture) {
  node.allow_keys(keys::picture);
  picture = Json::object();
  if (const auto width = node.find("width")) picture["width"] = between(*width, 16, 8192, "pixels");
  if (const auto height = node.find("height")) picture["height"] = between(*height, 16, 8192, "pixels");
  if (const auto samples = node.find("samples"))
    picture["samples"] = between(*samples, 1, 8, "samples along a side of a pixel");
  if (const auto look = node.find("look")) picture["look"] = look->choice(keys::look);
}

}  // namespace

void load_output(const Node& node, Scene& scene) {
  node.allow_keys(keys::output);
  SceneOutput& output = scene.output;
  if (const auto formats = node.find("export")) {
    output.formats.clear();
    for (const Node& item : formats->items("formats")) {
      output.formats.push_back(item.choice(keys::formats));
    }
  }
  if (const auto surface = node.find("surface"))
    load_surface_wish(*surface, scene.world.spacing, output.surface);
  if (const auto camera = node.find("camera")) load_camera(*camera, output.camera);
  if (const auto picture = node.find("picture")) load_picture(*picture, output.picture);
}

}  // namespace runner
