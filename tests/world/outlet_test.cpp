// SPDX-License-Identifier: Apache-2.0
// Channels: rectangular nozzles upstream, outlets downstream, and faces through which liquid comes in and goes out.
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
  const ParticleData p = *w.particles();
  double n = 0;
  for (const Vec3d& x : p.position) n += x.x > 0.2 && x.x < 0.4 ? 1 : 0;
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

// Nothing then finds how fast liquid leaves against a level, or comes in below one: it goes as it comes.
TEST(Outlet, LevelsRestWhereLiquidIsSwitchedOff) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = channel_desc();
  d.gravity = {0, -9.81, 0};
  d.domain.outlets[1].level = 0.5 * depth;
  World w = channel(d, 0);
  require(w.step(0.01));
  require(w.scheduler().enable("sph", false));
  require(w.step(0.01));
  EXPECT_FALSE(w.synchronize().halted);
  require(w.scheduler().enable("sph", true));
  const std::uint64_t before = removed(w);
  for (int k = 0; k < 10; ++k) require(w.step(0.01));
  EXPECT_GT(removed(w), before);
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
  expect_refused([](WorldDesc& d) { d.domain.outlets[1].level = 1.01 * d.domain.max.y; },
                 "nothing would leave; lower it");
  expect_refused(
      [](WorldDesc& d) {
        d.domain.velocity[2] = {1, 0.1, 0};
      },
      "domain.velocity[-y]: walls slide along themselves");
  expect_refused(
      [](WorldDesc& d) {
        d.domain.velocity[1] = {0, 1, 0};
      },
      "domain.velocity[+x]: is of a wall, and there is none at +x");
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

// --- emitters with a level ---------------------------------------------------------------------------------

constexpr double g = 9.81;
double celerity(double h) { return std::sqrt(g * h); }

/// Half the length: twelve support radii, so that waves cross it in half the time.
WorldDesc short_channel_desc() {
  WorldDesc d = channel_desc();
  d.domain.max.x = 0.5 * length_x;
  return d;
}

EmitterDesc sea(MaterialId liquid, double level, Vec3d inwards = {-1, 0, 0}) {
  EmitterDesc e;
  e.name = "sea";
  e.material = liquid;
  e.axis = inwards;
  e.level = level;
  return e;
}

/// A tank with liquid of a depth, and a level beyond its face +x.
World tank(const WorldDesc& d, double inside, double level, std::uint64_t most = 0) {
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  FluidDesc f;
  f.material = *w->add_material({});
  f.shape = Shape::box({0, 0, 0}, {d.domain.max.x, inside, d.domain.max.z});
  if (inside > 0) require(w->add_fluid(f));
  EmitterDesc e = sea(f.material, level);
  e.max_particles = most;
  e.height = 1.5 * depth;
  require(w->add_emitter(e));
  return std::move(*w);
}

/// Depth of all of a channel and mean velocity along it, of a part of its length.
struct Flow {
  double depth = 0, speed = 0;
};
Flow flow_of(World& w, double from, double to) {
  const ParticleData p = *w.particles();
  double n = 0, u = 0;
  for (std::size_t i = 0; i < p.position.size(); ++i) {
    if (!(p.position[i].x >= from && p.position[i].x < to)) continue;
    n += 1;
    u += p.velocity[i].x;
  }
  return {n * dx * dx * dx / ((to - from) * width), n > 0 ? u / n : 0};
}

void run(World& w, int steps) {
  for (int k = 0; k < steps; ++k) require(w.step(0.005));
}

// Behind the wave that runs up the tank and back (0.3 m each at 1 m/s) water comes in at c_L - c_0, (c_L + c_0)^2/(4 g) deep. Layers come as a
// whole, 64 particles, a tenth of what comes in until 0.5 s; the speed lags by H/c_L, 5 % of that time. The wave comes back and leaves: from then on
// the tank is full, to 2 % or a fifth of a spacing (0.7 % was measured, 16 particles), and nothing moves.
TEST(Inlet, ATankFillsToTheLevelAndStops) {
  MELTSIM_NEEDS_BACKEND();
  World w = tank(short_channel_desc(), 0.6 * depth, depth);
  run(w, 100);
  const double c = celerity(depth), c0 = celerity(0.6 * depth), h = (c + c0) * (c + c0) / (4 * g);
  const double due = (c - c0) * h * width * (0.5 - 2.5 * dx / c) / (dx * dx * dx);
  StepResult r = w.synchronize();
  ASSERT_FALSE(r.halted) << r.halt_reason;
  EXPECT_NEAR(double(r.entered), due, 64 + 0.02 * due);
  EXPECT_EQ(r.removed, 0u);
  run(w, 180);
  r = w.synchronize();
  EXPECT_EQ(r.fluid, 30u * 6 * 8 + r.entered - r.removed);
  EXPECT_NEAR(flow_of(w, 0, 0.5 * length_x).depth, depth, 0.02 * depth);
  run(w, 20);
  EXPECT_LT(w.synchronize().max_speed, 0.1);  // an eighth of what it was
  EXPECT_FALSE(r.emitter_exhausted);
}

// Ritter: into a dry tank a reservoir empties at critical flow, 8/27 c_L h_L, until the wave comes back from its end after 1 s. Four
// layers of the ten carry 4/9 of the depth; the first 0.1 s, in which the speed sets in, is left out. A layer is 3 % of what comes.
TEST(Inlet, ADryTankFillsAtCriticalFlow) {
  MELTSIM_NEEDS_BACKEND();
  World w = tank(channel_desc(), 0, depth);
  run(w, 20);
  const double before = double(w.synchronize().entered);
  run(w, 100);
  const double due = 8.0 / 27 * celerity(depth) * depth * width * 0.5 / (dx * dx * dx);
  EXPECT_NEAR(double(w.synchronize().entered) - before, due, 0.04 * due);
}

/// A channel of a depth between two levels; the emitter upstream.
World between(double upstream, double downstream, EmitterId& id) {
  WorldDesc d = short_channel_desc();
  d.domain.faces[0] = Face::open;
  World w = tank(d, depth, downstream);
  EmitterDesc e = sea(MaterialId{0, 1}, upstream, {1, 0, 0});
  e.name = "upstream";
  e.height = 1.5 * depth;
  const auto added = w.add_emitter(e);
  require(added);
  id = *added;
  return w;
}

// Characteristics of both ends meet: u = c_1 - c_2 and c = (c_1 + c_2)/2, from when each has crossed the channel. Means over 0.5 s;
// water is compressed by 0.5 %, layers come and go: 3 % of the speed, 2 % of the depth.
TEST(Inlet, BetweenTwoLevelsAChannelFlowsAtTheDifferenceOfCelerities) {
  MELTSIM_NEEDS_BACKEND();
  EmitterId upstream;
  World w = between(1.1 * depth, 0.9 * depth, upstream);
  run(w, 120);
  Flow mean;
  for (int k = 0; k < 10; ++k) {
    run(w, 10);
    const Flow now = flow_of(w, 0.05, 0.25);
    mean.depth += now.depth / 10;
    mean.speed += now.speed / 10;
  }
  const double a = celerity(1.1 * depth), b = celerity(0.9 * depth);
  EXPECT_NEAR(mean.speed, a - b, 0.03 * (a - b));
  EXPECT_NEAR(mean.depth, (a + b) * (a + b) / (4 * g), 0.02 * depth);
}

// A wave of 1.2 s, 1.1 m long, from a level upstream that goes up and down by a fifth of the depth. In the middle of the channel depth and
// speed tell the part that goes back from the one that comes: eta = (h +- u k h/omega)/2. A wall gives back 0.97 of it, this face 0.08.
TEST(Inlet, LongWavesLeaveTroughsAndCrests) {
  MELTSIM_NEEDS_BACKEND();
  EmitterId upstream;
  World w = between(depth, depth, upstream);
  const double omega = 2 * 3.14159265358979323846 / 1.2;
  double k = omega / celerity(depth);
  for (int i = 0; i < 50; ++i) k = omega * omega / (g * std::tanh(k * depth));
  double mean = 0, depth_cos = 0, depth_sin = 0, speed_cos = 0, speed_sin = 0;
  const int period = 240, first = 120;  // of steps; one period is looked at
  for (int n = 0; n < first + period; ++n) {
    const double t = 0.005 * n;
    EmitterSetting tide;
    tide.level = depth * (1 + 0.2 * std::sin(omega * t));
    require(w.set_emitter(upstream, tide));
    run(w, 1);
    if (n < first || n % 4 != 0) continue;
    const Flow now = flow_of(w, 0.1, 0.2);
    mean += now.depth;
    depth_cos += now.depth * std::cos(omega * t);
    depth_sin += now.depth * std::sin(omega * t);
    speed_cos += now.speed * std::cos(omega * t);
    speed_sin += now.speed * std::sin(omega * t);
  }
  const double samples = period / 4, scale = k * mean / samples / omega;
  const double came = std::hypot(depth_cos + scale * speed_cos, depth_sin + scale * speed_sin) / samples;
  const double went = std::hypot(depth_cos - scale * speed_cos, depth_sin - scale * speed_sin) / samples;
  EXPECT_NEAR(came, 0.1 * depth, 0.03 * depth);  // viscosity has damped it
  EXPECT_LT(went, 0.12 * came);
}

/// A short tank, 4.8 support radii, so that ebb and flood take little time.
constexpr double basin_length = 0.12, tide_period = 0.6;
WorldDesc basin_desc() {
  WorldDesc d = channel_desc();
  d.domain.max.x = basin_length;
  return d;
}

/// The level beyond the only emitter goes up and down.
void ebb_and_flood(World& w, EmitterId id, int steps) {
  for (int k = 0; k < steps; ++k) {
    EmitterSetting tide;
    tide.level = depth * (1 + 0.4 * std::sin(2 * 3.14159265358979323846 * w.time() / tide_period));
    require(w.set_emitter(id, tide));
    run(w, 1);
  }
}

World basin(const WorldDesc& d, EmitterId& id, std::uint64_t most) {
  auto made = World::create(d);
  require(made);
  World w = std::move(*made);
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0, 0, 0}, {basin_length, depth, width});
  require(w.add_fluid(f));
  EmitterDesc e = sea(f.material, depth);
  e.height = 1.5 * depth;
  e.max_particles = most;
  id = *w.add_emitter(e);
  return w;
}

// Four tides bring more than twice as many particles as there are ids: those of what has left are used again. The basin, which waves cross
// in a fifth of a tide, follows the level but for waves in it; at the end it is at its mean, to a tenth.
TEST(Inlet, EbbAndFloodUseIdsAgain) {
  MELTSIM_NEEDS_BACKEND();
  EmitterId id;
  World w = basin(basin_desc(), id, 800);
  ebb_and_flood(w, id, 480);
  EmitterSetting still;
  still.level = depth;
  require(w.set_emitter(id, still));
  run(w, 120);
  const StepResult r = w.synchronize();
  ASSERT_FALSE(r.halted) << r.halt_reason;
  EXPECT_FALSE(r.emitter_exhausted);
  EXPECT_GT(r.entered, 1600u);
  EXPECT_EQ(r.fluid, 12u * 10 * 8 + r.entered - r.removed);
  EXPECT_EQ(r.fluid, w.particles()->position.size());
  EXPECT_NEAR(flow_of(w, 0, basin_length).depth, depth, 0.1 * depth);
}

TEST(Inlet, AReserveThatIsSpentIsReported) {
  MELTSIM_NEEDS_BACKEND();
  World w = tank(basin_desc(), 0.4 * depth, depth, 15 * 8);
  run(w, 100);
  const StepResult r = w.synchronize();
  EXPECT_TRUE(r.emitter_exhausted);
  EXPECT_EQ(r.entered, 15u * 8);
}

TEST(Inlet, ASnapshotGoesOnToTheSameBits) {
  MELTSIM_NEEDS_BACKEND();
  EmitterId id, other_id;
  World w = basin(basin_desc(), id, 800), other = basin(basin_desc(), other_id, 800);
  ebb_and_flood(w, id, 80);  // ids in use and in reserve are mixed, the level is falling
  const auto bytes = w.snapshot();
  require(bytes);
  require(w.save_state(0));
  ebb_and_flood(w, id, 40);
  const auto hash = *w.state_hash();
  const StepResult r = w.synchronize();
  require(other.restore(bytes->data(), bytes->size()));
  ebb_and_flood(other, other_id, 40);
  EXPECT_EQ(*other.state_hash(), hash);
  EXPECT_EQ(other.synchronize().entered, r.entered);
  EXPECT_EQ(other.synchronize().removed, r.removed);
  require(w.load_state(0));
  run(w, 40);  // at the level of when it was saved
  require(other.restore(bytes->data(), bytes->size()));
  run(other, 40);
  EXPECT_EQ(*other.state_hash(), *w.state_hash());
}

TEST(Inlet, NeitherThreadsNorPrecisionChangeWhatItDoes) {
  MELTSIM_NEEDS_BACKEND();
  std::uint64_t hashes[2], entered[2];
  for (int k = 0; k < 2; ++k) {
    WorldDesc d = basin_desc();
    d.threads = k == 0 ? 1 : 3;
    World w = tank(d, 0.6 * depth, depth);
    run(w, 60);
    hashes[k] = *w.state_hash();
    d.precision = k == 0 ? Precision::single_precision : Precision::double_precision;
    World rounded = tank(d, 0.6 * depth, depth);
    run(rounded, 60);
    entered[k] = rounded.synchronize().entered;
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_NEAR(double(entered[0]), double(entered[1]), 48);  // one layer
}

// What comes in has its temperature, heat is exchanged only: all is there, to the rounding of single precision.
TEST(Inlet, BringsItsTemperature) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = basin_desc();
  d.heat.model = HeatModel::enthalpy;
  d.heat.time_scale = 100;
  auto made = World::create(d);
  require(made);
  World w = std::move(*made);
  MaterialDesc water;
  water.conductivity = 0.6;
  FluidDesc f;
  f.material = *w.add_material(water);
  f.temperature = 20;
  f.shape = Shape::box({0, 0, 0}, {basin_length, 0.6 * depth, width});
  require(w.add_fluid(f));
  EmitterDesc e = sea(f.material, depth);
  e.temperature = 40;
  const EmitterId id = *w.add_emitter(e);
  run(w, 40);
  StepResult r = w.synchronize();
  ASSERT_GT(r.entered, 100u);
  ASSERT_EQ(r.removed, 0u);
  const double each = water.density * dx * dx * dx * water.heat_capacity, before = double(r.entered);
  double due = each * (20.0 * 12 * 6 * 8 + 40 * before);
  EXPECT_NEAR(w.totals()->thermal, due, 1e-6 * due);
  EmitterSetting colder;
  colder.temperature = 10;
  require(w.set_emitter(id, colder));
  run(w, 15);
  r = w.synchronize();
  ASSERT_GT(double(r.entered), before);
  due += each * 10 * (double(r.entered) - before);
  EXPECT_NEAR(w.totals()->thermal, due, 1e-6 * due);
  EXPECT_NEAR(w.totals()->mass, water.density * dx * dx * dx * double(r.fluid), 1e-6 * w.totals()->mass);
}

TEST(Inlet, TurnedOffItLetsOutOnly) {
  MELTSIM_NEEDS_BACKEND();
  EmitterId id;
  World w = basin(basin_desc(), id, 800);
  EmitterSetting off;
  off.on = false;
  off.level = 1.5 * depth;
  require(w.set_emitter(id, off));
  run(w, 40);
  EXPECT_EQ(w.synchronize().entered, 0u);
  off.level = 0.5 * depth;
  require(w.set_emitter(id, off));
  run(w, 40);
  EXPECT_EQ(w.synchronize().entered, 0u);
  EXPECT_GT(w.synchronize().removed, 100u);
  off = {};
  off.on = true;
  off.level = depth;
  require(w.set_emitter(id, off));
  run(w, 60);
  EXPECT_GT(w.synchronize().entered, 100u);
}

// Gravity along +z, the face -y, heights against gravity: as it fills the tank of the first test, in another frame.
TEST(Inlet, AnyFaceAlongGravityLetsIn) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = basin_desc();
  World there = tank(d, 0.6 * depth, depth);
  run(there, 60);
  d.domain.max = {width, basin_length, 0.3};
  d.gravity = {0, 0, g};
  d.domain.faces = {Face::periodic, Face::periodic, Face::open, Face::wall, Face::open, Face::wall};
  auto made = World::create(d);
  require(made);
  World w = std::move(*made);
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0, 0, 0.3 - 0.6 * depth}, {width, basin_length, 0.3});
  require(w.add_fluid(f));
  require(w.add_emitter(sea(f.material, -0.3 + depth, {0, 2, 0})));
  run(w, 60);
  EXPECT_NEAR(double(w.synchronize().entered), double(there.synchronize().entered), 48);  // one layer
}

TEST(Inlet, BadInputIsRefusedAndNamesTheFix) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = channel_desc();
  d.domain.faces[3] = Face::wall;
  auto made = World::create(d);
  require(made);
  World w = std::move(*made);
  MaterialDesc milk;
  const EmitterDesc good = sea(*w.add_material(milk), depth);
  const auto refused = [&](const std::function<void(EmitterDesc&)>& change, const std::string& words) {
    EmitterDesc bad = good;
    change(bad);
    const auto r = w.add_emitter(bad);
    ASSERT_FALSE(r) << words;
    EXPECT_EQ(r.error().message.find("emitter \"sea\": "), 0u) << r.error().message;
    EXPECT_NE(r.error().message.find(words), std::string::npos) << r.error().message;
  };
  refused([](EmitterDesc& b) { b.level = std::nan(""); }, "level: must be finite");
  refused([](EmitterDesc& b) { b.level = 0.01; },
          "level: must be at least two spacings (0.02 m) above the floor");
  refused([](EmitterDesc& b) { b.level = 0.4; }, "level: the opening must reach the level");
  refused([](EmitterDesc& b) { b.height = 0.05; }, "height: the opening must reach the level, 0.1 m");
  refused([](EmitterDesc& b) { b.axis = {1, 1, 0}; }, "axis: must lie along x, y or z");
  refused([](EmitterDesc& b) { b.axis = {1, 0, 0}; }, "-x is a wall; make that face open");
  refused([](EmitterDesc& b) { b.axis = {0, 0, 1}; }, "-z is periodic; make that face open");
  refused([](EmitterDesc& b) { b.radius = 0.1; }, "radius: got 0.1 m beside a level");
  refused([](EmitterDesc& b) { b.speed = 2; }, "speed: got 2 m/s beside a level");
  refused([](EmitterDesc& b) { b.center = {1, 0, 0}; }, "beside a level; the axis says which face");
  refused([](EmitterDesc& b) { b.until = 1; }, "until: got 1 s beside a level");
  refused([](EmitterDesc& b) { b.max_particles = 5; }, "max_particles: 5 is less than one layer of the face");
  refused([](EmitterDesc& b) { b.material = {}; }, "material: no such material");
  refused([](EmitterDesc& b) { b.temperature = -300; }, "temperature: must be >= -273.15");
  EmitterDesc nozzle = inlet(good.material);
  nozzle.center.x = length_x - 0.045;
  require(w.add_emitter(nozzle));
  refused([](EmitterDesc&) {}, "axis: the nozzle of emitter \"emitter1\"");
  World other = *World::create(d);
  EmitterDesc e = sea(*other.add_material(milk), depth);
  const EmitterId id = *other.add_emitter(e);
  nozzle.name = "jet";
  nozzle.material = e.material;
  EXPECT_NE(other.add_emitter(nozzle).error().message.find("less than two support radii from the open face"),
            std::string::npos);
  EXPECT_NE(other.add_emitter(e).error().message.find("has a level beyond that face already"),
            std::string::npos);
  const auto unsettable = [&](const std::function<void(EmitterSetting&)>& change, const std::string& words) {
    EmitterSetting bad;
    change(bad);
    const auto r = other.set_emitter(id, bad);
    ASSERT_FALSE(r) << words;
    EXPECT_NE(r.error().message.find(words), std::string::npos) << r.error().message;
  };
  unsettable([](EmitterSetting& b) { b.level = 0.2; }, "more than the opening's 0.1 m");
  unsettable([](EmitterSetting& b) { b.level = -1; }, "level: must be at least two spacings");
  unsettable([](EmitterSetting& b) { b.speed = 1; }, "speed: follows from the level");
  unsettable([](EmitterSetting& b) { b.center = Vec3d{}; }, "center: an open face of the domain stays");
  unsettable([](EmitterSetting& b) { b.temperature = std::nan(""); }, "temperature: must be");
  EXPECT_NE(other.set_gravity({1, -9, 0}).error().message.find("gravity: emitter \"sea\" has a level"),
            std::string::npos);
  require(other.set_gravity({0, -5, 0}));
  d.domain.outlets[1].level = depth;
  World third = *World::create(d);
  EXPECT_NE(third.add_emitter(sea(*third.add_material(milk), depth)).error().message.find("has an outlet"),
            std::string::npos);
}

}  // namespace
}  // namespace meltsim_test
