// SPDX-License-Identifier: Apache-2.0
// Channels: rectangular nozzles upstream, outlets downstream.
#include <cmath>
#include <functional>
#include <string>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

// Ten layers: half a spacing is 5 % of the depth. 7.5 spacings across a period are the least there may be.
constexpr double dx = 0.01, depth = 0.1, length_x = 0.6, width = 0.08, speed = 0.4;

WorldDesc channel_desc() {
  WorldDesc d = describe();
  d.spacing = dx;
  d.heat.model = HeatModel::none;
  d.domain.bounded = true;
  d.domain.max = {length_x, 0.3, width};
  d.domain.faces = {Face::wall, Face::open, Face::wall, Face::open, Face::periodic, Face::periodic};
  d.domain.no_slip = false;  // so that nothing but the outlet decides on the depth
  return d;
}

EmitterDesc inlet(MaterialId water) {
  EmitterDesc e;
  e.material = water;
  e.center = {0.5 * dx, 0.5 * depth, 0.5 * width};  // its pipe begins at the wall behind
  e.axis = {1, 0, 0};
  e.width = width;
  e.height = depth;
  e.speed = speed;
  e.max_particles = 20000;
  return e;
}

/// Water at `flow` in all of the channel, behind the pipe of the inlet where there is one.
World channel(const WorldDesc& d, double flow) {
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  const auto water = *w->add_material({});
  FluidDesc f;
  f.material = water;
  f.shape = Shape::box({flow > 0 ? 3 * dx : 0, 0, 0}, {length_x, depth, width});
  f.velocity = {flow, 0, 0};
  require(w->add_fluid(f));
  if (flow > 0) require(w->add_emitter(inlet(water)));
  return std::move(*w);
}

/// Mean depth between 0.2 and 0.4 m, of the volumes of particles.
double mean_depth(World& w) {
  double n = 0;
  for (const Vec3d& x : w.particles()->position) n += x.x > 0.2 && x.x < 0.4 ? 1 : 0;
  return n * dx * dx * dx / (0.2 * width);
}

std::uint64_t removed(World& w) {
  const StepResult r = w.synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  return r.removed;
}

// Subcritical: 0.4 m/s, waves at 1 m/s. A disturbance of the start has left after 1.2 s; sloshing between inlet and outlet
// and the coming and going of layers leave 4 % of the depth, less than half a spacing, and 4 % of what left in 0.75 s.
TEST(Outlet, AChannelKeepsTheLevelBeyondAndLetsOutWhatComesIn) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = channel_desc();
  d.domain.outlets[1].level = depth;
  World w = channel(d, speed);
  for (int k = 0; k < 250; ++k) require(w.step(0.005));
  const double before = double(removed(w));
  double mean = 0;
  for (int k = 0; k < 150; ++k) {
    require(w.step(0.005));
    if (k % 10 == 9) mean += mean_depth(w) / 15;
  }
  const double out = (double(removed(w)) - before) * dx * dx * dx;
  EXPECT_NEAR(mean, depth, 0.04 * depth);
  EXPECT_NEAR(out, speed * depth * width * 0.75, 0.04 * speed * depth * width * 0.75);
}

/// What has left still water against 0.6 of its depth [m^3]: behind the wave that runs up the channel (at 1 m/s; 0.6 s to its
/// end) the water is as deep as the level, and flows at 2 sqrt(g h) - 2 sqrt(g h_L). A wave ten layers deep is longer than
/// shallow water's, and what lies within H of the outlet leaves first: 10 %.
double drained(double time) {
  const double level = 0.6 * depth, u = 2 * (std::sqrt(9.81 * depth) - std::sqrt(9.81 * level));
  return u * level * width * time;
}

TEST(Outlet, StillWaterBelowTheLevelStaysAndAboveItLeaves) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = channel_desc();
  d.domain.outlets[1].level = depth + dx;  // sloshing of the start stays below
  World still = channel(d, 0);
  for (int k = 0; k < 100; ++k) require(still.step(0.005));
  EXPECT_EQ(removed(still), 0u);
  d.domain.outlets[1].level = 0.6 * depth;
  World high = channel(d, 0);
  for (int k = 0; k < 100; ++k) require(high.step(0.005));
  EXPECT_NEAR(double(removed(high)) * dx * dx * dx, drained(0.5), 0.1 * drained(0.5));
}

// What the outlet held at the start, H deep, leaves at its speed; then what follows it.
TEST(Outlet, ASpeedTakesSpeedTimesArea) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = channel_desc();
  d.domain.outlets[1].speed = speed;
  World w = channel(d, speed);
  for (int k = 0; k < 200; ++k) require(w.step(0.005));
  EXPECT_NEAR(double(removed(w)) * dx * dx * dx, speed * depth * width * 1.0, 0.04 * speed * depth * width);
  const ParticleData p = *w.particles();
  for (std::size_t i = 0; i < p.position.size(); ++i)
    if (p.position[i].x > length_x - 0.99 * 2.5 * dx) {
      EXPECT_NEAR(p.velocity[i].x, speed, 1e-6);
    }
}

TEST(Outlet, AnyFaceAlongGravityTakes) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = channel_desc();
  d.domain.max = {width, length_x, 0.3};  // gravity along -z, the channel along -y
  d.gravity = {0, 0, 9.81};
  d.domain.faces = {Face::periodic, Face::periodic, Face::open, Face::wall, Face::open, Face::wall};
  d.domain.outlets[2].level = -0.3 + 0.6 * depth;  // heights are against gravity: the floor is at -0.3
  auto made = World::create(d);
  ASSERT_TRUE(made) << made.error().message;
  World w = std::move(*made);
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0, 0, 0.3 - depth}, {width, length_x, 0.3});
  require(w.add_fluid(f));
  for (int k = 0; k < 100; ++k) require(w.step(0.005));
  EXPECT_NEAR(double(removed(w)) * dx * dx * dx, drained(0.5), 0.1 * drained(0.5));
}

TEST(Outlet, ASnapshotGoesOnToTheSameBits) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = channel_desc();
  d.domain.outlets[1].level = depth;
  World w = channel(d, speed);
  for (int k = 0; k < 40; ++k) require(w.step(0.005));
  const auto bytes = w.snapshot();
  require(bytes);
  World other = channel(d, speed);
  require(other.restore(bytes->data(), bytes->size()));
  for (int k = 0; k < 40; ++k) {
    require(w.step(0.005));
    require(other.step(0.005));
  }
  EXPECT_EQ(*w.state_hash(), *other.state_hash());
}

// Two faces downstream of one nozzle: none takes the other's particles for its own, and what an outlet moves no nozzle lets go.
TEST(Outlet, NozzleAndOutletOfOneVelocityDoNotMixUp) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = channel_desc();
  d.gravity = {0, 0, 0};
  d.sound_speed = 10;
  d.domain.outlets[1].speed = speed;
  auto made = World::create(d);
  require(made);
  World w = std::move(*made);
  require(w.add_emitter(inlet(*w.add_material({}))));
  for (int k = 0; k < 400; ++k) require(w.step(0.005));  // 0.8 m: the first layers have left
  const ParticleData p = *w.particles();
  for (std::size_t i = 0; i < p.position.size(); ++i)
    if (p.position[i].x > length_x - 0.99 * 2.5 * dx) {
      EXPECT_EQ(p.tag[i] & tag_held, tag_held);
      EXPECT_NEAR(p.velocity[i].y, 0, 1e-9);
    }
  EXPECT_GT(removed(w), 0u);
}

TEST(RectangularNozzle, EmitsSpeedTimesAreaAcrossItsSides) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = dx;
  d.gravity = {0, 0, 0};
  d.sound_speed = 10;
  d.heat.model = HeatModel::none;
  auto made = World::create(d);
  require(made);
  World w = std::move(*made);
  EmitterDesc e;
  e.material = *w.add_material({});
  e.center = {0, 0, 0};
  e.axis = {0, 0, 3};
  e.up = {1, 0, 0.5};  // its part along the axis does not count
  e.width = 0.083;     // 8 points, a pitch of 1.04 spacings
  e.height = 0.032;    // 3 points
  e.speed = 1;
  e.until = 0.2;
  require(w.add_emitter(e));
  for (int k = 0; k < 60; ++k) require(w.step(0.005));
  const ParticleData p = *w.particles();
  // Layers come n dx^3/(A v) apart, the first at once.
  const double layers = std::ceil(0.2 / (24 * dx * dx * dx / (0.083 * 0.032)));
  EXPECT_EQ(double(p.position.size()), 24 * layers);
  double across = 0, upright = 0;
  for (const Vec3d& x : p.position) {
    across = std::max(across, std::fabs(x.y));
    upright = std::max(upright, std::fabs(x.x));
  }
  EXPECT_NEAR(across, 0.5 * 0.083 * 7 / 8, 1e-5);
  EXPECT_NEAR(upright, 0.5 * 0.032 * 2 / 3, 1e-5);
}

void expect_refused(const std::function<void(WorldDesc&)>& change, const std::string& words) {
  WorldDesc d = channel_desc();
  change(d);
  const auto w = World::create(d);
  ASSERT_FALSE(w) << words;
  EXPECT_EQ(w.error().code, ErrorCode::invalid_argument);
  EXPECT_NE(w.error().message.find(words), std::string::npos) << w.error().message;
}

TEST(Outlet, BadInputNamesTheFace) {
  MELTSIM_NEEDS_BACKEND();
  expect_refused([](WorldDesc& d) { d.domain.outlets[0].level = 0.1; },
                 "domain.outlets[-x].level: liquid leaves through open");
  expect_refused([](WorldDesc& d) { d.domain.outlets[4].speed = 1; },
                 "domain.outlets[-z].speed: liquid leaves through open");
  expect_refused([](WorldDesc& d) { d.domain.outlets[1].speed = -1; },
                 "domain.outlets[+x].speed: must be finite and > 0");
  expect_refused([](WorldDesc& d) { d.domain.outlets[1].level = std::nan(""); },
                 "domain.outlets[+x].level: must be finite");
  expect_refused([](WorldDesc& d) { d.domain.outlets[1].level = -0.1; },
                 "above the floor, got -0.1 m, 0.1 m below it");
  expect_refused([](WorldDesc& d) { d.domain.outlets[3].level = 0.1; },
                 "domain.outlets[+y].level: needs gravity along");
  expect_refused(
      [](WorldDesc& d) {
        d.domain.outlets[1].level = 0.1;
        d.gravity = {1, -9, 0};
      },
      "domain.outlets[+x].level: needs gravity along");
  expect_refused(
      [](WorldDesc& d) {
        d.domain.outlets[1].level = 0.1;
        d.domain.outlets[1].speed = 1;
      },
      "drop one of them");
  expect_refused(
      [](WorldDesc& d) {
        d.domain.outlets[1].level = 0.1;
        d.domain.faces[2] = Face::open;
      },
      "needs a wall below");
  World w = channel(channel_desc(), 0);
  MaterialDesc milk;
  milk.name = "milk";
  EmitterDesc e = inlet(*w.add_material(milk));
  const auto refused = [&](const std::function<void(EmitterDesc&)>& change, const std::string& words) {
    EmitterDesc bad = e;
    change(bad);
    const auto r = w.add_emitter(bad);
    ASSERT_FALSE(r) << words;
    EXPECT_NE(r.error().message.find(words), std::string::npos) << r.error().message;
  };
  refused([](EmitterDesc& b) { b.height = 0; }, "height: must be at least two spacings");
  refused([](EmitterDesc& b) { b.radius = 0.1; }, "radius: an opening is a disc or a rectangle");
  refused([](EmitterDesc& b) { b.up = b.axis; }, "up: must be a finite vector that is not along the axis");
  refused([](EmitterDesc& b) { b.center.y = 0; },
          "the nozzle's opening of 0.08 by 0.1 m reaches into a wall");
}

}  // namespace
}  // namespace meltsim_test
