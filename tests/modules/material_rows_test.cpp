// SPDX-License-Identifier: Apache-2.0
// Materials as World turns them into rows: the zero of a solid's enthalpy in particular.
#include <gtest/gtest.h>

#include "meltsim/physics/heat.hpp"
#include "world/world_impl.hpp"

namespace {

using namespace meltsim;

std::vector<core::MaterialRow<double>> rows(HeatModel model) {
  WorldImpl world;
  world.desc.heat.model = model;
  MaterialDesc wax_melt, wax;
  wax_melt.name = "wax melt";
  wax_melt.heat_capacity = 2900;
  wax.name = "wax";
  wax.density = 900;
  wax.heat_capacity = 2100;
  wax.diffusivity = 1e-7;
  wax.melting_point = 60;
  wax.latent_heat = 2e5;
  const auto liquid = world.add_material(wax_melt);
  EXPECT_TRUE(liquid);
  wax.melts_into = *liquid;
  EXPECT_TRUE(world.add_material(wax));
  return world.material_rows();
}

// To rounding of h, 1e5 J/kg.
TEST(MaterialRows, MeltedSolidLiesOnItsLiquidsCurve) {
  for (const HeatModel model : {HeatModel::enthalpy, HeatModel::paper}) {
    const auto r = rows(model);
    for (const double t : {60.001, 80.0, 500.0})
      EXPECT_NEAR(physics::enthalpy_of(r[1], t), physics::enthalpy_of(r[0], t), 1e-8);
    EXPECT_NEAR(physics::temperature_of(r[0], r[1].melting_enthalpy + r[1].latent_heat), 60, 1e-10);
  }
}

TEST(MaterialRows, LatentHeatIsTheEnthalpyModels) {
  EXPECT_EQ(rows(HeatModel::enthalpy)[1].latent_heat, 2e5);
  EXPECT_EQ(rows(HeatModel::paper)[1].latent_heat, 0.0);
}

TEST(MaterialRows, DiffusivityReplacesConductivity) {
  const auto r = rows(HeatModel::enthalpy);
  EXPECT_DOUBLE_EQ(r[1].conductivity, 1e-7 * 900 * 2100);
  EXPECT_DOUBLE_EQ(r[1].diffusivity, 1e-7);
  EXPECT_DOUBLE_EQ(r[0].conductivity, 0.6);
  EXPECT_DOUBLE_EQ(r[0].diffusivity, 0.6 / (1000 * 2900.0));
  EXPECT_EQ(r[1].liquid, 0u);
  EXPECT_EQ(r[1].liquid_conductivity, 0.6);
}

}  // namespace
