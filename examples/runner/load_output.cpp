// SPDX-License-Identifier: Apache-2.0
// output: checks that look at several keys.
#include <fmt/format.h>

#include "load_parts.hpp"

namespace runner {

void load_wish(const Node& node, const Options<Json>& options, Json& wish) {
  wish = Json::object();
  load_options(node, options, wish);
}

void load_surface_wish(const Node& node, Scene& scene) {
  Json& surface = scene.output.surface;
  load_wish(node, surface_options(), surface);
  const auto cell = node.find("cell");
  if (!cell) return;
  const double edge = surface["cell"], spacing = scene.world.spacing;  // bounds of SurfaceDesc::cell
  if (edge < spacing / 16 || edge > 2 * spacing)
    cell->fail(fmt::format("expected 1/16 to 2 spacings, {:.4g} to {:.4g} (m), got {}", spacing / 16,
                           2 * spacing, cell->found()));
}

void load_camera(const Node& node, Json& camera) {
  load_wish(node, camera_options(), camera);
  if (camera.contains("eye") && camera.contains("look_at") && camera["eye"] == camera["look_at"])
    node.find("look_at")->fail("is where the eye is; name the point to look at");
  if (camera.contains("up") && length(node.find("up")->vector("any length")) == 0)
    node.find("up")->fail("expected a direction, got [0, 0, 0]");
}

}  // namespace runner
