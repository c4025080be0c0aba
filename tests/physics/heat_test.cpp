// SPDX-License-Identifier: Apache-2.0
// The enthalpy curve, conductances, the paper's pair update and the phase change's arithmetic.
#include "meltsim/physics/heat.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "meltsim/physics/phase_change.hpp"
#include "support/random.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;
using test_support::Random;

constexpr double latent = 333.7e3, water_capacity = 4217, ice_capacity = 2050;

MaterialRow<double> water() {
  MaterialRow<double> m;
  m.heat_capacity = m.liquid_heat_capacity = water_capacity;
  m.conductivity = m.liquid_conductivity = 0.561;
  return m;
}

/// A solid that melts into water; its zero of enthalpy is the one World gives it.
MaterialRow<double> ice(double melting_point, double latent_heat) {
  MaterialRow<double> m = water();
  m.heat_capacity = ice_capacity;
  m.conductivity = 2.22;
  m.melting_point = melting_point;
  m.latent_heat = m.melting_heat = latent_heat;
  m.melting_enthalpy = water_capacity * melting_point - latent_heat;
  m.melts = m.plateau = 1;
  return m;
}

/// The same, but it melts over so many degrees from its melting point on.
MaterialRow<double> alloy(double melting_point, double range, double latent_heat) {
  MaterialRow<double> m = ice(melting_point, latent_heat);
  m.melting_range = range;
  m.melting_heat = latent_heat + 0.5 * (ice_capacity + water_capacity) * range;
  m.melting_slope = range / m.melting_heat;
  m.melting_enthalpy = water_capacity * (melting_point + range) - m.melting_heat;
  return m;
}

// -273 to 2000 degrees; one division and one multiplication each way: 1e-12 of the value.
TEST(EnthalpyCurve, InverseBothWays) {
  for (const MaterialRow<double>& m :
       {water(), ice(0, latent), ice(327.5, 23e3), ice(0, 0), alloy(30, 5, latent), alloy(-5, 200, 0)}) {
    for (double t = -273; t < 2000; t += 7.3)
      EXPECT_NEAR(temperature_of(m, enthalpy_of(m, t)), t, 1e-9 * (1 + std::fabs(t)));
    for (double h = -8e5; h < 8e6; h += 33333) {
      if (m.melts != 0u && m.melting_range == 0 && liquid_fraction(m, h) > 0 && liquid_fraction(m, h) < 1)
        continue;  // the plateau
      EXPECT_NEAR(enthalpy_of(m, temperature_of(m, h)), h, 1e-9 * (1e4 + std::fabs(h)));
    }
  }
}

TEST(EnthalpyCurve, SlopesAreTheHeatCapacities) {
  const auto m = ice(10, latent);
  EXPECT_NEAR(enthalpy_of(m, 5.0) - enthalpy_of(m, 4.0), ice_capacity, 1e-6);
  EXPECT_NEAR(enthalpy_of(m, 15.0) - enthalpy_of(m, 14.0), water_capacity, 1e-6);
  EXPECT_NEAR(enthalpy_of(m, 10.0) - enthalpy_of(m, 9.0), ice_capacity, 1e-6);  // still solid at the point
  EXPECT_NEAR(temperature_of(m, enthalpy_of(m, 10.0) + latent + water_capacity), 11.0, 1e-9);
}

TEST(EnthalpyCurve, PlateauHoldsTheMeltingPoint) {
  const auto m = ice(10, latent);
  for (double share = 0; share <= 1; share += 0.125) {
    const double h = m.melting_enthalpy + share * latent;
    EXPECT_EQ(temperature_of(m, h), 10.0);
    EXPECT_NEAR(liquid_fraction(m, h), share, 1e-12);
  }
  EXPECT_EQ(liquid_fraction(m, m.melting_enthalpy - 1), 0.0);
  EXPECT_EQ(liquid_fraction(m, m.melting_enthalpy + 2 * latent), 1.0);
  EXPECT_EQ(liquid_fraction(water(), -1e6), 1.0);
}

// The paper's criterion: T >= T_melt, on the exact number.
TEST(EnthalpyCurve, WithoutLatentHeatItMeltsAtTheMeltingPoint) {
  const auto m = ice(-5, 0);
  EXPECT_EQ(liquid_fraction(m, enthalpy_of(m, -5.0)), 1.0);
  EXPECT_EQ(liquid_fraction(m, enthalpy_of(m, -5.0001)), 0.0);
  EXPECT_EQ(temperature_of(m, enthalpy_of(m, -5.0)), -5.0);
}

// So that the switch of phase changes no number but the tag.
TEST(EnthalpyCurve, MeltedSolidLiesOnItsLiquidsCurve) {
  for (const double point : {-20.0, 0.0, 327.5}) {
    const auto m = ice(point, latent);
    for (double t = point + 0.01; t < point + 500; t += 10)
      EXPECT_NEAR(enthalpy_of(m, t), enthalpy_of(water(), t), 1e-9 * (latent + std::fabs(enthalpy_of(m, t))));
    EXPECT_NEAR(temperature_of(water(), m.melting_enthalpy + latent), point, 1e-9);
  }
}

// Between the ends the liquid fraction is the share of the range, and the heat L and the mean of both capacities.
TEST(EnthalpyCurve, MeltingOverARangeIsLinearInTemperature) {
  const double begin = 30, range = 8;
  const auto m = alloy(begin, range, latent);
  const double solid = enthalpy_of(m, begin), molten = enthalpy_of(m, begin + range);
  EXPECT_NEAR(molten - solid, latent + 0.5 * (ice_capacity + water_capacity) * range, 1e-6);
  EXPECT_NEAR(molten, enthalpy_of(water(), begin + range), 1e-6);
  for (double share = 0; share <= 1; share += 0.125) {
    const double h = enthalpy_of(m, begin + share * range);
    EXPECT_NEAR(liquid_fraction(m, h), share, 1e-12);
    EXPECT_NEAR(h, solid + share * (molten - solid), 1e-6);
  }
  EXPECT_EQ(liquid_fraction(m, solid - 1), 0.0);
  EXPECT_EQ(liquid_fraction(m, molten + 1), 1.0);
  EXPECT_NEAR(enthalpy_of(m, begin - 1), solid - ice_capacity, 1e-6);
  EXPECT_NEAR(enthalpy_of(m, begin + range + 1), molten + water_capacity, 1e-6);
}

TEST(Melting, NeedsSurfaceAndAllOfTheLatentHeat) {
  const auto m = ice(0, latent);
  const double full = m.melting_enthalpy + latent;
  EXPECT_TRUE(melts(m, true, full));
  EXPECT_TRUE(melts(m, true, full + 1e5));
  EXPECT_FALSE(melts(m, false, full + 1e5));  // an internal particle never does
  EXPECT_FALSE(melts(m, true, full - 1));
  EXPECT_FALSE(melts(water(), true, 1e9));
}

TEST(Melting, VolumeGoesOverAndArrives) {
  EXPECT_DOUBLE_EQ(relaxed_volume(2.0, 1.0, 0.25), 1.75);
  EXPECT_EQ(relaxed_volume(2.0, 1.0, 7.0), 1.0);  // a long step does not overshoot
  float v = 10.0f;
  for (int n = 0; n < 2000; ++n) {
    const float next = relaxed_volume(v, 1.0f, 0.01f);
    ASSERT_LE(next, v);
    v = next;
  }
  EXPECT_EQ(v, 1.0f);  // exactly: the density of a melted particle must not stay off for ever
}

// V P/phi^2 of a crushed place is that at phi = 1.1 without a share, here from the Tait equation written out. 1e-14: rounding.
TEST(Melting, InACrushedPlaceItPushesNoHarderThanAtItsBound) {
  const auto push = [](double phi) { return (std::pow(phi, 7) - 1) / (phi * phi); };
  for (const double phi : {1.0, 1.05, 1.0999}) EXPECT_EQ(born_share(push(phi)), 1.0) << phi;
  for (const double phi : {1.11, 1.3, 1.63, 3.0})
    EXPECT_NEAR(born_share(push(phi)) * push(phi) / push(1.1), 1, 1e-14) << phi;
}

TEST(Conductance, HarmonicAndInsulating) {
  const auto mean = [](double k_i, double k_j) {
    return pair_conductivity(resistivity_of(k_i), resistivity_of(k_j));
  };
  EXPECT_DOUBLE_EQ(mean(1.0, 3.0), 1.5);
  EXPECT_EQ(mean(0.0, 3.0), 0.0);
  EXPECT_EQ(mean(0.0, 0.0), 0.0);
  EXPECT_NEAR(mean(1e-6, 1.0), 2e-6, 1e-11);  // the poorer one limits
  const LaplacianQuotient<double> l{10.0, 2.0};
  EXPECT_DOUBLE_EQ(pair_conductance(2.0, 3.0, l, 1.0 + 1.0 / 3.0), 45.0);
  EXPECT_EQ(pair_conductance(2.0, 3.0, l, 1.0 + resistivity_of(0.0)), 0.0);
  // In lanes that are left out: marks, and no volume.
  EXPECT_EQ(pair_conductance(2.0f, 0.0f, LaplacianQuotient<float>{10.0f, 2.0f}, -800.0f), 0.0f);
  const auto m = ice(0, latent);
  EXPECT_DOUBLE_EQ(conductivity_at(m, 0.0, 20.0), 2.22);
  EXPECT_DOUBLE_EQ(conductivity_at(m, 1.0, 20.0), 0.561);
  EXPECT_DOUBLE_EQ(conductivity_at(m, 0.5, 20.0), 0.5 * (2.22 + 0.561));
}

// A particle whose front crosses it at a constant rate stands, on average, one spacing from its neighbour on
// either side, through one phase only: the two half cells are of that phase. So toward what is hotter it is
// liquid, toward what is colder solid, however far it has melted.
TEST(Conductance, BothPhasesConductLikeWhatLiesBeforeTheFront) {
  const auto m = ice(0, latent);
  EXPECT_DOUBLE_EQ(conductivity_toward(m, 0.0, 40.0), 0.561);
  EXPECT_DOUBLE_EQ(conductivity_toward(m, 0.0, 1e-9), 0.561);
  EXPECT_DOUBLE_EQ(conductivity_toward(m, 0.0, -10.0), 2.22);
  EXPECT_DOUBLE_EQ(pair_conductivity(resistivity_of(conductivity_toward(m, 0.0, 40.0)), 1 / 0.561), 0.561);
}

// Kirchhoff: k (T_j - T_i) is the integral of k from T_i to T_j, so it is continuous where melting begins and ends, and
// the same from both ends.
TEST(Conductance, TowardNeighboursTheFluxIsTheIntegralOfTheConductivity) {
  const auto m = ice(0, latent);
  const auto integral = [](double t) { return t < 0 ? 2.22 * t : 0.561 * t; };
  for (const double t : {-20.0, -1e-9, 0.0, 1e-9, 3.0, 60.0})
    for (const double other : {-30.0, -1e-6, 0.0, 1e-6, 5.0, 80.0}) {
      EXPECT_NEAR(conductivity_toward(m, t, other) * (other - t), integral(other) - integral(t), 1e-12)
          << t << " " << other;
      EXPECT_DOUBLE_EQ(conductivity_toward(m, t, other),
                       t == other ? 2.22 : conductivity_toward(m, other, t));
    }
}

// Across the whole range the flux is that of a conductivity linear in the liquid fraction.
TEST(Conductance, AcrossAMeltingRangeTheFluxIsThatOfTheMeanConductivity) {
  const auto m = alloy(30, 8, latent);
  const double across = 2.22 * 10 + 0.5 * (2.22 + 0.561) * 8 + 0.561 * 12;
  EXPECT_NEAR(conductivity_toward(m, 20.0, 50.0) * 30, across, 1e-12);
  EXPECT_NEAR(conductivity_toward(m, 50.0, 20.0) * 30, across, 1e-12);
}

// Lattices of every kind that has one direction, or two, to conduct in: what the pair sum finds along it, added up
// here, against what conduction_share makes of the density sum. 2.5 %: one slope for all shapes, fitted
// to the plane; without a correction it would be up to 0.86.
TEST(Conductance, ShareIsWhatThePairSumFindsAlongASurface) {
  struct Lattice {
    int y, z;  // cells across; 0 = no end, -1 = ends at the particle's own layer
  };
  const Lattice shapes[] = {{0, 0}, {-1, 0}, {-1, -1}, {1, 0}, {2, 0}, {1, 1}, {2, 2}, {3, 3}, {2, 1}};
  for (const double H : {1.5, 2.0, 2.5, 3.0, 4.0}) {
    const auto k = make_kernel<double>(H, 1.0);
    const auto c = make_conduction_share<double>(H, 1.0);
    const auto there = [](int at, int cells) { return cells == 0 || (at >= 0 && (cells < 0 || at < cells)); };
    for (const Lattice& s : shapes) {
      double moment = 0, phi = 0;
      for (int x = -4; x <= 4; ++x)
        for (int y = -4; y <= 4; ++y)
          for (int z = -4; z <= 4; ++z) {
            const double r2 = x * x + y * y + z * z, r = std::sqrt(r2);
            if (r >= H || !there(y, s.y) || !there(z, s.z)) continue;
            phi += kernel_value(k, r);
            moment += 0.5 * kernel_laplacian(k, r, r2) * x * x;
          }
      EXPECT_NEAR(conduction_share(c, phi) / moment, 1.0, 0.025) << H << ": " << s.y << ", " << s.z;
    }
    EXPECT_EQ(conduction_share(c, 1.02), 1.0) << "compressed liquid is whole";
    EXPECT_GE(conduction_share(c, 0.0), least_conduction_share);
  }
}

// Energy is conserved because both ends compute the same number.
TEST(Conductance, SymmetricToTheBit) {
  Random random(31);
  for (int n = 0; n < 100000; ++n) {
    const auto vi = static_cast<float>(random.uniform(1e-3, 1e-2)),
               vj = static_cast<float>(random.uniform(1e-3, 1e-2));
    const auto ri = static_cast<float>(random.uniform(0, 3)), rj = static_cast<float>(random.uniform(0, 3));
    const LaplacianQuotient<float> l{static_cast<float>(random.uniform(0, 1e4)),
                                     static_cast<float>(random.uniform(1e-3, 1))};
    ASSERT_EQ(pair_conductance(vi, vj, l, ri + rj), pair_conductance(vj, vi, l, rj + ri));
  }
}

// dT_i/dt = k V_j (T_j - T_i), k = (K_i + K_j)/2 L: the 2x2 system of one implicit step, by Eigen.
TEST(PaperPairUpdate, IsBackwardEulerOfTheIsolatedPair) {
  Random random(32);
  for (int n = 0; n < 1000; ++n) {
    const double ki = random.uniform(0, 70), kj = random.uniform(0, 70), l = random.uniform(0, 2e3);
    const double dt = std::pow(10.0, random.uniform(-6, 2));
    const double vi = random.uniform(1e-3, 1e-2), vj = random.uniform(1e-3, 1e-2);
    const double ti = random.uniform(-20, 100), tj = random.uniform(-20, 100);
    const double k = 0.5 * (ki + kj) * l * dt;
    Eigen::Matrix2d a;
    a << 1 + k * vj, -k * vj, -k * vi, 1 + k * vi;
    const Eigen::Vector2d exact = a.fullPivLu().solve(Eigen::Vector2d(ti, tj));
    const double ui = paper_pair_update(ki, kj, l, dt, vi, vj, ti, tj);
    const double uj = paper_pair_update(kj, ki, l, dt, vj, vi, tj, ti);
    // 1e-12 of the range of temperatures, times the condition of the system, at worst k V.
    const double tolerance = 1e-12 * 120 * (1 + 1e-3 * k * (vi + vj));
    ASSERT_NEAR(ti + ui, exact[0], tolerance);
    ASSERT_NEAR(tj + uj, exact[1], tolerance);
    ASSERT_NEAR(vi * ui + vj * uj, 0.0, 1e-14);        // sum V T, up to 1 in value
    ASSERT_TRUE((ti + ui - tj) * (ti - tj) >= -1e-9);  // never past the partner
  }
}

}  // namespace
