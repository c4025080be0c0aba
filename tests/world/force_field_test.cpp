// SPDX-License-Identifier: Apache-2.0
// Force fields: what is accelerated, by how much, and what is not; what is refused.
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Without gravity, so that fields alone act.
WorldDesc still(Precision precision = Precision::double_precision) {
  WorldDesc d = describe();
  d.precision = precision;
  d.spacing = 0.1;
  d.gravity = {};
  d.heat.model = HeatModel::none;
  return d;
}

World make(const WorldDesc& d) {
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  return std::move(*w);
}

MaterialId add(World& w, const char* name, double density) {
  MaterialDesc m;
  m.name = name;
  m.density = density;
  return *w.add_material(m);
}

void pour(World& w, MaterialId water, Vec3d min, Vec3d max) {
  FluidDesc f;
  f.material = water;
  f.shape = Shape::box(min, max);
  require(w.add_fluid(f));
}

BodyId solid(World& w, MaterialId material, Motion motion, Vec3d min, Vec3d max) {
  SolidDesc s;
  s.material = material;
  s.motion = motion;
  s.shape = Shape::box(min, max);
  if (motion == Motion::proxy) s.mass = 30;
  auto id = w.add_solid(s);
  EXPECT_TRUE(id) << id.error().message;
  return *id;
}

ForceFieldDesc uniform(Vec3d a, std::optional<Shape> where = {}) {
  ForceFieldDesc f;
  f.acceleration = a;
  f.shape = std::move(where);
  return f;
}

void run(World& w, int steps, double dt) {
  for (int k = 0; k < steps; ++k) require(w.step(dt));
  const StepResult r = w.synchronize();
  ASSERT_FALSE(r.halted) << r.halt_reason;
}

/// Acceleration in the first sub-step of every particle: liquid at rest on its lattice feels nothing else.
std::vector<Vec3d> first_kick(World& w, double dt) {
  require(w.step(dt));
  EXPECT_EQ(w.steps(), 1u);
  std::vector<Vec3d> a;
  const ParticleData p = *w.particles();
  for (const Vec3d& v : p.velocity) a.push_back(v * (1 / dt));
  return a;
}

// Every kind of region, turned, against Shape::contains, which is another code; every kind of field against its formula written
// out. 1,000 particles of which a part is inside. Rounding of one sub-step of 1e-4 s: 1e-12 of 1 m/s^2; in single precision the
// lattice's own rounding is a pressure of 100 m^2/s^2 times 1e-6, 1e-4 m/s^2 over a spacing, and more at edges: 1e-3.
TEST(ForceField, ActsWhereItsShapeIsAndAsItsFormulaSays) {
  MELTSIM_NEEDS_BACKEND();
  const Vec3d about{0.4, 0.7, 0.45}, n{2 / 3.0, -1 / 3.0, 2 / 3.0};
  const Shape box =
      Shape::box({-0.35, -0.3, -0.2}, {0.3, 0.4, 0.33}).transformed({0.5, 0.5, 0.5}, {1, 2, 0.5}, 0.7, 1.1);
  const Shape ball = Shape::sphere({0.1, 0, 0}, 0.36).transformed({0.4, 0.55, 0.5}, {0, 0, 1}, 0.3, 1.2);
  const Shape rod = Shape::cylinder({0.1, 0.2, 0.1}, {0.83, 0.7, 0.92}, 0.31);
  struct Case {
    ForceFieldKind kind;
    std::optional<Shape> shape;
    double radius;
    int power;
    std::function<Vec3d(Vec3d)> expected;
  };
  const auto fall = [](double r, double radius, int power) {
    return r < radius ? r / radius : std::pow(r / radius, power);
  };
  const auto swirl = [&](Vec3d x, double radius, int power) {
    const Vec3d d = x - about, across = d - n * dot(d, n);
    return cross(n, across) * (3 / length(across) * fall(length(across), radius, power));
  };
  const Vec3d wind{1, -2, 0.5}, spin{0.3, 0.2, -0.9};
  const double dt = 1e-4, rate = 40;
  const std::vector<Case> cases{
      {ForceFieldKind::uniform, box, 0, 0,
       [](Vec3d) {
         return Vec3d{1, -2, 0.5};
       }},
      {ForceFieldKind::radial, ball, 0.2, -2,
       [&](Vec3d x) { return (x - about) * (3 / length(x - about) * fall(length(x - about), 0.2, -2)); }},
      {ForceFieldKind::radial, std::nullopt, 0.3, -1,
       [&](Vec3d x) { return (x - about) * (3 / length(x - about) * fall(length(x - about), 0.3, -1)); }},
      {ForceFieldKind::vortex, rod, 0.2, -1, [&](Vec3d x) { return swirl(x, 0.2, -1); }},
      {ForceFieldKind::vortex, box, 0.4, 1, [&](Vec3d x) { return swirl(x, 1e9, 1) * (1e9 / 0.4); }},
      {ForceFieldKind::radial, rod, 0, 0, [&](Vec3d x) { return (x - about) * (3 / length(x - about)); }},
      {ForceFieldKind::drag, ball, 0, 0,
       [&](Vec3d x) { return (wind + cross(spin, x - about)) * (-std::expm1(-rate * dt) / dt); }}};
  for (const Precision precision : {Precision::double_precision, Precision::single_precision})
    for (const Case& c : cases) {
      WorldDesc d = still(precision);
      d.sound_speed = 10;
      World w = make(d);
      pour(w, add(w, "water", 1000), {0, 0, 0}, {1, 1, 1});
      ForceFieldDesc f;
      f.kind = c.kind;
      f.shape = c.shape;
      f.acceleration = f.velocity = {1, -2, 0.5};
      f.center = about;
      f.axis = n * 3.0;
      f.strength = 3;
      f.radius = c.radius;
      f.power = c.power;
      f.angular_velocity = spin;
      f.rate = rate;
      require(w.add_force_field(f));
      const std::vector<Vec3d> places = w.particles()->position;
      const std::vector<Vec3d> a = first_kick(w, dt);
      int inside = 0;
      const double eps = precision == Precision::double_precision ? 1e-11 : 1e-3;
      for (std::size_t i = 0; i < a.size(); ++i) {
        const bool in = !c.shape || c.shape->contains(places[i]);
        inside += in ? 1 : 0;
        const Vec3d is = in ? c.expected(places[i]) : Vec3d{};
        EXPECT_LT(length(a[i] - is), eps * (1 + length(is)))
            << int(c.kind) << " at " << places[i].x << ' ' << places[i].y;
      }
      if (c.shape) {
        EXPECT_GT(inside, 150);
        EXPECT_LT(inside, 800);
      }
    }
}

// Gravity and a field of the opposite acceleration: neither liquid nor what holds it up at the floor feels anything. Nothing moves
// faster than rounding makes it in half a second, and the floor carries nothing of 500 N. Without what the images lack being
// taken from the sum of both, the first layer is thrown up at 5 m/s^2.
TEST(ForceField, AgainstGravityMakesAColumnWeightless) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = still();
  d.gravity = {0, -9.81, 0};
  d.domain.bounded = true;
  d.domain.max = {0.8, 1.2, 0.8};
  World w = make(d);
  pour(w, add(w, "water", 1000), {0, 0, 0}, {0.8, 0.8, 0.8});
  const ForceFieldId id = *w.add_force_field(uniform({0, 9.81, 0}, Shape::box({-1, -1, -1}, {2, 2, 2})));
  ProbeDesc floor;
  floor.kind = ProbeKind::force;
  floor.wall = 2;
  floor.fields = {"force"};
  floor.every = 0.1;
  require(w.add_probe(floor));
  run(w, 5, 0.1);
  EXPECT_LT(w.totals()->max_speed, 1e-10);
  const std::vector<ProbeSeries> samples = *w.take_samples();
  ASSERT_FALSE(samples.front().values.empty());
  for (const double v : samples.front().values) EXPECT_LT(std::fabs(v), 1e-6);
  require(w.remove(id));
  run(w, 1, 0.1);
  EXPECT_GT(w.totals()->max_speed, 1e-2);  // it has its weight again
}

/// Liquid, a free body and a rigid one, out of each other's reach.
World one_of_each(const WorldDesc& d) {
  World w = make(d);
  pour(w, add(w, "water", 1000), {0, 0, 0}, {0.5, 0.5, 0.5});
  const MaterialId wood = add(w, "wood", 700);
  solid(w, wood, Motion::free, {1, 0, 0}, {1.4, 0.4, 0.4});
  solid(w, wood, Motion::rigid, {0, 1, 0}, {0.4, 1.4, 0.4});
  return w;
}

// Momentum comes from fields alone where there is no wall: to rounding, of fixed-point sums of pieces 1e-9. Work is the change of
// kinetic energy where nothing is compressed: of liquid that is accelerated as a whole, and of a rigid body.
TEST(ForceField, ImpulseAndWorkAreInTheLedger) {
  MELTSIM_NEEDS_BACKEND();
  World w = one_of_each(still());
  ForceFieldDesc f;
  f.kind = ForceFieldKind::vortex;
  f.strength = 2;
  require(w.add_force_field(f));
  f.kind = ForceFieldKind::radial;
  f.strength = -1;
  f.radius = 0.3;
  f.power = -1;
  f.center = Vec3d{0.2, 0.3, 0.1};
  require(w.add_force_field(f));
  f.kind = ForceFieldKind::drag;
  f.velocity = {1, 2, 3};
  f.rate = 0.5;
  require(w.add_force_field(f));
  require(w.add_force_field(uniform({0.3, 0.1, 0})));
  run(w, 20, 0.02);
  const Ledger l = *w.ledger();
  const double scale = length(l.momentum);
  EXPECT_GT(scale, 10);
  EXPECT_LT(length(l.momentum - l.field_impulse), 1e-9 * scale);
  EXPECT_LT(length(w.totals()->field_impulse - l.field_impulse), 1e-14 * scale);

  World falls = make(still());
  pour(falls, add(falls, "water", 1000), {0, 0, 0}, {0.5, 0.5, 0.5});
  solid(falls, add(falls, "wood", 700), Motion::rigid, {0, 1, 0}, {0.4, 1.4, 0.4});
  require(falls.add_force_field(uniform({0.3, 2, 0})));
  run(falls, 20, 0.02);
  const Ledger e = *falls.ledger();
  EXPECT_GT(e.kinetic, 10);
  EXPECT_NEAR(e.field_work / e.kinetic, 1, 1e-9);
}

// A vortex that grows with the distance is the acceleration of a rigid rotation: a rigid body about its centre then has
// omega = s/R t, whatever its inertia. The torque is that in the middle of a sub-step, half a drift along the tangent ahead, and so too
// large by (omega dt/2)^2: below 2.3e-4.
TEST(ForceField, AVortexTurnsARigidBodyAtAConstantAngularAcceleration) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(still());
  const BodyId body = solid(w, add(w, "wood", 700), Motion::rigid, {0, 0, 0}, {0.6, 0.4, 0.2});
  ForceFieldDesc f;
  f.kind = ForceFieldKind::vortex;
  f.axis = {0, 0, 2};
  f.center = Vec3d{0.3, 0.2, 0.1};
  f.strength = 1.5;
  f.radius = 0.5;
  f.power = 1;
  require(w.add_force_field(f));
  require(w.watch_forces(body));
  const double dt = w.stable_dt();
  EXPECT_LT(dt, 1e-2);
  run(w, 50, 0.02);
  const PieceInfo p = w.pieces()->front();
  EXPECT_NEAR(p.angular_velocity.z, 3.0, 3 * std::pow(0.5 * 3 * dt, 2));
  EXPECT_LT(length(p.velocity), 1e-9);
  EXPECT_NEAR(w.ledger()->field_work / w.ledger()->kinetic, 1,
              1e-3);  // turning within a sub-step, of first order
  const BodyForces forces = w.take_forces()->front();
  EXPECT_NEAR(forces.total.angular.z, w.ledger()->angular_momentum.z,
              1e-6 * forces.total.angular.z);  // torque
}

// Drag as in Stokes' law, v = u (1 - exp(-k t)): exact for any sub-step, for liquid and bodies; also where 1/k is a thousandth of a
// sub-step. A rigid body takes up the wind's rotation at the same rate; its velocity of the beginning and its place of the middle of a
// sub-step make that first order in dt: 1e-3 at 100 sub-steps per time constant.
TEST(ForceField, DragTakesUpTheWindExponentially) {
  MELTSIM_NEEDS_BACKEND();
  for (const double rate : {0.5, 20.0, 1e5}) {
    World w = make(still());
    pour(w, add(w, "water", 1000), {0, 0, 0}, {0.4, 0.4, 0.4});
    solid(w, add(w, "wood", 700), Motion::free, {1, 0, 0}, {1.4, 0.4, 0.4});
    ForceFieldDesc f;
    f.kind = ForceFieldKind::drag;
    f.velocity = {2, -1, 0.5};
    f.rate = rate;
    require(w.add_force_field(f));
    for (int k = 0; k < 5; ++k) {
      run(w, 1, 0.05);
      const Vec3d is = f.velocity * -std::expm1(-rate * w.time());
      const ParticleData p = *w.particles();
      for (const Vec3d& v : p.velocity) EXPECT_LT(length(v - is), 1e-9) << rate;
    }
  }
  // Three winds at once, each stiff, act as their mean. Added up they would diverge.
  World storm = make(still());
  pour(storm, add(storm, "water", 1000), {0, 0, 0}, {0.4, 0.4, 0.4});
  ForceFieldDesc gust;
  gust.kind = ForceFieldKind::drag;
  gust.rate = 1e5;
  for (const double speed : {1.0, 2.0, 3.0}) {
    gust.velocity = {speed, 0, 0};
    require(storm.add_force_field(gust));
  }
  run(storm, 5, 0.05);
  EXPECT_NEAR(storm.totals()->max_speed, 2, 1e-9);
  World w = make(still());
  solid(w, add(w, "wood", 700), Motion::rigid, {0, 0, 0}, {0.4, 0.4, 0.2});
  ForceFieldDesc f;
  f.kind = ForceFieldKind::drag;
  f.center = Vec3d{0.2, 0.2, 0.1};
  f.angular_velocity = {0, 0, 2};
  f.rate = 2;
  require(w.add_force_field(f));
  for (int k = 0; k < 100; ++k) run(w, 1, 0.005);
  EXPECT_NEAR(w.pieces()->front().angular_velocity.z, 2 * -std::expm1(-1.0), 2e-3);
}

// What falls in still air, v = g/k (1 - exp(-k t)): exact for any sub-step, as gravity stays as it is. While drag was taken beside it at the
// beginning of a sub-step the speed was k dt/(1 - exp(-k dt)) times that, 1.6 times for k dt = 1. 1e-6: sums of some
// hundred sub-steps.
TEST(ForceField, DragBesideGravityFallsAtTheRightSpeed) {
  MELTSIM_NEEDS_BACKEND();
  for (const double rate : {3.0, 100.0, 1e4}) {
    WorldDesc d = still();
    d.gravity = {0, -10, 0};
    World w = one_of_each(d);
    ForceFieldDesc f;
    f.kind = ForceFieldKind::drag;
    f.rate = rate;
    require(w.add_force_field(f));
    for (int k = 0; k < 5; ++k) {
      run(w, 1, 0.05);
      const Vec3d is = {0, 10 / rate * std::expm1(-rate * w.time()), 0};
      const ParticleData p = *w.particles();
      for (const Vec3d& v : p.velocity) EXPECT_LT(length(v - is), 1e-6 * length(is)) << rate;
    }
  }
}

// Who is moved: a proxy by the same acceleration as its particles, and its host is told the impulse; bodies that the host moves or that
// are fixed or held by nothing; each kind only where the field says so.
TEST(ForceField, MovesWhatCanMoveAndNothingElse) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(still());
  const MaterialId water = add(w, "water", 1000), wood = add(w, "wood", 700);
  pour(w, water, {0, 3, 0}, {0.4, 3.4, 0.4});
  const BodyId proxy = solid(w, wood, Motion::proxy, {0, 0, 0}, {0.4, 0.4, 0.4});
  const BodyId carried = solid(w, wood, Motion::kinematic, {1, 0, 0}, {1.4, 0.4, 0.4});
  const BodyId fixed = solid(w, wood, Motion::fixed, {2, 0, 0}, {2.4, 0.4, 0.4});
  const BodyId held = solid(w, wood, Motion::rigid, {3, 0, 0}, {3.4, 0.4, 0.4});
  require(w.hold(held));
  ForceFieldDesc f = uniform({1, 2, -1});
  f.liquid = false;
  const ForceFieldId id = *w.add_force_field(f);
  const auto fastest = [&](BodyId b) {
    double most = 0;
    const ParticleData p = *w.particles();
    for (std::size_t i = 0; i < p.id.size(); ++i)
      if (is_solid(p.tag[i]) && body_of(p.tag[i]) == b.index + 1u)
        most = std::max(most, length(p.velocity[i]));
    return most;
  };
  const auto liquid = [&] {
    double most = 0;
    const ParticleData p = *w.particles();
    for (std::size_t i = 0; i < p.id.size(); ++i)
      if (is_fluid(p.tag[i])) most = std::max(most, length(p.velocity[i]));
    return most;
  };
  run(w, 10, 0.01);
  EXPECT_LT(length(w.proxy(proxy)->velocity - Vec3d{0.1, 0.2, -0.1}), 1e-9);
  const BodyForces forces = w.take_forces()->front();
  EXPECT_LT(length(forces.total.linear - Vec3d{3, 6, -3}), 1e-6);  // 30 kg
  for (const BodyId b : {carried, fixed, held}) EXPECT_EQ(fastest(b), 0);
  EXPECT_LT(liquid(), 1e-12);
  f.liquid = true;
  f.bodies = false;
  require(w.set_force_field(id, f));
  run(w, 10, 0.01);
  EXPECT_NEAR(liquid(), std::sqrt(6.0) * 0.1, 1e-9);
  EXPECT_LT(length(w.proxy(proxy)->velocity - Vec3d{0.1, 0.2, -0.1}), 1e-9);
}

// A change costs no plan and no upload: a state that was saved before it is there, which any of both would have lost. Strength per step
// sums up; times begin and end it.
TEST(ForceField, ChangesFromStepToStepWithoutANewPlan) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(still());
  pour(w, add(w, "water", 1000), {0, 0, 0}, {0.4, 0.4, 0.4});
  run(w, 1, 0.01);
  EXPECT_FALSE(w.plan().to_string().find("force_fields") != std::string::npos);  // no bytes
  const ForceFieldId id = *w.add_force_field(uniform({0, 8, 0}));
  run(w, 1, 0.01);
  EXPECT_TRUE(w.plan().to_string().find("force_fields") != std::string::npos);
  double speed = 0.08;
  require(w.save_state(0));
  for (int k = 0; k < 6; ++k) {
    require(w.set_force_field(id, uniform({0, double(k), 0})));
    require(w.step(0.01));
    speed += 0.01 * k;
  }
  EXPECT_NEAR(w.totals()->max_speed, speed, 1e-9);
  const ForceFieldId second = *w.add_force_field(uniform({0, 1, 0}));
  run(w, 1, 0.01);
  require(w.remove(second));
  require(w.load_state(0));
  EXPECT_NEAR(w.totals()->max_speed, 0.08, 1e-12);
  EXPECT_NEAR(w.ledger()->field_impulse.y, 0.08 * w.ledger()->mass, 1e-9);
  ForceFieldDesc later = uniform({0, 4, 0});
  later.from = w.time() + 0.02;
  later.until = w.time() + 0.05;
  require(w.set_force_field(id, later));
  run(w, 10, 0.01);
  EXPECT_NEAR(w.totals()->max_speed, 0.08 + 4 * 0.03, 1e-9);
  require(w.remove(id));
  run(w, 1, 0.01);
  EXPECT_FALSE(w.plan().to_string().find("force_fields") != std::string::npos);
}

// A World that goes back goes on to the bit, with the same field; what the fields did is part of the snapshot.
TEST(ForceField, SnapshotsHoldWhatItDidAndGoOnToTheBit) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = still(Precision::single_precision);
  d.gravity = {0, -9.81, 0};
  d.domain.bounded = true;
  d.domain.max = {1, 1, 1};
  World w = make(d);
  pour(w, add(w, "water", 1000), {0, 0, 0}, {0.5, 0.6, 1});
  ForceFieldDesc f;
  f.kind = ForceFieldKind::vortex;
  f.shape = Shape::cylinder({0.5, 0, 0.5}, {0.5, 1, 0.5}, 0.4);
  f.strength = 6;
  f.radius = 0.2;
  require(w.add_force_field(f));
  run(w, 5, 0.02);
  const auto snapshot = *w.snapshot();
  const Ledger then = *w.ledger();
  EXPECT_NE(then.field_work, 0);
  run(w, 5, 0.02);
  const std::uint64_t end = *w.state_hash();
  require(w.restore(snapshot.data(), snapshot.size()));
  EXPECT_EQ(w.ledger()->field_work, then.field_work);
  EXPECT_EQ(w.ledger()->field_impulse.x, then.field_impulse.x);
  run(w, 5, 0.02);
  EXPECT_EQ(*w.state_hash(), end);
}

// Sub-steps and the speed of sound know it: as of a gravity of that size, whatever it points to.
TEST(ForceField, SoundAndSubStepsFollowWhatItMayDo) {
  MELTSIM_NEEDS_BACKEND();
  const auto resolved = [](double gravity, std::optional<ForceFieldDesc> field, bool later) {
    WorldDesc d = still();
    d.gravity = {0, -gravity, 0};
    d.domain.bounded = true;
    d.domain.max = {1, 1, 1};
    World w = make(d);
    pour(w, add(w, "water", 1000), {0, 0, 0}, {1, 0.9, 1});
    if (later) run(w, 1, 1e-3);
    if (field) require(w.add_force_field(*field));
    run(w, 1, 1e-3);
    return w.resolved();
  };
  const Resolved heavy = resolved(50, std::nullopt, false);
  for (const bool later : {false, true}) {
    const Resolved pushed = resolved(0, uniform({0, 0, 50}), later);
    EXPECT_NEAR(pushed.sound_speed / heavy.sound_speed, 1, 0.05);  // 1 m, and 0.95 of fall
    EXPECT_NEAR(pushed.stable_dt / heavy.stable_dt, 1, 0.05);
    ForceFieldDesc wind;
    wind.kind = ForceFieldKind::drag;
    wind.velocity = {6, 8, 0};
    wind.rate = 1;
    EXPECT_NEAR(resolved(0, wind, later).sound_speed, 100, 1e-9);  // ten times 10 m/s
  }
}

TEST(ForceField, WhatCannotBeIsRefusedAndChangesNothing) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = still();
  d.sound_speed = 40;
  World w = make(d), other = make(d);
  pour(w, add(w, "water", 1000), {0, 0, 0}, {0.4, 0.4, 0.4});
  const ForceFieldId id = *w.add_force_field(uniform({0, 1, 0}));
  run(w, 1, 0.01);
  const std::uint64_t before = *w.state_hash();
  const auto refused = [&](const std::string& word, const std::function<void(ForceFieldDesc&)>& spoil) {
    ForceFieldDesc f = uniform({0, 1, 0});
    f.name = "gust";
    spoil(f);
    const auto added = w.add_force_field(f);
    ASSERT_FALSE(added) << word;
    EXPECT_EQ(added.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(added.error().message.find(word), std::string::npos) << added.error().message;
    EXPECT_NE(added.error().message.find(f.name), std::string::npos) << added.error().message;
    const Status set = w.set_force_field(id, f);
    EXPECT_FALSE(set) << word;
    EXPECT_NE(set.error().message.find(word), std::string::npos) << set.error().message;
  };
  refused("acceleration", [](ForceFieldDesc& f) { f.acceleration.y = nan; });
  refused("center", [](ForceFieldDesc& f) { f.center = Vec3d{0, infinity, 0}; });
  refused("strength", [](ForceFieldDesc& f) { f.strength = nan; });
  refused("radius", [](ForceFieldDesc& f) { f.radius = -0.1; });
  refused("radius", [](ForceFieldDesc& f) {
    f.kind = ForceFieldKind::radial;
    f.power = -2;
  });
  refused("power", [](ForceFieldDesc& f) {
    f.kind = ForceFieldKind::vortex;
    f.radius = 1;
    f.power = -3;
  });
  refused("axis", [](ForceFieldDesc& f) {
    f.kind = ForceFieldKind::vortex;
    f.axis = {};
  });
  refused("rate", [](ForceFieldDesc& f) { f.rate = -1; });
  refused("velocity", [](ForceFieldDesc& f) { f.velocity.z = -infinity; });
  refused("half the sound_speed", [](ForceFieldDesc& f) {
    f.kind = ForceFieldKind::drag;
    f.rate = 1;
    f.velocity = {25, 0, 0};
  });
  refused("contains nothing", [](ForceFieldDesc& f) { f.shape = Shape{}; });
  refused("sphere.radius", [](ForceFieldDesc& f) { f.shape = Shape::sphere({}, -1); });
  refused("box, a sphere or a cylinder", [](ForceFieldDesc& f) {
    f.shape = Shape::torus({}, {0, 1, 0}, 1, 0.2);
  });
  refused("box, a sphere or a cylinder", [](ForceFieldDesc& f) {
    f.shape = Shape::unite({Shape::sphere({}, 1), Shape::sphere({1, 0, 0}, 1)});
  });
  refused("box, a sphere or a cylinder", [](ForceFieldDesc& f) {
    f.shape = Shape::capsule({}, {1, 0, 0}, 1);
  });
  refused("acts on nothing", [](ForceFieldDesc& f) { f.liquid = f.bodies = false; });
  refused("from", [](ForceFieldDesc& f) { f.from = -1; });
  refused("until", [](ForceFieldDesc& f) { f.until = 0; });
  refused("kind", [](ForceFieldDesc& f) { f.kind = static_cast<ForceFieldKind>(9); });
  ForceFieldDesc twin = uniform({0, 1, 0});
  twin.name = "field1";
  EXPECT_NE(w.add_force_field(twin).error().message.find("another name"), std::string::npos);
  // Handles: null, of another World, removed before.
  EXPECT_FALSE(w.set_force_field({}, twin));
  const ForceFieldId foreign = *other.add_force_field(twin);
  EXPECT_NE(w.set_force_field(foreign, twin).error().message.find("of this World"), std::string::npos);
  EXPECT_FALSE(w.remove(foreign));
  std::vector<ForceFieldId> more;
  for (int k = 1; k < 16; ++k) more.push_back(*w.add_force_field(uniform({})));
  const auto full = w.add_force_field(uniform({}));
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error().code, ErrorCode::capacity);
  EXPECT_NE(full.error().message.find("16"), std::string::npos);
  for (const ForceFieldId field : more) require(w.remove(field));
  EXPECT_FALSE(w.remove(more[3]));
  const ForceFieldId again = *w.add_force_field(uniform({}));
  EXPECT_FALSE(w.remove(more[0]));  // the same row, another field
  require(w.remove(again));
  EXPECT_EQ(w.force_field(id)->name, "field1");
  EXPECT_EQ(w.force_field(id)->acceleration.y, 1);
  EXPECT_FALSE(w.force_field(more[0]));
  EXPECT_EQ(*w.state_hash(), before);
  run(w, 1, 0.01);
  EXPECT_NEAR(w.totals()->max_speed, 0.02, 1e-12);  // the first one is what it was
}

}  // namespace
}  // namespace meltsim_test
