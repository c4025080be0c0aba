// SPDX-License-Identifier: Apache-2.0
// Liquid that starts at rest (physics/hydrostatic.hpp).
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double dx = 0.1, g = 9.81, water = 1000;

/// A closed box of 8 x 8 spacings, and 24 high, without heat.
WorldDesc box(bool at_rest) {
  WorldDesc d = describe();
  d.spacing = dx;
  d.heat.model = HeatModel::none;
  d.domain.bounded = true;
  d.domain.no_slip = false;
  d.domain.min = {0, 0, 0};
  d.domain.max = {0.8, 2.4, 0.8};
  d.gravity = {0, -g, 0};
  d.hydrostatic_start = at_rest;
  return d;
}

MaterialId liquid(World& w, const std::string& name, double density) {
  MaterialDesc m;
  m.name = name;
  m.density = density;
  return *w.add_material(m);
}

void fill(World& w, MaterialId m, const Vec3d& low, const Vec3d& high) {
  FluidDesc f;
  f.material = m;
  f.shape = Shape::box(low, high);
  require(w.add_fluid(f));
}

/// Of the last sub-step, of which this is one before nothing was stepped.
double pressure(World& w, const Vec3d& at) {
  if (w.steps() == 0) require(w.step(1e-4));
  return (*w.sample({at}, {"pressure"})).at(0);
}

std::vector<Vec3d> places(World& w) {
  require(w.prepare());
  const auto p = w.particles();
  EXPECT_TRUE(p);
  return p->position;
}

// A layer of liquid is a step of rho g dx in pressure: what is read is within half of it.
TEST(HydrostaticStart, PressureIsThatOfTheDepth) {
  MELTSIM_NEEDS_BACKEND();
  World w = std::move(*World::create(box(true)));
  fill(w, liquid(w, "water", water), {0, 0, 0}, {0.8, 1.6, 0.8});
  for (const double y : {0.05, 0.45, 0.85, 1.25})
    EXPECT_NEAR(pressure(w, {0.4, y, 0.4}), water * g * (1.6 - y), water * g * dx / 2) << y;
}

// Without it the pressure at the floor swings from nothing to twice that of the depth, for seconds. With it layers are in balance, to
// rounding: what is left is half a layer's pressure that a reading may be off by. 0.3 s are two swings; later the lattice comes
// apart, which it does in any liquid.
TEST(HydrostaticStart, ATankDoesNotRing) {
  MELTSIM_NEEDS_BACKEND();
  const auto swing = [](bool at_rest) {
    World w = std::move(*World::create(box(at_rest)));
    fill(w, liquid(w, "water", water), {0, 0, 0}, {0.8, 1.6, 0.8});
    double largest = 0;
    for (int k = 0; k < 60; ++k) {
      require(w.step(0.005));
      largest = std::max(largest, std::fabs(pressure(w, {0.4, 0.05, 0.4}) - water * g * 1.55));
    }
    return largest / (water * g * 1.55);
  };
  EXPECT_LT(swing(true), 0.5 / 15.5);
  EXPECT_GT(swing(false), 0.5);
}

/// The fastest particle of a tank of water of this width and 1 m of depth within 0.3 s [m/s].
double fastest(Vec3d size, const ForceFieldDesc* field = nullptr) {
  WorldDesc d = box(true);
  d.domain.max = size;
  World w = std::move(*World::create(d));
  fill(w, liquid(w, "water", water), {0, 0, 0}, {size.x, 1, size.z});
  if (field != nullptr) require(w.add_force_field(*field));
  double most = 0;
  for (int k = 0; k < 60; ++k) {
    require(w.step(0.005));
    most = std::max(most, w.synchronize().max_speed);
  }
  return most;
}

// Cells are longer or shorter than a spacing where a tank is no whole number of them wide. Taken for even ones their layers moved at
// 0.07 to 0.2 m/s; even ones do at 3e-4, which single precision leaves. The last has columns that two numbers of a spacing's grid would share.
TEST(HydrostaticStart, ATankOfAnyWidthIsAtRest) {
  MELTSIM_NEEDS_BACKEND();
  for (const Vec3d size : {Vec3d{0.8, 1.6, 0.8}, Vec3d{0.82, 1.6, 0.82}, Vec3d{0.84, 1.6, 0.8},
                           Vec3d{0.8, 1.6, 0.85}, Vec3d{0.87, 1.6, 0.93}, Vec3d{3.16, 1.6, 0.8}})
    EXPECT_LT(fastest(size), 2e-3) << size.x << " " << size.z;
}

// A field adds to gravity where it acts, and changes nothing where it does not: layers moved at 0.05 m/s once there was one.
TEST(HydrostaticStart, FieldsLeaveLiquidAtRest) {
  MELTSIM_NEEDS_BACKEND();
  ForceFieldDesc none, down, wind, above;
  down.acceleration = {0, -4, 0};
  wind.kind = ForceFieldKind::drag;
  wind.rate = 5;
  above.shape = Shape::box({0, 1.3, 0}, {0.8, 1.6, 0.8});  // in the air
  above.acceleration = {0, 0, 1};
  for (const ForceFieldDesc& field : {none, down, wind, above})
    EXPECT_LT(fastest({0.8, 1.6, 0.8}, &field), 2e-3) << static_cast<int>(field.kind) << field.acceleration.y;
}

TEST(HydrostaticStart, EachLiquidPressesWithItsOwnWeight) {
  MELTSIM_NEEDS_BACKEND();
  World w = std::move(*World::create(box(true)));
  fill(w, liquid(w, "brine", 1200), {0, 0, 0}, {0.8, 0.8, 0.8});
  fill(w, liquid(w, "oil", 600), {0, 0.8, 0}, {0.8, 1.6, 0.8});
  EXPECT_NEAR(pressure(w, {0.4, 0.05, 0.4}), g * (1200 * 0.75 + 600 * 0.8), 1200 * g * dx / 2);
  EXPECT_NEAR(pressure(w, {0.4, 0.85, 0.4}), g * 600 * 0.75, 1200 * g * dx / 2);
}

// A column that stands in a shallow bed presses on its own floor, not on that of the bed.
TEST(HydrostaticStart, LevelsBesideEachOtherKeepTheirPressures) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = box(true);
  d.domain.max = {3.2, 2.4, 0.8};
  World w = std::move(*World::create(d));
  const MaterialId m = liquid(w, "water", water);
  fill(w, m, {0, 0, 0}, {1.6, 1.6, 0.8});
  fill(w, m, {1.6, 0, 0}, {3.2, 0.4, 0.8});
  EXPECT_NEAR(pressure(w, {0.8, 0.05, 0.4}), water * g * 1.55, water * g * dx / 2);
  EXPECT_NEAR(pressure(w, {2.4, 0.05, 0.4}), water * g * 0.35, water * g * dx / 2);
}

// The liquid below a body or a lid has the pressure of the level beside it.
TEST(HydrostaticStart, BelowABodyTheLevelBesideItHolds) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = box(true);
  d.domain.max = {1.6, 2.4, 0.8};
  World w = std::move(*World::create(d));
  MaterialDesc stone;
  stone.name = "stone";
  SolidDesc s;
  s.material = *w.add_material(stone);
  s.fixed = true;
  s.shape = Shape::box({0, 0.8, 0}, {0.8, 2.4, 0.8});  // a gap beneath
  require(w.add_solid(s));
  fill(w, liquid(w, "water", water), {0, 0, 0}, {1.6, 1.6, 0.8});
  EXPECT_NEAR(pressure(w, {0.4, 0.25, 0.4}), water * g * 1.35, water * g * dx / 2);
  EXPECT_NEAR(pressure(w, {1.2, 0.25, 0.4}), water * g * 1.35, water * g * dx / 2);
}

// Columns are found by counting where they are many, else by comparing; what lies in one may come in any order.
TEST(HydrostaticStart, ColumnsAreTheSameInWhateverOrderTheirLiquidCame) {
  MELTSIM_NEEDS_BACKEND();
  const auto heights = [](bool upper_first) {
    World w = std::move(*World::create(box(true)));
    const MaterialId m = liquid(w, "water", water);
    for (const bool upper : {upper_first, !upper_first})
      fill(w, m, {0, upper ? 0.8 : 0.0, 0}, {0.8, upper ? 1.6 : 0.8, 0.8});
    std::vector<double> y;
    for (const Vec3d& x : places(w)) y.push_back(x.y);
    std::sort(y.begin(), y.end());
    return y;
  };
  const std::vector<double> y = heights(false);
  EXPECT_LT(y.front(), 0.05) << "compressed";
  EXPECT_EQ(y, heights(true));
}

TEST(HydrostaticStart, ColumnsFarApartAreLikeOthers) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = box(true);
  d.domain.max = {40, 2.4, 40};
  World w = std::move(*World::create(d));
  const MaterialId m = liquid(w, "water", water);
  fill(w, m, {0, 0, 0}, {0.2, 1.6, 0.2});
  fill(w, m, {39.8, 0, 39.8}, {40, 1.6, 40});
  std::vector<double> near, far;
  for (const Vec3d& x : places(w)) (x.x < 1 ? near : far).push_back(x.y);
  ASSERT_EQ(near.size(), 2u * 16 * 2);
  EXPECT_LT(*std::max_element(near.begin(), near.end()), 1.55 - 1e-4) << "compressed, all that is below";
  EXPECT_EQ(near, far);
}

// Layers above a body are as those above liquid, however few they are: what the steps and corners of bodies leave out of balance is no
// faster than what has fallen by a fifth of a spacing. 0.02 s are six times that in which sound crosses the tank.
TEST(HydrostaticStart, LiquidOverBodiesIsAtRestAtEveryDepth) {
  MELTSIM_NEEDS_BACKEND();
  for (const bool round : {false, true})
    for (int layers = 1; layers <= 12; ++layers) {
      World w = std::move(*World::create(box(true)));
      MaterialDesc stone;
      stone.name = "stone";
      SolidDesc s;
      s.material = *w.add_material(stone);
      s.fixed = true;
      s.shape = round ? Shape::sphere({0.4, 0.3, 0.4}, 0.3) : Shape::box({0.2, 0.2, 0.2}, {0.6, 0.6, 0.6});
      require(w.add_solid(s));
      fill(w, liquid(w, "water", water), {0, 0, 0}, {0.8, 0.6 + dx * layers, 0.8});
      require(w.step(0.02));
      EXPECT_LT(w.synchronize().max_speed, std::sqrt(2 * g * dx / 5)) << layers << " layers";
    }
}

/// A box that is full.
World full(bool tension, bool at_rest) {
  WorldDesc d = box(at_rest);
  d.tension = tension;
  d.domain.max = {0.8, 1.6, 0.8};
  World w = std::move(*World::create(d));
  fill(w, liquid(w, "water", water), {0, 0, 0}, {0.8, 1.6, 0.8});
  return w;
}

// Without tension liquid leaves the lid by what it is compressed, with tension half of it pulls. A layer is what a reading may be off by,
// as its neighbour in the lid is an image.
TEST(HydrostaticStart, AFullBoxPressesOnItsFloorOrPullsAtItsLid) {
  MELTSIM_NEEDS_BACKEND();
  for (const bool tension : {false, true}) {
    World w = full(tension, true), ringing = full(tension, false);
    const double above = tension ? 0.8 : 1.6;  // the floor, where pressure is 0
    EXPECT_NEAR(pressure(w, {0.4, 0.05, 0.4}), water * g * (above - 0.05), water * g * dx) << tension;
    EXPECT_NEAR(pressure(w, {0.4, 1.25, 0.4}), water * g * (above - 1.25), water * g * dx) << tension;
    double fastest[2] = {};
    for (int k = 0; k < 20; ++k)
      for (World* which : {&w, &ringing}) {
        require(which->step(0.005));
        double& most = fastest[which == &w ? 0 : 1];
        most = std::max(most, which->totals()->max_speed);
      }
    EXPECT_LT(fastest[0], 0.5 * fastest[1])
        << tension;  // images in a lid lack weight, as those in floors do not
  }
}

TEST(HydrostaticStart, WhatFallsHasNoPressure) {
  MELTSIM_NEEDS_BACKEND();
  std::vector<double> there[2];
  for (const bool at_rest : {false, true}) {
    World w = std::move(*World::create(box(at_rest)));
    fill(w, liquid(w, "water", water), {0, 0.8, 0}, {0.8, 1.6, 0.8});
    for (const Vec3d& x : places(w)) there[at_rest ? 1 : 0].push_back(x.y);
  }
  EXPECT_EQ(there[0], there[1]);
}

/// A pool of half a box of 1.6 m, at the face to which gravity points.
struct Pool {
  Vec3d gravity, low, high;
  int axis;
  bool from_above;  ///< that face is the upper one
};

std::vector<double> heights(const Pool& p) {
  WorldDesc d = box(true);
  d.domain.max = {1.6, 1.6, 1.6};
  d.gravity = p.gravity;
  World w = std::move(*World::create(d));
  fill(w, liquid(w, "water", water), p.low, p.high);
  std::vector<double> h;
  for (const Vec3d& x : places(w)) {
    const double at = p.axis == 0 ? x.x : p.axis == 1 ? x.y : x.z;
    h.push_back(p.from_above ? 1.6 - at : at);
  }
  std::sort(h.begin(), h.end());
  return h;
}

// Turned, the same pool has the same heights above its floor, to rounding.
TEST(HydrostaticStart, GravityMayPointAnywhere) {
  MELTSIM_NEEDS_BACKEND();
  const std::vector<double> down = heights({{0, -g, 0}, {0, 0, 0}, {1.6, 0.8, 1.6}, 1, false});
  for (const Pool& p : {Pool{{-g, 0, 0}, {0, 0, 0}, {0.8, 1.6, 1.6}, 0, false},
                        Pool{{0, 0, g}, {0, 0, 0.8}, {1.6, 1.6, 1.6}, 2, true}}) {
    const std::vector<double> turned = heights(p);
    ASSERT_EQ(turned.size(), down.size());
    for (std::size_t i = 0; i < down.size(); ++i) ASSERT_NEAR(turned[i], down[i], 1e-6);
  }
}

// What was read or saved in between changes nothing: liquid is compressed anew with what was added since.
TEST(HydrostaticStart, WhatIsAddedLaterCounts) {
  MELTSIM_NEEDS_BACKEND();
  std::uint64_t hash[2];
  for (const bool looked : {false, true}) {
    World w = std::move(*World::create(box(true)));
    const MaterialId m = liquid(w, "water", water);
    fill(w, m, {0, 0, 0}, {0.8, 0.8, 0.8});
    if (looked) {
      EXPECT_LT(places(w).back().y, 0.75);
    }
    fill(w, m, {0, 0.8, 0}, {0.8, 1.6, 0.8});
    require(w.prepare());
    hash[looked ? 1 : 0] = *w.state_hash();
  }
  EXPECT_EQ(hash[0], hash[1]);
}

TEST(HydrostaticStart, GravityThatChangesBeforeTheFirstStepCounts) {
  MELTSIM_NEEDS_BACKEND();
  World w = std::move(*World::create(box(true)));
  fill(w, liquid(w, "water", water), {0, 0, 0}, {0.8, 0.8, 0.8});
  const double top = 0.75;
  EXPECT_LT(places(w).back().y, top - 0.001);
  require(w.set_gravity({0, 0, 0}));
  EXPECT_NEAR(places(w).back().y, top, 1e-7);  // rounding of single precision
}

// What makes sound faster before the first step makes liquid stiffer: less compressed, whether or not somebody looked before, and
// whatever is refused after.
TEST(HydrostaticStart, AFasterSoundBeforeTheFirstStepCounts) {
  MELTSIM_NEEDS_BACKEND();
  for (const std::string what : {"body", "nozzle", "tension"}) {
    std::uint64_t hash[2];
    for (const bool looked : {false, true}) {
      World w = std::move(*World::create(box(true)));
      MaterialDesc m;
      m.name = "water";
      m.surface_tension = 0.07;
      const MaterialId material = *w.add_material(m);
      fill(w, material, {0, 0, 0}, {0.8, 0.8, 0.8});
      SolidDesc stone;
      stone.name = "stone";
      stone.material = material;
      stone.shape = Shape::box({0.3, 1.6, 0.3}, {0.5, 1.8, 0.5});
      const auto body = w.add_solid(stone);
      require(body);
      EmitterDesc e;
      e.material = material;
      e.center = {0.4, 2.1, 0.4};
      e.axis = {1, 0, 0};
      e.radius = 0.1;
      e.speed = 1;
      e.max_particles = 50;
      const auto nozzle = w.add_emitter(e);
      require(nozzle);
      const double before = looked ? places(w)[511].y : 0;  // of the topmost layer
      EmitterSetting faster;
      faster.speed = 40;
      m.surface_tension = 1e5;
      if (what == "body") require(w.set_velocity(*body, {0, 0, 40}));
      if (what == "nozzle") require(w.set_emitter(*nozzle, faster));
      if (what == "tension") require(w.set_material(material, m));
      const double after = places(w)[511].y;
      if (looked) {
        EXPECT_GT(after, before + 1e-4) << what;
      }
      hash[looked ? 1 : 0] = *w.state_hash();
      stone.name = "another";
      EXPECT_FALSE(w.add_solid(stone));  // where the first one is
      EXPECT_EQ(places(w)[511].y, after) << what;
      EXPECT_EQ(*w.state_hash(), hash[looked ? 1 : 0]) << what;
    }
    EXPECT_EQ(hash[0], hash[1]) << what;
  }
}

// A snapshot of the start is compressed; who restores it does not compress it again.
// What was added here is not what a snapshot of the start brings: a body that is put into it displaces that.
TEST(HydrostaticStart, ASnapshotBringsItsOwnLiquid) {
  MELTSIM_NEEDS_BACKEND();
  World small = std::move(*World::create(box(true))), large = std::move(*World::create(box(true)));
  fill(small, liquid(small, "water", water), {0, 0, 0}, {0.8, 0.4, 0.8});
  const MaterialId material = liquid(large, "water", water);
  fill(large, material, {0, 0, 0}, {0.8, 1.6, 0.8});
  const auto bytes = small.snapshot();
  require(bytes);
  require(large.restore(bytes->data(), bytes->size()));
  SolidDesc stone;
  stone.shape = Shape::box({0.2, 0, 0.2}, {0.6, 0.2, 0.6});
  stone.material = material;
  stone.motion = Motion::fixed;
  require(large.add_solid(stone));
  require(large.step(1e-4));
  EXPECT_EQ(large.synchronize().fluid, 8u * 4 * 8 - 4 * 2 * 4);
}

TEST(HydrostaticStart, SnapshotsOfTheStartAreTheStart) {
  MELTSIM_NEEDS_BACKEND();
  const auto tank = [] {
    World w = std::move(*World::create(box(true)));
    fill(w, liquid(w, "water", water), {0, 0, 0}, {0.8, 1.6, 0.8});
    return w;
  };
  World a = tank(), b = tank();
  const auto saved = a.snapshot();
  ASSERT_TRUE(saved);
  require(b.restore(saved->data(), saved->size()));
  EXPECT_EQ(*a.state_hash(), *b.state_hash());
  require(a.step(0.01));
  require(b.step(0.01));
  EXPECT_EQ(*a.state_hash(), *b.state_hash());
  require(a.restore(saved->data(), saved->size()));
  require(a.step(0.01));
  EXPECT_EQ(*a.state_hash(), *b.state_hash());
}

}  // namespace
}  // namespace meltsim_test
