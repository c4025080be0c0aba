// SPDX-License-Identifier: Apache-2.0
// What acts on bodies that a host watches, and proxies: rigid bodies of a host's physics engine.
#include <cmath>
#include <string>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double g = 9.81;

WorldDesc tank(Vec3d size, double spacing, Precision precision = Precision::single_precision) {
  WorldDesc d = describe();
  d.precision = precision;
  d.spacing = spacing;
  d.domain.bounded = true;
  d.domain.max = size;
  d.heat.model = HeatModel::none;
  return d;
}

World make(const WorldDesc& d) {
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  return std::move(*w);
}

MaterialId material(World& w, double density, const std::string& name = "stone") {
  MaterialDesc m;
  m.name = name;
  m.density = density;
  return *w.add_material(m);
}

void pour(World& w, const Shape& shape) {
  FluidDesc f;
  f.shape = shape;
  f.material = material(w, 1000, "water");
  require(w.add_fluid(f));
}

BodyId body(World& w, Motion motion, const Shape& shape, double density = 2000, Vec3d velocity = {}) {
  SolidDesc s;
  s.material = material(w, density, "stone" + std::to_string(density) + std::to_string(int(motion)));
  s.shape = shape;
  s.motion = motion;
  s.velocity = velocity;
  const auto id = w.add_solid(s);
  EXPECT_TRUE(id) << id.error().message;
  return *id;
}

BodyId proxy(World& w, const Shape& shape, double mass, Vec3d velocity = {}, Vec3d spin = {}) {
  SolidDesc s;
  s.material = material(w, 1000, "hull");
  s.shape = shape;
  s.motion = Motion::proxy;
  s.mass = mass;
  s.velocity = velocity;
  s.angular_velocity = spin;
  s.max_speed = 2;
  const auto id = w.add_solid(s);
  EXPECT_TRUE(id) << id.error().message;
  return *id;
}

BodyForces only(World& w) {
  const auto all = w.take_forces();
  EXPECT_TRUE(all) << all.error().message;
  EXPECT_EQ(all->size(), 1u);
  return all->at(0);
}

void run(World& w, int steps, double dt) {
  for (int k = 0; k < steps; ++k) require(w.step(dt));
  const StepResult r = w.synchronize();
  ASSERT_FALSE(r.halted) << r.halt_reason;
}

Vec3d momentum(const PieceInfo& p) { return p.velocity * p.mass; }
Vec3d spin(const PieceInfo& p) { return p.inertia * p.angular_velocity; }

// The impulse on a body that can move is its change of momentum less that by gravity, the angular impulse its change of spin,
// in every sub-step: sums are exact to 2^-40 of a particle's largest, velocities in double to 1e-16 of a metre per second
// some thousand times. 1e-9 of what water at 1 m/s does to it. It rolls off another body and into water, so that pressure,
// viscosity and contact all take part.
TEST(Forces, AreTheChangeOfMomentumAndSpin) {
  MELTSIM_NEEDS_BACKEND();
  for (const Motion motion : {Motion::free, Motion::rigid}) {
    World w = make(tank({1.2, 1.2, 1.2}, 0.1, Precision::double_precision));
    pour(w, Shape::box({0, 0, 0}, {1.2, 0.4, 1.2}));
    body(w, Motion::fixed, Shape::box({0.3, 0.3, 0.3}, {0.6, 0.6, 0.6}));
    const BodyId id = body(w, motion, Shape::box({0.5, 0.6, 0.5}, {0.8, 0.9, 0.8}), 1500);
    require(w.watch_forces(id));
    require(w.prepare());
    PieceInfo before = w.pieces()->at(1);
    double contact = 0, liquid = 0;
    for (int k = 0; k < 40; ++k) {
      run(w, 10, 0.001);
      const PieceInfo after = w.pieces()->at(1);
      const BodyForces f = only(w);
      EXPECT_NEAR(f.seconds, 0.01, 1e-12);
      const Vec3d got = f.total.linear + Vec3d{0, -g * after.mass * f.seconds, 0};
      EXPECT_LT(length(momentum(after) - momentum(before) - got), 1e-9 * after.mass) << k;
      EXPECT_LT(length(f.position - after.center), 0.01);  // a step away
      if (motion == Motion::rigid) {
        EXPECT_LT(length(spin(after) - spin(before) - f.total.angular), 1e-7 * after.mass) << k;
      }
      contact += length(f.contact.linear);
      liquid += length(f.pressure.linear);
      before = after;
    }
    EXPECT_GT(contact, 1);
    EXPECT_GT(liquid, 1);
  }
}

// A reading has the forces that it was asked for, whatever becomes of the bodies before the host takes it.
TEST(Forces, OfAReadingAreThoseOfItsRequest) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(tank({1.2, 1.2, 1.2}, 0.1));
  const BodyId stays = body(w, Motion::free, Shape::box({0.2, 0.2, 0.2}, {0.4, 0.4, 0.4})),
               leaves = body(w, Motion::rigid, Shape::box({0.6, 0.2, 0.6}, {0.8, 0.4, 0.8}));
  require(w.watch_forces(stays));
  require(w.watch_forces(leaves));
  run(w, 4, 0.005);
  ReadRequest what;
  what.forces = true;
  const auto ticket = w.request(what);
  ASSERT_TRUE(ticket) << ticket.error().message;
  require(w.watch_forces(stays, false));
  require(w.remove(leaves));
  run(w, 4, 0.005);
  const auto reading = w.take(*ticket);
  ASSERT_TRUE(reading) << reading.error().message;
  ASSERT_EQ(reading->forces.size(), 2u);
  EXPECT_EQ(reading->forces[0].body.index, stays.index);
  EXPECT_EQ(reading->forces[1].body.index, leaves.index);
  EXPECT_NEAR(reading->forces[1].seconds, 0.02, 1e-8);  // four steps in single precision
}

// A block that rests on a plate presses it with its weight: 1 %, of which the last oscillation of a settling body is most.
TEST(Forces, OfAPlateUnderARestingBodyAreItsWeight) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(tank({1.2, 1.2, 1.2}, 0.1));
  const BodyId plate = body(w, Motion::kinematic, Shape::box({0.2, 0, 0.2}, {1.0, 0.2, 1.0}));
  const BodyId block = body(w, Motion::free, Shape::box({0.4, 0.2, 0.4}, {0.8, 0.6, 0.8}));
  require(w.watch_forces(plate));
  require(w.watch_forces(block));
  run(w, 400, 0.005);
  require(w.take_forces());
  run(w, 200, 0.005);
  const auto f = *w.take_forces();
  ASSERT_EQ(f.size(), 2u);
  EXPECT_EQ(f[0].body.index, plate.index);
  const double weight = 2000 * 0.064 * g;
  EXPECT_NEAR(f[0].total.linear.y / f[0].seconds, -weight, 0.01 * weight);
  EXPECT_NEAR(f[1].contact.linear.y / f[1].seconds, weight, 0.01 * weight);
  EXPECT_EQ(f[0].pressure.linear.y, 0) << "there is no liquid";
  EXPECT_LT(length(f[0].contact.linear + f[1].contact.linear), 1e-5 * weight * f[0].seconds)
      << "what one gets the other gives";
}

// A body that is held under water loses the weight of what it displaces, as in Load.AHeldBodyLosesTheWeightOfWhatItDisplaces:
// 6 % at 4 spacings, because the edge of a body displaces a little more than its particles' volume.
TEST(Forces, OnAHeldBodyAreItsBuoyancy) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(tank({1.2, 1.4, 1.2}, 0.1));
  pour(w, Shape::box({0, 0, 0}, {1.2, 1.2, 1.2}));
  const BodyId id = body(w, Motion::fixed, Shape::box({0.4, 0.4, 0.4}, {0.8, 0.8, 0.8}));
  require(w.watch_forces(id));
  run(w, 300, 0.002);
  require(w.take_forces());
  run(w, 300, 0.002);
  const BodyForces f = only(w);
  const double displaced = 1000 * 0.064 * g;
  EXPECT_NEAR(f.pressure.linear.y / f.seconds, displaced, 0.06 * displaced);
  EXPECT_LT(length(f.viscosity.linear) / f.seconds, 0.01 * displaced) << "the water is at rest";
  EXPECT_EQ(length(f.contact.linear), 0);
}

// A piston lifts a column of water in a shaft: what it works is what the water gains, 1 %. 8 spacings across, 10 high: the
// pressure that the piston feels hangs on layers, not on how many there are.
TEST(Forces, WorkOfAPistonIsTheEnergyThatTheColumnGains) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = tank({0.8, 2.4, 0.8}, 0.1, Precision::double_precision);
  d.domain.no_slip = false;
  World w = make(d);
  pour(w, Shape::box({0, 0.2, 0}, {0.8, 1.2, 0.8}));
  SolidDesc s;
  s.material = material(w, 2000, "iron");
  s.shape = Shape::box({0, 0, 0}, {0.8, 0.2, 0.8});
  s.motion = Motion::kinematic;
  s.max_speed = 0.5;
  const BodyId piston = *w.add_solid(s);
  require(w.watch_forces(piston));
  run(w, 500, 0.002);  // still water
  require(w.take_forces());
  const auto energy = [&] {
    const Totals t = *w.totals();
    const BodyMotion m = *w.motion(piston);
    const double mass = 2000 * 0.128;  // the piston's own is no energy of the water
    return t.kinetic + t.potential - 0.5 * mass * dot(m.velocity, m.velocity) - mass * g * m.position->y;
  };
  const double before = energy();
  double work = 0;
  constexpr int steps = 400;
  for (int k = 0; k < steps; ++k) {  // up by 0.4 m, with the speed of a cycloid
    BodyMotion m;
    m.velocity = {0, 0.5 * (1 - std::cos(2 * 3.14159265358979 * (k + 0.5) / steps)), 0};
    require(w.set_motion(piston, m));
    require(w.step(0.002));
    work -= dot(only(w).total.linear, m.velocity);
  }
  const double gained = energy() - before;
  EXPECT_GT(gained, 0.9 * 640 * g * 0.4);
  EXPECT_NEAR(work, gained, 0.01 * gained);
}

// A paddle stirs a drop that nothing else touches: the torque that it feels is the negative of the rate at which the drop's angular
// momentum about the shaft grows. Where pressure does it (water) to 1e-5: places in the middle of sub-steps differ from those at their
// ends. Viscous forces of pairs are not along the line between them, so that what one particle loses about the shaft is not what the other
// gains: syrup has 4.4 % more than the paddle gave (4.9 % at half the spacing), allowed 6 %. The work of the torque is what the drop has in
// kinetic energy and what viscosity took.
TEST(Forces, OfAStirrerAreTheTorqueThatTurnsTheLiquid) {
  MELTSIM_NEEDS_BACKEND();
  for (const double mu : {1e-3, 20.0}) {
    WorldDesc d = describe();
    d.precision = Precision::double_precision;
    d.spacing = 0.1;
    d.gravity = {};
    d.sound_speed = 30;
    d.heat.model = HeatModel::none;
    d.viscosity = Viscosity::explicit_;
    World w = *World::create(d);
    MaterialDesc m;
    m.name = "syrup";
    m.viscosity = mu;
    FluidDesc f;
    f.material = *w.add_material(m);
    f.shape = Shape::sphere({}, 0.62);
    require(w.add_fluid(f));
    SolidDesc s;
    s.material = material(w, 2000, "iron");
    s.shape = Shape::box({-0.4, -0.1, -0.2}, {0.4, 0.1, 0.2});
    s.motion = Motion::kinematic;
    s.pivot = Vec3d{};
    s.angular_velocity = {0, 0, 2};
    const BodyId paddle = *w.add_solid(s);
    require(w.watch_forces(paddle));
    const auto turning = [&] {
      const ParticleData p = *w.particles();
      double spin = 0, kinetic = 0;
      for (std::size_t i = 0; i < p.id.size(); ++i)
        if (is_fluid(p.tag[i])) {
          spin += p.mass[i] * cross(p.position[i], p.velocity[i]).z;
          kinetic += 0.5 * p.mass[i] * dot(p.velocity[i], p.velocity[i]);
        }
      return std::pair{spin, kinetic};
    };
    double torque = 0;
    for (int k = 0; k < 20; ++k) {
      require(w.step(0.01));
      torque -= only(w).total.angular.z;
    }
    const auto [spin, kinetic] = turning();
    EXPECT_GT(spin, 5) << mu;
    EXPECT_NEAR(torque, spin, (mu < 1 ? 1e-5 : 0.06) * spin) << mu;
    EXPECT_GT(torque * 2, kinetic) << "work at 2 rad/s: viscosity takes the rest";
  }
}

// Heat: what particles have more of afterwards, to the rounding of sums in double.
TEST(Forces, HeatIsWhatItsParticlesGain) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = tank({1.2, 1.2, 1.2}, 0.1);
  d.heat.model = HeatModel::enthalpy;
  d.heat.time_scale = 1000;
  World w = make(d);
  FluidDesc f;
  f.shape = Shape::box({0, 0, 0}, {1.2, 0.6, 1.2});
  f.material = material(w, 1000, "water");
  f.temperature = 80;
  require(w.add_fluid(f));
  const BodyId id = body(w, Motion::free, Shape::box({0.4, 0.3, 0.4}, {0.8, 0.7, 0.8}), 900);
  require(w.watch_forces(id));
  const auto enthalpy = [&] {
    const ParticleData p = *w.particles();
    double sum = 0;
    for (std::size_t i = 0; i < p.id.size(); ++i)
      if (is_solid(p.tag[i])) sum += p.enthalpy[i];
    return sum;
  };
  require(w.prepare());
  const double before = enthalpy();
  run(w, 100, 0.002);
  const double gained = enthalpy() - before;
  EXPECT_GT(gained, 1000);
  EXPECT_NEAR(only(w).heat, gained, 1e-6 * gained);
}

// Readings begin anew where the last one ended, whatever comes in between: their sum is one reading's, and so are the bits of
// the state. What is added between two of them uploads, and loses nothing.
TEST(Forces, OfReadingsAddUpAndChangeNoBit) {
  MELTSIM_NEEDS_BACKEND();
  const auto scene = [](bool watched) {
    World w = make(tank({1.2, 1.2, 1.2}, 0.1));
    pour(w, Shape::box({0, 0, 0}, {1.2, 0.4, 1.2}));
    const BodyId id = body(w, Motion::free, Shape::box({0.4, 0.3, 0.4}, {0.7, 0.6, 0.7}));
    if (watched) require(w.watch_forces(id));
    return w;
  };
  World one = scene(true), many = scene(true), plain = scene(false);
  run(plain, 60, 0.002);
  run(one, 60, 0.002);
  const BodyForces whole = only(one);
  Vec3d linear{}, angular{};
  double seconds = 0;
  const auto add = [&](const std::vector<BodyForces>& f) {
    ASSERT_EQ(f.size(), 1u);
    linear += f[0].total.linear;
    angular += f[0].total.angular;
    seconds += f[0].seconds;
  };
  ReadRequest what;
  what.forces = true;
  for (int k = 0; k < 6; ++k) {
    run(many, 5, 0.002);
    const auto ticket = many.request(what);
    ASSERT_TRUE(ticket);
    run(many, 5, 0.002);
    add(many.take(*ticket)->forces);
    if (k == 2) material(many, 500, "cork");  // the next step uploads
  }
  add(*many.take_forces());
  EXPECT_EQ(*plain.state_hash(), *one.state_hash());
  EXPECT_EQ(*plain.state_hash(), *many.state_hash());
  EXPECT_NEAR(seconds, whole.seconds, 1e-12);
  EXPECT_LT(length(linear - whole.total.linear), 1e-9 * length(whole.total.linear));
  EXPECT_LT(length(angular - whole.total.angular), 1e-9 * (1 + length(whole.total.angular)));
  EXPECT_EQ(only(many).seconds, 0) << "nothing was stepped since";
}

TEST(Forces, DoNotDependOnThreads) {
  MELTSIM_NEEDS_BACKEND();
  Vec3d first[2];
  for (const int threads : {1, 2}) {
    WorldDesc d = tank({1.2, 1.2, 1.2}, 0.1);
    d.threads = threads;
    World w = make(d);
    pour(w, Shape::box({0, 0, 0}, {1.2, 0.4, 1.2}));
    const BodyId id = body(w, Motion::free, Shape::box({0.4, 0.3, 0.4}, {0.7, 0.6, 0.7}));
    require(w.watch_forces(id));
    run(w, 50, 0.002);
    const BodyForces f = only(w);
    if (threads == 1) {
      first[0] = f.total.linear;
      first[1] = f.pressure.angular;
    }
    EXPECT_EQ(length(f.total.linear - first[0]), 0);
    EXPECT_EQ(length(f.pressure.angular - first[1]), 0);
  }
}

TEST(Forces, CostNothingWhereNobodyWatches) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(tank({1.2, 1.2, 1.2}, 0.1));
  const BodyId id = body(w, Motion::free, Shape::box({0.4, 0.3, 0.4}, {0.7, 0.6, 0.7}));
  const auto runs = [&] {
    for (const auto& s : w.plan().stages)
      if (s.name == "sampling.forces") return s.runs;
    ADD_FAILURE();
    return false;
  };
  EXPECT_FALSE(runs());
  EXPECT_TRUE(w.take_forces()->empty());
  require(w.watch_forces(id));
  EXPECT_TRUE(runs());
  require(w.watch_forces(id, false));
  EXPECT_FALSE(runs());
}

// --- proxies --------------------------------------------------------------------------------------------------------------

// In air, with a spin: the motion of a free body (Euler's equations are held in tests/world/rigid_test.cpp). A constant spin
// about an axis of inertia and a parabola are exact, to what 100 roundings of metres in double leave: 1e-12.
TEST(Proxy, FliesFreely) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(tank({4, 8, 4}, 0.1, Precision::double_precision));
  const BodyId id = proxy(w, Shape::box({1, 4, 1}, {1.4, 4.4, 1.4}), 50, {1, 1, 0.5}, {0, 2, 0});
  const ProxyState before = *w.proxy(id);
  EXPECT_LT(length(before.position - Vec3d{1.2, 4.2, 1.2}), 1e-12);
  run(w, 100, 0.002);
  const ProxyState after = *w.proxy(id);
  const double t = 0.2;
  EXPECT_LT(length(after.position - before.position - Vec3d{t, t - 0.5 * g * t * t, 0.5 * t}), 1e-12);
  EXPECT_LT(length(after.velocity - Vec3d{1, 1 - g * t, 0.5}), 1e-12);
  EXPECT_NEAR(after.orientation.w, std::cos(0.2), 1e-12);
  EXPECT_NEAR(after.orientation.y, std::sin(0.2), 1e-12);
  EXPECT_LT(length(w.pieces()->at(0).center - after.position), 1e-12) << "its particles are with it";
  EXPECT_LT(length(only(w).total.linear), 1e-10);
}

// With the mass and inertia of a rigid body it does what that does: in water, until rounding, which motions of liquid
// amplify, tells them apart. 50 steps of double precision: 1e-9.
TEST(Proxy, MovesAsARigidBodyOfItsMassAndInertia) {
  MELTSIM_NEEDS_BACKEND();
  Vec3d center[2], turn[2];
  for (const bool as_proxy : {false, true}) {
    WorldDesc d = tank({1.2, 1.2, 1.2}, 0.1, Precision::double_precision);
    d.sound_speed = 50;
    World w = make(d);
    pour(w, Shape::box({0, 0, 0}, {1.2, 0.5, 1.2}));
    SolidDesc s;
    s.material = material(w, 700);
    s.shape = Shape::box({0.4, 0.3, 0.5}, {0.8, 0.6, 0.7});
    s.angular_velocity = {1, 0, 2};
    s.motion = Motion::rigid;
    if (as_proxy) {
      s.motion = Motion::proxy;
      s.mass = 700 * 0.024;
      const double each =
          0.7;  // of a particle [kg]; sums of squares of -1.5 .. 1.5, -1 .. 1, -0.5 .. 0.5 spacings
      const double xx = each * 0.01 * 5 * 6, yy = each * 0.01 * 2 * 8, zz = each * 0.01 * 0.5 * 12;
      s.inertia.m[0][0] = yy + zz;
      s.inertia.m[1][1] = zz + xx;
      s.inertia.m[2][2] = xx + yy;
    }
    require(w.add_solid(s));
    run(w, 50, 0.001);
    const PieceInfo p = w.pieces()->at(0);
    center[as_proxy ? 1 : 0] = p.center;
    turn[as_proxy ? 1 : 0] = p.angular_velocity;
  }
  EXPECT_LT(length(center[0] - center[1]), 1e-9);
  EXPECT_LT(length(turn[0] - turn[1]), 1e-6);
  EXPECT_GT(length(turn[0] - Vec3d{1, 0, 2}), 0.01) << "the water did something";
}

/// A host's rigid body that is integrated once a frame, semi-implicitly, with the impulses of the frame before.
struct HostBody {
  Vec3d position, velocity, spin;
  Quat<double> orientation;
};
void frame(World& w, BodyId id, HostBody& b, double mass, double inertia, double dt) {
  ProxyState s;
  s.position = b.position;
  s.orientation = b.orientation;
  s.velocity = b.velocity;
  s.angular_velocity = b.spin;
  require(w.set_proxy(id, s));
  require(w.step(dt));
  ReadRequest what;
  what.forces = true;
  const auto ticket = w.request(what);
  ASSERT_TRUE(ticket) << ticket.error().message;
  const auto reading = w.take(*ticket);
  ASSERT_TRUE(reading) << reading.error().message;
  ASSERT_FALSE(reading->result.halted) << reading->result.halt_reason;
  const BodyForces& f = reading->forces.at(0);
  b.velocity += f.total.linear * (1 / mass) + Vec3d{0, -g * dt, 0};
  b.spin += f.total.angular * (1 / inertia);  // of a cube: the same about every axis
  b.position += b.velocity * dt;
  const Vec3d a = b.spin * (0.5 * dt);
  const Quat<double> q = b.orientation;
  Quat<double> n{q.w - a.x * q.x - a.y * q.y - a.z * q.z, q.x + a.x * q.w + a.y * q.z - a.z * q.y,
                 q.y - a.x * q.z + a.y * q.w + a.z * q.x, q.z + a.x * q.y - a.y * q.x + a.z * q.w};
  const double norm = std::sqrt(n.w * n.w + n.x * n.x + n.y * n.y + n.z * n.z);
  b.orientation = {n.w / norm, n.x / norm, n.y / norm, n.z / norm};
  EXPECT_LT(length(f.velocity - b.velocity), 1e-3 * (1 + length(b.velocity)))
      << "the host's impulses move its body as the proxy has moved";
}

class ProxyDraught : public ::testing::TestWithParam<double> {};

// A host exchanges at 60 Hz. 5 spacings, half of one as elsewhere.
TEST_P(ProxyDraught, EqualsTheDensityRatioWithinHalfASpacing) {
  MELTSIM_NEEDS_BACKEND();
  const double ratio = GetParam(), spacing = 0.1, side = 0.5, area = 1.3 * 1.3;
  World w = make(tank({1.3, 1.6, 1.3}, spacing));
  const double floor = spacing * std::round((0.8 - ratio * side) / spacing);
  pour(w, Shape::box({0, 0, 0}, {1.3, 0.8, 1.3}));
  const double mass = 1000 * ratio * side * side * side;
  const BodyId id = proxy(w, Shape::box({0.4, floor, 0.4}, {0.4 + side, floor + side, 0.4 + side}), mass);
  const double water = double(w.totals()->fluid) * spacing * spacing * spacing;
  const ProxyState start = *w.proxy(id);
  HostBody b{start.position, {}, {}, {}};
  double height = 0;
  int samples = 0;
  for (int k = 0; k < 180; ++k) {  // 3 s; heave has a period of some 1 s
    frame(w, id, b, mass, mass * side * side / 6, 1.0 / 60);
    if (::testing::Test::HasFatalFailure()) return;
    if (k < 120) continue;
    height += b.position.y;
    ++samples;
  }
  height /= samples;
  const double level = (water + ratio * side * side * side) / area;
  EXPECT_NEAR(level - (height - side / 2), ratio * side, 0.5 * spacing);
  EXPECT_LT(length(b.velocity), 0.5);
}
INSTANTIATE_TEST_SUITE_P(Densities, ProxyDraught, ::testing::Values(0.1, 0.9));

// A cube of a tenth of the density of water that is let go under water: its added mass is some six times its own. Moved as a
// kinematic body by the impulses of the frame before, each frame answers the last one with several times its change of velocity: the
// body is faster than 10 m/s within five frames. The proxy rises at no more than sqrt(2 g h) = 4 m/s and floats.
TEST(Proxy, RisesWhereForcesReadOnceAFrameThrowABodyOut) {
  MELTSIM_NEEDS_BACKEND();
  const double side = 0.5, mass = 100 * side * side * side;
  const Shape cube = Shape::box({0.4, 0.2, 0.4}, {0.9, 0.7, 0.9});
  double fastest[2] = {0, 0};
  for (const bool as_proxy : {false, true}) {
    World w = make(tank({1.3, 2.4, 1.3}, 0.1));
    pour(w, Shape::box({0, 0, 0}, {1.3, 1.0, 1.3}));
    double& speed = fastest[as_proxy ? 1 : 0];
    if (as_proxy) {
      const BodyId id = proxy(w, cube, mass);
      HostBody b{w.proxy(id)->position, {}, {}, {}};
      for (int k = 0; k < 150; ++k) {
        frame(w, id, b, mass, mass * side * side / 6, 1.0 / 60);
        if (::testing::Test::HasFatalFailure()) return;
        speed = std::fmax(speed, length(b.velocity));
      }
      EXPECT_GT(b.position.y, 0.9) << "it floats";
      continue;
    }
    const BodyId id = body(w, Motion::kinematic, cube, 1000);
    require(w.watch_forces(id));
    Vec3d v{};
    for (int k = 0; k < 5; ++k) {
      BodyMotion m;
      m.velocity = v;
      require(w.set_motion(id, m));
      if (!w.step(1.0 / 60)) break;  // refused: too fast
      v += only(w).total.linear * (1 / mass) + Vec3d{0, -g / 60, 0};
      speed = std::fmax(speed, length(v));
    }
  }
  EXPECT_GT(fastest[0], 10);
  EXPECT_LT(fastest[1], 4);
}

// Ten times as heavy as water, and not much heavier: both go to the floor and rest there.
TEST(Proxy, SinksWhereItIsHeavier) {
  MELTSIM_NEEDS_BACKEND();
  for (const double ratio : {1.3, 10.0}) {
    World w = make(tank({1, 1.2, 1}, 0.1));
    pour(w, Shape::box({0, 0, 0}, {1, 0.8, 1}));
    const double side = 0.3, mass = 1000 * ratio * side * side * side;
    const BodyId id = proxy(w, Shape::box({0.4, 0.4, 0.4}, {0.7, 0.7, 0.7}), mass);
    HostBody b{w.proxy(id)->position, {}, {}, {}};
    double speed = 0;
    for (int k = 0; k < 150; ++k) {
      frame(w, id, b, mass, mass * side * side / 6, 1.0 / 60);
      if (::testing::Test::HasFatalFailure()) return;
      if (k >= 120)
        speed += length(b.velocity) /
                 30;  // of single frames the velocity is that of an exchange: up to g/60 = 0.16
    }
    EXPECT_NEAR(b.position.y, side / 2, 0.05) << ratio;
    EXPECT_LT(speed, 0.1) << ratio;
  }
}

// The gap to the host's pose closes within a step, and is no part of its velocity; a teleport is there at once.
TEST(Proxy, FollowsThePoseOfItsHost) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = tank({4, 4, 4}, 0.1, Precision::double_precision);
  d.gravity = {};
  World w = make(d);
  const BodyId id = proxy(w, Shape::box({1, 1, 1}, {1.4, 1.4, 1.4}), 50);
  ProxyState s = *w.proxy(id);
  s.position += Vec3d{0.01, 0, 0};
  s.velocity = {0, 1, 0};
  s.orientation = {std::cos(0.05), 0, 0, std::sin(0.05)};
  require(w.set_proxy(id, s));
  run(w, 1, 0.02);
  ProxyState now = *w.proxy(id);
  EXPECT_LT(length(now.position - s.position - Vec3d{0, 0.02, 0}), 1e-12);
  EXPECT_LT(length(now.velocity - s.velocity), 1e-12);
  EXPECT_NEAR(now.orientation.z, s.orientation.z, 1e-12);
  run(w, 1, 0.02);  // without a new state: only the velocity
  now = *w.proxy(id);
  EXPECT_LT(length(now.position - s.position - Vec3d{0, 0.04, 0}), 1e-12);
  s.position = {3, 3, 3};
  s.velocity = {};
  s.acceleration = {0, 0, 2};
  s.teleport = true;
  require(w.set_proxy(id, s));
  run(w, 1, 0.1);
  now = *w.proxy(id);
  EXPECT_LT(length(now.position - Vec3d{3, 3, 3.01}), 1e-12);
  EXPECT_LT(length(now.velocity - Vec3d{0, 0, 0.2}), 1e-12);
  EXPECT_LT(length(w.pieces()->at(0).center - now.position), 1e-12);
}

// A host's pose 1.5 m away, set without teleport: the proxy comes at a tenth of the sound speed, as steps and states go on.
// Without that bound it crosses the tank in a step of 20 ms, at 75 m/s. 1e-12 m: rounding.
TEST(Proxy, GetsToAFarPoseNoFasterThanLiquidMoves) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = tank({4, 4, 4}, 0.1, Precision::double_precision);
  d.gravity = {};
  World w = make(d);
  const BodyId id = proxy(w, Shape::box({1, 1, 1}, {1.4, 1.4, 1.4}), 50);
  require(w.prepare());
  const double most = 0.1 * w.resolved().sound_speed * 0.02;
  ASSERT_LT(most, 0.4);
  ProxyState s = *w.proxy(id);
  const double begin = s.position.x;
  s.position.x += 1.5;
  for (int k = 1; k < 4; ++k) {
    require(w.set_proxy(id, s));
    run(w, 1, 0.02);
    const ProxyState now = *w.proxy(id);
    EXPECT_NEAR(now.position.x, begin + k * most, 1e-12);
    EXPECT_EQ(length(now.velocity), 0);
  }
}

// A state that is restored goes on with the same bits, the motion of the proxy included.
TEST(Proxy, IsPartOfASnapshot) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(tank({1.2, 1.2, 1.2}, 0.1));
  pour(w, Shape::box({0, 0, 0}, {1.2, 0.4, 1.2}));
  const BodyId id = proxy(w, Shape::box({0.4, 0.3, 0.4}, {0.7, 0.6, 0.7}), 20, {0.3, 0, 0}, {1, 2, 3});
  run(w, 20, 0.002);
  const auto saved = *w.snapshot();
  run(w, 20, 0.002);
  const auto hash = *w.state_hash();
  const ProxyState there = *w.proxy(id);
  require(w.restore(saved.data(), saved.size()));
  run(w, 20, 0.002);
  EXPECT_EQ(*w.state_hash(), hash);
  EXPECT_EQ(length(w.proxy(id)->position - there.position), 0);
}

TEST(Proxy, BadInputIsRefusedByName) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(tank({1.2, 1.2, 1.2}, 0.1)), other = make(tank({1.2, 1.2, 1.2}, 0.1));
  const auto refused = [](const auto& r, const std::string& part) {
    EXPECT_FALSE(r) << part;
    if (r) return;
    EXPECT_EQ(r.error().code, ErrorCode::invalid_argument) << part;
    EXPECT_NE(r.error().message.find(part), std::string::npos) << r.error().message;
  };
  SolidDesc s;
  s.material = material(w, 900);
  s.shape = Shape::box({0.4, 0.4, 0.4}, {0.8, 0.8, 0.8});
  s.motion = Motion::proxy;
  refused(w.add_solid(s), "mass: a proxy needs");
  s.mass = -1;
  refused(w.add_solid(s), "mass: a proxy needs");
  s.mass = 10;
  s.growth = 1;
  refused(w.add_solid(s), "growth: a proxy");
  s.growth = 0;
  s.inertia.m[0][1] = 1;
  refused(w.add_solid(s), "inertia: must be");
  s.inertia = {};
  s.inertia.m[0][0] = 3;
  s.inertia.m[1][1] = s.inertia.m[2][2] = 1;
  refused(w.add_solid(s), "inertia: no principal moment");
  s.inertia = {};
  SolidDesc two = s;
  two.shape =
      Shape::unite({Shape::box({0.1, 0.1, 0.1}, {0.3, 0.3, 0.3}), Shape::box({0.8, 0.8, 0.8}, {1, 1, 1})});
  refused(w.add_solid(two), "shape: a proxy is one piece");
  SolidDesc rigid = s;
  rigid.motion = Motion::rigid;
  refused(w.add_solid(rigid), "mass: only of proxies");
  SolidDesc fixed = s;
  fixed.fixed = true;
  refused(w.add_solid(fixed), "fixed: a proxy");
  const BodyId id = *w.add_solid(s);
  const auto before = *w.state_hash();
  ProxyState p = *w.proxy(id);
  const auto with = [&](auto change) {
    ProxyState changed = p;
    change(changed);
    return w.set_proxy(id, changed);
  };
  const double nan = std::nan("");
  refused(with([&](ProxyState& x) { x.position.x = nan; }), "position");
  refused(with([&](ProxyState& x) { x.velocity.y = infinity; }), "velocity");
  refused(with([&](ProxyState& x) { x.angular_velocity.z = nan; }), "angular_velocity");
  refused(with([&](ProxyState& x) { x.acceleration.z = nan; }), "acceleration");
  refused(with([&](ProxyState& x) { x.orientation = {0, 0, 0, 0}; }), "orientation");
  refused(with([&](ProxyState& x) {
            x.position = {0, 0, 0};
            x.teleport = true;
          }),
          "position: would reach through a wall");
  refused(w.set_motion(id, {}), "use set_proxy");
  refused(w.apply_impulse(id, {1, 0, 0}), "use set_proxy");
  refused(w.set_velocity(id, {1, 0, 0}), "use set_proxy");
  refused(w.watch_forces(id, false), "always watched");
  refused(other.set_proxy(id, p), "set_proxy: body");
  refused(other.watch_forces(id), "watch_forces: body");
  refused(other.proxy(id), "proxy: body");
  EXPECT_EQ(*w.state_hash(), before) << "what is refused changes nothing";
  require(with([&](ProxyState& x) { x.velocity.y = 1000; }));
  refused(w.step(0.001), "set_proxy");
  require(w.set_proxy(id, p));
  require(w.step(0.001));
  require(w.remove(id));
  refused(w.set_proxy(id, p), "was removed");
  refused(w.watch_forces(id), "was removed");
  EXPECT_TRUE(w.take_forces()->empty());
}

}  // namespace
}  // namespace meltsim_test
