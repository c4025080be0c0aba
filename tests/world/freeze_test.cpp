// SPDX-License-Identifier: Apache-2.0
// Liquid that freezes onto bodies: what is kept, what grows where, and that it is all reproducible.
#include <algorithm>
#include <cmath>
#include <set>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

/// Very cold ice in barely warm water freezes a shell around itself. With the latent heat of water its cold
/// would do for 31 particles, a third of a layer; 5e4 J/kg make that 150, after the water has cooled.
IceScene cold_block() {
  IceScene s;
  s.freezes = true;
  s.growth = 2;
  s.latent_heat = 5e4;
  s.ice_temperature = -200;
  s.water_temperature = 1;
  s.block_floor = 0.4;
  s.depth = 1.2;
  s.box = 2.2;
  return s;
}

/// Steps until this many have frozen.
void freeze(World& world, std::uint64_t wanted, int most = 400) {
  for (int k = 0; k < most; ++k) {
    require(world.step(0.005));
    const StepResult r = world.synchronize();
    ASSERT_FALSE(r.halted) << r.halt_reason;
    if (r.frozen >= wanted) return;
  }
  FAIL() << "only " << world.synchronize().frozen << " froze";
}

std::uint64_t bytes(const Plan& p, const std::string& channel) {
  for (const ChannelReport& c : p.channels)
    if (c.name == channel) return c.bytes;
  ADD_FAILURE() << "no channel " << channel;
  return 0;
}

const StageReport& stage(const Plan& p, const std::string& name) {
  return *std::find_if(p.stages.begin(), p.stages.end(),
                       [&](const StageReport& s) { return s.name == name; });
}

/// Share of the cells between a wall at 10 degrees and one at -5 that is frozen in the end, and the heat from the warm one, of what is
/// right; ice conducts four times as well.
struct SteadyFront {
  double frozen, heat;
};
SteadyFront steady_front(bool from_ice) {
  constexpr int cells = 12;
  constexpr double length = 1.2, dx = length / cells, side = 8 * dx, hot = 10, cold = -5, latent = 20;
  WorldDesc d = describe();
  d.spacing = dx;
  d.gravity = {0, 0, 0};
  d.sound_speed = 1e-2;  // nothing moves
  d.domain.bounded = true;
  d.domain.max = {side, side, length};
  d.domain.faces = {Face::periodic, Face::periodic, Face::periodic, Face::periodic, Face::wall, Face::wall};
  d.domain.heat[4].temperature = cold;
  d.domain.heat[5].temperature = hot;
  World w = *World::create(d);
  MaterialDesc water, ice;
  water.conductivity = water.heat_capacity = water.viscosity = 1;
  ice.name = "ice";
  ice.conductivity = 4;
  ice.heat_capacity = 1;
  ice.latent_heat = latent;
  ice.melting_point = 0;
  ice.melts_into = *w.add_material(water);
  ice.freezes = true;
  SolidDesc s;
  s.fixed = true;
  s.material = *w.add_material(ice);
  s.temperature = -0.1;
  s.growth = cells + 2;
  s.shape = Shape::box({0, 0, 0}, {side, side, from_ice ? length : 2 * dx});
  require(w.add_solid(s));
  FluidDesc f;
  f.shape = Shape::box({0, 0, 2 * dx}, {side, side, length});
  f.material = ice.melts_into;
  f.temperature = 0.1;
  if (!from_ice) require(w.add_fluid(f));
  const double time =
      1000 * length * length * (latent / hot + 1);  // melts all; ten times what heat takes across
  for (int k = 0; k < 200; ++k) require(w.step(time / 100));
  const auto p = *w.particles();
  double solid = 0;
  for (const float fraction : p.liquid_fraction) solid += 1 - static_cast<double>(fraction);
  ProbeDesc probe;
  probe.kind = ProbeKind::heat;
  probe.wall = 5;
  require(w.add_probe(probe));
  require(w.step(time / 100));
  const double heat = w.take_samples()->at(0).values.back();
  const double right = length * -4 * cold / (-4 * cold + hot);
  return {solid / static_cast<double>(p.id.size()) * length / right,
          heat / (hot / (length - right) * side * side)};
}

// The front rests where as much heat comes from the water as goes into the ice, 8 of 12 cells from the cold wall, whichever it was
// before. 4 %: a third of a cell, as far as that is known inside a cell; one cell short, as it was while liquid at the front conducted as
// liquid on both sides, is 12 % and 11 % of the heat.
TEST(Freezing, AFrontRestsWhereHeatBalances_FromIceAndFromWater) {
  MELTSIM_NEEDS_BACKEND();
  for (const bool from_ice : {true, false}) {
    const SteadyFront front = steady_front(from_ice);
    EXPECT_NEAR(front.frozen, 1, 0.04) << from_ice;
    EXPECT_NEAR(front.heat, 1, 0.04) << from_ice;
  }
}

TEST(Freezing, TheShellIsWhatTheHeatBalanceSays) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.precision = Precision::double_precision;
  IceScene scene = cold_block();
  scene.fixed = true;
  Scene s = ice_in_water(d, scene);
  const Totals before = *s.world.totals();
  const double ice = 27 * 917 * 0.008, water = before.mass - ice;
  for (int k = 0; k < 500; ++k) require(s.world.step(0.005));
  const StepResult r = s.world.synchronize();
  const Totals after = *s.world.totals();
  ASSERT_FALSE(r.halted) << r.halt_reason;
  EXPECT_GT(r.frozen, 8u);
  EXPECT_EQ(r.solid, 27 + r.frozen - r.melted);
  EXPECT_EQ(r.solid, after.solid);
  EXPECT_EQ(r.fluid, after.fluid);
  EXPECT_EQ(after.mass, before.mass);
  EXPECT_NEAR(after.thermal / before.thermal, 1.0, 1e-12);  // the ledger in double
  // What the ice took up beyond warming itself is what the water gave: its degree, then latent heat. Counted
  // by liquid fractions: heat reaches the second layer before the first has frozen through.
  const auto p = *s.world.particles();
  double frozen = 0, left = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    frozen += (1 - p.liquid_fraction[i]) * p.mass[i];
    left += p.mass[i] * (p.temperature[i] < 0 ? 2100 * p.temperature[i] : 4186 * p.temperature[i]);
  }
  const double balance = ice + (ice * 2100 * 200 - water * 4186 * 1 + left) / 5e4;
  EXPECT_NEAR(frozen, balance, 8.0);  // one particle of water
}

// First the cold block freezes a shell, then the bath melts all of it: nothing is left of the lattice, and
// every particle has the mass it had.
TEST(Freezing, WhatFrozeMeltsAgainAndMassAndHeatAreAsBefore) {
  MELTSIM_NEEDS_BACKEND();
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    WorldDesc d = describe();
    d.precision = precision;
    IceScene scene = cold_block();
    scene.water_temperature = 15;  // the ice takes 9e7 J, the water holds 3.5e8
    Scene s = ice_in_water(d, scene);
    const auto before = *s.world.particles();
    const Totals start = *s.world.totals();
    melt(s.world, 0.005, 12);
    const StepResult r = s.world.synchronize();
    EXPECT_GT(r.frozen, 4u);
    EXPECT_EQ(r.solid, 0u);
    EXPECT_EQ(r.melted, 27 + r.frozen);
    const auto after = *s.world.particles();
    ASSERT_EQ(before.id, after.id);
    EXPECT_EQ(before.mass, after.mass);  // bit for bit
    const Totals end = *s.world.totals();
    EXPECT_NEAR(end.thermal / start.thermal, 1.0, precision == Precision::single_precision ? 1e-6 : 1e-12);
    // Nothing solid, nothing to freeze on: the plan knows.
    const Plan p = s.world.plan();
    EXPECT_FALSE(stage(p, "topology.freeze").runs);
    EXPECT_EQ(bytes(p, "vertex_pick"), 0u);
    require(s.world.step(0.005));
    EXPECT_EQ(s.world.synchronize().frozen, r.frozen);
  }
}

TEST(Freezing, MomentumOfBodyAndLiquidIsConstant) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.gravity = {0, 0, 0};
  d.sound_speed = 20;
  d.heat.time_scale = 1e6;
  auto world = World::create(d);
  ASSERT_TRUE(world);
  const auto water = *world->add_material({});
  MaterialDesc ice;
  ice.name = "ice";
  ice.density = 917;
  ice.melting_point = 0;
  ice.latent_heat = 5e4;
  ice.melts_into = water;
  ice.freezes = true;
  const auto m = *world->add_material(ice);
  FluidDesc f;
  f.shape = Shape::box({-0.4, -0.4, -0.4}, {1.2, 1.0, 1.0});
  f.material = water;
  f.temperature = 0.5;
  f.velocity = {0.2, 0, 0.1};
  require(world->add_fluid(f));
  SolidDesc b;
  b.shape = Shape::box({0, 0, 0}, {0.6, 0.6, 0.6});
  b.material = m;
  b.temperature = -250;
  b.velocity = {-0.2, 0.1, 0};
  b.angular_velocity = {0, 0, 0.5};
  b.growth = 2;
  require(world->add_solid(b));
  const Totals before = *world->totals();
  double scale = 0;  // the sum of |m v|, against which rounding is measured
  const auto p = *world->particles();
  for (std::size_t i = 0; i < p.id.size(); ++i) scale += p.mass[i] * length(p.velocity[i]);
  for (int k = 0; k < 400; ++k) require(world->step(0.0025));
  const StepResult r = world->synchronize();
  ASSERT_FALSE(r.halted) << r.halt_reason;
  EXPECT_GT(r.frozen, 20u);
  const Totals after = *world->totals();
  // Joining a body changes no velocity; what is left is the rounding of 400 velocity sums in float.
  EXPECT_LT(length(after.momentum - before.momentum) / scale, 1e-6);
  EXPECT_EQ(after.mass, before.mass);
}

TEST(Freezing, BitsDoNotDependOnTheNumberOfThreads) {
  MELTSIM_NEEDS_BACKEND();
  std::set<std::uint64_t> hashes;
  for (const int threads : {1, 2, 3}) {
    WorldDesc d = describe();
    d.threads = threads;
    IceScene scene = cold_block();
    scene.box = 3;
    scene.depth = 2.2;
    scene.growth = 8;  // above 1024 particles and vertices loops are shared out
    Scene s = ice_in_water(d, scene);
    ASSERT_GT(s.world.lattice()->live.size(), 2048u);
    for (int k = 0; k < 60; ++k) require(s.world.step(0.005));
    EXPECT_GT(s.world.synchronize().frozen, 8u);
    hashes.insert(*s.world.state_hash());
  }
  EXPECT_EQ(hashes.size(), 1u);
}

TEST(Freezing, RestoreAndContinueEqualsUninterrupted) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = ice_in_water(describe(), cold_block());
  ASSERT_NO_FATAL_FAILURE(freeze(a.world, 4));
  const auto snapshot = *a.world.snapshot();
  const std::uint64_t frozen = a.world.synchronize().frozen;
  Scene b = ice_in_water(describe(), cold_block());
  require(b.world.restore(snapshot.data(), snapshot.size()));
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
  EXPECT_EQ(b.world.synchronize().frozen, frozen);
  for (int k = 0; k < 60; ++k) {
    require(a.world.step(0.005));
    require(b.world.step(0.005));
  }
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
  EXPECT_GT(a.world.synchronize().frozen, frozen);
  EXPECT_EQ(a.world.synchronize().frozen, b.world.synchronize().frozen);
  // The format before vertices could change their particles is refused by its number.
  auto old = snapshot;
  old[8] = 1;
  const Status s = b.world.restore(old.data(), old.size());
  ASSERT_FALSE(s);
  EXPECT_NE(s.error().message.find("format version 1"), std::string::npos) << s.error().message;
}

TEST(Freezing, AFixedBodyGrowsOnItsLattice) {
  MELTSIM_NEEDS_BACKEND();
  IceScene scene = cold_block();
  scene.fixed = true;
  scene.block_floor = 0;  // the floor cuts the sites below off
  Scene s = ice_in_water(describe(), scene);
  const LatticeData built = *s.world.lattice();
  EXPECT_EQ(built.live.size(), 7u * 7u * 5u);
  EXPECT_EQ(std::count(built.live.begin(), built.live.end(), 1), 27);
  ASSERT_NO_FATAL_FAILURE(freeze(s.world, 12));
  const LatticeData now = *s.world.lattice();
  const auto p = *s.world.particles();
  std::uint64_t grown = 0;
  for (std::size_t v = 0; v < now.live.size(); ++v) {
    if (!now.live[v]) continue;
    const std::uint32_t i = now.particle_id[v];
    grown += v >= 27 ? 1 : 0;
    const Vec3d site{(now.coordinates[v].x + 0.5) * 0.2, (now.coordinates[v].y + 0.5) * 0.2,
                     (now.coordinates[v].z + 0.5) * 0.2};
    EXPECT_LT(length(p.position[i] - site), 1e-5);
    EXPECT_EQ(length(p.velocity[i]), 0.0);
    EXPECT_EQ(p.tag[i] & (tag_solid | tag_fixed), tag_solid | tag_fixed);
    EXPECT_EQ(body_of(p.tag[i]), 1u);
    EXPECT_EQ(material_of(p.tag[i]), s.ice.index);
  }
  EXPECT_GE(grown, 12u);
  EXPECT_EQ(s.world.pieces()->size(), 1u);
  EXPECT_EQ(s.world.pieces()->front().particles, 27 + grown);
}

// Liquid may not be thrown about by what freezes beside it: 1.011 of the rest density and 0.5 m/s, what the
// start of the tank makes as well. If liquid saw 0.8 of a new solid particle's volume, it would be 1.033 and
// 1.4 m/s; the bars lie between.
TEST(Freezing, DoesNotSplash) {
  MELTSIM_NEEDS_BACKEND();
  IceScene scene = cold_block();
  scene.fixed = true;
  Scene s = ice_in_water(describe(), scene);
  for (int k = 0; k < 3; ++k) require(s.world.step(0.005));
  s.world.synchronize();
  double densest = 0, fastest = 0;
  for (int k = 0; k < 300; ++k) {
    require(s.world.step(0.005));
    const StepResult r = s.world.synchronize();
    densest = std::max(densest, r.max_density_ratio);
    fastest = std::max(fastest, r.max_speed);
  }
  EXPECT_GT(s.world.synchronize().frozen, 80u);
  EXPECT_LT(densest, 1.02);
  EXPECT_LT(fastest, 0.9);
}

/// 6 x 6 x 6 particles of melt at the melting point on two layers of seed, cooled from below and above.
World still_pool() {
  constexpr double dx = 0.01, side = 6 * dx;
  WorldDesc d = describe();
  d.spacing = dx;
  d.heat.time_scale = 100;
  d.domain.bounded = true;
  d.domain.max = {side, 13 * dx, side};
  d.domain.heat[2].temperature = 600;
  SurfaceHeatDesc air;
  air.ambient = 20;
  air.convection = 500;
  d.heat.free_surface = air;
  World w = *World::create(d);
  MaterialDesc melt, metal;
  melt.density = metal.density = 2400;
  melt.viscosity = 0.01;
  melt.conductivity = 100;
  metal.conductivity = 200;
  melt.heat_capacity = metal.heat_capacity = 1080;
  metal.name = "metal";
  metal.melting_point = 660;
  metal.latent_heat = 3.9e5;
  metal.melts_into = *w.add_material(melt);
  metal.freezes = true;
  SolidDesc seed;
  seed.fixed = true;
  seed.material = *w.add_material(metal);
  seed.temperature = 640;
  seed.growth = 11;
  seed.surface = air;
  seed.shape = Shape::box({0, 0, 0}, {side, 2 * dx, side});
  require(w.add_solid(seed));
  FluidDesc f;
  f.shape = Shape::box({0, 2 * dx, 0}, {side, 8 * dx, side});
  f.material = metal.melts_into;
  f.temperature = 660;
  require(w.add_fluid(f));
  return w;
}

// Right: eight full layers, whose centre is where it was. One particle in a hundred may lie on top, and one in fifty may wait where two
// want a site; a tenth of the melt lay on top while particles jumped to their sites, and liquid was thrown about at 2.1 m/s instead of 0.7.
TEST(Freezing, AStillPoolFreezesFlatAndDense) {
  MELTSIM_NEEDS_BACKEND();
  World w = still_pool();
  double fastest = 0;
  for (int k = 0; k < 200 && w.synchronize().frozen < 216u; ++k) {
    require(w.step(0.01));
    const StepResult r = w.synchronize();
    ASSERT_FALSE(r.halted) << r.halt_reason;
    fastest = std::max(fastest, r.max_speed);
  }
  const auto p = *w.particles();
  int above = 0;
  for (const Vec3d& x : p.position) above += x.y > 0.08 ? 1 : 0;
  EXPECT_LE(above, 2);
  EXPECT_GE(w.synchronize().frozen, 212u);
  EXPECT_LT(fastest, 1.4);
}

// A body without growth takes back what melted off it, and no more than that.
TEST(Freezing, WithoutGrowthOnlyFormerSitesFill) {
  MELTSIM_NEEDS_BACKEND();
  IceScene scene = cold_block();
  scene.growth = 0;
  Scene s = ice_in_water(describe(), scene);
  for (int k = 0; k < 100; ++k) require(s.world.step(0.005));
  EXPECT_EQ(s.world.synchronize().frozen, 0u);
  EXPECT_TRUE(stage(s.world.plan(), "topology.freeze").runs);
}

TEST(Freezing, ThePapersHeatFreezesToo) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.heat.model = HeatModel::paper;
  IceScene scene = cold_block();
  scene.ice_temperature = -60;
  Scene s = ice_in_water(d, scene);
  ASSERT_NO_FATAL_FAILURE(freeze(s.world, 20));
}

// Water as cold as the ice, with the solid's enthalpy: no heat flows, and yet it freezes, layer by layer.
TEST(Freezing, SupercooledLiquidOfOneTemperatureFreezesWithoutHeat) {
  MELTSIM_NEEDS_BACKEND();
  IceScene scene = cold_block();
  scene.ice_temperature = scene.water_temperature = -5;
  Scene s = ice_in_water(describe(), scene);
  EXPECT_FALSE(stage(s.world.plan(), "thermal.exchange").runs);
  const double thermal = s.world.totals()->thermal;
  ASSERT_NO_FATAL_FAILURE(freeze(s.world, 20));
  EXPECT_EQ(s.world.totals()->thermal, thermal);
}

TEST(Freezing, AWorldInWhichNothingFreezesHasNoneOfIt) {
  MELTSIM_NEEDS_BACKEND();
  Scene plain = ice_in_water(describe());
  const Plan without = plain.world.plan();
  EXPECT_FALSE(stage(without, "topology.freeze").runs);
  EXPECT_EQ(stage(without, "topology.freeze").reason,
            "no body that its liquid can freeze onto or a species could precipitate on, or heat is off");
  for (const char* c : {"claim", "vertex_pick"}) EXPECT_EQ(bytes(without, c), 0u) << c;
  Scene s = ice_in_water(describe(), cold_block());
  const Plan with = s.world.plan();
  EXPECT_TRUE(stage(with, "topology.freeze").runs);
  for (const char* c : {"claim", "vertex_pick"}) EXPECT_GT(bytes(with, c), 0u) << c;
  require(s.world.scheduler().enable("topology", false));
  EXPECT_FALSE(stage(s.world.plan(), "topology.freeze").runs);
}

TEST(Freezing, GrowthThatCannotBeIsRefusedByName) {
  MELTSIM_NEEDS_BACKEND();
  IceScene scene;
  scene.block = 0;
  Scene s = ice_in_water(describe(), scene);
  SolidDesc b;
  b.material = s.ice;  // does not freeze
  b.shape = Shape::box({0.8, 1.2, 0.8}, {1.2, 1.6, 1.2});
  const auto refused = [&](World& w, const char* what) {
    const auto r = w.add_solid(b);
    ASSERT_FALSE(r);
    EXPECT_NE(r.error().message.find(what), std::string::npos) << r.error().message;
  };
  b.growth = -1;
  refused(s.world, "growth: must be >= 0");
  b.growth = 2;
  refused(s.world, "which does not freeze");
  WorldDesc d = describe();  // unbounded: nothing cuts the box off
  World open = *World::create(d);
  MaterialDesc ice;
  ice.name = "ice";
  ice.melting_point = 0;
  ice.melts_into = *open.add_material({});
  ice.freezes = true;
  b.material = *open.add_material(ice);
  for (const int growth : {400, 2000000000}) {
    b.growth = growth;
    refused(open, "grow less, or bound the domain");
  }
  EXPECT_EQ(open.totals()->solid, 0u);
}

}  // namespace
}  // namespace meltsim_test
