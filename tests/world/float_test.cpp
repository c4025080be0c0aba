// SPDX-License-Identifier: Apache-2.0
// Bodies float at the draught of their density, sink, rest and pile up.
#include <algorithm>
#include <cmath>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

class Draught : public ::testing::TestWithParam<double> {};

TEST_P(Draught, EqualsTheDensityRatioWithinATenthOfASpacing) {
  MELTSIM_NEEDS_BACKEND();
  const double ratio = GetParam();
  WorldDesc d = describe();
  d.spacing = 0.2;
  d.domain.bounded = true;
  d.domain.max = {3.2, 3, 3.2};  // one body width of water on every side
  d.heat.model = HeatModel::none;
  auto w = World::create(d);
  ASSERT_TRUE(w);
  const auto water = *w->add_material({});
  MaterialDesc m;
  m.name = "float";
  m.density = 1000 * ratio;
  const auto light = *w->add_material(m);
  FluidDesc f;
  f.shape = Shape::box({0, 0, 0}, {3.2, 1.6, 3.2});
  f.material = water;
  require(w->add_fluid(f));
  const double side = 1.2;  // 6 spacings; a tenth of one is 8 % of the least draught
  SolidDesc b;
  // Starts at the lattice site nearest to its draught; it must stay there.
  const double floor = 0.2 * std::round((1.6 - ratio * side) / 0.2);
  b.shape = Shape::box({1, floor, 1}, {1 + side, floor + side, 1 + side});
  b.material = light;
  require(w->add_solid(b));
  const auto totals = *w->totals();
  const double water_volume = double(totals.fluid) * 0.008;
  double center = 0;
  int samples = 0;
  // The last 2.5 s are a period of the heaviest body's heave, which dies within some of them.
  for (int k = 0; k < 1900; ++k) {
    require(w->step(0.0025));
    if (k >= 900 && k % 25 == 0) {
      center += w->totals()->solid_center.y;
      ++samples;
    }
  }
  ASSERT_FALSE(w->synchronize().halted);
  center /= samples;
  const double level = (water_volume + ratio * side * side * side) / (3.2 * 3.2);
  const double draught = level - (center - side / 2);
  // It is off by 0.003 m or less; what is left of the heave is as large.
  EXPECT_NEAR(draught, ratio * side, 0.02) << "level " << level << " centre " << center;
}

// Flat attitude is stable only below 0.211 or above 0.789; in between a cube turns within minutes, not in 5 s.
INSTANTIATE_TEST_SUITE_P(Densities, Draught, ::testing::Values(0.2, 0.5, 0.917));

TEST(Floating, AHeavyBodySinksToTheFloorAndRests) {
  MELTSIM_NEEDS_BACKEND();
  IceScene scene;
  scene.ice_density = 8000;
  scene.time_scale = 0;
  scene.block_floor = 0.6;
  Scene s = ice_in_water(describe(), scene);
  for (int k = 0; k < 800; ++k) require(s.world.step(0.005));
  ASSERT_FALSE(s.world.synchronize().halted);
  const auto p = *s.world.pieces();
  ASSERT_EQ(p.size(), 1u);
  EXPECT_NEAR(p[0].center.y, 0.3, 0.1);  // half of 0.6 m above the floor, half a spacing
  EXPECT_LT(length(p[0].velocity), 0.05);
}

TEST(Contact, ATowerOfThreeBlocksStands) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.2;
  d.domain.bounded = true;
  d.domain.max = {2, 3, 2};
  auto w = World::create(d);
  ASSERT_TRUE(w);
  double floor = 0;
  for (const double density : {10000.0, 200.0, 1000.0}) {  // light on heavy, and five times as heavy on light
    MaterialDesc m;
    m.name = std::to_string(density);
    m.density = density;
    const auto id = *w->add_material(m);
    SolidDesc b;
    b.shape = Shape::box({0.6, floor, 0.6}, {1.2, floor + 0.6, 1.2});
    b.material = id;
    require(w->add_solid(b));
    floor += 0.6;
  }
  for (int k = 0; k < 5000; ++k) require(w->step(0.002));  // 10 s
  ASSERT_FALSE(w->synchronize().halted);
  const auto p = *w->pieces();
  ASSERT_EQ(p.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    // Contacts give way by 0.001 m.
    EXPECT_NEAR(p[k].center.y, 0.3 + 0.6 * double(k), 0.02) << "sunk in by more than a tenth of a spacing";
    EXPECT_NEAR(p[k].center.x, 0.9, 0.1);
    EXPECT_LT(length(p[k].velocity), 0.02);
  }
}

/// A cube of 200 kg/m^3 under one of 10000, 3 sites each, on the floor of a box.
World light_under_heavy() {
  WorldDesc d = describe();
  d.spacing = 0.2;
  d.domain.bounded = true;
  d.domain.max = {2, 3, 2};
  auto w = World::create(d);
  EXPECT_TRUE(w);
  double floor = 0;
  for (const double density : {200.0, 10000.0}) {
    MaterialDesc m;
    m.name = std::to_string(density);
    m.density = density;
    SolidDesc b;
    b.shape = Shape::box({0.6, floor, 0.6}, {1.2, floor + 0.6, 1.2});
    b.material = *w->add_material(m);
    require(w->add_solid(b));
    floor += 0.6;
  }
  return std::move(*w);
}

// Without static friction it creeps: the heavy block is off by a spacing after 12 s at 1 ms, earlier at 2 ms.
// 20 s of 2 ms; a tenth of a spacing sideways. The fall of the start dies away up and down within a minute.
TEST(Contact, AHeavyBlockOnALightOneDoesNotCreep) {
  MELTSIM_NEEDS_BACKEND();
  World w = light_under_heavy();
  for (int k = 0; k < 10000; ++k) require(w.step(0.002));
  ASSERT_FALSE(w.synchronize().halted);
  const auto p = *w.pieces();
  ASSERT_EQ(p.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(p[k].center.x, 0.9, 0.02);
    EXPECT_NEAR(p[k].center.z, 0.9, 0.02);
    EXPECT_NEAR(p[k].center.y, 0.3 + 0.6 * double(k), 0.06);  // pressed in by a third of a spacing at most
    EXPECT_LT(std::hypot(p[k].velocity.x, p[k].velocity.z), 1e-3);
    EXPECT_LT(std::fabs(p[k].velocity.y), 0.1);
  }
}

// Bit for bit: what contacts remember is part of the state.
TEST(Contact, RestoringContinuesFriction) {
  MELTSIM_NEEDS_BACKEND();
  World a = light_under_heavy(), b = light_under_heavy();
  for (int k = 0; k < 300; ++k) require(a.step(0.002));
  const auto snapshot = *a.snapshot();
  require(b.restore(snapshot.data(), snapshot.size()));
  for (World* w : {&a, &b})
    for (int k = 0; k < 300; ++k) require(w->step(0.002));
  EXPECT_EQ(*a.state_hash(), *b.state_hash());
}

// A block slides on a plane as Coulomb says: v0^2 / (2 mu g) far. 1 m/s and 0.3: 0.170 m in 0.34 s; 3 % for
// the press of the first steps, in which the block sinks in.
TEST(Contact, ASlidingBlockStopsWhereCoulombSays) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.05;
  d.domain.bounded = true;
  d.domain.max = {2, 1, 1};
  auto w = World::create(d);
  ASSERT_TRUE(w);
  MaterialDesc m;
  m.name = "stone";
  SolidDesc b;
  b.shape = Shape::box({0.2, 0, 0.2}, {0.6, 0.2, 0.6});
  b.material = *w->add_material(m);
  b.velocity = {1, 0, 0};
  require(w->add_solid(b));
  const double start = w->totals()->solid_center.x;
  for (int k = 0; k < 3000; ++k) require(w->step(5e-4));
  EXPECT_NEAR(w->totals()->solid_center.x - start, 1 / (2 * 0.3 * 9.81), 0.005);
  EXPECT_LT(w->totals()->max_speed, 1e-3);
}

/// Water over a plate between walls, whose upper face is at 1.2 m, and a block of 2500 kg/m^3 that falls into it: all of it after 2 s.
ParticleData over_plate(int layers, bool at_rest) {
  WorldDesc d = describe();
  d.spacing = 0.2;
  d.hydrostatic_start = at_rest;
  d.domain.bounded = true;
  d.domain.max = {2, 3, 2};
  World w = std::move(*World::create(d));
  const auto water = *w.add_material({});
  MaterialDesc m;
  m.name = "stone";
  m.density = 2500;
  const auto stone = *w.add_material(m);
  SolidDesc plate;
  plate.shape = Shape::box({0, 1.2 - 0.2 * layers, 0}, {2, 1.2, 2});
  plate.material = stone;
  plate.fixed = true;
  require(w.add_solid(plate));
  SolidDesc block;
  block.shape = Shape::box({0.6, 2, 0.6}, {1.2, 2.6, 1.2});
  block.material = stone;
  require(w.add_solid(block));
  FluidDesc f;
  f.shape = Shape::box({0, 1.2, 0}, {2, 2.0, 2});
  f.material = water;
  require(w.add_fluid(f));
  for (int k = 0; k < 800; ++k) require(w.step(0.0025));
  EXPECT_FALSE(w.synchronize().halted);
  return *w.particles();
}

// One layer holds water that splashes, but lets a particle through where water at rest, whose layers are even, is struck
// (docs/limits.md); two hold both.
TEST(Contact, NothingPassesThroughAFixedPlate) {
  MELTSIM_NEEDS_BACKEND();
  for (const auto& [layers, at_rest] : {std::pair{1, false}, {2, false}, {2, true}}) {
    const ParticleData p = over_plate(layers, at_rest);
    const double lowest = 1.2 - 0.2 * layers;
    for (std::size_t i = 0; i < p.id.size(); ++i)
      EXPECT_GT(p.position[i].y, lowest) << p.id[i] << ", " << layers << " layers";
  }
}

// A liquid whose density falls a million times with temperature is as hard to step as two such liquids side by side.
TEST(Floating, AContrastOfATableIsInTheStep) {
  MELTSIM_NEEDS_BACKEND();
  const auto step_of = [](double hot) {
    WorldDesc d = describe();
    d.spacing = 0.1;
    d.sound_speed = 20;
    auto world = World::create(d);
    MaterialDesc m;
    if (hot > 0) m.density_points = {{0, 1000}, {100, hot}};
    FluidDesc f;
    f.material = *world->add_material(m);
    f.shape = Shape::box({0, 0, 0}, {0.5, 0.5, 0.5});
    require(world->add_fluid(f));
    return world->stable_dt();
  };
  EXPECT_NEAR(step_of(1e-2) / step_of(0), std::pow(1e-5, 0.25), 1e-9);
  EXPECT_NEAR(step_of(1000) / step_of(0), 1, 1e-12);
}

// Water 10 spacings deep with a cube on it, thrown against the ceiling, with bodies about as soft as the liquid or softer. Springs of
// bodies and compressed liquid hold energy that the ledger does not count, so the sum may only fall; 1 % of the fall is what water
// that starts without pressure gives back. Where particles of a crushed body pressed on liquid as those of a whole one of their
// density, each of these brought 1.5 to 10 times the energy of the fall.
TEST(Floating, ASoftBodyThrownAgainstTheCeilingGainsNoEnergy) {
  MELTSIM_NEEDS_BACKEND();
  struct Case {
    double density;
    int side;
    double stiffness;
  };
  for (const Case& c : {Case{500, 2, 1}, Case{400, 3, 0.5}, Case{500, 3, 0.25}}) {
    constexpr double dx = 0.05;
    WorldDesc d = describe();
    d.spacing = dx;
    d.domain.bounded = true;
    d.domain.max = {8 * dx, 20 * dx, 8 * dx};
    d.heat.model = HeatModel::none;
    auto w = World::create(d);
    ASSERT_TRUE(w);
    FluidDesc f;
    f.material = *w->add_material({});
    f.shape = Shape::box({0, 0, 0}, {8 * dx, 10 * dx, 8 * dx});
    require(w->add_fluid(f));
    MaterialDesc m;
    m.name = "soft";
    m.density = c.density;
    m.stiffness = c.stiffness;
    SolidDesc b;
    b.material = *w->add_material(m);
    b.shape =
        Shape::box({3 * dx, 10 * dx, 3 * dx}, {(3 + c.side) * dx, (10 + c.side) * dx, (3 + c.side) * dx});
    require(w->add_solid(b));
    require(w->step(0.01));
    require(w->set_gravity(-d.gravity));
    const auto energy = [&] {
      const Ledger l = *w->ledger();
      return l.kinetic + l.potential;
    };
    const double fall = w->ledger()->mass * 9.81 * 10 * dx, start = energy();
    double most = start;
    for (int k = 0; k < 45; ++k) {  // it strikes at 0.3 s
      require(w->step(0.01));
      most = std::max(most, energy());
    }
    EXPECT_FALSE(w->synchronize().halted);
    EXPECT_LT((most - start) / fall, 0.01) << c.density << " kg/m^3, " << c.side << " spacings";
  }
}

}  // namespace
}  // namespace meltsim_test
