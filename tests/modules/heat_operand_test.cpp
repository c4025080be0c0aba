// SPDX-License-Identifier: Apache-2.0
// Heat's operands made where particles are put in order: the bits that thermal.operands makes, every time, and not where
// a stage changes enthalpies in between.
#include <string>

#include "meltsim/particle_tag.hpp"
#include "modules/engine.hpp"

namespace {

using namespace modules_test;

constexpr double dx = 0.1;

/// Ice and water that move and exchange heat; some of both hold both phases.
struct Slush {
  core::SceneConstants c = plain_constants(dx);
  core::SceneState s;
  Slush() {
    for (core::MaterialRow<double>& m : c.materials) m.conductivity = m.liquid_conductivity = 0.6;
    c.materials[1].conductivity = 2.2;
    c.domain.bounded = true;
    c.domain.max = {0.9, 0.8, 0.8};
    Random random(41);
    for (int z = 0; z < 8; ++z)
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) {
          const std::uint32_t tag = x < 4 ? 1u | tag_solid : 0u;
          const auto i = add_particle(s, c, Vec3d{x + 0.5, y + 0.5, z + 0.5} * dx + random.vector(0.1 * dx),
                                      tag, random.vector(2));
          s.enthalpy[i] = s.mass[i] * random.uniform(-5000, 4000);  // both phases: from -1000 to 0 J/kg
        }
  }
};

/// One sub-step of all stages that a scene of these facts has, with two stages of heat.
template <class T>
void step(Rig<T>& rig, std::uint32_t facts, std::uint64_t index) {
  core::SubstepArguments a;
  a.dt = 1e-3;
  a.index = index;
  a.heat_dt = 20;
  a.heat_stages = 2;
  a.heat_supersteps = 1;
  a.heat_bound = 1e9;
  for (int s = 0; s < core::stage_count; ++s)
    if (core::runs(core::stage_table[static_cast<std::size_t>(s)], facts)) a.stages |= std::uint64_t{1} << s;
  rig.engine->substep(a);
}

template <class T>
class HeatOperands : public ::testing::Test {};
using Precisions = ::testing::Types<float, double>;
TYPED_TEST_SUITE(HeatOperands, Precisions);

TYPED_TEST(HeatOperands, MadeInPassingAreThoseOfTheStage) {
  const Slush slush;
  for (const std::uint32_t search : core::search_facts) {
    const std::uint32_t facts = core::fact_particles | core::fact_fluid | core::fact_heat_enthalpy | search;
    Rig<TypeParam> stage(Order::shuffled), passing(Order::shuffled, true), timed(Order::shuffled, true);
    timed.engine->enable_timings(true);
    for (auto* rig : {&stage, &passing, &timed}) {
      rig->upload(slush.c, {}, slush.s, facts);
      for (std::uint64_t k = 1; k <= 6; ++k) step(*rig, facts, k);
    }
    EXPECT_FALSE(stage.frame().heat_at_hand);
    EXPECT_FALSE(timed.frame().heat_at_hand) << "timings look at stages one by one";
    ASSERT_TRUE(passing.frame().heat_at_hand);
    core::SceneState a, b, c;
    stage.engine->download(a);
    passing.engine->download(b);
    timed.engine->download(c);
    double changed = 0;
    for (std::size_t i = 0; i < a.enthalpy.size(); ++i) {
      ASSERT_EQ(a.enthalpy[i], b.enthalpy[i]) << i << ", search " << search;
      ASSERT_EQ(a.enthalpy[i], c.enthalpy[i]) << i << ", search " << search;
      ASSERT_EQ(length(a.position[i] - b.position[i]), 0.0) << i << ", search " << search;
      changed = std::max(changed, std::fabs(a.enthalpy[i] - slush.s.enthalpy[i]) / slush.s.mass[i]);
    }
    EXPECT_GT(changed, 10.0) << "J/kg: heat has to flow";
    EXPECT_EQ(passing.engine->synchronize().halted, 0u);
  }
}

TYPED_TEST(HeatOperands, NotMadeInPassingWhereHeatComesFromOutside) {
  const Slush slush;
  const std::uint32_t facts = core::fact_particles | core::fact_fluid | core::fact_heat_enthalpy |
                              core::fact_heat_boundary | core::fact_packed;
  Rig<TypeParam> rig(Order::shuffled, true);
  rig.upload(slush.c, {}, slush.s, facts);
  step(rig, facts, 1);
  EXPECT_FALSE(rig.frame().heat_at_hand) << "thermal.boundary may take hold of temperatures first";
}

}  // namespace
