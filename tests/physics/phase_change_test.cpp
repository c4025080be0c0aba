// SPDX-License-Identifier: Apache-2.0
// When liquid freezes, where a site lies, and how a newly frozen particle comes to its volume.
#include "meltsim/physics/phase_change.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace {

using namespace meltsim;
using namespace meltsim::physics;

MaterialRow<double> liquid(double latent) {
  MaterialRow<double> m;
  m.freezes = m.plateau = 1;
  m.heat_capacity = 2000;
  m.liquid_heat_capacity = 4000;
  m.latent_heat = m.melting_heat = latent;
  m.melting_enthalpy = -latent;
  return m;
}

TEST(Freezing, NeedsTheWholeLatentHeatGone) {
  const auto water = liquid(3e5);
  EXPECT_TRUE(freezes(water, -3e5));
  EXPECT_TRUE(freezes(water, -4e5));  // supercooled
  EXPECT_FALSE(freezes(water, -3e5 + 1e-3));
  EXPECT_FALSE(freezes(water, 0.0));
  auto oil = water;
  oil.freezes = 0;
  EXPECT_FALSE(freezes(oil, -4e5));
}

// At no enthalpy does a material both melt and freeze: what has just done one does not do the other.
TEST(Freezing, ExcludesMelting) {
  for (const double latent : {0.0, 1e-3, 3e5}) {
    auto m = liquid(latent);
    m.melts = 1;
    for (const double h : {-2 * latent - 1, -latent - 1e-12, -latent, -0.5 * latent, -1e-12, 0.0, 1e-12, 1.0})
      EXPECT_FALSE(freezes(m, h) && melts(m, true, h)) << latent << " " << h;
    EXPECT_TRUE(melts(m, true, 0.0));
  }
}

TEST(Freezing, SitesTurnLikeARigidBody) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, -2, 0.5).normalized()));
  const Eigen::Vector3d rest(0.2, -0.4, 0.1), exact = q * rest;
  const Vec3<double> ours =
      site_offset(Quat<double>{q.w(), q.x(), q.y(), q.z()}, Vec3<double>{0.2, -0.4, 0.1});
  EXPECT_NEAR(ours.x, exact.x(), 1e-15);
  EXPECT_NEAR(ours.y, exact.y(), 1e-15);
  EXPECT_NEAR(ours.z, exact.z(), 1e-15);
}

// A hundredth of a spacing in an acoustic step, less in a shorter one, and never past the site.
TEST(Freezing, WhatIsDrawnComesSlowlyAndStopsAtItsSite) {
  EXPECT_DOUBLE_EQ(drawn_share(0.05, 0.1, 2e-3, 2e-3), 0.02);
  EXPECT_DOUBLE_EQ(drawn_share(0.05, 0.1, 1e-3, 2e-3), 0.01);
  EXPECT_DOUBLE_EQ(drawn_share(0.05, 0.1, 8e-3, 2e-3), 0.02);
  EXPECT_EQ(drawn_share(0.0005, 0.1, 2e-3, 2e-3), 1.0);
  EXPECT_EQ(drawn_share(0.0, 0.1, 2e-3, 2e-3), 1.0);
  EXPECT_LT(joins_within, site_agreement);
}

TEST(Freezing, ReachIsTheBallOfOneParticle) {
  EXPECT_NEAR(4.0 / 3.0 * M_PI * std::pow(capture_radius, 3), 1.0, 0.01);
  // Two sites' balls overlap, so that liquid between them is reached; the site beyond is not.
  EXPECT_GT(capture_radius, 0.5);
  EXPECT_LT(capture_radius, site_clearance);
}

}  // namespace
