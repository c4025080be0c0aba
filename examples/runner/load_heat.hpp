// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node.hpp"
#include "scene.hpp"

namespace runner {

/// {temperature | flux, convection, emissivity, ambient}.
meltsim::SurfaceHeatDesc load_surface(const Node& node);

/// A number, or a list of [temperature, value].
void load_property(const Node& value, const char* key, const char* unit, double& constant,
                   std::vector<meltsim::PropertyPoint>& points);

/// A number, or a list of [time, value], of which `first` is the first value then.
void load_timed(const Node& value, const char* unit, double& first, std::vector<meltsim::TimedValue>& points);

/// A list of [time, x, y, z]; of a body, of [time, x, y, z, degrees], too.
std::vector<meltsim::PathPoint> load_path(const Node& value);
std::vector<meltsim::PosePoint> load_poses(const Node& value);

}  // namespace runner
