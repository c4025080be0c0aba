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

/// Half widths of what is liquid along n directions, as from the second moment: sqrt(5 <(x.n)^2>) is the radius of a ball.
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
    double far = 0;  // the outermost particle
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
  f.shape = Shape::box({0, 0, 0}, {10 * dx, 10 * dx, 10 * dx});
  f.velocity = {0.02, -0.01, 0.03};  // another frame of reference, in which momenta are no zeros
  require(w.add_fluid(f));
  require(w.prepare());
  const Momentum before = momentum_of(w);
  // Corners of a cube are sqrt(3) times as far as its faces.
  EXPECT_GT(widths_of(w).most, 1.5 * widths_of(w).least);
  require(w.step(4 * time_of(6.2 * dx)));
  const Momentum after = momentum_of(w);
  // Sums of 1000 particles over some 400 sub-steps, each rounded to 1e-16.
  EXPECT_LT(length(after.linear - before.linear), 1e-12 * before.speeds);
  EXPECT_LT(length(after.angular - before.angular), 1e-11 * before.moments);
  // Outermost particles of a lattice that became a ball of 6 spacings lie up to half a spacing apart.
  const Widths ball = widths_of(w);
  EXPECT_LT(ball.most - ball.least, 0.8 * dx);
  EXPECT_EQ(w.synchronize().removed, 0u);
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
  f.shape = Shape::sphere({14 * dx, 0, 14 * dx}, 7 * dx);  // the half of it that is in the domain
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
  // A neutral wall is a plane of symmetry.
  EXPECT_NEAR(angle_on_wall(90), 90, 6);
  EXPECT_NEAR(angle_on_wall(60), 60, 12);
  EXPECT_NEAR(angle_on_wall(120), 120, 12);
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
