// SPDX-License-Identifier: Apache-2.0
// A sound speed that follows what moves: where it goes, what it costs and what it gives, and that it follows from states and
// steps alone.
#include <cmath>
#include <string>
#include <vector>

#include "meltsim/physics/fluid.hpp"
#include "meltsim/physics/sound_speed.hpp"
#include "scenes.hpp"

namespace meltsim_test {
namespace {

/// A pool of four layers, and a jet that falls into it from five times its depth, later on: 1,280 particles, so that walls,
/// corners and the surface are all there and a second of it takes a second of time.
struct Pool {
  bool follows = true;
  int threads = 1;
  Precision precision = Precision::double_precision;
  double jet_from = 1.0, jet_until = 1.4;
  double density = 0;  ///< of a cube that floats in it [kg/m^3]; 0: none
  double modulus = 0;  ///< of the cube [Pa]
};
World pool(const Pool& p) {
  WorldDesc d = describe();
  d.spacing = 0.05;
  d.precision = p.precision;
  d.threads = p.threads;
  d.follow_sound_speed = p.follows;
  d.domain.bounded = true;
  d.domain.max = {1, 1.2, 0.8};
  d.heat.model = HeatModel::none;
  d.max_substeps = 1000;
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  MaterialDesc water;
  water.name = "water";
  water.viscosity = 0.5;  // so that what moves at first is at rest before the jet comes
  const MaterialId liquid = *w->add_material(water);
  FluidDesc f;
  f.material = liquid;
  f.shape = Shape::box({0, 0, 0}, {1, 0.2, 0.8});
  EXPECT_TRUE(w->add_fluid(f));
  if (p.density > 0) {
    MaterialDesc cork;
    cork.name = "cork";
    cork.density = p.density;
    cork.youngs_modulus = p.modulus;
    SolidDesc s;
    s.name = "cube";
    s.material = *w->add_material(cork);
    s.shape = Shape::box({0.3, 0.1, 0.3}, {0.5, 0.3, 0.5});
    EXPECT_TRUE(w->add_solid(s));
  }
  EmitterDesc e;
  e.material = liquid;
  e.center = {0.5, 1.0, 0.4};
  e.axis = {0, -1, 0};
  e.radius = 0.1;
  e.speed = 1;
  e.from = p.jet_from;
  e.until = p.jet_until;
  EXPECT_TRUE(w->add_emitter(e));
  return std::move(*w);
}
Ledger after(World& w, double seconds, double dt = 0.02) {
  for (int k = 0; k < static_cast<int>(std::lround(seconds / dt)); ++k) {
    const Status s = w.step(dt);
    EXPECT_TRUE(s) << s.error().message;
  }
  const StepResult r = w.synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  return *w.ledger();
}

// u is the integral of P/rho^2 over rho: 1e4 intervals of Simpson's rule hold 12 digits.
TEST(Sound, EnergyOfCompressionIsTheIntegralOfPressure) {
  for (const double phi : {1.001, 1.05, 1.5}) {
    const int n = 10000;
    double sum = 0;
    for (int k = 0; k <= n; ++k) {
      const double x = 1 + (phi - 1) * k / n, rho0 = 900, c = 30;
      const double p = physics::tait_pressure(physics::tait_stiffness(rho0, c), x) / (x * x * rho0);
      sum += p * (k == 0 || k == n ? 1 : k % 2 != 0 ? 4 : 2) * (phi - 1) / n / 3;
    }
    EXPECT_NEAR(physics::compression_share(phi, 1.0) * 30 * 30, sum, 1e-9 * sum) << phi;
  }
  EXPECT_EQ(physics::compression_share(0.7, 1.0), 0);  // no tension
  EXPECT_GT(physics::compression_share(0.7, 0.0), 0);
}

TEST(Sound, LevelsAreNotBelowTheSpeedAndLessThanOneLevelAbove) {
  for (double c = 10; c <= 40; c *= 1.013) {
    const double level = physics::sound_level_of(c, 40);
    EXPECT_GE(level, c);
    EXPECT_LT(level, c * physics::sound_level * (1 + 1e-12));
    EXPECT_LE(level, 40);
  }
  EXPECT_EQ(physics::sound_level_of(40, 40), 40);
  EXPECT_EQ(physics::sound_level_of(41, 40), 40);
}

// The scene's c is that of a fall from the nozzle, 1.1 m and a speed of 1 m/s; the pool alone asks for that of 0.2 m: 0.42 of it.
TEST(Sound, FallsInCalmLiquidAndIsThereAgainWhenTheJetComes) {
  MELTSIM_NEEDS_BACKEND();
  World follows = pool({}), fixed = pool({false});
  const double c = follows.resolved().sound_speed;
  EXPECT_EQ(c, fixed.resolved().sound_speed);
  const Ledger calm = after(follows, 0.7), calm_fixed = after(fixed, 0.7);
  EXPECT_LT(calm.sound_speed, 0.5 * c);
  EXPECT_GT(calm.sound_speed, 0.35 * c);
  EXPECT_LT(calm.step, 0.55 * calm_fixed.step);  // 0.42, and levels of 9 %
  EXPECT_LT(calm.density_error_max,
            0.01);  // 0.005 at rest; sums near walls are a little off (docs/limits.md)
  const Ledger falls = after(follows, 0.4), falls_fixed = after(fixed, 0.4);
  EXPECT_GT(falls.sound_speed, 0.9 * c);
  EXPECT_EQ(falls_fixed.sound_speed, c);
  EXPECT_EQ(falls_fixed.sound_work, 0);
  // The jet is in the pool: as compressed as it is without. Splashes are not alike from run to run: a factor of 2.
  const Ledger splash = after(follows, 0.4), splash_fixed = after(fixed, 0.4);
  EXPECT_LT(splash.density_error_mean, 2 * splash_fixed.density_error_mean);
  // Energy: what came in and what was lost, alike to a tenth of what the jet brought, 1 m of fall of its mass.
  const double jet = (splash_fixed.mass - calm_fixed.mass) * 9.81;
  EXPECT_EQ(splash.mass, splash_fixed.mass);
  EXPECT_NEAR(splash.kinetic + splash.potential, splash_fixed.kinetic + splash_fixed.potential, 0.1 * jet);
}

// Pressure over the Tait equation's at the same density is the stiffness that a sub-step was taken with. Before the jet comes c
// rises in every sub-step, by 1e-3 of itself; both numbers are double, and phi - 1 of 2e-4 leaves 11 digits. The pool heaves a little,
// so that at moments hardly any of its 1,280 particles is pressed.
TEST(Sound, EverySubStepIsTakenWithTheSoundSpeedThatTheLedgerSays) {
  MELTSIM_NEEDS_BACKEND();
  World w = pool({});
  const double full = w.resolved().sound_speed;
  after(w, 0.8);
  double before = w.ledger()->sound_speed;
  int rises = 0, pressed = 0, looked = 0;
  for (int k = 0; k < 1000 && before < 0.9 * full; ++k) {
    const std::uint64_t steps = w.synchronize().steps;
    require(w.step(4e-4));
    const Ledger l = *w.ledger();
    ASSERT_EQ(l.step, steps + 1) << "more than one sub-step";
    const ParticleData now = *w.particles();
    int compressed = 0;
    for (std::size_t i = 0; i < now.id.size(); ++i) {
      const double phi = now.density[i] / 1000;
      if (!is_fluid(now.tag[i]) || phi < 1.0002) continue;
      ++compressed;
      const double stiffness = now.pressure[i] / physics::tait_pressure(1.0, phi);
      ASSERT_NEAR(stiffness / physics::tait_stiffness(1000.0, l.sound_speed), 1, 1e-9) << "sub-step " << k;
    }
    ++looked;
    pressed += compressed > 500 ? 1 : 0;
    rises += l.sound_speed > before ? 1 : 0;
    before = l.sound_speed;
  }
  EXPECT_GE(before, 0.9 * full);
  EXPECT_GT(pressed, looked / 2);
  EXPECT_GT(rises, 100);
}

// A cube that floats: it is as stiff as sound is fast, and lies as deep as without.
TEST(Sound, ABodyFloatsAsDeepAsAtAFixedSoundSpeed) {
  MELTSIM_NEEDS_BACKEND();
  Pool p;
  p.density = 500;
  p.jet_from = 9, p.jet_until = 10;
  Pool q = p;
  q.follows = false;
  World follows = pool(p), fixed = pool(q);
  double height[2] = {0, 0};
  World* const both[2] = {&follows, &fixed};
  std::uint64_t steps[2] = {0, 0};
  for (int k = 0; k < 2; ++k) {
    after(*both[k], 1.0);
    for (int n = 0; n < 10; ++n) {  // it bobs: a mean of 0.4 s
      after(*both[k], 0.04);
      height[k] += (*both[k]->pieces())[0].center.y / 10;
    }
    steps[k] = both[k]->synchronize().steps;
  }
  EXPECT_LT(steps[0], 0.6 * steps[1]);
  EXPECT_NEAR(height[0], height[1], 0.2 * 0.05);  // a fifth of a spacing: places of single particles
}

TEST(Sound, ABodyWithAModulusKeepsTheSoundSpeedWhereItIs) {
  MELTSIM_NEEDS_BACKEND();
  Pool p;
  p.density = 500;
  p.modulus = 1e7;
  World w = pool(p);
  const double dt = w.resolved().stable_dt;
  const Ledger l = after(w, 0.2);
  EXPECT_EQ(l.sound_speed, w.resolved().sound_speed);
  EXPECT_EQ(w.resolved().stable_dt, dt);
}

// To the bit, in both precisions: however many threads there are, and wherever a host looks.
TEST(Sound, FollowsFromStatesAlone_StateHash) {
  MELTSIM_NEEDS_BACKEND();
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    Pool p, q;
    p.precision = q.precision = precision;
    q.threads = 3;
    World a = pool(p), b = pool(q);
    for (int k = 0; k < 65; ++k) {
      require(a.step(0.02));
      require(b.step(0.02));
      if (k % 3 == 0) {
        static_cast<void>(b.ledger());
        static_cast<void>(b.synchronize());
        static_cast<void>(b.resolved());
      }
    }
    EXPECT_EQ(*a.state_hash(), *b.state_hash());
    EXPECT_EQ(a.synchronize().steps, b.synchronize().steps);
  }
}

// While c falls, is low, rises and is back: a snapshot goes on in the same World and in another one, and a saved state does.
TEST(Sound, SnapshotsAndSavedStatesGoOn_StateHash) {
  MELTSIM_NEEDS_BACKEND();
  for (const int at : {3, 20, 39, 48}) {
    World a = pool({}), other = pool({});
    for (int k = 0; k < at; ++k) require(a.step(0.02));
    const auto snapshot = *a.snapshot();
    require(a.save_state(0));
    for (int k = at; k < at + 12; ++k) require(a.step(0.02));
    const std::uint64_t hash = *a.state_hash(), steps = a.synchronize().steps;
    const double c = a.ledger()->sound_speed;
    require(a.load_state(0));
    require(other.restore(snapshot.data(), snapshot.size()));
    EXPECT_EQ(other.stable_dt(), a.stable_dt());
    for (World* w : {&a, &other}) {
      for (int k = at; k < at + 12; ++k) require(w->step(0.02));
      EXPECT_EQ(*w->state_hash(), hash) << at;
      EXPECT_EQ(w->synchronize().steps, steps) << at;
      EXPECT_EQ(w->ledger()->sound_speed, c) << at;
    }
    require(a.restore(snapshot.data(), snapshot.size()));
    for (int k = at; k < at + 12; ++k) require(a.step(0.02));
    EXPECT_EQ(*a.state_hash(), hash) << at;
  }
}

TEST(Sound, SnapshotsPassBetweenWorldsThatFollowAndThatDoNot) {
  MELTSIM_NEEDS_BACKEND();
  World follows = pool({}), fixed = pool({false});
  after(follows, 0.3);
  after(fixed, 0.3);
  const auto from_follows = *follows.snapshot(), from_fixed = *fixed.snapshot();
  require(follows.restore(from_fixed.data(), from_fixed.size()));
  require(fixed.restore(from_follows.data(), from_follows.size()));
  const Ledger a = after(follows, 0.2), b = after(fixed, 0.2);
  EXPECT_LT(a.sound_speed, 0.5 * b.sound_speed);
  EXPECT_EQ(b.sound_speed, fixed.resolved().sound_speed);
}

/// A pool beside a paddle that the host may move at up to 3 m/s, which its derived sound speed allows for.
struct Paddle {
  World world;
  BodyId body;
};
Paddle paddle() {
  WorldDesc d = describe();
  d.spacing = 0.05;
  d.precision = Precision::double_precision;
  d.follow_sound_speed = true;
  d.domain.bounded = true;
  d.domain.max = {1, 1, 0.4};
  d.heat.model = HeatModel::none;
  d.max_substeps = 1000;
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  MaterialDesc m;
  m.viscosity = 0.5;
  const MaterialId water = *w->add_material(m);
  FluidDesc f;
  f.material = water;
  f.shape = Shape::box({0.2, 0, 0}, {1, 0.2, 0.4});
  EXPECT_TRUE(w->add_fluid(f));
  SolidDesc s;
  s.name = "paddle";
  s.material = water;
  s.motion = Motion::kinematic;
  s.max_speed = 3;
  s.shape = Shape::box({0, 0, 0}, {0.1, 0.6, 0.4});
  const auto body = w->add_solid(s);
  EXPECT_TRUE(body);
  return {std::move(*w), *body};
}

// A paddle that is set off at once is faster than any rise: c is there with its first step. What that gives the liquid is the
// energy of compression of every particle, m u(rho), times the change: 1e-6 for sums in another order.
TEST(Sound, IsThereWhenTheHostPushes_Work) {
  MELTSIM_NEEDS_BACKEND();
  Paddle p = paddle();
  World& w = p.world;
  const double full = w.resolved().sound_speed;
  after(w, 0.4);
  require(w.snapshot());  // the ledger's work is that up to the last look or snapshot
  const Ledger calm = *w.ledger();
  EXPECT_LT(calm.sound_speed, 0.7 * full);
  const ParticleData before = *w.particles();
  double mass = 0;
  for (std::size_t i = 0; i < before.id.size(); ++i)
    if (is_fluid(before.tag[i]))
      mass += before.mass[i] * physics::compression_share(before.density[i] / 1000, 1.0);
  BodyMotion motion;
  motion.velocity = {3, 0, 0};
  require(w.set_motion(p.body, motion));
  require(w.step(1e-4));
  require(w.snapshot());
  const Ledger l = *w.ledger();
  ASSERT_EQ(l.step, calm.step + 1);
  EXPECT_GT(l.sound_speed, 10 * 3);
  EXPECT_LE(l.sound_speed, full);
  const double expected = mass * (l.sound_speed * l.sound_speed - calm.sound_speed * calm.sound_speed);
  EXPECT_GT(expected, 0.01);
  EXPECT_NEAR(l.sound_work - calm.sound_work, expected, 1e-6 * expected);
  EXPECT_LT(after(w, 0.1, 0.002).density_error_mean, 0.02);
}

TEST(Sound, IsRefusedBesideASoundSpeed) {
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.sound_speed = 20;
  d.follow_sound_speed = true;
  const auto w = World::create(d);
  ASSERT_FALSE(w);
  EXPECT_NE(w.error().message.find("follow_sound_speed: a sound_speed of 20 m/s"), std::string::npos)
      << w.error().message;
}

}  // namespace
}  // namespace meltsim_test
