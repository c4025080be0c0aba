// SPDX-License-Identifier: Apache-2.0
// Surface tension and wetting in a World: what is conserved, shapes and angles at rest, what is refused.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "meltsim/physics/surface_tension.hpp"
#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double dx =
    1e-3;  // drops of a few millimetres of water, more viscous so that they come to rest soon
constexpr double sigma = 0.072;
constexpr double pi = 3.14159265358979323846;

MaterialDesc water(double viscosity = 0.02) {
  MaterialDesc m;
  m.viscosity = viscosity;
  m.surface_tension = sigma;
  return m;
}

WorldDesc space() {
  WorldDesc d = describe();
  d.precision = Precision::double_precision;
  d.spacing = dx;
  d.gravity = {0, 0, 0};
  d.max_substeps = 100000;
  return d;
}

World create(const WorldDesc& d) {
  auto w = World::create(d);
  require(w);
  return std::move(*w);
}

/// Of liquid and bodies.
struct Momentum {
  Vec3d linear, angular;
  double speeds = 0;  ///< sum of m |v|, which rounding is a share of
  double moments = 0;
};
Momentum momentum_of(World& w) {
  const ParticleData p = *w.particles();
  Momentum m;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    m.linear += p.velocity[i] * p.mass[i];
    m.angular += cross(p.position[i], p.velocity[i]) * p.mass[i];
    m.speeds += length(p.velocity[i]) * p.mass[i];
    m.moments += length(p.position[i]) * length(p.velocity[i]) * p.mass[i];
  }
  return m;
}

double time_of(double radius) { return std::sqrt(1000 * radius * radius * radius / sigma); }

/// Distances of the outermost particles from the centre along 60 directions.
struct Widths {
  double least = 1e9, most = 0;
};
Widths widths_of(World& w) {
  const ParticleData p = *w.particles();
  Vec3d centre;
  for (const Vec3d& x : p.position) centre += x * (1.0 / double(p.position.size()));
  Widths widths;
  const int n = 60;
  for (int k = 0; k < n; ++k) {
    const double z = 1 - (2 * k + 1.0) / n, angle = 2.399963 * k, s = std::sqrt(1 - z * z);
    const Vec3d along{s * std::cos(angle), s * std::sin(angle), z};
    double far = 0;
    for (const Vec3d& x : p.position) far = std::max(far, dot(x - centre, along));
    widths.least = std::min(widths.least, far);
    widths.most = std::max(widths.most, far);
  }
  return widths;
}

TEST(Tension, CubeBecomesBallAndKeepsItsMomentum) {
  MELTSIM_NEEDS_BACKEND();
  World w = create(space());
  FluidDesc f;
  f.material = *w.add_material(water());
  f.shape = Shape::box({0, 0, 0}, {12 * dx, 12 * dx, 12 * dx});
  f.velocity = {0.02, -0.01, 0.03};  // another frame of reference, in which momenta are no zeros
  require(w.add_fluid(f));
  require(w.prepare());
  const Momentum before = momentum_of(w);
  // Towards its faces a cube of 12 lattice points is 5.5 spacings wide, towards its corners 9.5.
  EXPECT_GT(widths_of(w).most - widths_of(w).least, 2.5 * dx);
  require(w.step(6 * time_of(7.4 * dx)));
  // Sums of 1728 particles over some 1500 sub-steps, each rounded to 1e-16.
  EXPECT_LT(length(momentum_of(w).linear - before.linear), 1e-12 * before.speeds);
  // A lattice in a ball leaves terraces of half a spacing.
  EXPECT_LT(widths_of(w).most - widths_of(w).least, 0.9 * dx);
  EXPECT_EQ(w.synchronize().removed, 0u);
}

// Without viscosity every force is along the line between two particles.
TEST(Tension, WithoutViscosityAngularMomentumIsKept) {
  MELTSIM_NEEDS_BACKEND();
  World w = create(space());
  FluidDesc f;
  f.material = *w.add_material(water(0));
  f.shape = Shape::box({0, 0, 0}, {8 * dx, 5 * dx, 6 * dx});
  f.velocity = {0.02, -0.01, 0.03};
  require(w.add_fluid(f));
  f.shape = Shape::box({1 * dx, 5 * dx, 1 * dx}, {5 * dx, 9 * dx, 4 * dx});  // blown past it: the whole turns
  f.velocity = {0.3, 0, -0.2};
  require(w.add_fluid(f));
  require(w.prepare());
  const Momentum before = momentum_of(w);
  require(w.step(0.03));
  const Momentum after = momentum_of(w);
  EXPECT_LT(length(after.linear - before.linear), 1e-12 * before.speeds);
  EXPECT_LT(length(after.angular - before.angular), 1e-11 * before.moments);
  EXPECT_GT(after.speeds, 1.001 * length(after.linear));  // it moves within itself, too
}

TEST(Tension, WithoutItNothingRuns) {
  MELTSIM_NEEDS_BACKEND();
  for (const bool tense : {false, true}) {
    World w = create(space());
    MaterialDesc m = water();
    if (!tense) m.surface_tension = 0;
    FluidDesc f;
    f.material = *w.add_material(m);
    f.shape = Shape::box({0, 0, 0}, {6 * dx, 6 * dx, 6 * dx});
    require(w.add_fluid(f));
    require(w.prepare());
    const Plan plan = w.plan();
    const bool runs = std::any_of(plan.stages.begin(), plan.stages.end(),
                                  [](const StageReport& r) { return r.name == "sph.cohere" && r.runs; });
    EXPECT_EQ(runs, tense);
  }
}

TEST(Tension, DropsMergeAndBodiesFeelTheirLiquid) {
  MELTSIM_NEEDS_BACKEND();
  World w = create(space());
  FluidDesc f;
  f.material = *w.add_material(water());
  // Two drops whose surfaces are within reach of each other, and a body that one of them touches.
  f.shape = Shape::sphere({-4 * dx, 0, 0}, 4 * dx);
  require(w.add_fluid(f));
  f.shape = Shape::sphere({4.5 * dx, 0, 0}, 4 * dx);
  require(w.add_fluid(f));
  MaterialDesc solid;
  solid.name = "solid";
  solid.contact_angle = 30;
  SolidDesc b;
  b.material = *w.add_material(solid);
  b.shape = Shape::box({9 * dx, -2 * dx, -2 * dx}, {12 * dx, 2 * dx, 2 * dx});
  b.motion = Motion::rigid;
  const auto body = w.add_solid(b);
  require(body);
  require(w.prepare());
  require(w.step(3 * time_of(5 * dx)));
  const ParticleData p = *w.particles();
  double low = 1e9, high = -1e9, pulled = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    if (!is_fluid(p.tag[i])) {
      pulled += p.velocity[i].x * p.mass[i];
      continue;
    }
    low = std::min(low, p.position[i].x);
    high = std::max(high, p.position[i].x);
  }
  const Momentum after = momentum_of(w);
  // Rigid bodies sum in fixed point; 1e-6 is the target that physics sets.
  EXPECT_LT(length(after.linear), 1e-6 * after.speeds);
  EXPECT_LT(pulled, 0);              // towards the liquid that wets it
  EXPECT_LT(high - low, 16.5 * dx);  // apart they span 16.5 spacings
}

/// Angle of a cap of known volume from the height of its centre of mass above what it stands on [degrees].
double cap_angle(double volume, double centre) {
  double best = 0, error = 1e9;
  for (double angle = 10; angle < 175; angle += 0.25) {
    const double c = std::cos(angle * pi / 180);
    const double radius = std::cbrt(3 * volume / (pi * (2 + c) * (1 - c) * (1 - c)));
    const double height = radius * (1 - c), top = 2 * radius - height;
    const double at = 3 * top * top / (4 * (3 * radius - height)) - radius * c;
    if (std::abs(at - centre) < error) {
      error = std::abs(at - centre);
      best = angle;
    }
  }
  return best;
}

double angle_on_wall(double angle) {
  WorldDesc d = space();
  d.domain.bounded = true;
  d.domain.max = {28 * dx, 16 * dx, 28 * dx};
  d.domain.no_slip = false;  // so that it comes to rest soon; the angle does not depend on it
  d.domain.contact_angle = angle;
  World w = create(d);
  FluidDesc f;
  f.material = *w.add_material(water());
  f.shape = Shape::intersect(
      {Shape::box({0, 0, 0}, d.domain.max), Shape::sphere({14 * dx, 0, 14 * dx}, 7 * dx)});  // half a ball
  require(w.add_fluid(f));
  require(w.prepare());
  require(w.step(8 * time_of(7 * dx)));
  const ParticleData p = *w.particles();
  double volume = 0, centre = 0;
  for (const Vec3d& x : p.position) {
    volume += dx * dx * dx;
    centre += x.y / double(p.position.size());
  }
  return cap_angle(volume, centre);
}

TEST(Tension, DropsOnWallsHaveTheirAngle) {
  MELTSIM_NEEDS_BACKEND();
  // A neutral wall is a plane of symmetry. Walls of 60 and 120 degrees gave 68 and 120: what is left of an angle of 60 is
  // in docs/limits.md.
  EXPECT_NEAR(angle_on_wall(90), 90, 6);
  EXPECT_NEAR(angle_on_wall(60), 60, 12);
  EXPECT_NEAR(angle_on_wall(120), 120, 8);
}

double angle_on_body(double angle) {
  WorldDesc d = space();
  d.domain.bounded = true;
  d.domain.max = {26 * dx, 18 * dx, 26 * dx};
  World w = create(d);
  MaterialDesc solid;
  solid.name = "solid";
  solid.contact_angle = angle;
  SolidDesc b;
  b.material = *w.add_material(solid);
  b.shape = Shape::box({0, 0, 0}, {26 * dx, 3 * dx, 26 * dx});
  b.motion = Motion::fixed;
  require(w.add_solid(b));
  FluidDesc f;
  f.material = *w.add_material(water());
  f.shape = Shape::intersect(
      {Shape::box({0, 3 * dx, 0}, d.domain.max), Shape::sphere({13 * dx, 3 * dx, 13 * dx}, 6 * dx)});
  require(w.add_fluid(f));
  require(w.prepare());
  require(w.step(8 * time_of(6 * dx)));
  const ParticleData p = *w.particles();
  double volume = 0, centre = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (is_fluid(p.tag[i])) volume += dx * dx * dx, centre += (p.position[i].y - 3 * dx) * dx * dx * dx;
  return cap_angle(volume, centre / volume);
}

TEST(Tension, DropsOnBodiesHaveTheirAngle) {
  MELTSIM_NEEDS_BACKEND();
  // 64 and 125 degrees were seen on a CPU, 128 on a GPU. The face of a lattice is even to a spacing: half of one in the height of the
  // drop's centre, which is 3.4 spacings at 120 degrees and 2.3 at 90, is 13 degrees. 6 were aimed at.
  EXPECT_NEAR(angle_on_body(60), 60, 12);
  EXPECT_NEAR(angle_on_body(120), 120, 12);
}

// A column that spreads to a puddle. Bashforth and Adams' equation for a sessile drop of 2688 mm^3, 0.2 N/m and 90 degrees has its
// centre of mass at 2.52 mm; 2.56 was seen, and 1.96 with half of the strength.
TEST(Tension, PuddleIsAsHighAsTheory) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = space();
  d.precision = Precision::single_precision;
  d.gravity = {0, -9.81, 0};
  d.domain.bounded = true;
  d.domain.max = {48 * dx, 20 * dx, 48 * dx};
  d.domain.no_slip = false;
  World w = create(d);
  MaterialDesc m = water(0.5);  // it must not swing beyond its rest: particles would keep it there
  m.surface_tension = 0.2;      // 4.5 spacings to a capillary length
  FluidDesc f;
  f.material = *w.add_material(m);
  f.shape = Shape::cylinder({24 * dx, 0, 24 * dx}, {24 * dx, 6 * dx, 24 * dx}, 12 * dx);
  require(w.add_fluid(f));
  require(w.prepare());
  ASSERT_EQ(w.synchronize().fluid, 2688u);
  require(w.step(0.3));
  const ParticleData p = *w.particles();
  double centre = 0;
  for (const Vec3d& x : p.position) centre += x.y / double(p.position.size());
  EXPECT_NEAR(centre / (2.52 * dx), 1, 0.1);
}

TEST(Tension, SoundFollowsIt) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = space();
  const double least = physics::cohesion_sound_speed(sigma, 1000, dx);
  for (const double sound : {0.0, 0.5 * least, 1.01 * least}) {
    d.sound_speed = sound;
    World w = create(d);
    FluidDesc f;
    f.material = *w.add_material(water());
    f.shape = Shape::box({0, 0, 0}, {6 * dx, 6 * dx, 6 * dx});
    require(w.add_fluid(f));
    const Status s = w.prepare();
    if (sound == 0.5 * least) {
      ASSERT_FALSE(s);
      EXPECT_EQ(s.error().code, ErrorCode::invalid_argument);
      EXPECT_NE(s.error().message.find("sound_speed: "), std::string::npos) << s.error().message;
      EXPECT_NE(s.error().message.find("surface_tension"), std::string::npos) << s.error().message;
      continue;
    }
    require(s);
    EXPECT_GE(w.resolved().sound_speed, least * (1 - 1e-12));
    EXPECT_LE(w.resolved().stable_dt, physics::capillary_dt(sigma, 1000, dx));
  }
}

TEST(Tension, BadInputIsRefused) {
  MELTSIM_NEEDS_BACKEND();
  World w = create(space());
  const auto refused = [&w](double tension, double angle, const char* what) {
    MaterialDesc m = water();
    m.surface_tension = tension;
    m.contact_angle = angle;
    const auto id = w.add_material(m);
    ASSERT_FALSE(id) << what;
    EXPECT_EQ(id.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(id.error().message.find(what), std::string::npos) << id.error().message;
  };
  const double nan = std::nan("");
  refused(-0.072, 90, "surface_tension: must be finite and >= 0 N/m, got -0.072");
  refused(nan, 90, "surface_tension: must be finite");
  refused(infinity, 90, "surface_tension: must be finite");
  refused(0.072, -1, "contact_angle: must be in 0..180 degrees, got -1");
  refused(0.072, 181, "contact_angle: must be in 0..180 degrees, got 181");
  refused(0.072, nan, "contact_angle: must be in 0..180 degrees");
  WorldDesc d = space();
  d.domain.bounded = true;
  d.domain.max = {20 * dx, 20 * dx, 20 * dx};
  d.domain.contact_angle = 200;
  const auto bad = World::create(d);
  ASSERT_FALSE(bad);
  EXPECT_NE(bad.error().message.find("domain.contact_angle: must be in 0..180"), std::string::npos)
      << bad.error().message;
}

}  // namespace
}  // namespace meltsim_test
