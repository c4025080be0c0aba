// SPDX-License-Identifier: Apache-2.0
// What random sequences of calls (tests/fuzz) found, each reduced to the few calls that it takes.
#include <cmath>
#include <optional>
#include <string>
#include <utility>

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

// Setting gravity, or a time scale beside a probe of heat, gives the engine its probes anew; samples that were still there were read
// beyond what was fetched: a crash.
TEST(Found, SamplesOutliveGravityThatTurns) {
  MELTSIM_NEEDS_BACKEND();
  const auto pool = [] {
    WorldDesc d = describe();
    d.spacing = 0.1;
    d.domain.bounded = true;
    d.domain.min = {0, 2, 0};  // heights that are not those above the origin of what is stored
    d.domain.max = {0.6, 3, 0.6};
    auto w = World::create(d);
    EXPECT_TRUE(w);
    FluidDesc f;
    f.material = *w->add_material({});
    f.shape = Shape::box({0, 2, 0}, {0.6, 2.4, 0.6});
    EXPECT_TRUE(w->add_fluid(f));
    ProbeDesc p;
    p.kind = ProbeKind::level;
    p.points = {{0.25, 2.2, 0.25}};
    EXPECT_TRUE(w->add_probe(p));
    p.kind = ProbeKind::heat;
    p.points.clear();
    p.wall = 2;
    EXPECT_TRUE(w->add_probe(p));
    for (int k = 0; k < 5; ++k) require(w->step(w->stable_dt()));
    return std::move(*w);
  };
  World calm = pool(), turned = pool();
  const auto expected = calm.take_samples();
  require(expected);
  require(turned.set_gravity({9.81, 0, 0}));
  require(turned.set_heat_time_scale(2));
  require(turned.prepare());
  const auto got = turned.take_samples();
  require(got);
  ASSERT_EQ(got->size(), 2u);
  ASSERT_EQ(expected->front().values.size(), 5u);
  for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ((*got)[k].values, (*expected)[k].values);
  EXPECT_GT(expected->front().values.front(), 2.2);
}

// There is no table of regions while no heat flows: it was written through a null pointer.
TEST(Found, AHeatRegionMayBeSetWhileNoHeatFlows) {
  MELTSIM_NEEDS_BACKEND();
  const auto heated = [](double scale, double source) {
    WorldDesc d = describe();
    d.spacing = 0.1;
    d.gravity = {};
    d.heat.time_scale = scale;
    auto w = World::create(d);
    EXPECT_TRUE(w);
    FluidDesc f;
    f.material = *w->add_material({});
    f.shape = Shape::box({0, 0, 0}, {0.4, 0.4, 0.4});
    EXPECT_TRUE(w->add_fluid(f));
    HeatRegionDesc r;
    r.shape = f.shape;
    r.source = source;
    const auto id = w->add_heat_region(r);
    EXPECT_TRUE(id);
    return std::pair<World, HeatRegionId>(std::move(*w), *id);
  };
  auto [still, region] = heated(0, 1e3);
  require(still.step(still.stable_dt()));
  require(still.set_heat_region(region, std::nullopt, 1e6));
  require(still.set_heat_time_scale(1));
  const double from = still.time();
  require(still.step(still.stable_dt()));
  // 64 particles, all of them in the region: source times volume times time.
  EXPECT_NEAR(still.totals()->heat_in, 1e6 * 0.064 * (still.time() - from), 1e-6 * 1e6 * 0.064 * from);
}

// --- a sound speed that follows what moves ----------------------------------------------------------------------------

WorldDesc following() {
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.domain.bounded = true;
  d.domain.max = {0.8, 1.6, 0.8};
  d.follow_sound_speed = true;
  return d;
}
void fill(World& w, double top) {
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0, 0, 0}, {0.8, top, 0.8});
  require(w.add_fluid(f));
}

// That a step begins with a look at what moves is part of the state: without it what was restored went on with another sound speed.
TEST(Found, AStateFromBeforeTheFirstLookGoesOnAlike) {
  MELTSIM_NEEDS_BACKEND();
  auto w = World::create(following());
  require(w);
  fill(*w, 0.4);
  for (int round = 0; round < 2; ++round) {  // ahead of the first step, and behind a change of the host's
    const auto bytes = w->snapshot();
    require(bytes);
    require(w->save_state(0));
    const auto go_on = [&] {
      for (int k = 0; k < 5; ++k) require(w->step(w->stable_dt()));
      return *w->state_hash();
    };
    const std::uint64_t first = go_on();
    require(w->load_state(0));
    EXPECT_EQ(go_on(), first) << round;
    require(w->restore(bytes->data(), bytes->size()));
    EXPECT_EQ(go_on(), first) << round;
    require(w->set_gravity({0, -5, 0}));
  }
}

// It rose from what it was in the empty World, over many steps, while liquid fell: compressed threefold, then halted.
TEST(Found, SoundIsThereWithWhatIsAdded) {
  MELTSIM_NEEDS_BACKEND();
  auto late = World::create(following()), at_once = World::create(following());
  require(late);
  require(at_once);
  for (int k = 0; k < 5; ++k) require(late->step(1e-3));
  fill(*late, 0.8);
  fill(*at_once, 0.8);
  for (World* w : {&*late, &*at_once})
    while (w->time() < 0.3) require(w->step(w->stable_dt()));
  const StepResult r = late->synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  // Both start from rest, and go by the same heads: to the compression that is allowed, 0.5 %, and the noise of the start.
  EXPECT_NEAR(r.max_density_ratio, at_once->synchronize().max_density_ratio, 0.01);
  EXPECT_NEAR(late->ledger()->sound_speed, at_once->ledger()->sound_speed,
              0.05 * at_once->ledger()->sound_speed);
}

// A step of heat or viscosity that is refused had looked at what moves.
TEST(Found, ARefusedStepLeavesTheSoundSpeedAndTheLimits) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = following();
  d.heat.max_supersteps = 1;
  auto w = World::create(d);
  require(w);
  MaterialDesc m;
  m.conductivity = 1e12;
  FluidDesc f;
  f.material = *w->add_material(m);
  f.shape = Shape::box({0, 0, 0}, {0.8, 0.4, 0.8});
  f.temperature = 50;
  require(w->add_fluid(f));
  f.shape = Shape::box({0, 0.4, 0}, {0.8, 0.5, 0.8});
  f.temperature = 20;
  f.velocity = {0, 0.5, 0};
  require(w->add_fluid(f));
  const double stable = w->stable_dt();
  const auto before = *w->snapshot();
  const Status refused = w->step(stable);
  ASSERT_FALSE(refused) << "the test tests nothing";
  EXPECT_EQ(refused.error().code, ErrorCode::step_too_large);
  EXPECT_EQ(w->stable_dt(), stable);
  EXPECT_EQ(*w->snapshot(), before);
}

// A melt may follow from a surface that begins to heat, and shortens the step; the step was refused, the limits stayed.
TEST(Found, ARefusedStepForgetsThatSomethingMayMelt) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.heat.max_supersteps = 1;
  auto w = World::create(d);
  require(w);
  MaterialDesc m;
  m.name = "liquid";
  MaterialDesc ice = solid("ice", *w->add_material(m), 5);
  ice.conductivity = 1e12;
  SolidDesc s;
  s.material = *w->add_material(ice);
  s.shape = Shape::box({0, 0, 0}, {0.3, 0.3, 0.3});
  s.temperature = -10;
  s.fixed = true;
  require(w->add_solid(s));
  require(w->step(1e-3));
  SurfaceHeatDesc warm;
  warm.temperature = 20;
  require(w->set_free_surface_heat(warm));
  const double stable = w->stable_dt();
  ASSERT_FALSE(w->step(1e-3)) << "the test tests nothing";
  EXPECT_EQ(w->stable_dt(), stable);
}

// --- surface tension --------------------------------------------------------------------------------------------------

// A table of materials is no scene; and what is set later counts as what was there from the start.
TEST(Found, SoundFollowsTheTensionOfWhatIsThereAlone) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.001;
  d.gravity = {};
  MaterialDesc oil, mercury;
  oil.name = "oil";
  mercury.name = "mercury";
  mercury.surface_tension = 0.485;
  const auto drop = [&](bool listed, const MaterialDesc& of) {
    auto w = World::create(d);
    EXPECT_TRUE(w);
    FluidDesc f;
    f.material = *w->add_material(of);
    if (listed) {
      EXPECT_TRUE(w->add_material(mercury));
    }
    f.shape = Shape::box({0, 0, 0}, {0.006, 0.006, 0.006});
    EXPECT_TRUE(w->add_fluid(f));
    EXPECT_TRUE(w->prepare());
    return std::move(*w);
  };
  World alone = drop(false, oil), listed = drop(true, oil);
  EXPECT_EQ(listed.resolved().sound_speed, alone.resolved().sound_speed);
  EXPECT_EQ(listed.stable_dt(), alone.stable_dt());
  MaterialDesc tense = oil;
  tense.surface_tension = 0.072;
  World from_the_start = drop(false, tense);
  ASSERT_GT(from_the_start.resolved().sound_speed, alone.resolved().sound_speed);
  require(alone.step(alone.stable_dt()));
  require(alone.set_material(MaterialId{0, alone.add_material(mercury)->generation}, tense));
  require(alone.prepare());
  EXPECT_EQ(alone.resolved().sound_speed, from_the_start.resolved().sound_speed);
}

// Its layers count from another time then, fewer of them before its end than it had left out: the World refused its own snapshot.
TEST(Found, ANozzleThatHasEndedMayGetAnotherSpeed) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.gravity = {};
  auto w = World::create(d);
  require(w);
  EmitterDesc e;
  e.material = *w->add_material({});
  e.radius = 0.15;
  e.speed = 2;
  while (w->time() < 1) require(w->step(0.05));
  e.until = 0.5;
  const auto nozzle = w->add_emitter(e);
  require(nozzle);
  EmitterSetting slower;
  slower.speed = 0.1;
  require(w->set_emitter(*nozzle, slower));
  require(w->step(0.05));
  const auto bytes = w->snapshot();
  require(bytes);
  require(w->restore(bytes->data(), bytes->size()));
  require(w->step(0.05));
  EXPECT_EQ(w->totals()->fluid, 0u);
}

// 1e300 squared is no number, and the World then refused its own snapshots.
TEST(Found, SpeedsBeyondReasonAreRefused) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.domain.bounded = true;
  d.domain.max = {1, 1, 1};
  d.domain.faces[1] = Face::open;
  d.domain.outlets[1].speed = 1e300;
  expect_refused(World::create(d), {"domain.outlets[+x].speed", "1e+15", "1e+300"});
  d.domain.outlets[1].speed = 1;
  auto w = World::create(d);
  require(w);
  SolidDesc s;
  s.material = *w->add_material({});
  s.shape = Shape::box({0.3, 0.3, 0.3}, {0.6, 0.6, 0.6});
  s.motion = Motion::kinematic;
  EmitterDesc e;
  e.material = s.material;
  e.center = {0.5, 0.8, 0.5};
  e.radius = 0.1;
  e.until = 1;
  e.speed = 1e30;
  expect_refused(w->add_emitter(e), {"emitter1", "speed", "1e+15", "1e+30"});
  s.max_speed = 1e300;
  expect_refused(w->add_solid(s), {"body1", "max_speed", "1e+15", "1e+300"});
}

// A host that names one body "body2" and none of the others was refused the second of those.
TEST(Found, NamesThatNobodyGaveAreFree) {
  MELTSIM_NEEDS_BACKEND();
  auto w = World::create(describe());
  require(w);
  SolidDesc s;
  s.material = *w->add_material({});
  HeatRegionDesc heat;
  ForceFieldDesc field;
  field.acceleration = {0, 1, 0};
  double at = 0;
  for (const int number : {2, 0, 0}) {  // 0: without a name
    const auto name = [&](const char* kind) { return number != 0 ? kind + std::to_string(number) : ""; };
    s.name = name("body");
    s.shape = Shape::box({at, 0, 0}, {at + 0.2, 0.2, 0.2});
    at += 1;
    require(w->add_solid(s));
    heat.name = name("heat");
    heat.shape = s.shape;
    heat.source = 1;
    require(w->add_heat_region(heat));
    field.name = name("field");
    require(w->add_force_field(field));
  }
}

// --- bodies that are held ---------------------------------------------------------------------------------------------

World with_held_body(double until, BodyId& id) {
  WorldDesc d = describe();
  d.spacing = 0.1;
  auto w = World::create(d);
  EXPECT_TRUE(w);
  SolidDesc s;
  s.material = *w->add_material({});
  s.shape = Shape::box({0, 0, 0}, {0.3, 0.3, 0.3});
  s.held_until = until;
  s.velocity = {1, 0, 0};
  id = *w->add_solid(s);
  return std::move(*w);
}
double lowest(World& w) { return w.totals()->solid_center.y; }

// What the host had said since stayed, so that a body was let go that was held, and the other way round.
TEST(Found, HowLongABodyIsHeldIsPartOfTheState) {
  MELTSIM_NEEDS_BACKEND();
  BodyId id, other_id;
  World w = with_held_body(0.1, id), other = with_held_body(0.1, other_id);
  require(w.step(0.01));
  const auto until = *w.snapshot();
  require(w.hold(id));
  const auto for_ever = *w.snapshot();
  require(w.hold(id, false));
  const double high = lowest(w);
  for (World* to : {&w, &other}) {
    require(to->restore(until.data(), until.size()));
    while (to->time() < 0.095) require(to->step(0.01));
    EXPECT_EQ(lowest(*to), high);
    while (to->time() < 0.195) require(to->step(0.01));
    EXPECT_NEAR(lowest(*to), high - 0.5 * 9.81 * 0.01, 1e-3);
    EXPECT_NEAR(to->totals()->momentum.x / to->totals()->mass, 1, 1e-5);
    require(to->restore(for_ever.data(), for_ever.size()));
    while (to->time() < 0.3) require(to->step(0.01));
    EXPECT_EQ(lowest(*to), high);
  }
  // A state saved on the backend, too; to be held for ever instead of for a time uploads nothing.
  require(w.restore(until.data(), until.size()));
  require(w.step(0.01));
  require(w.save_state(0));
  require(w.hold(id));
  require(w.load_state(0));
  while (w.time() < 0.195) require(w.step(0.01));
  EXPECT_LT(lowest(w), high - 0.04);
}

// A rigid body's rotation is double while it moves; held, it was rounded by the next upload, and the hash was another one.
TEST(Found, ARigidBodyIsHeldAsItIs) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.precision = Precision::single_precision;
  auto w = World::create(d);
  require(w);
  SolidDesc s;
  s.material = *w->add_material({});
  s.shape = Shape::box({0, 0, 0}, {0.3, 0.3, 0.3});
  s.motion = Motion::rigid;
  s.angular_velocity = {1, 2, 3};
  const auto id = w->add_solid(s);
  require(id);
  for (int k = 0; k < 10; ++k) require(w->step(0.01));
  require(w->hold(*id));
  const std::uint64_t before = *w->state_hash();
  require(w->save_state(0));
  require(w->step(0.01));
  require(w->load_state(0));
  EXPECT_EQ(*w->state_hash(), before);
}

// The body was let go by a step that was not taken.
TEST(Found, ARefusedStepLetsGoOfNothing) {
  MELTSIM_NEEDS_BACKEND();
  BodyId id;
  World w = with_held_body(0.1, id);
  while (w.time() < 0.095) require(w.step(0.01));
  const auto before = *w.snapshot();
  const double stable = w.stable_dt();
  const Status refused = w.step(1e6);
  ASSERT_FALSE(refused) << "the test tests nothing";
  EXPECT_EQ(*w.snapshot(), before);
  EXPECT_EQ(w.stable_dt(), stable);
}

// A motion of a step that was refused moves nothing yet: it limits no sub-step, either.
TEST(Found, AMotionThatWasRefusedLimitsNothing) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  auto w = World::create(d);
  require(w);
  SolidDesc s;
  s.material = *w->add_material({});
  s.shape = Shape::box({0, 0, 0}, {0.3, 0.3, 0.3});
  s.motion = Motion::kinematic;
  const auto id = w->add_solid(s);
  require(id);
  require(w->step(0.01));
  const double stable = w->stable_dt();
  BodyMotion far;
  far.position = {1e9, 0, 0};  // alone in a World it may be as fast as it likes
  require(w->set_motion(*id, far));
  const Status refused = w->step(0.01);
  ASSERT_FALSE(refused) << "the test tests nothing";
  EXPECT_NE(refused.error().message.find("max_substeps"), std::string::npos) << refused.error().message;
  EXPECT_EQ(w->stable_dt(), stable);
}

// Which vertices lie side by side is built at the upload, also where no stage asks for it as yet: once heat flows, pieces are searched
// by it, and a body that is whole stays whole. Found as a rigid body that fell apart into its particles.
TEST(Found, ARigidBodyThatMayMeltLaterStaysWhole) {
  MELTSIM_NEEDS_BACKEND();
  IceScene alone;
  alone.water = false;
  alone.motion = Motion::rigid;
  WorldDesc d = describe();
  d.pieces_interval = 1;
  Scene s = ice_in_water(d, alone);
  require(s.world.step(0.001));
  ASSERT_EQ(s.world.pieces()->size(), 1u);
  const std::uint64_t uploads = s.world.plan().uploads;
  HeatRegionDesc r;
  r.shape = Shape::box({0.7, 1.1, 0.7}, {1.1, 1.5, 1.1});
  r.source = 1;  // far from melting anything
  require(s.world.add_heat_region(r));
  for (int k = 0; k < 3; ++k) require(s.world.step(0.001));
  ASSERT_EQ(s.world.plan().uploads, uploads) << "the test tests nothing";
  ASSERT_EQ(s.world.pieces()->size(), 1u);
  EXPECT_EQ(s.world.pieces()->front().particles, 27u);
}

/// Steps that a World takes and one that was built alike, with `less`, and has taken its snapshot: the same to the bit.
void goes_on_alike(World& w, World& less) {
  const auto bytes = w.snapshot();
  require(bytes);
  require(less.restore(bytes->data(), bytes->size()));
  ASSERT_EQ(*less.state_hash(), *w.state_hash());
  for (int k = 0; k < 3; ++k) {
    require(w.step(0.002));
    require(less.step(0.002));
  }
  EXPECT_EQ(*less.state_hash(), *w.state_hash());
}

// Where a body that the host moves has its corner goes by its lattice, not by the World's origin, which is where the first thing was
// added: here 3 m away, there at the body.
TEST(Found, AProxyIsThatOfAWorldWithAnotherOrigin) {
  MELTSIM_NEEDS_BACKEND();
  const auto build = [](World& w, bool beside) {
    const MaterialId id = *w.add_material({});
    if (beside) {
      FluidDesc f;
      f.material = id;
      f.shape = Shape::box({0.1, 0.1, 0.1}, {0.14, 0.14, 0.14});
      require(w.add_fluid(f));
    }
    SolidDesc s;
    s.material = id;
    s.motion = Motion::proxy;
    s.mass = 0.1;
    s.shape = Shape::box({3.22, 3.32, -3.36}, {3.28, 3.38, -3.3});
    s.angular_velocity = {1, 2, 3};
    require(w.add_solid(s));
  };
  WorldDesc d = describe();
  d.spacing = 0.02;
  auto w = World::create(d), other = World::create(d);
  ASSERT_TRUE(w && other);
  build(*w, true);
  build(*other, false);
  require(w->step(0.002));
  goes_on_alike(*w, *other);
}

// Isotropic pressure is on by itself where a body can move, which one that is held cannot. Of what no particle is left, no tag says
// whether it was held.
TEST(Found, AHeldBodyThatHasMeltedLeavesTheStressAsItIs) {
  MELTSIM_NEEDS_BACKEND();
  const auto build = [] {
    IceScene without;
    without.block = 0;
    Scene s = ice_in_water(describe(), without);
    SolidDesc held;
    held.material = s.ice;
    held.shape = Shape::box({0.8, 1.2, 0.8}, {1.4, 1.8, 1.4});
    held.temperature = 30;  // melts in the first sub-step
    held.held_until = infinity;
    require(s.world.add_solid(held));
    return s;
  };
  Scene s = build(), other = build();
  for (int k = 0; k < 20; ++k) require(s.world.step(0.002));
  ASSERT_EQ(s.world.synchronize().solid, 0u) << "the test tests nothing";
  goes_on_alike(s.world, other.world);
}

// An emitter that would bring more than there is memory for is refused, and the World goes on: else no step, no snapshot and no other
// setting would be possible any more.
TEST(Found, AnEmitterIsNotSetToBringMoreThanThereIsMemoryFor) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = ice_in_water(describe(), {});
  EmitterDesc tap;
  tap.material = s.water;
  tap.center = {0.4, 1.8, 0.4};
  tap.radius = 0.25;
  tap.speed = 1;
  tap.until = 0.1;
  const auto id = s.world.add_emitter(tap);
  require(id);
  require(s.world.step(0.002));
  const auto before = *s.world.snapshot();
  EmitterSetting much;
  much.speed = 1e9;  // 5 10^8 layers of 4: at 200 bytes and more each, 4 10^11 bytes
  const Status refused = s.world.set_emitter(*id, much);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::out_of_memory) << refused.error().message;
  EXPECT_NE(refused.error().message.find("speed: would emit"), std::string::npos) << refused.error().message;
  EXPECT_EQ(*s.world.snapshot(), before);
  EmitterSetting twice;
  twice.speed = 2;
  require(s.world.set_emitter(*id, twice));
  require(s.world.step(0.002));
}

}  // namespace
}  // namespace meltsim_test
