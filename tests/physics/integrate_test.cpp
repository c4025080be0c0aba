// SPDX-License-Identifier: Apache-2.0
// Drift-kick-drift on an oscillator x'' = -omega^2 x.
#include "meltsim/physics/integrate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "meltsim/physics/shape_matching.hpp"

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
  EXPECT_DOUBLE_EQ(force_dt(0.4, 0.9, 10.0), 0.12);
  EXPECT_EQ(support_factor(2.5), 1.0);
  EXPECT_EQ(support_factor(2.0), 0.7);
  EXPECT_EQ(spring_dt(2.0, 250, 1000, 0), 2.0);
  EXPECT_DOUBLE_EQ(spring_dt(2.0, 100, 10000, 0), 0.4);
  // In liquid: nothing down to half its density, and steps that meet there; then the power 0.6, or the pile if that is less.
  EXPECT_EQ(spring_dt(2.0, 500, 500, 1000), 2.0);
  EXPECT_NEAR(spring_dt(2.0, 499.999, 500, 1000), 2.0, 1e-5);
  EXPECT_NEAR(spring_dt(2.0, 5, 5, 1000), 2.0 * std::pow(0.01, 0.6), 1e-12);
  EXPECT_DOUBLE_EQ(spring_dt(2.0, 100, 10000, 500), 0.4);
  EXPECT_DOUBLE_EQ(drag_dt(0.01, 0.5, 200.0), 0.5);
}

/// A mode of a body under shape matching (shape_matching.hpp): x'' = -(alpha l) x - damping l x', dt_s = 1.
struct Mode {
  double x = 1, v = 0, alpha = 1, eigenvalue = 1, damping = 0;
  void step(double dt) {
    x += 0.5 * dt * v;
    v += shape_velocity(stiffness_of_step(alpha, dt, 1.0), damping * dt, dt,
                        Vec3<double>{-eigenvalue * x, 0, 0}, Vec3<double>{-eigenvalue * v, 0, 0})
             .x;
    x += 0.5 * dt * v;
  }
  double energy() const { return v * v + alpha * eigenvalue * x * x; }
};

// The law's period, 2 pi/sqrt(alpha l), whatever the steps: at lengths drawn from 0.001..0.02 it is met to second
// order, (omega dt)^2/24 = 2e-5; the zero of x is found between two steps.
TEST(Integrate, AModeKeepsItsPeriodAtRandomSteps) {
  for (const double alpha : {1.0, 0.25}) {
    Mode m;
    m.alpha = alpha;
    std::uint64_t seed = 12345;
    double t = 0;
    for (;;) {
      seed = seed * 6364136223846793005u + 1442695040888963407u;
      const double dt = 0.001 + 0.019 * double(seed >> 33) / 2147483648.0, before = m.x;
      m.step(dt);
      if (m.x <= 0) {
        t += dt * before / (before - m.x);
        break;
      }
      t += dt;
    }
    EXPECT_NEAR(t / (0.5 * 3.14159265358979323846 / std::sqrt(alpha)), 1, 1e-4);
  }
}

// 1e5 steps drawn from 0.01..1: with the least damping the energy stays below its start times 4/3, the most by which one
// step's conserved energy differs from another's; without damping the highest mode gains, 2e-4 per step in amplitude.
TEST(Integrate, RandomStepsAddNoEnergyToAMode) {
  const auto largest = [](double alpha, double eigenvalue, double damping) {
    Mode m;
    m.alpha = alpha;
    m.eigenvalue = eigenvalue;
    m.damping = damping;
    std::uint64_t seed = 99;
    const double start = m.energy();
    double most = 1;
    for (int k = 0; k < 100000; ++k) {
      seed = seed * 6364136223846793005u + 1442695040888963407u;
      m.step(0.01 + 0.99 * double(seed >> 33) / 2147483648.0);
      most = std::max(most, m.energy() / start);
    }
    return most;
  };
  for (const double alpha : {1.0, 0.5, 0.1})
    for (const double eigenvalue : {1.0, 0.7, 0.3, 0.01})
      EXPECT_LT(largest(alpha, eigenvalue, least_damping(alpha)), 4.0 / 3) << alpha << ' ' << eigenvalue;
  EXPECT_GT(largest(1, 1, 0), 100);
}

// The worst that any sequence of lengths can do, by dynamic programming over the phase: growth of the logarithm of the
// amplitude per step. 720 phases resolve 1e-4.
TEST(Integrate, NoSequenceOfStepsAddsEnergyToAMode) {
  const auto worst = [](double damping) {
    constexpr int phases = 720, lengths = 11;
    std::vector<double> gain(phases * lengths), lands(phases * lengths), value(phases, 0), next(phases);
    const double pi = 3.14159265358979323846;
    for (int a = 0; a < phases; ++a)
      for (int j = 0; j < lengths; ++j) {
        Mode m;
        m.x = std::cos(pi * a / phases);
        m.v = std::sin(pi * a / phases);
        m.damping = damping;
        m.step(0.01 + 0.99 * j / (lengths - 1));
        double phase = std::atan2(m.v, m.x);
        if (phase < 0) phase += pi;
        gain[a * lengths + j] = 0.5 * std::log(m.energy());
        lands[a * lengths + j] = phase / pi * phases;
      }
    double rate = 0;
    for (int n = 0; n < 1000; ++n) {
      double high = -1e9, low = 1e9;
      for (int a = 0; a < phases; ++a) {
        next[a] = -1e9;
        for (int j = 0; j < lengths; ++j) {
          const double at = lands[a * lengths + j], share = at - std::floor(at);
          const int b = static_cast<int>(at) % phases;
          next[a] = std::max(
              next[a], gain[a * lengths + j] + (1 - share) * value[b] + share * value[(b + 1) % phases]);
        }
        high = std::max(high, next[a] - value[a]);
        low = std::min(low, next[a] - value[a]);
      }
      rate = 0.5 * (high + low);
      const double base = next[0];
      for (int a = 0; a < phases; ++a) value[a] = next[a] - base;
    }
    return rate;
  };
  EXPECT_LT(worst(least_damping(1.0)), 1e-4);
  EXPECT_GT(worst(0), 1e-2);
}

}  // namespace
