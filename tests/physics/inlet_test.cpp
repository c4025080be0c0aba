// SPDX-License-Identifier: Apache-2.0
// Flow at a face with liquid beyond, against the Riemann problem of shallow water, solved by bisection and by search.
#include "meltsim/physics/inlet.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace meltsim;
using namespace meltsim::physics;

constexpr double g = 9.81, dx = 0.01, sound = 20, area = 0.4;

/// Sums that stand for a depth and a velocity; their whole numbers resolve 1e-6 of dx^3 and 4e-9 c.
OutletSums ahead_of(double depth, double speed) {
  OutletSums s;
  const double volume = depth * area / (dx * dx * dx);
  for (int k = 0; k < 1000; ++k) s.add(volume / 1000, speed / sound);
  return s;
}

InletFlow flow_of(double depth, double speed, double head) {
  return inlet_flow(ahead_of(depth, speed), dx, sound, area, head, g);
}

/// Of the reservoir's rarefaction, u = 2 c - 2 c_L, the state that what arrives from inside meets.
InletFlow met(double depth, double speed, double head) {
  const double arriving = speed + 2 * std::sqrt(g * depth), beyond = std::sqrt(g * head);
  double low = 0, high = 10 * beyond + arriving;
  for (int k = 0; k < 200; ++k) {
    const double c = 0.5 * (low + high);
    ((2 * c - 2 * beyond) + 2 * c < arriving ? low : high) = c;
  }
  return {2 * low - 2 * beyond, low * low / g};
}

/// Of the same, the state of the largest flux: what a reservoir can give at most.
InletFlow largest(double head) {
  const double beyond = std::sqrt(g * head);
  InletFlow best;
  for (int k = 0; k <= 30000; ++k) {
    const double c = beyond * k / 30000, u = 2 * c - 2 * beyond;
    if (u * c * c / g < best.speed * best.depth) best = {u, c * c / g};
  }
  return best;
}

TEST(Inlet, FlowIsThatOfBothCharacteristicsOrTheLargest) {
  for (const double head : {0.05, 0.1, 0.4})
    for (const double share : {0.0, 0.05, 0.3, 0.6, 0.9, 1.0, 1.3})
      for (const double speed : {-0.3, 0.0, 0.2}) {
        if (share == 0 && speed != 0) continue;
        const double depth = share * head;
        const InletFlow b = flow_of(depth, speed, head), most = largest(head), both = met(depth, speed, head);
        const InletFlow due = both.speed < most.speed ? most : both;
        EXPECT_NEAR(b.speed, due.speed, 1e-4 * std::sqrt(g * head)) << head << " " << share << " " << speed;
        EXPECT_NEAR(b.depth, due.depth, 2e-4 * head) << head << " " << share << " " << speed;
      }
}

// A small wave that arrives at the level has its own velocity there, eta sqrt(g/h), trough or crest: nothing goes back.
TEST(Inlet, ASmallWaveGoesThrough) {
  const double head = 0.2;
  for (const double eta : {-1e-4, 1e-4}) {
    const double u = eta * std::sqrt(g / head);
    EXPECT_NEAR(flow_of(head + eta, u, head).speed, u, 2e-3 * std::fabs(u));
  }
  EXPECT_NEAR(flow_of(head, 0, head).speed, 0, 1e-6);
  EXPECT_NEAR(flow_of(head, 0, head).depth, head, 1e-6);
}

TEST(Inlet, WholeLayersCarryTheFlux) {
  for (const double depth : {0.005, 0.012, 0.0151, 0.1, 0.237}) {
    const InletFlow b{-0.3, depth};
    const double layers = std::round(depth / dx);
    EXPECT_NEAR(inlet_speed(b, dx) * layers * dx, b.speed * depth, 1e-12) << depth;
  }
  EXPECT_EQ(inlet_speed({-0.3, 0.004}, dx), 0);   // less than half a layer
  EXPECT_EQ(inlet_speed({0.3, 0.013}, dx), 0.3);  // outwards it is the liquid there that leaves
}

// With H/c_L as its time: after as long, within steps of a thousandth of it, 1/e is left.
TEST(Inlet, VelocityFollowsWithinTheTimeFromWhereItIsMeasured) {
  const double support = 0.025, head = 0.1, tau = support / std::sqrt(g * head);
  double u = 1;
  for (int k = 0; k < 1000; ++k) u = inlet_approach(u, 0, tau / 1000, support, head, g);
  EXPECT_NEAR(u, std::exp(-1.0), 1e-3);
}

// Weights sum to those of a plane layer of H, for columns a spacing apart wherever they stand, to 0.2 %.
TEST(Inlet, WeightsOfColumnsAddUpToASupportRadius) {
  const double support = 2.5 * dx;
  for (double phase = 0; phase < 1; phase += 0.1) {
    double sum = 0;
    for (int k = 0; k < 20; ++k) sum += inlet_weight((k + phase) * dx / support) * dx;
    EXPECT_NEAR(sum, support, 0.002 * support) << phase;
  }
  EXPECT_EQ(inlet_weight(1.0), 0);
  EXPECT_EQ(inlet_weight(3.5), 0);
  EXPECT_EQ(inlet_weight(2.0), 1);
}

}  // namespace
