// SPDX-License-Identifier: Apache-2.0
// The walls of a domain as pictures show them: bars along the edges between its faces.
#pragma once

#include <vector>

#include "show/camera.hpp"

namespace runner {

/// A box along the axes, in world coordinates [m].
struct Bar {
  meltsim::Vec3d min, max;
};

/// Of the bars [m].
double tank_width(const Scene& scene);
/// One bar outside of every edge that belongs to a wall; none where there are no walls. Edges between two faces that are
/// turned to the eye are left out: they would stand before what the domain holds.
std::vector<Bar> tank_bars(const Scene& scene, const meltsim::Vec3d& eye);

}  // namespace runner
