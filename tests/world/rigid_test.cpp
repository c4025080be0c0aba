// SPDX-License-Identifier: Apache-2.0
// Rigid bodies: six degrees of freedom per piece, against exact motions.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

WorldDesc rigid_desc(Precision precision = Precision::double_precision) {
  WorldDesc d = describe();
  d.precision = precision;
  d.spacing = 0.1;
  d.sound_speed = 40;  // ten times the largest speed of any scene here
  d.heat.model = HeatModel::none;
  return d;
}

WorldDesc weightless(Precision precision = Precision::double_precision) {
  WorldDesc d = rigid_desc(precision);
  d.gravity = {};
  return d;
}

World make(const WorldDesc& d) {
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  return std::move(*w);
}

MaterialId stone(World& w, double density = 2000, const std::string& name = "stone") {
  MaterialDesc m;
  m.name = name;
  m.density = density;
  return *w.add_material(m);
}

BodyId rigid(World& w, MaterialId material, const Shape& shape, Vec3d velocity = {}, Vec3d spin = {}) {
  SolidDesc s;
  s.material = material;
  s.shape = shape;
  s.motion = Motion::rigid;
  s.velocity = velocity;
  s.angular_velocity = spin;
  auto id = w.add_solid(s);
  EXPECT_TRUE(id) << id.error().message;
  return *id;
}

void run(World& w, int steps, double dt) {
  for (int k = 0; k < steps; ++k) require(w.step(dt));
  const StepResult r = w.synchronize();
  ASSERT_FALSE(r.halted) << r.halt_reason;
}

/// Largest change of a distance between two particles of one piece, relative to the spacing.
double strain(const ParticleData& before, const ParticleData& now, double spacing) {
  double worst = 0;
  for (std::size_t i = 0; i < now.id.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      if (now.piece[i] == 0 || now.piece[i] != now.piece[j]) continue;
      const double d = length(now.position[i] - now.position[j]),
                   was = length(before.position[i] - before.position[j]);
      worst = std::max(worst, std::fabs(d - was) / spacing);
    }
  return worst;
}

const StageReport& stage(const Plan& p, const std::string& name) {
  return *std::find_if(p.stages.begin(), p.stages.end(),
                       [&](const StageReport& s) { return s.name == name; });
}

// Drift-kick-drift is exact for a constant acceleration; 100 steps round a position of some metres 100 times, 1e-12
// in double. In single precision a position of 5 m rounds to 2.4e-7 m, at random: 1e-5.
TEST(Rigid, FallsFreely) {
  MELTSIM_NEEDS_BACKEND();
  for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
    World w = make(rigid_desc(precision));
    rigid(w, stone(w), Shape::box({0, 0, 0}, {0.3, 0.2, 0.4}), {1, 2, 3});
    const auto before = w.pieces()->at(0);
    run(w, 100, 0.002);
    const auto after = w.pieces()->at(0);
    const double t = 0.2, eps = precision == Precision::double_precision ? 1e-12 : 1e-5;
    EXPECT_LT(length(after.center - (before.center + Vec3d{t, 2 * t - 0.5 * 9.81 * t * t, 3 * t})), eps);
    EXPECT_LT(length(after.velocity - Vec3d{1, 2 - 9.81 * t, 3}), 10 * eps);
    EXPECT_LT(length(after.angular_velocity), 10 * eps);
  }
}

/// Euler's equations for a free body about its principal axes, by the classical Runge-Kutta method of fourth order.
Vec3d euler(Vec3d inertia, Vec3d w, double time, int steps) {
  const auto rate = [&](Vec3d a) {
    return Vec3d{(inertia.y - inertia.z) / inertia.x * a.y * a.z,
                 (inertia.z - inertia.x) / inertia.y * a.z * a.x,
                 (inertia.x - inertia.y) / inertia.z * a.x * a.y};
  };
  const double h = time / steps;
  for (int k = 0; k < steps; ++k) {
    const Vec3d a = rate(w), b = rate(w + a * (h / 2)), c = rate(w + b * (h / 2)), d = rate(w + c * h);
    w += (a + b * 2.0 + c * 2.0 + d) * (h / 6);
  }
  return w;
}

// A box of 3 x 2 x 5 points spun about its middle axis, x, turns over as Euler's equations say. Steps of 0.0075 rad have
// an error of (omega dt)^2/12 = 5e-6 per radian, which the instability of that axis amplifies by the ratio of the spin
// to its disturbance, 100, until the body has turned over: some 5e-3 of the spin.
TEST(Rigid, TurnsOverWhenSpunAboutItsMiddleAxis) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(weightless());
  const Vec3d spin{3, 0.03, 0.03};
  rigid(w, stone(w), Shape::box({0, 0, 0}, {0.3, 0.2, 0.5}), {}, spin);
  // n points a side have (n^2 - 1)/12 dx^2 of their mass, 2 kg each.
  const auto moment = [](double a, double b) { return 30 * 2 * 0.01 * (a * a + b * b - 2) / 12; };
  const Vec3d inertia{moment(2, 5), moment(3, 5), moment(3, 2)};
  const PieceInfo before = w.pieces()->at(0);
  EXPECT_NEAR(before.inertia.m[0][0] / inertia.x, 1, 1e-12);
  EXPECT_NEAR(before.inertia.m[1][1] / inertia.y, 1, 1e-12);
  EXPECT_NEAR(before.inertia.m[2][2] / inertia.z, 1, 1e-12);
  double lowest = 3, worst = 0;
  for (int k = 1; k <= 80; ++k) {
    run(w, 10, 0.0125);
    const PieceInfo p = w.pieces()->at(0);
    const Quat<double> q = p.orientation;
    const Vec3d in_body = rotate(Quat<double>{q.w, -q.x, -q.y, -q.z}, p.angular_velocity);
    worst = std::max(worst, length(in_body - euler(inertia, spin, w.time(), 2000 * k)));
    lowest = std::min(lowest, in_body.x);
  }
  EXPECT_LT(lowest, -2.9);  // it did turn over
  EXPECT_LT(worst / 3, 5e-3);
}

// A torque-free body for 10^5 sub-steps: momentum, angular momentum and energy to rounding, and no strain. In double a
// velocity of 1 m/s rounds to 1e-16 and sums to 1e-14 (2^-50 of the sound speed): a random walk of 10^5 steps adds up to
// 3e-12. A position of 30 m rounds to 4e-15 m: distances of 0.1 m keep 1e-12 whatever the number of steps.
TEST(Rigid, ATumblingBodyKeepsMomentaEnergyAndShapeForALongTime) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(weightless());
  rigid(w, stone(w), Shape::box({0, 0, 0}, {0.3, 0.2, 0.5}), {0.1, 0.05, 0}, {3, 0.1, 0.2});
  const ParticleData start = *w.particles();
  const Totals before = *w.totals();
  double worst = 0;
  for (int k = 0; k < 10; ++k) {
    run(w, 1000, 0.025);  // 10 sub-steps each
    worst = std::max(worst, strain(start, *w.particles(), 0.1));
  }
  const Totals after = *w.totals();
  EXPECT_GE(w.synchronize().steps, 100000u);
  EXPECT_LT(length(after.momentum - before.momentum) / length(before.momentum), 1e-11);
  const Vec3d spin_before = before.angular_momentum - cross(before.solid_center, before.momentum),
              spin_after = after.angular_momentum - cross(after.solid_center, after.momentum);
  EXPECT_LT(length(spin_after - spin_before) / length(spin_before), 1e-9);
  EXPECT_NEAR(after.kinetic / before.kinetic, 1, 1e-9);
  EXPECT_LT(worst, 1e-12);
  // A momentum within 1e-11 of itself, as above, over 28 m: 2.8e-10.
  EXPECT_LT(length(after.solid_center - (before.solid_center + Vec3d{0.1, 0.05, 0} * w.time())), 3e-10);
}

// The same in single precision. A position of 1 m rounds to 6e-8 m, 6e-7 spacings, and so do distances: twice that, and
// no more after 20,000 sub-steps than after one.
TEST(Rigid, ShapeDoesNotWearAwayInSinglePrecision) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(weightless(Precision::single_precision));
  rigid(w, stone(w), Shape::box({0, 0, 0}, {0.3, 0.2, 0.5}), {}, {3, 0.1, 0.2});
  const ParticleData start = *w.particles();
  const Totals before = *w.totals();
  run(w, 2000, 0.025);
  EXPECT_LT(strain(start, *w.particles(), 0.1), 2e-6);
  const Totals after = *w.totals();
  // Velocities round to 3e-8 of themselves, 30 particles at random, in 20,000 steps: 8e-7 of the spin.
  EXPECT_LT(length(after.angular_momentum - before.angular_momentum) / length(before.angular_momentum), 5e-6);
  EXPECT_NEAR(after.kinetic / before.kinetic, 1, 1e-5);
}

// A plane, a row and a single particle: inertias that are singular. A row spun about an axis across it turns by omega t;
// about its own axis it has no spin. 1e-9: the row's angle after 6.4 rad in steps of 1/160 of that has (omega dt)^2/12 of a
// rule of second order in the half drifts of particles, which do not enter, and rounding.
TEST(Rigid, RowsPlanesAndSingleParticlesMove) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(weightless());
  const MaterialId m = stone(w);
  rigid(w, m, Shape::box({0, 0, 0}, {0.1, 0.1, 0.1}), {0.1, 0.2, 0}, {0, 0, 5});
  rigid(w, m, Shape::box({3, 0, 0}, {3.6, 0.1, 0.1}), {0, 0.1, 0}, {2, 0, 1});
  rigid(w, m, Shape::box({6, 0, 0}, {6.4, 0.3, 0.1}), {0, 0, 0.1}, {0, 0, 2});
  const ParticleData start = *w.particles();
  ASSERT_EQ(start.id.size(), 1u + 6u + 12u);
  run(w, 320, 0.02);
  const double t = w.time();
  const ParticleData now = *w.particles();
  EXPECT_LT(length(now.position[0] - (start.position[0] + Vec3d{0.1, 0.2, 0} * t)), 1e-10);
  const auto pieces = *w.pieces();
  EXPECT_LT(length(pieces[0].angular_velocity), 1e-12);
  EXPECT_LT(length(pieces[1].angular_velocity - Vec3d{0, 0, 1}), 1e-9);
  const Vec3d row = now.position[6] - now.position[1];
  EXPECT_LT(length(row - Vec3d{0.5 * std::cos(t), 0.5 * std::sin(t), 0}), 1e-9);
  EXPECT_LT(length(pieces[2].angular_velocity - Vec3d{0, 0, 2}), 1e-9);
  EXPECT_LT(strain(start, now, 0.1), 1e-12);
}

// Longer than half of the period that it crosses: images are told apart by the rotation.
TEST(Rigid, ABodyLongerThanHalfAPeriodKeepsItsShape) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = weightless();
  d.domain.bounded = true;
  d.domain.max = {2, 4, 4};
  d.domain.faces[0] = d.domain.faces[1] = Face::periodic;
  World w = make(d);
  rigid(w, stone(w), Shape::box({0.3, 2, 2}, {1.8, 2.2, 2.2}), {1, 0, 0}, {0, 0, 0.5});
  const Totals before = *w.totals();
  run(w, 300, 0.02);
  const Totals after = *w.totals();
  EXPECT_LT(length(after.momentum - before.momentum) / length(before.momentum), 1e-11);
  EXPECT_NEAR(after.kinetic / before.kinetic, 1, 1e-10);
  // 3 rad later: neighbours in the lattice, taken across the faces, are a spacing apart.
  const ParticleData p = *w.particles();
  for (std::size_t i = 1; i < 15; ++i) {
    Vec3d r = p.position[i] - p.position[i - 1];
    r.x -= 2 * std::round(r.x / 2);
    EXPECT_NEAR(length(r), 0.1, 1e-12);
  }
}

/// A block on the floor of a box, with gravity tilted by `angle` [rad].
World incline(double angle, double friction) {
  WorldDesc d = rigid_desc();
  d.domain.bounded = true;
  d.domain.min = {-20, 0, 0};
  d.domain.max = {20, 2, 2};
  d.domain.friction = friction;
  d.gravity = {9.81 * std::sin(angle), -9.81 * std::cos(angle), 0};
  World w = make(d);
  MaterialDesc m;
  m.name = "rough";
  m.density = 2000;
  m.friction = friction;
  const MaterialId id = *w.add_material(m);
  rigid(w, id, Shape::box({0, 0, 0.5}, {0.6, 0.3, 1.1}));
  return w;
}

// Coulomb: it stays where tan(angle) < friction, where it comes to rest on its springs, kappa_t/kappa of a
// weight n g dt_s^2/kappa: far below a hundredth of a spacing.
TEST(Rigid, StaysOnASlopeThatFrictionHolds) {
  MELTSIM_NEEDS_BACKEND();
  World w = incline(std::atan(0.3), 0.4);
  run(w, 200, 0.01);
  const PieceInfo p = w.pieces()->at(0);
  EXPECT_NEAR(p.center.x, 0.3, 1e-3);
  EXPECT_LT(length(p.velocity), 1e-4);
}

// And slides at g (sin - friction cos) where it is not, which the tilt of the front edge changes by nothing: the friction's
// sum is friction times the weight. The settling of its springs lasts some 20 sub-steps of 2 s: 0.5 %.
TEST(Rigid, SlidesDownASlopeAsCoulombSays) {
  MELTSIM_NEEDS_BACKEND();
  const double angle = std::atan(0.7), friction = 0.4;
  World w = incline(angle, friction);
  run(w, 50, 0.01);
  const double first = w.pieces()->at(0).velocity.x, from = w.time();
  run(w, 50, 0.01);
  const double second = w.pieces()->at(0).velocity.x, a = (second - first) / (w.time() - from);
  EXPECT_NEAR(a / (9.81 * (std::sin(angle) - friction * std::cos(angle))), 1, 5e-3);
  EXPECT_LT(length(w.pieces()->at(0).angular_velocity), 0.05);
}

/// The speed of a ball of 6 spacings 2 s after it was let go on a slope of 0.1, 6 degrees, over that of a ball that rolls.
double rolled(Motion motion, bool plate) {
  const double angle = std::atan(0.1), dx = 0.1, R = 0.6, friction = 0.5, floor = plate ? 3 * dx : 0;
  WorldDesc d = rigid_desc();
  d.domain.bounded = true;
  d.domain.max = {8, 3, 3};
  d.domain.friction = friction;
  d.gravity = {9.81 * std::sin(angle), -9.81 * std::cos(angle), 0};
  World w = make(d);
  MaterialDesc m;
  m.name = "rough";
  m.density = 1000;
  m.friction = friction;
  SolidDesc s;
  s.material = *w.add_material(m);
  if (plate) {
    s.fixed = true;
    s.shape = Shape::box({0, 0, 0}, {8, floor, 3});
    require(w.add_solid(s));
    s.fixed = false;
  }
  s.motion = motion;
  s.shape = Shape::sphere({1.5, floor + R, 1.5}, R);
  require(w.add_solid(s));
  run(w, 200, 0.01);
  const PieceInfo p = w.pieces()->back();
  EXPECT_NEAR(-p.angular_velocity.z * R / p.velocity.x, 1, 0.25);
  return p.velocity.x / (5.0 / 7 * 9.81 * std::sin(angle) * 2);
}

// On the lattice a ball of 6 spacings has faces 5 spacings wide, on which it stood up to 20 degrees. The spheres of contact lie within
// the ball and touch its surface some 1.4 spacings apart: bumps of 0.04 spacings, of which it may be anywhere, and each of which
// takes some of its speed. At the end it has come down by 1.4 spacings; a tenth of that, and as much for where it is, are 15 % of its speed. One
// that deforms loses about as much again in the springs and dashpots of its lattice where it is pressed in: twice that.
TEST(Rigid, ABallRollsDownAGentleSlope) {
  MELTSIM_NEEDS_BACKEND();
  EXPECT_NEAR(rolled(Motion::rigid, false), 1, 0.15);
  EXPECT_NEAR(rolled(Motion::rigid, true), 1, 0.15);
  EXPECT_NEAR(rolled(Motion::free, false), 1, 0.3);
}

// Light on heavy, and five times as heavy on light, as ATowerOfThreeBlocksStands has of free bodies.
TEST(Rigid, ATowerOfThreeStands) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = rigid_desc();
  d.domain.bounded = true;
  d.domain.max = {1, 1.5, 1};
  World w = make(d);
  double floor = 0;
  for (const double density : {10000.0, 200.0, 1000.0}) {
    rigid(w, stone(w, density, std::to_string(density)),
          Shape::box({0.3, floor, 0.3}, {0.6, floor + 0.3, 0.6}));
    floor += 0.3;
  }
  run(w, 2500, 0.002);  // 5 s, 16 times the fall from its height
  const auto p = *w.pieces();
  ASSERT_EQ(p.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(p[k].center.y, 0.15 + 0.3 * double(k), 0.01);  // a tenth of a spacing
    EXPECT_NEAR(p[k].center.x, 0.45, 0.01);
    EXPECT_NEAR(p[k].center.z, 0.45, 0.01);
    EXPECT_LT(length(p[k].velocity), 1e-3);
  }
}

/// Three cubes on each other after 2 s, 6 times the fall from their height: how far the uppermost has come down and aside from where it
/// was built, and how far it leans. The middle one lies `aside` spacings further along x, half as many along z.
struct Towered {
  double down = 0, sideways = 0, lean = 0, speed = 0;  ///< [spacings, spacings, degrees, m/s]
};
Towered towered(Motion motion, double side, double aside) {
  WorldDesc d = rigid_desc();
  const double dx = d.spacing = 0.05;
  d.domain.bounded = true;
  d.domain.max = {1, 1, 1};
  World w = make(d);
  SolidDesc s;
  s.material = stone(w, 700, "wood");
  s.motion = motion;
  for (int k = 0; k < 3; ++k) {
    const Vec3d half{0.5 * side * dx, 2 * dx, 0.5 * side * dx},
        at{0.5 + (k == 1 ? aside * dx : 0), (4 * k + 2) * dx, 0.5 + (k == 1 ? 0.5 * aside * dx : 0)};
    s.shape = Shape::box(at - half, at + half);
    require(w.add_solid(s));
  }
  const PieceInfo before = w.pieces()->back();
  run(w, 1000, 0.002);
  const PieceInfo p = w.pieces()->back();
  const Vec3d way = (p.center - before.center) * (1 / dx);
  return {-way.y, std::hypot(way.x, way.z),
          2 * std::acos(std::min(1.0, std::fabs(p.orientation.w))) * 180 / 3.14159265, length(p.velocity)};
}

// Boxes of 3.7 spacings are 4 particles wide, and 12 of the 16 that carry a face are at its rim. Where rims had the depth of the side,
// 0.35 spacings, for a radius, boxes stood on their middles, were pressed in four times as far, and fell where they lay aside. Those of
// whole spacings that lie half a spacing off the lattice lean no more than others: 2 degrees, while their sides were found uneven.
TEST(Rigid, BoxesStandOnTheirRims) {
  MELTSIM_NEEDS_BACKEND();
  for (const Motion motion : {Motion::rigid, Motion::free}) {
    const Towered broken = towered(motion, 3.7, 0);
    EXPECT_LT(broken.down, 0.06);  // its springs: 0.03, of a rigid one
    EXPECT_LT(broken.sideways, 0.01);
    EXPECT_LT(broken.speed, 2e-3);
  }
  const Towered staggered = towered(Motion::rigid, 4, 1);
  EXPECT_LT(staggered.down, 0.06);
  EXPECT_LT(staggered.sideways, 0.05);
  EXPECT_LT(staggered.lean, 0.5);  // a quarter of what a rim a tenth of a spacing too low leans
  EXPECT_LT(staggered.speed, 5e-3);
}

class RigidDraught : public ::testing::TestWithParam<double> {};

// The scene and the tolerance of Draught (float_test.cpp).
TEST_P(RigidDraught, EqualsTheDensityRatioWithinHalfASpacing) {
  MELTSIM_NEEDS_BACKEND();
  const double ratio = GetParam(), side = 1.2;
  WorldDesc d = describe();
  d.spacing = 0.2;
  d.domain.bounded = true;
  d.domain.max = {3.2, 3, 3.2};
  d.heat.model = HeatModel::none;
  World w = make(d);
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0, 0, 0}, {3.2, 1.6, 3.2});
  require(w.add_fluid(f));
  const double floor = 0.2 * std::round((1.6 - ratio * side) / 0.2);
  rigid(w, stone(w, 1000 * ratio, "float"), Shape::box({1, floor, 1}, {1 + side, floor + side, 1 + side}));
  const double water = double(w.totals()->fluid) * 0.008;
  double center = 0;
  int samples = 0;
  for (int k = 0; k < 1000; ++k) {
    require(w.step(0.0025));
    if (k >= 700 && k % 25 == 0) {
      center += w.totals()->solid_center.y;
      ++samples;
    }
  }
  ASSERT_FALSE(w.synchronize().halted);
  const double level = (water + ratio * side * side * side) / (3.2 * 3.2);
  EXPECT_NEAR(level - (center / samples - side / 2), ratio * side, 0.1);
}
INSTANTIATE_TEST_SUITE_P(Densities, RigidDraught, ::testing::Values(0.2, 0.917));

// Where viscosity is implicit, velocity diffuses between the liquid and the motion of the whole body (lsm.rigid_shape), not
// of each particle on its own, which what presses on it alone would carry along. At 1e6 Pa s, some 200 times what an explicit
// sub-step of sound bears, a body of 5000 kg/m^3 creeps 1.4 times as fast as a free one; without that stage 2.2 times.
TEST(Rigid, CreepsThroughAThickLiquidLikeAFreeBody) {
  MELTSIM_NEEDS_BACKEND();
  const auto creep = [](Motion motion) {
    WorldDesc d = describe();
    d.spacing = 0.2;
    d.domain.bounded = true;
    d.domain.max = {3.2, 3, 3.2};
    d.heat.model = HeatModel::none;
    World w = make(d);
    MaterialDesc pitch;
    pitch.name = "pitch";
    pitch.viscosity = 1e6;
    FluidDesc f;
    f.material = *w.add_material(pitch);
    f.shape = Shape::box({0, 0, 0}, {3.2, 2.2, 3.2});
    require(w.add_fluid(f));
    SolidDesc s;
    s.material = stone(w, 5000);
    s.shape = Shape::box({1, 0.6, 1}, {2.2, 1.8, 2.2});
    s.motion = motion;
    require(w.add_solid(s));
    EXPECT_EQ(stage(w.plan(), "lsm.rigid_shape").runs, motion == Motion::rigid);
    run(w, 140, 0.005);
    const double from = w.totals()->solid_center.y;
    run(w, 60, 0.005);
    return from - w.totals()->solid_center.y;
  };
  const double rigid_way = creep(Motion::rigid), free_way = creep(Motion::free);
  EXPECT_GT(rigid_way / free_way, 0.7);
  EXPECT_LT(rigid_way / free_way, 1.7);
}

// Two rigid bodies and a free one collide in space: pair forces are antisymmetric and every piece has the momenta of its
// particles. Rounding of sums in double over 1000 steps: 1e-11 of what flies about.
TEST(Rigid, MomentaAreKeptInACollisionOfRigidAndFreeBodies) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(weightless());
  const MaterialId m = stone(w);
  rigid(w, m, Shape::box({0, 0, 0}, {0.4, 0.4, 0.4}), {1, 0, 0}, {0, 0, 1});
  rigid(w, m, Shape::box({1.2, 0.1, 0.1}, {1.6, 0.5, 0.3}), {-1, 0, 0});
  SolidDesc soft;
  soft.material = m;
  soft.shape = Shape::box({0.6, 0.1, 0}, {1.0, 0.4, 0.4});
  require(w.add_solid(soft));
  const ParticleData start = *w.particles();
  const Totals before = *w.totals();
  run(w, 400, 0.0025);
  const Totals after = *w.totals();
  const double mass = before.mass;
  EXPECT_LT(length(after.momentum - before.momentum) / mass, 1e-11);
  EXPECT_LT(after.kinetic, before.kinetic);  // they met, and dashpots took energy
  ParticleData now = *w.particles();
  for (std::size_t i = 0; i < now.id.size(); ++i)
    if (body_of(now.tag[i]) == 3u) now.piece[i] = 0;  // the free one may strain
  EXPECT_LT(strain(start, now, 0.1), 1e-12);
}

// A bar whose middle a region heats melts in two; both halves are rigid from then on, and what is left and what has melted
// has the momentum of before.
TEST(Rigid, MeltsInHalfAndFallsApartIntoRigidPieces) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = weightless();
  d.heat.model = HeatModel::enthalpy;
  d.heat.time_scale = 1e4;
  World w = make(d);
  const MaterialId water = *w.add_material({});
  MaterialDesc ice;
  ice.name = "ice";
  ice.density = 900;
  ice.melting_point = 0;
  ice.latent_heat = 1e5;
  ice.melts_into = water;
  const MaterialId m = *w.add_material(ice);
  SolidDesc bar;
  bar.material = m;
  bar.shape = Shape::box({0, 0, 0}, {1.5, 0.3, 0.3});
  bar.motion = Motion::rigid;
  bar.temperature = -100;
  bar.velocity = {0.02, 0.01, 0};
  bar.angular_velocity = {0, 0, 0.1};
  require(w.add_solid(bar));
  HeatRegionDesc h;
  h.shape = Shape::box({0.55, -1, -1}, {0.95, 1.5, 1.5});
  h.source = 3e5;  // [W/m^3] 1e4 times as fast: 3e9 J/m^3 in a second; 0.29e9 melt it
  h.until = 0.5;
  require(w.add_heat_region(h));
  const Totals before = *w.totals();
  std::size_t pieces = 1;
  ParticleData apart;
  for (int k = 0; k < 400 && pieces < 2; ++k) {
    run(w, 5, 0.005);
    pieces = w.pieces()->size();
  }
  ASSERT_EQ(pieces, 2u);
  apart = *w.particles();
  run(w, 100, 0.005);
  const Totals after = *w.totals();
  const ParticleData now = *w.particles();
  EXPECT_GT(after.melted, 20u);
  EXPECT_LT(length(after.momentum - before.momentum) / length(before.momentum), 1e-10);
  // Those that stayed solid keep their distances; what has melted since is of no piece now.
  EXPECT_LT(strain(apart, now, 0.1), 1e-11);
  const auto p = *w.pieces();
  ASSERT_EQ(p.size(), 2u);
  // They have been parts of one rotating body: their centres moved apart as free bodies do.
  EXPECT_GT(length(p[0].velocity - p[1].velocity), 0.03);
}

// Melting away in a warm bath takes the stages of rigid bodies with it; mass and heat are as before.
TEST(Rigid, MeltsAwayEntirely) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.precision = Precision::double_precision;
  IceScene scene;
  scene.motion = Motion::rigid;
  Scene s = ice_in_water(d, scene);
  EXPECT_TRUE(stage(s.world.plan(), "lsm.rigid").runs);
  EXPECT_FALSE(stage(s.world.plan(), "lsm.regions").runs);
  EXPECT_FALSE(stage(s.world.plan(), "topology.regions").runs);
  const Totals before = *s.world.totals();
  melt(s.world, 0.005, 10);
  const Totals after = *s.world.totals();
  EXPECT_EQ(after.solid, 0u);
  EXPECT_EQ(after.melted, 27u);
  EXPECT_EQ(after.mass, before.mass);
  EXPECT_NEAR(after.thermal / before.thermal, 1, 1e-12);
  require(s.world.step(0.005));
  EXPECT_FALSE(stage(s.world.plan(), "lsm.rigid").runs);
}

// Liquid that freezes onto a rigid body becomes part of it: the body turns on as one, and neighbours in the lattice are a
// spacing apart.
TEST(Rigid, GrowsByFreezing) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.precision = Precision::double_precision;
  IceScene scene;
  scene.motion = Motion::rigid;
  scene.freezes = true;
  scene.growth = 2;
  scene.latent_heat = 5e4;
  scene.ice_temperature = -200;
  scene.water_temperature = 1;
  scene.block_floor = 0.4;
  scene.depth = 1.2;
  scene.box = 2.2;
  Scene s = ice_in_water(d, scene);
  const Totals before = *s.world.totals();
  std::uint64_t frozen = 0;
  for (int k = 0; k < 400 && frozen < 20; ++k) {
    run(s.world, 1, 0.005);
    frozen = s.world.synchronize().frozen;
  }
  ASSERT_GE(frozen, 20u);
  EXPECT_NEAR(s.world.totals()->mass / before.mass, 1, 1e-14);
  const ParticleData then = *s.world.particles();
  run(s.world, 20, 0.005);
  const ParticleData now = *s.world.particles();
  double worst = 0;
  int pairs = 0;
  for (std::size_t i = 0; i < now.id.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      if (!is_solid(then.tag[i]) || !is_solid(now.tag[i]) || !is_solid(then.tag[j]) || !is_solid(now.tag[j]))
        continue;
      worst = std::max(worst, std::fabs(length(now.position[i] - now.position[j]) -
                                        length(then.position[i] - then.position[j])));
      ++pairs;
    }
  EXPECT_GT(pairs, 47 * 46 / 2 - 1);
  EXPECT_LT(worst, 0.2 * 0.1);
}

// A block of 3^3 particles of 2 kg with an inertia of 27 * 2 * 8/6 * 0.01 = 0.72 kg m^2 about each axis.
TEST(Rigid, TakesPushes) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(weightless());
  const BodyId body = rigid(w, stone(w), Shape::box({0, 0, 0}, {0.3, 0.3, 0.3}));
  require(w.apply_impulse(body, {54, -27, 0}, {0, 0, 0.72}));
  run(w, 10, 0.01);
  EXPECT_LT(length(w.pieces()->at(0).velocity - Vec3d{1, -0.5, 0}), 1e-11);
  EXPECT_LT(length(w.pieces()->at(0).angular_velocity - Vec3d{0, 0, 1}), 1e-10);
  require(w.set_velocity(body, {0, 0.3, 0}, {0, 2, 0}));
  run(w, 10, 0.01);
  EXPECT_LT(length(w.pieces()->at(0).velocity - Vec3d{0, 0.3, 0}), 1e-11);
  EXPECT_LT(length(w.pieces()->at(0).angular_velocity - Vec3d{0, 2, 0}), 1e-10);
  // A cube turns about any axis at a constant rate: by 0.1 rad about z, then 0.2 rad about y.
  const Quat<double> q = w.pieces()->at(0).orientation;
  const Quat<double> z{std::cos(0.05), 0, 0, std::sin(0.05)}, y{std::cos(0.1), 0, std::sin(0.1), 0};
  const Vec3d x = rotate(q, Vec3d{1, 0, 0}), expected = rotate(y, rotate(z, Vec3d{1, 0, 0}));
  EXPECT_LT(length(x - expected), 1e-10);
}

TEST(Rigid, RefusesWhatIsNotOfRigidBodies) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(weightless());
  const MaterialId m = stone(w);
  const BodyId body = rigid(w, m, Shape::box({0, 0, 0}, {0.3, 0.3, 0.3}));
  BodyMotion motion;
  motion.velocity = {1, 0, 0};
  const Status moved = w.set_motion(body, motion);
  ASSERT_FALSE(moved);
  EXPECT_NE(moved.error().message.find("only a kinematic body can be moved"), std::string::npos);
  SolidDesc s;
  s.material = m;
  s.shape = Shape::box({1, 0, 0}, {1.3, 0.3, 0.3});
  s.motion = Motion::rigid;
  s.fixed = true;
  const auto fixed = w.add_solid(s);
  ASSERT_FALSE(fixed);
  EXPECT_NE(fixed.error().message.find("fixed: a rigid body moves"), std::string::npos);
  s.fixed = false;
  s.pivot = Vec3d{1, 0, 0};
  const auto turned = w.add_solid(s);
  ASSERT_FALSE(turned);
  EXPECT_NE(turned.error().message.find("pivot: only of kinematic bodies"), std::string::npos);
  s.pivot.reset();
  s.motion = Motion::fixed;
  s.max_speed = 1;
  const auto fast = w.add_solid(s);
  ASSERT_FALSE(fast);
  EXPECT_NE(fast.error().message.find("max_speed: a fixed body does not move"), std::string::npos);
}

// The state has all of it: rotations in double, also of a World in single precision.
TEST(Rigid, ARestoredSnapshotContinuesWithTheSameBits) {
  MELTSIM_NEEDS_BACKEND();
  for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
    const auto scene = [&] {
      WorldDesc d = rigid_desc(precision);
      d.domain.bounded = true;
      d.domain.max = {2, 2, 2};
      World w = make(d);
      const MaterialId m = stone(w);
      rigid(w, m, Shape::box({0.5, 0.5, 0.5}, {0.9, 0.7, 0.8}), {0.1, 0, 0}, {1, 2, 3});
      rigid(w, m, Shape::box({0.6, 0.9, 0.5}, {0.8, 1.3, 0.8}), {0, -1, 0}, {0, 1, 0});
      return w;
    };
    World a = scene(), b = scene();
    run(a, 40, 0.01);
    const auto bytes = *a.snapshot();
    run(a, 40, 0.01);
    require(b.restore(bytes.data(), bytes.size()));
    run(b, 40, 0.01);
    EXPECT_EQ(*a.state_hash(), *b.state_hash());
    // A body of another kind in its place is another scene.
    WorldDesc d = rigid_desc(precision);
    d.domain.bounded = true;
    d.domain.max = {2, 2, 2};
    World c = make(d);
    SolidDesc s;
    s.material = stone(c);
    s.shape = Shape::box({0.5, 0.5, 0.5}, {0.9, 0.7, 0.8});
    require(c.add_solid(s));
    s.shape = Shape::box({0.6, 0.9, 0.5}, {0.8, 1.3, 0.8});
    require(c.add_solid(s));
    EXPECT_FALSE(c.restore(bytes.data(), bytes.size()));
  }
}

TEST(Rigid, BitsDoNotDependOnTheNumberOfThreads) {
  MELTSIM_NEEDS_BACKEND();
  std::vector<std::uint64_t> hashes;
  for (const int threads : {1, 4}) {
    WorldDesc d = describe();
    d.threads = threads;
    IceScene scene;
    scene.motion = Motion::rigid;
    Scene s = ice_in_water(d, scene);
    run(s.world, 60, 0.005);
    hashes.push_back(*s.world.state_hash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

// Coulomb's wall and its corner: a cube thrown into a corner of a box bounces, loses energy, never gains any, and stays
// whole.
TEST(Rigid, NeverGainsEnergyAtWalls) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = weightless();
  d.domain.bounded = true;
  d.domain.max = {1.5, 1.5, 1.5};
  World w = make(d);
  rigid(w, stone(w), Shape::box({0.5, 0.5, 0.5}, {0.9, 0.8, 0.7}), {2, -1.5, 1}, {2, 3, 1});
  const ParticleData start = *w.particles();
  double energy = w.totals()->kinetic;
  for (int k = 0; k < 40; ++k) {
    run(w, 20, 0.005);
    const double now = w.totals()->kinetic;
    // Springs that are pressed hold energy: what comes back is less than it was at the beginning.
    EXPECT_LT(now, energy * (1 + 1e-9));
    EXPECT_LT(strain(start, *w.particles(), 0.1), 1e-12);
  }
  EXPECT_LT(w.totals()->kinetic, 0.9 * energy);
}

}  // namespace
}  // namespace meltsim_test
