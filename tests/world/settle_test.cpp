// SPDX-License-Identifier: Apache-2.0
// Liquid that comes to rest before the first step (World::settle).
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double dx = 0.1, g = 9.81, water = 1000;

/// A tank of 1.2 x 1.2 m, without heat.
WorldDesc tank() {
  WorldDesc d = describe();
  d.spacing = dx;
  d.heat.model = HeatModel::none;
  d.domain.bounded = true;
  d.domain.min = {0, 0, 0};
  d.domain.max = {1.2, 2, 1.2};
  d.gravity = {0, -g, 0};
  return d;
}

MaterialId material(World& w, const std::string& name, double density) {
  MaterialDesc m;
  m.name = name;
  m.density = density;
  return *w.add_material(m);
}

void fill(World& w, MaterialId m, const Vec3d& low, const Vec3d& high, const Vec3d& velocity = {}) {
  FluidDesc f;
  f.material = m;
  f.shape = Shape::box(low, high);
  f.velocity = velocity;
  require(w.add_fluid(f));
}

BodyId fixed_block(World& w, MaterialId m, const Vec3d& low, const Vec3d& high) {
  SolidDesc s;
  s.material = m;
  s.shape = Shape::box(low, high);
  s.motion = Motion::fixed;
  return *w.add_solid(s);
}

/// Least and largest of what pushes a body up in the first tenth of a second, as shares of `right` [N].
struct Swing {
  double least = infinity, most = -infinity;
};
Swing push_on(World& w, BodyId body, double right) {
  require(w.watch_forces(body, true));
  Swing swing;
  for (int k = 0; k < 20; ++k) {
    require(w.step(0.005));
    const BodyForces f = w.take_forces()->at(0);
    const double share = f.total.linear.y / f.seconds / right;
    swing.least = std::min(swing.least, share);
    swing.most = std::max(swing.most, share);
  }
  return swing;
}

// A cube of 4 spacings under water, and a lid over half of a tank whose other half is higher. Right is what displaced water weighs, and
// what pressure under the lid amounts to. Within 5 %: pressure at a face is read in steps of a layer, a fifth of which is that of 1.2 m. What
// is left alone swings by a third at least.
TEST(Settle, ForcesAreThoseOfRestFromTheFirstStep) {
  MELTSIM_NEEDS_BACKEND();
  constexpr double near = 0.05, swings = 0.3;
  const auto cube = [](bool at_rest) {
    World w = std::move(*World::create(tank()));
    const BodyId body = fixed_block(w, material(w, "rock", 2500), {0.4, 0.4, 0.4}, {0.8, 0.8, 0.8});
    fill(w, material(w, "water", water), {0, 0, 0}, {1.2, 1.2, 1.2});
    if (at_rest) require(w.settle());
    return push_on(w, body, water * g * 0.4 * 0.4 * 0.4);
  };
  const auto lid = [](bool at_rest) {
    World w = std::move(*World::create(tank()));
    const BodyId body = fixed_block(w, material(w, "rock", 2500), {0, 0.6, 0}, {0.6, 1.6, 1.2});
    const MaterialId m = material(w, "water", water);
    fill(w, m, {0, 0, 0}, {0.6, 0.6, 1.2});
    fill(w, m, {0.6, 0, 0}, {1.2, 1.4, 1.2});
    if (at_rest) require(w.settle());
    return push_on(w, body, water * g * 0.8 * 0.6 * 1.2);
  };
  const Swing cube_rests = cube(true), cube_rings = cube(false), lid_rests = lid(true),
              lid_rings = lid(false);
  EXPECT_GT(cube_rests.least, 1 - near);
  EXPECT_LT(cube_rests.most, 1 + near);
  EXPECT_GT(lid_rests.least, 1 - near);
  EXPECT_LT(lid_rests.most, 1 + near);
  EXPECT_LT(cube_rings.least, 1 - swings);
  EXPECT_LT(lid_rings.least, 1 - swings);
}

/// A pool with a floating block, a turning stirrer, a drop in the air and a jet above it; hot, with what heats, pours and blows.
struct Busy {
  World world;
  BodyId ice;
};
Busy busy() {
  WorldDesc d = tank();
  d.heat.model = HeatModel::enthalpy;
  Busy b{std::move(*World::create(d)), {}};
  World& w = b.world;
  const MaterialId m = material(w, "water", water);
  MaterialDesc ice;
  ice.name = "ice";
  ice.density = 917;
  ice.melting_point = 0;
  ice.latent_heat = 3e5;
  ice.melts_into = m;
  ice.conductivity = 2.2;
  ice.heat_capacity = 2100;
  SolidDesc s;
  s.material = *w.add_material(ice);
  s.shape = Shape::box({0.2, 0.3, 0.2}, {0.6, 0.7, 0.6});
  s.temperature = -5;
  s.velocity = {0, -0.3, 0};
  b.ice = *w.add_solid(s);
  SolidDesc stirrer;
  stirrer.material = material(w, "steel", 7800);
  stirrer.shape = Shape::box({0.8, 0.2, 0.4}, {0.9, 0.5, 0.8});
  stirrer.motion = Motion::kinematic;
  stirrer.angular_velocity = {0, 2, 0};
  require(w.add_solid(stirrer));
  fill(w, m, {0, 0, 0}, {1.2, 0.6, 1.2});
  fill(w, m, {0.2, 1.2, 0.2}, {0.4, 1.4, 0.4});
  fill(w, m, {0.8, 1.2, 0.8}, {1.0, 1.4, 1.0}, {0, 0, -1});
  EmitterDesc e;
  e.material = m;
  e.center = {0.6, 1.8, 0.6};
  e.axis = {0, -1, 0};
  e.radius = 0.15;
  e.speed = 1;
  e.until = 0.5;
  require(w.add_emitter(e));
  HeatRegionDesc hot;
  hot.shape = Shape::box({0, 0, 0}, {1.2, 0.3, 1.2});
  hot.source = 1e6;
  require(w.add_heat_region(hot));
  ForceFieldDesc wind;
  wind.kind = ForceFieldKind::drag;
  wind.rate = 50;
  wind.center = Vec3d{};
  wind.velocity = {3, 0, 0};
  require(w.add_force_field(wind));
  return b;
}

// Bodies, what falls and what moves stay where they are; so do temperatures, velocities, clock and ledger. Only the pool moves: by some, and
// hundredths of a spacing, as bodies in it are no liquid.
TEST(Settle, NothingElseChanges) {
  MELTSIM_NEEDS_BACKEND();
  Busy b = busy();
  World& w = b.world;
  const auto was = w.particles();
  const auto settled = w.settle();
  ASSERT_TRUE(settled) << settled.error().message;
  EXPECT_GT(settled->farthest, 0.001 * dx);
  EXPECT_LT(settled->farthest, 0.5 * dx);
  EXPECT_EQ(w.time(), 0);
  EXPECT_EQ(w.steps(), 0u);
  const auto now = w.particles();
  ASSERT_EQ(now->id, was->id);
  EXPECT_EQ(now->tag, was->tag);
  EXPECT_EQ(now->temperature, was->temperature);
  EXPECT_EQ(now->mass, was->mass);
  std::size_t moved = 0;
  for (std::size_t i = 0; i < now->id.size(); ++i) {
    EXPECT_EQ(length(now->velocity[i] - was->velocity[i]), 0) << i;
    const bool elsewhere = length(now->position[i] - was->position[i]) > 0;
    moved += elsewhere ? 1 : 0;
    EXPECT_FALSE(elsewhere && (!is_fluid(now->tag[i]) || was->position[i].y > 0.7)) << i;
  }
  EXPECT_GT(moved, 500u);
  EXPECT_EQ(w.ledger()->heat_in, 0);
  const auto height = [&] {
    const auto pieces = w.pieces();
    for (const PieceInfo& piece : *pieces)
      if (piece.body == b.ice) return piece.center.y;
    return infinity;
  };
  const double y = height();
  require(w.step(0.02));  // it was held, and is not any more
  EXPECT_LT(height(), y - 0.0005);
  EXPECT_GT(w.ledger()->heat_in, 0);
}

// It repeats to the bit, a snapshot of it continues to the bit, and a second call holds what hangs as the first did.
TEST(Settle, IsAStateAsAnyOther) {
  MELTSIM_NEEDS_BACKEND();
  Busy a = busy(), b = busy();
  require(a.world.settle());
  require(b.world.settle());
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
  const auto bytes = a.world.snapshot();
  require(a.world.step(0.01));
  Busy c = busy();
  require(c.world.restore(bytes->data(), bytes->size()));
  require(c.world.step(0.01));
  EXPECT_EQ(*a.world.state_hash(), *c.world.state_hash());
  const auto second = b.world.settle();
  ASSERT_TRUE(second);
  EXPECT_LT(second->farthest, 0.01 * dx);  // what hangs would fall by half a spacing
}

// Faces that liquid would leave through hold it meanwhile.
TEST(Settle, NothingLeavesThroughOpenFaces) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = tank();
  d.domain.faces[1] = Face::open;
  World w = std::move(*World::create(d));
  fill(w, material(w, "water", water), {0, 0, 0}, {1.2, 0.6, 1.2});
  const std::uint64_t particles = w.synchronize().fluid;
  EXPECT_LT(w.settle()->farthest, 0.1 * dx);  // it would flow for two thirds of a spacing
  EXPECT_EQ(w.synchronize().fluid, particles);
  EXPECT_EQ(w.synchronize().removed, 0u);
  require(w.step(0.1));
  require(w.step(0.1));
  EXPECT_GT(w.synchronize().removed, 0u);
}

// What a host has of the backend's memory is of before.
TEST(Settle, EndsViewsAndSavedStates) {
  MELTSIM_NEEDS_BACKEND();
  Busy b = busy();
  require(b.world.prepare());
  require(b.world.save_state(0));
  const auto state = b.world.device_state();
  const auto surface = b.world.surface_view({});
  ASSERT_TRUE(state && surface);
  require(b.world.check_view(*surface));
  require(b.world.settle());
  EXPECT_FALSE(b.world.check_view(*state));
  EXPECT_FALSE(b.world.check_view(*surface));
  EXPECT_FALSE(b.world.load_state(0));
}

TEST(Settle, RefusesWhatMakesNoSense) {
  MELTSIM_NEEDS_BACKEND();
  World w = std::move(*World::create(tank()));
  EXPECT_EQ(w.settle()->seconds, 0);  // nothing is there
  fill(w, material(w, "water", water), {0, 0, 0}, {1.2, 0.6, 1.2});
  const std::uint64_t hash = *w.state_hash();
  for (const double wrong : {-1.0, infinity, std::numeric_limits<double>::quiet_NaN()}) {
    const auto s = w.settle(wrong);
    ASSERT_FALSE(s);
    EXPECT_NE(s.error().message.find("settle: seconds:"), std::string::npos) << s.error().message;
  }
  const auto long_rest = w.settle(1e9);
  ASSERT_FALSE(long_rest);
  EXPECT_NE(long_rest.error().message.find("more than 100000"), std::string::npos)
      << long_rest.error().message;
  w.interrupt();
  const auto s = w.settle();
  ASSERT_FALSE(s);
  EXPECT_EQ(s.error().code, ErrorCode::interrupted);
  EXPECT_EQ(*w.state_hash(), hash);
  EXPECT_EQ(w.settle(0.01)->seconds, 0.01);  // one call of interrupt() ends one
  require(w.step(0.001));
  const auto late = w.settle();
  ASSERT_FALSE(late);
  EXPECT_NE(late.error().message.find("before the first"), std::string::npos) << late.error().message;
}

}  // namespace
}  // namespace meltsim_test
