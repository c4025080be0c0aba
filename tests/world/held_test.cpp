// SPDX-License-Identifier: Apache-2.0
// Bodies that are held where they are and let go.
#include <cmath>
#include <string>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

WorldDesc held_desc() {
  WorldDesc d = describe();
  d.precision = Precision::double_precision;
  d.spacing = 0.1;
  d.sound_speed = 40;
  d.heat.model = HeatModel::none;
  d.domain.bounded = true;
  d.domain.max = {2, 3, 2};
  return d;
}

World make(const WorldDesc& d) {
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  return std::move(*w);
}

SolidDesc cube(World& w, Motion motion, double height = 2) {
  MaterialDesc m;
  m.name = "wood";
  m.density = 600;
  SolidDesc s;
  s.material = *w.add_material(m);
  s.shape = Shape::box({0.8, height, 0.8}, {1.2, height + 0.4, 1.2});
  s.motion = motion;
  return s;
}

Vec3d center(World& w) { return w.pieces()->at(0).center; }

class Held : public testing::TestWithParam<Motion> {};

// Steps of 0.01 s: let go at the beginning of the step that begins at 0.2 s, it has fallen 0.3 s at 0.5 s. Kick-drift is exact
// for constant acceleration but for rounding; 1e-9 of a fall of 0.44 m.
TEST_P(Held, FallsFromTheTimeItIsLetGo) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(held_desc());
  SolidDesc s = cube(w, GetParam());
  s.held_until = 0.2;
  require(w.add_solid(s));
  const Vec3d start = center(w);
  for (int k = 0; k < 20; ++k) require(w.step(0.01));
  EXPECT_EQ(length(center(w) - start), 0);
  for (int k = 0; k < 30; ++k) require(w.step(0.01));
  EXPECT_NEAR(start.y - center(w).y, 0.5 * 9.81 * 0.3 * 0.3, 1e-9);
}

TEST_P(Held, IsThrownAtItsVelocity) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = held_desc();
  d.gravity = {0, 0, 0};
  World w = make(d);
  SolidDesc s = cube(w, GetParam());
  s.held_until = 0.1;
  s.velocity = {0, -1, 0};
  s.angular_velocity = {0, 2, 0};
  require(w.add_solid(s));
  const Vec3d start = center(w);
  EXPECT_EQ(w.totals()->kinetic, 0);
  for (int k = 0; k < 20; ++k) require(w.step(0.01));
  const PieceInfo piece = w.pieces()->at(0);
  EXPECT_NEAR(piece.center.y - start.y, -0.1, 1e-9);
  EXPECT_NEAR(piece.velocity.y, -1, 1e-9);
  EXPECT_NEAR(piece.angular_velocity.y, 2, 0.01);  // shape matching lets a cube of four spacings breathe
}

// While it is held, a body is an obstacle: the liquid's bits are those beside a fixed one.
TEST_P(Held, IsFixedUntilThen) {
  MELTSIM_NEEDS_BACKEND();
  const auto run = [](Motion motion, double until) {
    World w = make(held_desc());
    SolidDesc s = cube(w, motion, 0.4);
    s.held_until = until;
    require(w.add_solid(s));
    FluidDesc f;
    MaterialDesc water;
    water.name = "water";
    f.material = *w.add_material(water);
    f.shape = Shape::box({0, 0, 0}, {2, 1, 2});
    require(w.add_fluid(f));
    for (int k = 0; k < 10; ++k) require(w.step(0.004));
    return *w.state_hash();
  };
  EXPECT_EQ(run(GetParam(), infinity), run(Motion::fixed, 0));
}

TEST_P(Held, TheHostHoldsAndLetsGo) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(held_desc());
  const BodyId body = *w.add_solid(cube(w, GetParam()));
  for (int k = 0; k < 20; ++k) require(w.step(0.01));
  require(w.hold(body));
  const Vec3d there = center(w);
  for (int k = 0; k < 5; ++k) require(w.step(0.01));
  EXPECT_EQ(length(center(w) - there), 0);
  EXPECT_EQ(w.totals()->kinetic, 0);
  const Status pushed = w.apply_impulse(body, {1, 0, 0});
  ASSERT_FALSE(pushed);
  EXPECT_NE(pushed.error().message.find("is held where it is; let it go with hold(body, false) first"),
            std::string::npos)
      << pushed.error().message;
  require(w.hold(body, false));
  require(w.hold(body, false));  // again does nothing
  for (int k = 0; k < 20; ++k) require(w.step(0.01));
  EXPECT_NEAR(there.y - center(w).y, 0.5 * 9.81 * 0.2 * 0.2, 1e-9);  // at rest when let go
}

// A snapshot of either time goes on to the same bits in a World of the scene that is at the other.
TEST_P(Held, SnapshotsKnowWhoIsHeld) {
  MELTSIM_NEEDS_BACKEND();
  const auto scene = [] {
    World w = make(held_desc());
    SolidDesc s = cube(w, GetParam());
    s.held_until = 0.1;
    s.velocity = {0.1, 0, 0};
    require(w.add_solid(s));
    return w;
  };
  World w = scene();
  for (int k = 0; k < 5; ++k) require(w.step(0.01));
  const auto held = *w.snapshot();
  for (int k = 0; k < 15; ++k) require(w.step(0.01));
  const auto free = *w.snapshot();
  const std::uint64_t hash = *w.state_hash();
  require(w.restore(held.data(), held.size()));
  for (int k = 0; k < 15; ++k) require(w.step(0.01));
  EXPECT_EQ(*w.state_hash(), hash);
  World other = scene();
  require(other.restore(free.data(), free.size()));
  EXPECT_EQ(*other.state_hash(), hash);
  require(other.step(0.01));
  require(w.step(0.01));
  EXPECT_EQ(*other.state_hash(), *w.state_hash());
}

TEST_P(Held, AheadOfTheFirstStepIsTheSameWhetherTheWorldWasPreparedBefore) {
  MELTSIM_NEEDS_BACKEND();
  const auto hash = [](bool prepared, bool ran) {
    WorldDesc d = held_desc();
    d.sound_speed = 0;
    World w = make(d);
    if (ran) require(w.step(0.01));  // empty
    SolidDesc s = cube(w, GetParam());
    s.velocity = {30, 0, 0};  // faster than any fall here: sound would follow it
    const BodyId body = *w.add_solid(s);
    if (prepared) require(w.prepare());
    require(w.hold(body));
    require(w.step(0.01));
    return std::make_pair(w.resolved().sound_speed, *w.state_hash());
  };
  for (const bool ran : {false, true}) EXPECT_EQ(hash(true, ran), hash(false, ran)) << ran;
}

// Velocities are those that the World's precision has, whether it is let go on the backend or in a state that the host holds.
TEST_P(Held, LetGoIsTheSameByWayOfTheHost) {
  MELTSIM_NEEDS_BACKEND();
  const auto hash = [](bool on_host) {
    WorldDesc d = held_desc();
    d.precision = Precision::single_precision;
    World w = make(d);
    SolidDesc s = cube(w, GetParam());
    s.held_until = infinity;
    s.velocity = {0.1, 0, 0};
    const BodyId body = *w.add_solid(s);
    require(w.step(0.01));
    const auto bytes = *w.snapshot();
    if (on_host) require(w.restore(bytes.data(), bytes.size()));
    require(w.hold(body, false));
    return *w.state_hash();
  };
  EXPECT_EQ(hash(true), hash(false));
}

INSTANTIATE_TEST_SUITE_P(Motions, Held, testing::Values(Motion::free, Motion::rigid),
                         [](const auto& p) { return p.param == Motion::free ? "Free" : "Rigid"; });

// Of two micrometres: what a World accepts its snapshots hold.
TEST(HeldBody, ASnapshotTakesAnySpinThatABodyHas) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 1e-6;
  d.gravity = {};
  World w = make(d);
  SolidDesc s;
  s.material = *w.add_material({});
  s.shape = Shape::box({0, 0, 0}, {2e-6, 2e-6, 2e-6});
  s.held_until = 1;
  s.angular_velocity = {0, 2e15, 0};
  require(w.add_solid(s));
  const auto snapshot = w.snapshot();
  ASSERT_TRUE(snapshot) << snapshot.error().message;
  require(w.restore(snapshot->data(), snapshot->size()));
}

// A held rigid body is none that moves, so it leaves the free one its lattice, with its stages. Dropped onto the floor from 0.4 m
// that is as high as before; without a lattice it lies there one particle high.
TEST(HeldBody, ARigidOneTakesNoLatticeFromAFreeOne) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(held_desc());
  SolidDesc s = cube(w, Motion::free, 0.4);
  const BodyId falls = *w.add_solid(s);
  s.motion = Motion::rigid;
  s.shape = Shape::box({0.8, 2, 0.8}, {1.2, 2.4, 1.2});
  s.held_until = 1;
  require(w.add_solid(s));
  const auto has_goals = [&] {
    for (const StageReport& stage : w.plan().stages)
      if (stage.name == "lsm.goals") return stage.runs;
    return false;
  };
  require(w.prepare());
  EXPECT_TRUE(has_goals());
  for (int k = 0; k < 90; ++k) require(w.step(0.01));
  const auto particles = *w.particles();
  double low = 1e9, high = -1e9;
  for (std::size_t i = 0; i < particles.id.size(); ++i)
    if (body_of(particles.tag[i]) == falls.index + 1) {
      low = std::min(low, particles.position[i].y);
      high = std::max(high, particles.position[i].y);
    }
  EXPECT_NEAR(high - low, 0.3,
              0.02);  // three spacings between its outermost layers; its weight strains it by far less
}

TEST(HeldBody, BadInputNamesTheField) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(held_desc());
  SolidDesc s = cube(w, Motion::free);
  const auto refused = [&](const char* words) {
    const auto r = w.add_solid(s);
    ASSERT_FALSE(r) << words;
    EXPECT_EQ(r.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(r.error().message.find(words), std::string::npos) << r.error().message;
  };
  s.held_until = -1;
  refused("held_until: must be >= 0 s, got -1");
  s.held_until = std::nan("");
  refused("held_until: must be >= 0 s, got nan");
  s.held_until = 1;
  s.motion = Motion::fixed;
  refused("held_until: only a free or rigid body can be let go");
  s.motion = Motion::kinematic;
  refused("held_until: only a free or rigid body can be let go");
  s.held_until = 0;
  const BodyId hand = *w.add_solid(s);
  const Status status = w.hold(hand);
  ASSERT_FALSE(status);
  EXPECT_NE(
      status.error().message.find("only a free or rigid body can be held; set_motion stops a kinematic one"),
      std::string::npos)
      << status.error().message;
}

// What is held counts for no step, so that springs would have it wider than the sites around it: those are made for bodies that move.
TEST(Held, ALightBodysRegionsKeepToTheSitesAroundIt) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.domain.bounded = true;
  d.domain.max = {1.2, 1.2, 1.2};
  auto w = World::create(d);
  require(w);
  MaterialDesc foam;
  foam.name = "foam";
  foam.density = 50;
  foam.region_half_width = 1;
  FluidDesc pool;
  pool.material = *w->add_material({});
  pool.shape = Shape::box({0, 0, 0}, {1.2, 0.6, 1.2});
  require(w->add_fluid(pool));
  SolidDesc block;
  block.shape = Shape::box({0.4, 0.4, 0.4}, {0.8, 0.8, 0.8});
  block.material = *w->add_material(foam);
  block.held_until = 0.02;
  require(w->add_solid(block));
  require(w->step(1e-3));
  const int held = w->lattice()->region_half_width;
  for (int k = 0; k < 8; ++k) require(w->step(0.01));
  ASSERT_FALSE(w->synchronize().halted);
  EXPECT_LE(held, w->lattice()->region_half_width);  // it moves now
}

}  // namespace
}  // namespace meltsim_test
