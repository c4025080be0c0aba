// SPDX-License-Identifier: Apache-2.0
// Energies of one particle, against work done on it and heat put into it.
#include "meltsim/physics/energy.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace meltsim;
using namespace meltsim::physics;

// Thrown in a uniform field it moves along x + v t + g t^2/2. The sum is constant, to the rounding of a few
// numbers of 1e3 J; a wrong sign or factor of either changes it by hundreds.
TEST(Energy, KineticAndPotentialOfAThrowAreConstant) {
  const Vec3<double> g{1.5, -9.81, 0.5}, x0{3, -2, 1}, v0{4, 20, -3};
  const double m = 2.5, start = kinetic_energy(m, v0) + potential_energy(m, g, x0);
  for (double t = 0.1; t < 5; t += 0.1) {
    const Vec3<double> v = v0 + g * t, x = x0 + v0 * t + g * (0.5 * t * t);
    EXPECT_NEAR(kinetic_energy(m, v) + potential_energy(m, g, x), start, 1e-11);
  }
  // The sum alone would bear a common factor: 2.5 kg at 20.6 m/s, and 2.5 kg lifted by 2 m.
  EXPECT_DOUBLE_EQ(kinetic_energy(m, v0), 0.5 * 2.5 * (16 + 400 + 9));
  EXPECT_DOUBLE_EQ(potential_energy(m, {0, -9.81, 0}, {7, 2, 7}), 2.5 * 9.81 * 2);
}

// Heat put in that warms nothing: between two enthalpies the latent energy grows by the heat less the two
// sensible parts.
TEST(Energy, LatentIsTheHeatThatChangesNoTemperature) {
  MaterialRow<double> ice;
  ice.plateau = 1;
  ice.heat_capacity = 2000;
  ice.liquid_heat_capacity = 4000;
  ice.latent_heat = ice.melting_heat = 3e5;
  ice.melting_point = 5;
  ice.melting_enthalpy = -2.8e5;
  const double mass = 0.25, cold = mass * enthalpy_of(ice, -10.0);
  EXPECT_EQ(latent_energy(ice, mass, cold), 0.0);
  for (const double heat : {1e3, 7500.0, 3e4, 8e4, 1e5}) {
    const double t = temperature_of(ice, (cold + heat) / mass);
    const double sensible = mass * (2000 * (std::fmin(t, 5) + 10) + 4000 * std::fmax(t - 5, 0));
    EXPECT_NEAR(latent_energy(ice, mass, cold + heat), heat - sensible, 1e-9);  // rounding of 1e5 J
  }
  ice.plateau = 0;  // the liquid of something that melts: it has taken up all of it
  EXPECT_EQ(latent_energy(ice, mass, 1e6), mass * 3e5);
  ice.latent_heat = 0;  // neither melts nor freezes
  EXPECT_EQ(latent_energy(ice, mass, 1e6), 0.0);
}

}  // namespace
