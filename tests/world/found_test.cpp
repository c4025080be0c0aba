// SPDX-License-Identifier: Apache-2.0
// What random sequences of calls (tests/fuzz) found, each reduced to the few calls that it takes.
#include <cmath>
#include <string>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

/// Refused with every one of these words in the message.
template <class R>
void expect_refused(const R& r, std::initializer_list<const char*> words) {
  ASSERT_FALSE(r);
  for (const char* word : words)
    EXPECT_NE(r.error().message.find(word), std::string::npos) << word << ": " << r.error().message;
}

MaterialDesc solid(const char* name, MaterialId liquid, double melting_point) {
  MaterialDesc m;
  m.name = name;
  m.melts_into = liquid;
  m.melting_point = melting_point;
  m.heat_capacity = 2000;
  return m;
}

TEST(Found, TemperaturesThatRoundingLosesAreRefused) {
  MELTSIM_NEEDS_BACKEND();
  auto w = World::create(describe());
  require(w);
  MaterialDesc m;
  m.name = "water";
  const MaterialId water = *w->add_material(m);
  expect_refused(w->add_material(solid("a", water, 1e30)), {"\"a\"", "melting_point", "1e+06", "1e+30"});
  require(w->add_material(solid("hot", water, 3400)));  // tungsten
  m.name = "b";
  m.heat_capacity = 1e15;
  const MaterialId heavy = *w->add_material(m);
  expect_refused(w->add_material(solid("c", heavy, 3400)), {"\"c\"", "heat_capacity", "2000", "1e+15"});
  m.name = "d";
  m.heat_capacity = 1e300;
  expect_refused(w->add_material(m), {"\"d\"", "heat_capacity", "1e+300"});
  m.heat_capacity = 4186;
  m.density = 1e300;
  expect_refused(w->add_material(m), {"\"d\"", "density", "1e+300"});
}

// Enthalpy of a melt that is read on the curve of another solid, which its liquid freezes into.
TEST(Found, WhatMeltsFarBelowWhereItsLiquidFreezesIsRefused) {
  MELTSIM_NEEDS_BACKEND();
  auto w = World::create(describe());
  require(w);
  MaterialDesc m;
  m.name = "wax";
  m.heat_capacity = 4000;
  const MaterialId wax = *w->add_material(m);
  MaterialDesc hard = solid("hard", wax, 80);
  hard.freezes = true;
  hard.heat_capacity = 300;
  require(w->add_material(hard));
  // 4000 (80 + 20) / 300 = 1333 degrees below 80.
  expect_refused(w->add_material(solid("soft", wax, -20)), {"\"soft\"", "\"wax\"", "\"hard\"", "80"});
  require(w->add_material(solid("near", wax, 70)));
}

// The region begins within the step, so the liquid that the body would melt into shortens the sub-step.
TEST(Found, ARefusedStepLeavesTheStepAsItWas) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.max_substeps = 1;
  d.gravity = {};
  auto w = World::create(d);
  require(w);
  MaterialDesc m;
  m.name = "liquid";
  m.density = 1391;
  const MaterialId liquid = *w->add_material(m);
  MaterialDesc ice = solid("ice", liquid, 5);
  ice.density = 400;
  SolidDesc s;
  s.material = *w->add_material(ice);
  s.shape = Shape::box({0, 0, 0}, {0.3, 0.3, 0.3});
  s.temperature = -10;
  s.velocity = {0.5, 0, 0};
  require(w->add_solid(s));
  HeatRegionDesc r;
  r.shape = s.shape;
  r.temperature = 20;
  r.from = 0.5;
  require(w->add_heat_region(r));
  const double stable = w->stable_dt();
  while (w->time() + stable < r.from) require(w->step(stable));
  const auto before = *w->snapshot();
  const Status refused = w->step(w->stable_dt());
  ASSERT_FALSE(refused) << "nothing is shorter when liquid can come to be: the test tests nothing";
  EXPECT_EQ(refused.error().code, ErrorCode::step_too_large);
  EXPECT_EQ(w->stable_dt(), stable);
  EXPECT_EQ(*w->snapshot(), before);
  // As the message says; more steps than there are would mean that it never gets there.
  for (int k = 0; k < 20; ++k) require(w->step(0.5 * stable));
  EXPECT_GT(w->time(), r.from);
}

// The plan that the module leaves behind has no room for what brings regions up to date.
TEST(Found, LatticeAfterMeltingWasSwitchedOff) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = ice_in_water(describe());
  const std::uint64_t solid = s.world.totals()->solid;
  while (s.world.totals()->solid == solid)
    require(s.world.step(s.world.stable_dt()));  // melts in the last of them
  require(s.world.scheduler().enable("topology", false));
  EXPECT_FALSE(s.world.plan().stages.empty());  // the new plan is made here
  const auto lattice = s.world.lattice();
  require(lattice);
  // Whoever is in a region is live: nobody who has melted pulls at the others.
  const int side = 2 * lattice->region_half_width + 1;
  const std::size_t per = static_cast<std::size_t>(side) * side * side;
  std::size_t live = 0;
  for (std::size_t v = 0; v < lattice->live.size(); ++v) {
    live += lattice->live[v];
    std::size_t members = 0;
    for (std::size_t k = 0; k < per; ++k) members += lattice->arrayR[v * per + k] != 0 ? 1 : 0;
    if (lattice->live[v] == 0) {
      EXPECT_EQ(members, 0u);
    }
    EXPECT_LE(members, s.world.totals()->solid);
  }
  EXPECT_EQ(live, s.world.totals()->solid);
}

// A modulus widens regions; half of a periodic axis away the nearest image is another one, and the body flew apart.
TEST(Found, RegionsStayWithinHalfOfAPeriodicAxis) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.05;
  d.gravity = {};
  d.sound_speed = 34;
  d.domain.bounded = true;
  d.domain.max = {0.5, 0.5, 0.55};
  d.domain.faces[0] = d.domain.faces[1] = Face::periodic;
  auto w = World::create(d);
  require(w);
  MaterialDesc m;
  m.name = "stiff";
  m.density = 580;
  m.region_half_width = 1;
  m.youngs_modulus = 9e6;
  SolidDesc s;
  s.material = *w->add_material(m);
  s.shape = Shape::box({0.05, 0.2, 0.025}, {0.35, 0.45, 0.325});
  s.velocity = {-0.8, 0.1, 0.1};
  require(w->add_solid(s));
  for (int k = 0; k < 40; ++k) require(w->step(w->stable_dt()));
  const StepResult r = w->synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  EXPECT_TRUE(r.modulus_unreachable);
  EXPECT_LE(w->resolved().stiffness[0].region_half_width, 4);  // 0.4 of ten spacings
  // It moves as a whole: nothing but rounding drives it apart.
  EXPECT_LT(r.max_speed, 1.001 * std::sqrt(0.8 * 0.8 + 0.02));
  m.name = "wide";
  m.youngs_modulus = 0;
  m.region_half_width = 5;
  s.material = *w->add_material(m);
  s.shape = Shape::box({0.05, 0.0, 0.35}, {0.25, 0.15, 0.5});
  expect_refused(w->add_solid(s), {"\"wide\"", "region_half_width", "at most 4"});
}

// Cancellation: what an enthalpy of -1e25 J lacks is not what brings it to 0 K.
TEST(Found, SourcesBeyondReasonCoolToAbsoluteZeroExactly) {
  MELTSIM_NEEDS_BACKEND();
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    WorldDesc d = describe();
    d.precision = precision;
    d.spacing = 0.1;
    d.gravity = {};
    auto w = World::create(d);
    require(w);
    MaterialDesc m;
    m.name = "liquid";
    m.conductivity = 20;
    FluidDesc f;
    f.material = *w->add_material(m);
    f.shape = Shape::box({0, 0, 0}, {0.4, 0.4, 0.4});
    f.temperature = 30;
    require(w->add_fluid(f));
    HeatRegionDesc r;
    r.shape = Shape::box({0, 0, 0}, {0.2, 0.4, 0.4});
    r.source = -1e30;
    require(w->add_heat_region(r));
    for (int k = 0; k < 5; ++k) require(w->step(w->stable_dt()));
    const StepResult result = w->synchronize();
    EXPECT_TRUE(result.cooled_to_zero);
    const auto t = w->totals();
    require(t);
    EXPECT_NEAR(t->temperature_min, -273.15, 1e-3);  // single precision of a temperature
    EXPECT_TRUE(std::isfinite(t->heat_in));
    require(w->snapshot());
  }
}

// The largest sound speed that is taken leaves still water still: rounding of its density moves it by c times 6e-8 a sub-step,
// 6 mm/s, and the ten neighbours that matter do not agree, nor do steps; twenty times that is never reached.
TEST(Found, SoundThatRoundingWouldMakeIsRefused) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.domain.bounded = true;
  d.domain.max = {0.6, 0.6, 0.6};
  d.precision = Precision::single_precision;
  d.sound_speed = 2e5;
  expect_refused(World::create(d), {"sound_speed", "single", "200000", "double"});
  d.precision = Precision::double_precision;
  require(World::create(d));
  d.sound_speed = 1e14;
  expect_refused(World::create(d), {"sound_speed", "1e+14"});
  d.precision = Precision::single_precision;
  d.sound_speed = 1e5;
  auto w = World::create(d);
  require(w);
  MaterialDesc m;
  m.name = "water";
  FluidDesc f;
  f.material = *w->add_material(m);
  f.shape = Shape::box({0, 0, 0}, {0.6, 0.3, 0.6});
  require(w->add_fluid(f));
  for (int k = 0; k < 300; ++k) require(w->step(w->stable_dt()));
  const StepResult r = w->synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  EXPECT_LT(r.max_speed, 0.12);
}

TEST(Found, APlaceThatDoublesDoNotResolveIsRefused) {
  MELTSIM_NEEDS_BACKEND();
  auto w = World::create(describe());
  require(w);
  MaterialDesc m;
  m.name = "liquid";
  EmitterDesc e;
  e.material = *w->add_material(m);
  e.center = {0, -1e30, 0};
  e.radius = 0.3;
  e.speed = 1;
  e.until = 1;
  expect_refused(w->add_emitter(e), {"emitter", "1e+30", "spacing"});
  expect_refused(w->add_emitter(e), {"emitter"});
  e.center = {0, 1, 0};
  require(w->add_emitter(e));  // and the origin is still where this one needs it
}

}  // namespace
}  // namespace meltsim_test
