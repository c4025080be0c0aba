// SPDX-License-Identifier: Apache-2.0
// Kinds of scenes in which bodies come and go.
#pragma once

#include <functional>

#include "scenes.hpp"

namespace meltsim_test {

struct BodyCase {
  const char* name;
  std::function<void(WorldDesc&, IceScene&)> change;
  std::function<void(SolidDesc&)> body;
};

/// With room for more.
inline IceScene scene_of(const BodyCase& c, WorldDesc& d) {
  IceScene s;
  d.reserved_particles = 600;
  c.change(d, s);
  return s;
}

/// A tank with ice above water.
inline Scene make(const BodyCase& c) {
  WorldDesc d = describe();
  const IceScene s = scene_of(c, d);
  return ice_in_water(d, s);
}

/// A body of ice above it.

inline Result<BodyId> add(const BodyCase& c, Scene& s, const char* name, double x, double z = 0.2,
                          int sites = 3) {
  SolidDesc d;
  d.name = name;
  d.material = s.ice;
  d.shape = Shape::box({x, 1.2, z}, {x + 0.6, 1.2 + 0.2 * sites, z + 0.2 * sites});
  d.temperature = -5;
  c.body(d);
  return s.world.add_solid(d);
}

}  // namespace meltsim_test
