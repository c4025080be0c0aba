// SPDX-License-Identifier: Apache-2.0
// Drift-kick-drift on an oscillator x'' = -omega^2 x.
#include "meltsim/physics/integrate.hpp"

#include <gtest/gtest.h>

namespace {

using namespace meltsim;
using namespace meltsim::physics;

struct Oscillator {
  Vec3<double> x{1, 0, 0}, v{0, 0.5, 0};
  double omega = 2;
  void step(double dt) {
    x = drift(x, v, 0.5 * dt);
    v = kick(v, x * (-omega * omega), dt);
    x = drift(x, v, 0.5 * dt);
  }
  double energy(double dt = 0) const {
    // The scheme conserves exactly the energy with v^2 scaled by 1 - (omega dt)^2/4.
    return 0.5 * dot(v, v) * (1 - 0.25 * omega * omega * dt * dt) + 0.5 * omega * omega * dot(x, x);
  }
};

// 1e5 steps at omega dt = 0.4: rounding only, 1e-11. The true energy swings by (omega dt)^2/4 = 4 % at most.
TEST(Integrate, OscillatorKeepsItsEnergy) {
  Oscillator o;
  const double dt = 0.2, start = o.energy(dt), truth = o.energy();
  for (int n = 0; n < 100000; ++n) {
    o.step(dt);
    ASSERT_NEAR(o.energy() / truth, 1.0, 0.05);
  }
  EXPECT_NEAR(o.energy(dt) / start, 1.0, 1e-11);
}

// One period: halving the step divides the error by four.
TEST(Integrate, SecondOrder) {
  const auto error = [](int steps) {
    Oscillator o;
    for (int n = 0; n < steps; ++n) o.step(3.14159265358979323846 / steps);
    return length(o.x - Vec3<double>{1, 0, 0});
  };
  EXPECT_NEAR(error(100) / error(200), 4.0, 0.05);
}

TEST(Integrate, TimeReversible) {
  Oscillator o;
  for (int n = 0; n < 1000; ++n) o.step(0.1);
  for (int n = 0; n < 1000; ++n) o.step(-0.1);
  EXPECT_LE(length(o.x - Vec3<double>{1, 0, 0}), 1e-11);
}

TEST(Integrate, LargestSteps) {
  EXPECT_DOUBLE_EQ(acoustic_dt(0.4, 0.5, 40.0), 0.005);
  EXPECT_DOUBLE_EQ(viscous_dt(0.01, 200.0), 0.5);
}

}  // namespace
