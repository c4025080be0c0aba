// SPDX-License-Identifier: Apache-2.0
// Nozzles that go on for ever: what has left comes again.
#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double pi = 3.14159265358979323846, dx = 0.1, speed = 2, radius = 0.15;
constexpr int per_layer = 8;                                                    // pi 1.5^2 = 7.07 spacings^2
constexpr double distance = per_layer * dx * dx * dx / (pi * radius * radius);  // from layer to layer [m]

/// A shaft with a nozzle at its top and an open floor.
struct Fountain {
  World world;
  EmitterId jet;
  MaterialId water;
};

Fountain fountain(bool recycle, std::uint64_t most, double gravity = 0) {
  WorldDesc d = describe();
  d.spacing = dx;
  d.domain.bounded = true;
  d.domain.max = {1.2, 1.2, 1.2};
  d.domain.faces[2] = Face::open;
  d.gravity = {0, gravity, 0};
  d.sound_speed = 40;
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  Fountain f{std::move(*w), {}, {}};
  f.water = *f.world.add_material({});
  EmitterDesc e;
  e.name = "jet";
  e.material = f.water;
  e.center = {0.6, 1.0, 0.6};
  e.axis = {0, -1, 0};
  e.radius = radius;
  e.speed = speed;
  e.recycle = recycle;
  e.max_particles = most;
  auto jet = f.world.add_emitter(e);
  EXPECT_TRUE(jet) << jet.error().message;
  f.jet = *jet;
  return f;
}

/// Heights of all particles, lowest first.
std::vector<double> heights(World& w) {
  const ParticleData p = *w.particles();
  std::vector<double> y;
  for (const Vec3d& x : p.position) y.push_back(x.y);
  std::sort(y.begin(), y.end());
  return y;
}

std::uint64_t layers_before(double t) { return static_cast<std::uint64_t>(std::ceil(t * speed / distance)); }

// In free flight the shaft holds the layers of half a second: 10. Three seconds bring 53, through ids for 12.
TEST(Recycle, AStreamGoesOnForEverInThePlaceOfWhatHasLeft) {
  MELTSIM_NEEDS_BACKEND();
  Fountain a = fountain(true, 12 * per_layer), b = fountain(false, 10000);
  for (int k = 0; k < 300; ++k) {
    require(a.world.step(0.01));
    require(b.world.step(0.01));
    if (k % 30 != 29) continue;
    const StepResult r = a.world.synchronize(), plain = b.world.synchronize();
    ASSERT_FALSE(r.halted) << r.halt_reason;
    EXPECT_FALSE(r.emitter_exhausted);
    EXPECT_EQ(r.entered, per_layer * layers_before(a.world.time()));
    EXPECT_EQ(r.entered - r.removed, r.fluid);
    EXPECT_EQ(r.fluid, plain.fluid);
    EXPECT_EQ(r.removed, plain.removed);
    // A layer of the one is put where that of the other has moved to by then: rounding of a metre, as often as there are sub-steps.
    const auto y = heights(a.world), as = heights(b.world);
    ASSERT_EQ(y.size(), as.size());
    for (std::size_t i = 0; i < y.size(); ++i) EXPECT_NEAR(y[i], as[i], 1e-4);
  }
  const ParticleData p = *a.world.particles();
  std::set<std::uint32_t> ids(p.id.begin(), p.id.end());
  EXPECT_EQ(ids.size(), p.id.size());
  EXPECT_LT(*ids.rbegin(), 12u * per_layer);
  EXPECT_NEAR(a.world.totals()->mass, double(p.id.size()) * 1000 * dx * dx * dx, 1e-4);  // float masses
}

// Without a limit there are ids for as many as fill the domain: 12^3.
TEST(Recycle, HasIdsForAsManyAsFillTheDomain) {
  MELTSIM_NEEDS_BACKEND();
  Fountain f = fountain(true, 0, -9.81);
  for (int k = 0; k < 25; ++k) require(f.world.step(0.01));  // none has left: that takes 0.29 s
  EXPECT_FALSE(f.world.synchronize().emitter_exhausted);
  EXPECT_EQ(f.world.ledger()->fluid, per_layer * layers_before(0.25));
  FluidDesc more;
  more.material = f.water;
  more.shape = Shape::box({0, 0.2, 0}, {0.2, 0.4, 0.2});
  const auto added = f.world.add_fluid(more);
  require(added);
  ASSERT_EQ(*added, 8u);
  const ParticleData p = *f.world.particles();
  EXPECT_EQ(*std::max_element(p.id.begin(), p.id.end()), 12u * 12 * 12 + 7);  // behind the reserve
}

// Ids for five layers where ten are on their way: those there are come, and the World says so. What the host takes out comes again.
TEST(Recycle, OfTooFewIdsThoseComeThatAreFree) {
  MELTSIM_NEEDS_BACKEND();
  const std::uint64_t most = 5 * per_layer + 3;
  Fountain f = fountain(true, most);
  for (int k = 0; k < 40; ++k) require(f.world.step(0.01));
  StepResult r = f.world.synchronize();
  ASSERT_FALSE(r.halted) << r.halt_reason;
  EXPECT_TRUE(r.emitter_exhausted);
  EXPECT_EQ(r.fluid, most);
  EXPECT_EQ(r.entered, most);
  require(f.world.remove_liquid(Shape::box({0, 0, 0}, {1.2, 1.2, 1.2})));
  EXPECT_EQ(f.world.synchronize().fluid, 0u);
  for (int k = 0; k < 40; ++k) require(f.world.step(0.01));
  r = f.world.synchronize();
  EXPECT_EQ(r.fluid, most);
  EXPECT_EQ(r.entered, 2 * most);
  EXPECT_EQ(r.removed, most);
  for (int k = 0; k < 200; ++k) require(f.world.step(0.01));  // leaves, and comes again
  r = f.world.synchronize();
  ASSERT_FALSE(r.halted) << r.halt_reason;
  EXPECT_LE(r.fluid, most);
  EXPECT_GT(r.entered, 4 * most);
}

// Like what any nozzle holds: it moves with it, and none comes while it is off.
TEST(Recycle, FollowsItsSettings) {
  MELTSIM_NEEDS_BACKEND();
  Fountain f = fountain(true, 12 * per_layer);
  for (int k = 0; k < 100; ++k) require(f.world.step(0.01));
  EmitterSetting off;
  off.on = false;
  require(f.world.set_emitter(f.jet, off));
  for (int k = 0; k < 100; ++k) require(f.world.step(0.01));
  EXPECT_EQ(f.world.synchronize().fluid, 0u);
  const std::uint64_t before = f.world.synchronize().entered;
  EmitterSetting on;
  on.on = true;
  on.center = Vec3d{0.4, 0.8, 0.6};
  on.temperature = 50;
  on.speed = 1;
  require(f.world.set_emitter(f.jet, on));
  for (int k = 0; k < 30; ++k) require(f.world.step(0.01));
  const StepResult r = f.world.synchronize();
  ASSERT_FALSE(r.halted) << r.halt_reason;
  EXPECT_NEAR(double(r.entered - before), per_layer * 0.3 / distance, per_layer);
  const ParticleData p = *f.world.particles();
  ASSERT_FALSE(p.position.empty());
  for (std::size_t i = 0; i < p.position.size(); ++i) {
    EXPECT_NEAR(p.position[i].x, 0.4, radius);
    EXPECT_NEAR(p.velocity[i].y, -1, 1e-5);
    EXPECT_NEAR(p.temperature[i], 50, 1e-3);
  }
}

TEST(Recycle, ASnapshotGoesOnToTheSameBits) {
  MELTSIM_NEEDS_BACKEND();
  Fountain f = fountain(true, 12 * per_layer, -1), other = fountain(true, 12 * per_layer, -1);
  for (int k = 0; k < 120; ++k) require(f.world.step(0.01));
  const auto bytes = f.world.snapshot();
  require(bytes);
  require(f.world.save_state(0));
  require(other.world.restore(bytes->data(), bytes->size()));
  const auto go_on = [](World& w) {
    for (int k = 0; k < 80; ++k) require(w.step(0.01));
    return *w.state_hash();
  };
  const auto hash = go_on(f.world);
  EXPECT_EQ(go_on(other.world), hash);
  require(f.world.load_state(0));
  EXPECT_EQ(go_on(f.world), hash);
  Fountain fewer = fountain(true, 11 * per_layer, -1);
  const Status refused = fewer.world.restore(bytes->data(), bytes->size());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("may have 88 particles"), std::string::npos)
      << refused.error().message;
}

// What stays in the World, frozen or at rest, is not taken from it: a tray fills until the ids are used up.
TEST(Recycle, WhatStaysIsNotTaken) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = dx;
  d.domain.bounded = true;
  d.domain.max = {0.8, 1.2, 0.8};
  auto w = World::create(d);
  require(w);
  EmitterDesc e;
  e.material = *w->add_material({});
  e.center = {0.4, 1.0, 0.4};
  e.radius = radius;
  e.speed = speed;
  e.recycle = true;
  e.max_particles = 100;
  require(w->add_emitter(e));
  for (int k = 0; k < 300; ++k) require(w->step(0.01));
  const StepResult r = w->synchronize();
  ASSERT_FALSE(r.halted) << r.halt_reason;
  EXPECT_EQ(r.fluid, 100u);
  EXPECT_EQ(r.entered, 100u);
  EXPECT_TRUE(r.emitter_exhausted);
}

TEST(Recycle, SaysWhatItCannotDo) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = dx;
  auto open = World::create(d);
  require(open);
  EmitterDesc e;
  e.material = *open->add_material({});
  e.radius = radius;
  e.recycle = true;
  auto refused = open->add_emitter(e);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("without bounds needs a limit"), std::string::npos)
      << refused.error().message;
  e.max_particles = 5;
  refused = open->add_emitter(e);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("less than one layer of the nozzle (8 particles)"),
            std::string::npos)
      << refused.error().message;
  e.max_particles = 50;
  for (int k = 0; k < 8; ++k) {
    e.center = {double(k), 0, 0};
    require(open->add_emitter(e));
  }
  e.center = {9, 0, 0};
  refused = open->add_emitter(e);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::capacity);
  e.level = 1;
  e.radius = 0;
  e.center = {};
  refused = open->add_emitter(e);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("recycle: "), std::string::npos) << refused.error().message;
}

}  // namespace
}  // namespace meltsim_test
