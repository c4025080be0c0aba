// SPDX-License-Identifier: Apache-2.0
// Species: plateau, mixture, and the face of a body, against sums made here.
#include "meltsim/physics/solute.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

namespace {

using namespace meltsim;
using namespace meltsim::physics;

SpeciesRow<double> sugar() {
  SpeciesRow<double> s;
  s.solubility = 0.6;
  s.volume = 1 / 1600.0;
  s.solvent_volume = 1 / 1000.0;
  s.diffusivity = 5e-10;
  s.log_viscosity = std::log(0.2);
  return s;
}

// A body drives at saturation until its content is down to it; liquid drives with what it holds. No jump between the two.
TEST(Solute, ABodyIsAPlateauAtSaturation) {
  const auto s = sugar();
  const double at = saturation_at(s, 20);
  EXPECT_EQ(at, 0.6);
  EXPECT_EQ(solute_potential(1.0, at, true), 0.6);
  EXPECT_EQ(solute_potential(0.61, at, true), 0.6);
  EXPECT_EQ(solute_potential(0.6, at, true), solute_potential(0.6, at, false));
  EXPECT_EQ(solute_potential(0.3, at, true), 0.3);
  EXPECT_EQ(solute_potential(0.3, at, false), 0.3);
  EXPECT_FALSE(is_dissolved(0.61 * 2.0, 2.0, at));
  EXPECT_TRUE(is_dissolved(0.6 * 2.0, 2.0, at));
}

// Linear between the points, constant beyond: 0.45 is half way by hand.
TEST(Solute, SaturationFollowsItsTable) {
  auto s = sugar();
  EXPECT_FALSE(precipitates(s));
  s.saturation.points = 2;
  s.saturation.temperature[0] = 20;
  s.saturation.temperature[1] = 60;
  s.saturation.value[0] = 0.3;
  s.saturation.value[1] = 0.6;
  EXPECT_TRUE(precipitates(s));
  EXPECT_EQ(saturation_at(s, 0), 0.3);
  EXPECT_NEAR(saturation_at(s, 40), 0.45, 1e-15);
  EXPECT_EQ(saturation_at(s, 90), 0.6);
}

// 500 J/kg a tenth of which may go in a sweep: of w_s = 0.6 and 1e5 J/kg they last for 500/1e5 0.4/0.1 = 0.02 of the mass.
TEST(Solute, AParticleDissolvesNoFurtherThanItsHeatLasts) {
  auto s = sugar();
  const auto limited = [&](double w, bool solid, double heat) {
    SoluteDrive d{0.6, 0.3};
    const bool lasts = limit_by_heat(s, w, solid, heat, 0.1, d);
    EXPECT_EQ(lasts, d.potential == 0.6 && d.room == 0.3);
    return d;
  };
  EXPECT_EQ(limited(1.0, true, 0).potential, 0.6);  // no heat of solution
  s.heat_of_solution = 1e5;
  EXPECT_NEAR(limited(1.0, true, 500).potential, 0.02, 1e-15);
  EXPECT_EQ(limited(1.0, true, 500).room, 0);
  EXPECT_EQ(limited(1.0, true, -1).potential, 0);        // below 0 K already
  EXPECT_EQ(limited(1.0, true, 2e4).potential, 0.6);     // lasts for 0.8
  EXPECT_EQ(limited(0.6019, true, 500).potential, 0.6);  // lasts for all that is not dissolved
  EXPECT_NEAR(limited(0.6021, true, 500).potential, 0.02, 1e-15);
  EXPECT_EQ(limited(0.7, false, 0).potential,
            0.6);  // liquid of a species that does not precipitate has no crystals
  s.heat_of_solution = -1e5;
  EXPECT_EQ(limited(1.0, true, 500).potential, 0.6);
  EXPECT_NEAR(limited(1.0, true, 500).room, 0.02, 1e-15);
  EXPECT_NEAR(limited(0.5, true, 500).room, 0.12, 1e-15);  // up to w_s it takes none
  EXPECT_EQ(limited(1.0, true, 1e4).room, 0.3);
  s.saturation.points = 2;  // precipitates: liquid may be crystals
  EXPECT_NEAR(limited(0.7, false, 500).room, 0.02, 1e-15);
}

// What one end gets the other loses, to the last bit; crystals get no more than they have room for, and give whatever room
// they have.
TEST(Solute, CrystalsTakeInWhatTheyHaveRoomFor) {
  const auto check = [](auto one) {
    using T = decltype(one);
    for (const T u_i : {T(0.1), T(0.3), T(0.7)})
      for (const T u_j : {T(0.1), T(0.3), T(0.7)})
        for (const T r_i : {T(0), T(0.05), T(1)})
          for (const T r_j : {T(0), T(0.05), T(1)}) {
            const T drive = limited_drive(u_i, r_i, u_j, r_j);
            EXPECT_EQ(drive, -limited_drive(u_j, r_j, u_i, r_i));
            EXPECT_LE(drive, r_i);
            EXPECT_GE(drive, -r_j);
            if (r_i == T(1) && r_j == T(1)) {
              EXPECT_EQ(drive, u_j - u_i);
            }
            if (u_j < u_i && r_j == T(1)) {
              EXPECT_EQ(drive, u_j - u_i);
            }
          }
  };
  check(1.0f);
  check(1.0);
  EXPECT_EQ(crystal_room(0.75), 0.25);
  EXPECT_EQ(crystal_room(1.0000001), 0);
  EXPECT_FALSE(crystallises(0.96, 0.3));  // 0.3 + 0.95 * 0.7 = 0.965
  EXPECT_TRUE(crystallises(0.97, 0.3));
  // Of a species that precipitates, liquid counts by its content; of another, whatever liquid holds is dissolved.
  auto s = sugar();
  EXPECT_EQ(undissolved(s, 0.8, 1.0, false), 0);
  s.saturation.points = 2;
  EXPECT_NEAR(undissolved(s, 0.8, 1.0, false), 0.5, 1e-15);
  EXPECT_EQ(undissolved(s, 0.6, 1.0, false), 0);
}

// Crystals in saturated solution: q + w_s (m - q) = S, all of it at w = 1 and none at w_s.
TEST(Solute, WhatIsNotDissolvedIsInSaturatedSolution) {
  const auto s = sugar();
  constexpr double m = 3;
  for (const double w : {1.0, 0.9, 0.7, 0.6}) {
    const double q = undissolved(s, w * m, m, true);
    EXPECT_NEAR(q + 0.6 * (m - q), w * m, 1e-14);
  }
  EXPECT_NEAR(undissolved(s, m, m, true), m, 1e-14);
  EXPECT_EQ(undissolved(s, 0.5 * m, m, true), 0);
  EXPECT_EQ(undissolved(s, 0.9 * m, m, false), 0);
}

TEST(Solute, VolumesAddUpAndResistivityIsThatOfTheSolution) {
  const auto s = sugar();
  EXPECT_NEAR(solution_volume(s, 0.25), 0.75 / 1000 + 0.25 / 1600, 1e-18);
  EXPECT_NEAR(dissolved_volume(s, 3.2), 0.002, 1e-15);
  const double density = 1 / (0.75 / 1000 + 0.25 / 1600);
  EXPECT_NEAR(solute_resistivity(s, 0.25) * density * 5e-10, 1, 1e-14);
}

// r + (f - 1/2) dx from the front to the other cell's centre, f = 0, 1/2 and 1: a pair of liquid is r apart and has 2/(rho D).
TEST(Solute, AFrontResistsByHowFarItIsWithinItsCell) {
  const auto s = sugar();
  const double R = solute_resistivity(s, 0.6), dx = 0.02;
  for (const auto& [w, f] : {std::pair{1.0, 0.0}, {0.8, 0.5}, {0.6, 1.0}, {0.3, 1.0}})
    for (const double r : {1.0, 1.5, 2.4})  // [spacings]
      EXPECT_NEAR(across_front(front_resistivity(s, w, 0.6), R, dx, r * dx, 0.6, 0.6) / (2 * R),
                  (r + f - 0.5) / r, 1e-14)
          << w << ' ' << r;
  // Nearer than a spacing as at a spacing: of a crowd it is not known where in its cell the front is.
  EXPECT_EQ(across_front(front_resistivity(s, 1.0, 0.6), R, dx, 0.3 * dx, 0.6, 0.6), R);
  // A species that mixes in any ratio has no front.
  EXPECT_EQ(front_resistivity(s, 1.0, 1.0), 2 * R);
}

// The slope of erfc at 0 over that of the straight line from there to z, by the library's erfc.
TEST(Solute, ALayerThinnerThanTheSpacingTakesMore) {
  for (const double z : {1e-4, 0.1, 0.3, 0.5, 0.8}) {
    const double v = std::erfc(z), slope = 2 / std::sqrt(3.14159265358979323846) * z / (1 - v);
    EXPECT_NEAR(layer_gain(0.6, 0.6 * v) / slope, 1, 4e-3) << v;
    EXPECT_EQ(layer_gain(0.6, 0.6 * v), layer_gain(0.6 * v, 0.6));
  }
  EXPECT_EQ(layer_gain(0.6, 0.6), 1);
  EXPECT_EQ(layer_gain(0.6, 0.0), most_layer_gain);
  EXPECT_EQ(layer_gain(0.6f, -1e-9f), float(most_layer_gain));  // rounding
  EXPECT_TRUE(std::isfinite(layer_gain(0.0f, 0.0f)));
}

TEST(Solute, LogarithmsOfViscositiesAddUpByMass) {
  auto milk = sugar();
  milk.log_viscosity = std::log(2e-3);
  MixtureViscosity mixture;
  mixture.add(sugar(), 0.3);
  mixture.add(milk, 0.2);
  EXPECT_NEAR(mixture.with(1e-3), std::pow(0.2, 0.3) * std::pow(2e-3, 0.2) * std::pow(1e-3, 0.5), 1e-15);
  EXPECT_EQ(MixtureViscosity{}.with(1.2345e-3), 1.2345e-3);  // the solvent alone, to the bit
  // Without viscosity of its own a species takes all of it away; nothing of it none.
  auto gas = sugar();
  gas.log_viscosity = -std::numeric_limits<double>::infinity();
  MixtureViscosity thin;
  thin.add(gas, 0.0);
  EXPECT_EQ(thin.with(1e-3), 1e-3);
  thin.add(gas, 0.1);
  EXPECT_EQ(thin.with(1e-3), 0);
  EXPECT_EQ(thin.with(0), 0);
  // All of it is the species: the solvent's viscosity is no matter.
  MixtureViscosity pure;
  pure.add(milk, 1.0);
  EXPECT_NEAR(pure.with(0), 2e-3, 1e-18);
}

// The pairs across a plane, particle by particle: a column of the lattice on one side, all within H on the other.
TEST(Solute, AFaceOfABodyLosesWhatTheTransferCoefficientSays) {
  constexpr double dx = 0.02, k = 3e-5, density = 1200;
  for (const double support : {2.0 * dx, 2.5 * dx, 4.0 * dx}) {
    const auto kernel = make_kernel<double>(support, dx);
    const double r = surface_resistivity(k, density, support, dx), volume = dx * dx * dx;
    double rate = 0;
    for (int a = 0; a < 6; ++a)
      for (int x = 1; x < 6; ++x)
        for (int y = -6; y <= 6; ++y)
          for (int z = -6; z <= 6; ++z) {
            const double r2 = dx * dx * double((a + x) * (a + x) + y * y + z * z);
            rate += pair_conductance(volume, volume, laplacian_quotient(kernel, std::sqrt(r2), r2), r);
          }
    EXPECT_NEAR(rate / (k * density * dx * dx), 1, 1e-12) << support / dx;
  }
}

}  // namespace
