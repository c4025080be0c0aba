// SPDX-License-Identifier: Apache-2.0
// Small worlds shared by the tests. MELTSIM_TEST_BACKEND=cuda runs the same texts on a GPU; without one they
// are skipped, or fail if MELTSIM_REQUIRE_GPU=1.
#pragma once

#include <gtest/gtest.h>

#include "meltsim/meltsim.hpp"

namespace meltsim_test {

using namespace meltsim;

/// Name of the backend that the texts of a program run on unless the environment names another; each program has its own.
const char* usual_backend();

/// The backend the texts run on.
Backend backend();

/// A description with the backend filled in.
WorldDesc describe();

/// Fails the test when a Result or Status is an Error.
template <class R>
void require(const R& r) {
  ASSERT_TRUE(r) << r.error().message;
}

struct IceScene {
  double box = 2.4, depth = 1.0;  // 12 x 5 x 12 liquid lattice: every wall and the surface matter
  int block = 3;                  // 27 vertices, one of them internal
  double ice_temperature = -10, water_temperature = 80;
  double ice_density = 917;
  double time_scale = 2e6;  // a block of 0.6 m melts within a second or two
  double block_floor = 1.2;
  bool water = true;
  int region_half_width = 2;
  bool freezes = false;
  int growth = 0;
  bool fixed = false;
  Motion motion = Motion::free;
  double latent_heat = 3.34e5;
};

struct Scene {
  World world;
  MaterialId water, ice;
};

/// A tank with a block of ice above the water.
Scene ice_in_water(WorldDesc desc, const IceScene& s = {});

/// Steps until nothing is solid or `limit` seconds have passed; returns the steps.
int melt(World& world, double dt, double limit);

#define MELTSIM_NEEDS_BACKEND()                                                           \
  do {                                                                                    \
    const auto probe = ::meltsim::World::create(::meltsim_test::describe());              \
    if (!probe && ::meltsim_test::backend() == ::meltsim::Backend::cuda) {                \
      if (std::getenv("MELTSIM_REQUIRE_GPU") != nullptr) FAIL() << probe.error().message; \
      GTEST_SKIP() << probe.error().message;                                              \
    }                                                                                     \
  } while (false)

}  // namespace meltsim_test
