// SPDX-License-Identifier: Apache-2.0
// A teleport into liquid: what the body would bury goes to the nearest free places around it.
#include <cmath>
#include <limits>
#include <string>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double dx = 0.1;

WorldDesc tank(Vec3d size) {
  WorldDesc d = describe();
  d.spacing = dx;
  d.heat.model = HeatModel::none;
  d.domain.bounded = true;
  d.domain.max = size;
  return d;
}

struct Pool {
  World world;
  MaterialId water, stone;
  BodyId box;  ///< kinematic, 4 x 4 x 4
};

/// Water up to `depth` and a box of stone in a corner above it.
Pool pool(double depth, Vec3d size = {1.2, 1.6, 1.2}, double high = 1.1) {
  auto made = World::create(tank(size));
  EXPECT_TRUE(made) << made.error().message;
  Pool p{std::move(*made), {}, {}, {}};
  p.water = *p.world.add_material({});
  MaterialDesc stone;
  stone.name = "stone";
  stone.density = 2000;
  p.stone = *p.world.add_material(stone);
  FluidDesc f;
  f.material = p.water;
  f.shape = Shape::box({0, 0, 0}, {size.x, depth, size.z});
  require(p.world.add_fluid(f));
  SolidDesc s;
  s.name = "box";
  s.material = p.stone;
  s.shape = Shape::box({0.1, high, 0.1}, {0.5, high + 0.4, 0.5});
  s.motion = Motion::kinematic;
  const auto id = p.world.add_solid(s);
  EXPECT_TRUE(id) << id.error().message;
  p.box = *id;
  return p;
}

BodyMotion jump(Vec3d to) {
  BodyMotion m;
  m.position = to;
  m.teleport = true;
  return m;
}

/// Least distance of liquid from the cube of 4 x 4 x 4 particles about a centre [m].
double clearance(const ParticleData& p, Vec3d center) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    if (!is_fluid(p.tag[i])) continue;
    // From the nearest of its particles.
    const auto off = [](double r) {
      const double nearest = std::min(1.5, std::max(-1.5, std::floor(r / dx) + 0.5)) * dx;
      return r - nearest;
    };
    const Vec3d r = p.position[i] - center;
    least = std::min(least, length(Vec3d{off(r.x), off(r.y), off(r.z)}));
  }
  return least;
}

TEST(Teleport, PutsLiquidOutOfTheWayAndAccountsForIt) {
  MELTSIM_NEEDS_BACKEND();
  Pool a = pool(0.8);
  for (int k = 0; k < 10; ++k) require(a.world.step(0.01));
  const ParticleData before = *a.world.particles();
  const Ledger was = *a.world.ledger();
  const Vec3d there{0.63, 0.33, 0.61};  // between sites, deep in the water
  require(a.world.set_motion(a.box, jump(there)));
  const ParticleData after = *a.world.particles();
  ASSERT_EQ(after.id, before.id);
  std::size_t moved = 0;
  double lift = 0;
  for (std::size_t i = 0; i < before.id.size(); ++i) {
    EXPECT_EQ(length(after.velocity[i] - before.velocity[i]), 0.0);
    const double way = length(after.position[i] - before.position[i]);
    if (way == 0) continue;
    ++moved;
    lift += before.mass[i] * 9.81 * (after.position[i].y - before.position[i].y);
    EXPECT_TRUE(is_fluid(before.tag[i]));
    // The surface above it, and a layer on that, is as far as it has to go.
    EXPECT_LT(way, 1.2);
    EXPECT_GT(after.position[i].y, 0.7);
  }
  // As many as its room holds, 64, and those within 0.9 spacings of its faces: less than a layer around it, 6^3.
  EXPECT_GE(moved, 64u);
  EXPECT_LT(moved, 216u);
  EXPECT_GE(clearance(after, there), 0.9 * dx * (1 - 1e-6));
  // No two in one place.
  for (std::size_t i = 0; i < after.id.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      if (length(after.position[i] - before.position[i]) == 0) break;
      if (is_removed(after.tag[j])) continue;
      EXPECT_GE(length(after.position[i] - after.position[j]), 0.9 * dx * (1 - 1e-6));
    }
  const Ledger now = *a.world.ledger();
  EXPECT_EQ(now.displaced, moved);
  EXPECT_NEAR(now.displaced_work, lift, 1e-6 * lift);
  // Sums of some thousand particles in single precision's positions.
  EXPECT_NEAR(now.potential - was.potential, lift, 1e-4 * lift);
  EXPECT_EQ(length(now.momentum - was.momentum), 0.0);
  for (int k = 0; k < 40; ++k) require(a.world.step(0.01));
  const StepResult r = a.world.synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  EXPECT_EQ(r.fluid, before.id.size() - 64);
  // It falls back from a column's height above the surface: no faster than from the ceiling, 5.6 m/s.
  EXPECT_LT(r.max_speed, std::sqrt(2 * 9.81 * 1.6));
  EXPECT_GT(clearance(*a.world.particles(), there), 0.4 * dx);
}

TEST(Teleport, IsTheSameWhereverTheStateIs) {
  MELTSIM_NEEDS_BACKEND();
  Pool a = pool(0.8), b = pool(0.8), c = pool(0.8);
  require(a.world.prepare());  // on the backend; b has it on the host
  for (Pool* p : {&a, &b}) require(p->world.set_motion(p->box, jump({0.6, 0.4, 0.6})));
  for (Pool* p : {&a, &b}) require(p->world.step(0.01));
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
  const auto bytes = b.world.snapshot();
  require(c.world.restore(bytes->data(), bytes->size()));
  for (Pool* p : {&a, &c}) require(p->world.set_motion(p->box, jump({0.4, 0.3, 0.8})));
  for (Pool* p : {&a, &c}) require(p->world.step(0.01));
  EXPECT_EQ(*a.world.state_hash(), *c.world.state_hash());
}

TEST(Teleport, IsRefusedWhereThereIsNoRoomAndChangesNothing) {
  MELTSIM_NEEDS_BACKEND();
  const auto refused = [](Pool& p, const BodyMotion& m, const char* names) {
    require(p.world.step(0.002));
    const std::uint64_t hash = *p.world.state_hash();
    const Status s = p.world.set_motion(p.box, m);
    ASSERT_FALSE(s) << names;
    EXPECT_EQ(s.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(s.error().message.find(names), std::string::npos) << s.error().message;
    EXPECT_EQ(*p.world.state_hash(), hash);
    EXPECT_EQ(p.world.ledger()->displaced, 0u);
    require(p.world.step(0.002));
  };
  // A tank that is full but for the layer in which the box stands, beside which there is none left.
  Pool full = pool(1.1, {0.5, 1.5, 0.5}, 1.1);
  FluidDesc more;
  more.material = full.water;
  more.shape = Shape::box({0, 1.1, 0}, {0.5, 1.5, 0.5});
  require(full.world.add_fluid(more));
  refused(full, jump({0.3, 0.4, 0.3}), "room for");
  // Water shut in by another body, around which there is all the room of the World.
  Pool shut = pool(0.1, {2, 2, 2}, 1.5);
  SolidDesc chest;
  chest.name = "chest";
  chest.material = shut.stone;
  chest.motion = Motion::fixed;
  chest.shape = Shape::subtract(Shape::box({0.6, 0.2, 0.6}, {1.6, 1.2, 1.6}),
                                Shape::box({0.8, 0.4, 0.8}, {1.4, 1.0, 1.4}));
  require(shut.world.add_solid(chest));
  more.material = shut.water;
  more.shape = Shape::box({0.8, 0.4, 0.8}, {1.4, 1.0, 1.4});
  require(shut.world.add_fluid(more));
  refused(shut, jump({1.1, 0.7, 1.1}), "room for");
  // Onto a nozzle, and to where another body is about to be.
  Pool met = pool(0.4);
  EmitterDesc e;
  e.material = met.water;
  e.center = {0.8, 0.9, 0.8};
  e.radius = 0.15;
  e.until = 10;
  require(met.world.add_emitter(e));
  SolidDesc other;
  other.name = "other";
  other.material = met.stone;
  other.shape = Shape::box({0.7, 1.2, 0.1}, {0.9, 1.4, 0.3});
  other.motion = Motion::kinematic;
  const BodyId there = *met.world.add_solid(other);
  for (int k = 0; k < 20; ++k) require(met.world.step(0.01));
  require(met.world.set_motion(there, jump({0.3, 0.7, 0.8})));
  const Status onto = met.world.set_motion(met.box, jump({0.3, 0.7, 0.7}));
  ASSERT_FALSE(onto);
  EXPECT_NE(onto.error().message.find("\"other\", which goes there"), std::string::npos)
      << onto.error().message;
  refused(met, jump({0.8, 1.0, 0.8}), "a nozzle is in the way");
}

TEST(Teleport, OfAProxyPutsLiquidOutOfItsWayToo) {
  MELTSIM_NEEDS_BACKEND();
  Pool a = pool(0.8);
  SolidDesc s;
  s.name = "buoy";
  s.material = a.stone;
  s.shape = Shape::box({0.7, 1.1, 0.7}, {1.0, 1.4, 1.0});
  s.motion = Motion::proxy;
  s.mass = 20;
  const BodyId buoy = *a.world.add_solid(s);
  require(a.world.step(0.01));
  ProxyState to;
  to.position = {0.6, 0.4, 0.6};
  to.teleport = true;
  require(a.world.set_proxy(buoy, to));
  EXPECT_GE(a.world.ledger()->displaced, 27u);
  for (int k = 0; k < 20; ++k) require(a.world.step(0.01));
  EXPECT_FALSE(a.world.synchronize().halted);
}

}  // namespace
}  // namespace meltsim_test
