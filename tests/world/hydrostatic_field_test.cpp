// SPDX-License-Identifier: Apache-2.0
// Hydrostatic force fields: pressure below a level counted from that of a liquid at rest.
#include <algorithm>
#include <cmath>
#include <string>

#include "meltsim/physics/artificial_viscosity.hpp"
#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double g = 9.81, dx = 0.1, support = 2.5 * dx;

ForceFieldDesc below(double level, double density = 1000) {
  ForceFieldDesc f;
  f.kind = ForceFieldKind::hydrostatic;
  f.center = Vec3d{0, level, 0};
  f.density = density;
  return f;
}

struct Tank {
  World world;
  MaterialId water;
};

/// Open above, `depth` of water in it.
Tank tank(double width, double depth, double height, Precision precision = Precision::single_precision) {
  WorldDesc d = describe();
  d.precision = precision;
  d.spacing = dx;
  d.gravity = {0, -g, 0};
  d.domain.bounded = true;
  d.domain.max = {width, height, width};
  d.heat.model = HeatModel::none;
  d.max_substeps = 1000;
  d.artificial_viscosity = 0.01;  // the least beside isotropic pressure
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  MaterialDesc m;
  m.name = "water";
  const MaterialId water = *w->add_material(m);
  if (depth > 0) {
    FluidDesc f;
    f.material = water;
    f.shape = Shape::box({0, 0, 0}, {width, depth, width});
    require(w->add_fluid(f));
  }
  return {std::move(*w), water};
}

BodyId body(World& w, double density, Motion motion, const Shape& shape) {
  MaterialDesc m;
  m.name = "body " + std::to_string(w.bodies()->size());
  m.density = density;
  SolidDesc s;
  s.material = *w.add_material(m);
  s.motion = motion;
  s.shape = shape;
  const auto id = w.add_solid(s);
  EXPECT_TRUE(id) << id.error().message;
  return *id;
}

// In empty space, so that it is all there is beside gravity: none above the level, all of rho V/M from a support below it on, in proportion between.
TEST(HydrostaticField, LiftsByTheWeightOfAsMuchLiquid) {
  MELTSIM_NEEDS_BACKEND();
  constexpr double level = 2, density = 800;
  for (const double depth : {-0.5, 0.0, 0.25 * support, 0.6 * support, 1.5 * support, 1.0}) {
    Tank t = tank(2, 0, 4, Precision::double_precision);
    const BodyId b =
        body(t.world, 500, Motion::rigid,
             Shape::box({1, level - depth - dx / 2, 1}, {1 + dx, level - depth + dx / 2, 1 + dx}));
    require(t.world.add_force_field(below(level, density)));
    require(t.world.prepare());
    const double dt = 1e-3,
                 deep = level - (*t.world.pieces())[0].center.y;  // sampling moves it by up to half a spacing
    require(t.world.step(dt));
    const double share = std::min(std::max(deep / support, 0.0), 1.0);
    // A body of one particle, whose volume and mass are in double: sums of a few terms.
    EXPECT_NEAR((*t.world.pieces())[0].velocity.y / dt, -g * (1 - share * density / 500), 1e-9) << depth;
    EXPECT_EQ((*t.world.pieces())[0].body, b);
  }
}

// Its own pressure is what the weight above the level makes, wherever below: rho g (0.6 m + half of what the field sets in over).
TEST(HydrostaticField, LeavesLiquidAtRestUnderAnEvenPressure) {
  MELTSIM_NEEDS_BACKEND();
  constexpr double depth = 2.4, level = 1.8;
  Tank t = tank(1.2, depth, 3);
  require(t.world.add_force_field(below(level)));
  // The sound speed is that of what weighs: the fall to the level, what the field sets in over, and a spacing.
  require(t.world.prepare());
  // From the highest particle, half a spacing below the surface.
  EXPECT_NEAR(t.world.resolved().sound_speed, 10 * std::sqrt(2 * g * (depth - dx / 2 - level + support + dx)),
              1e-3);
  double fastest = 0;
  for (int k = 0; k < 30; ++k) {
    require(t.world.step(0.01));
    const StepResult r = t.world.synchronize();
    fastest = std::max(fastest, r.max_speed);
    EXPECT_FALSE(r.level_bared);
  }
  EXPECT_LT(fastest,
            0.03 * std::sqrt(g * (depth - level)));  // as tanks without a field do (hydrostatic_start)
  const double expected = 1000 * g * (depth - level + 0.5 * support);
  for (const double y : {0.35, 0.65, 0.95}) {
    const auto p = t.world.sample({{0.6, y, 0.6}}, "pressure");
    ASSERT_TRUE(p) << p.error().message;
    // Read with that of rest, which is 0 above the level and as of full weight from a support below it. Beside walls and a free surface: limits.md
    EXPECT_NEAR((*p)[0] - 1000 * g * (level - 0.5 * support - y), expected, 0.06 * expected) << y;
  }
}

/// Adds a probe of one field or none.
ProbeId probe(World& w, ProbeKind kind, const char* field, const Vec3d& at, BodyId of = {}, int wall = -1) {
  ProbeDesc p;
  p.kind = kind;
  if (kind == ProbeKind::point) p.points = {at};
  p.fields = {field};
  p.body = of;
  if (wall >= 0) p.wall = wall;
  const auto id = w.add_probe(p);
  EXPECT_TRUE(id) << id.error().message;
  return *id;
}

// What is read is with the pressure of rest, whatever reads it: at points, of particles, on walls, on a fixed and on a moved body.
TEST(HydrostaticField, PressureIsReadWithThatOfRest) {
  MELTSIM_NEEDS_BACKEND();
  constexpr double width = 1.6, depth = 2.4, level = 1.8, side = 0.4;
  Tank t = tank(width, depth, 3);
  const BodyId fixed =
      body(t.world, 1000, Motion::fixed, Shape::box({0.3, 0.6, 0.3}, {0.7, 0.6 + side, 0.7}));
  const BodyId moved =
      body(t.world, 1000, Motion::kinematic, Shape::box({0.9, 0.6, 0.9}, {1.3, 0.6 + side, 1.3}));
  require(t.world.add_force_field(below(level)));
  const Vec3d at{0.3, 1.35, 0.9};
  const ProbeId point = probe(t.world, ProbeKind::point, "pressure", at);
  const ProbeId lift = probe(t.world, ProbeKind::force, "force", {}, fixed);
  const ProbeId floor = probe(t.world, ProbeKind::force, "force", {}, {}, 2);
  const ProbeId wall = probe(t.world, ProbeKind::force, "force", {}, {}, 0);
  require(t.world.watch_forces(fixed));
  require(t.world.watch_forces(moved));
  require(t.world.step(0.3));
  require(t.world.take_forces());
  ASSERT_TRUE(t.world.take_samples());  // from where it has come to rest
  for (int k = 0; k < 10; ++k) require(t.world.step(0.02));
  ASSERT_FALSE(t.world.synchronize().halted);

  const auto series = t.world.take_samples();
  ASSERT_TRUE(series) << series.error().message;
  const auto mean = [&](ProbeId p, std::size_t component) {
    for (const ProbeSeries& s : *series) {
      if (s.probe != p) continue;
      double sum = 0;
      for (std::size_t k = component; k < s.values.size(); k += s.width) sum += s.values[k];
      return sum / static_cast<double>(s.time.size());
    }
    return std::nan("");
  };
  // Tolerances: a mean over a support is that of its middle but near walls (limits.md); what oscillates after the start, 2 %; a cube of four spacings, 5 %.
  EXPECT_NEAR(mean(point, 0), 1000 * g * (depth - at.y), 0.03 * 1000 * g * (depth - at.y));
  const auto sample = t.world.sample({at}, "pressure");
  ASSERT_TRUE(sample);
  EXPECT_NEAR((*sample)[0], 1000 * g * (depth - at.y),
              0.1 * 1000 * g * (depth - at.y));  // a moment: see below
  // The floor carries all that is there; a side wall rho g h^2/2 of its width, to the tenth that layers beside walls are known to.
  const double displaced = 1000 * g * side * side * side;
  EXPECT_NEAR(mean(floor, 1), -1000 * g * width * width * depth, 0.03 * 1000 * g * width * width * depth);
  EXPECT_NEAR(mean(wall, 0), -0.5 * 1000 * g * depth * depth * width,
              0.06 * 0.5 * 1000 * g * depth * depth * width);
  EXPECT_NEAR(mean(lift, 1), displaced, 0.05 * displaced);
  const auto forces = t.world.take_forces();
  ASSERT_TRUE(forces && forces->size() == 2u);
  for (const BodyForces& f : *forces)
    for (const Impulse& of : {f.total, f.pressure})
      EXPECT_NEAR(of.linear.y / f.seconds, displaced, 0.05 * displaced) << (f.body == moved);
  // Of particles, in both forms: at one moment of a tank that still rings by 5 % (as it does without the field).
  const ParticleData p = *t.world.particles();
  ReadRequest what;
  what.particles = true;
  auto reading = t.world.take(*t.world.request(what));
  ASSERT_TRUE(reading) << reading.error().message;
  ASSERT_EQ(reading->particles.pressure.size(), p.pressure.size());
  double off = 0, count = 0;
  for (std::size_t i = 0; i < p.pressure.size(); ++i) {
    EXPECT_NEAR(reading->particles.pressure[i], p.pressure[i], 1e-4 * 1000 * g * depth);
    if (is_solid(p.tag[i])) continue;
    off += p.pressure[i] - 1000 * g * (depth - p.position[i].y);
    ++count;
  }
  EXPECT_LT(std::fabs(off / count), 0.1 * 1000 * g * depth / 2);
}

TEST(HydrostaticField, SaysWhereTheLevelIsBared) {
  MELTSIM_NEEDS_BACKEND();
  for (const double level : {0.4, 1.0}) {
    Tank t = tank(0.8, 0.8, 1.6);
    require(t.world.add_force_field(below(level)));
    require(t.world.step(1e-3));
    EXPECT_EQ(t.world.synchronize().level_bared, level > 0.8) << level;
  }
}

/// How far a rigid sphere goes from rest in water by its equation of motion: added mass of a half of what it displaces, 0.55 in a box three
/// times as wide (coupling.added_mass); drag by Schiller & Naumann with the viscosity that artificial viscosity amounts to.
double way_of_sphere(double density, double radius, double viscosity, double time) {
  const double volume = 4.0 / 3 * 3.14159265358979 * radius * radius * radius, dt = 1e-4;
  double x = 0, v = 0;
  for (double t = 0; t < time; t += dt) {
    const double re = std::max(std::fabs(v) * 2 * radius / viscosity, 1e-9);
    const double drag = 24 / re * (1 + 0.15 * std::pow(re, 0.687));
    const double force = (1000 - density) * volume * g -
                         0.5 * 1000 * drag * 3.14159265358979 * radius * radius * v * std::fabs(v);
    v += dt * force / ((density + 550) * volume);
    x += v * dt;
  }
  return x;
}

// What it is for. Under 28 spacings of water the level of the pressure holds such a sphere back. Of its way by its equation of motion 0.85 are asked
// for: sampled on a lattice it takes more liquid along than a smooth one (an added mass of 0.64 to 0.8: coupling.added_mass).
TEST(HydrostaticField, ASphereDeepInWaterRisesAsItsEquationOfMotionSays) {
  MELTSIM_NEEDS_BACKEND();
  constexpr double radius = 4 * dx, time = 1;
  Tank t = tank(2.2, 3.6, 4.4);
  body(t.world, 917, Motion::rigid, Shape::sphere({1.1, 0.8, 1.1}, radius));
  require(t.world.add_force_field(below(3.0)));  // without it, 0.73 of its way
  require(t.world.prepare());
  const double nu = physics::artificial_kinematic_viscosity(0.01, t.world.resolved().sound_speed, support);
  for (int k = 0; k < 20; ++k) require(t.world.step(time / 20));
  const StepResult r = t.world.synchronize();
  EXPECT_FALSE(r.halted || r.level_bared) << r.halt_reason;
  const double way = (*t.world.pieces())[0].center.y - 0.8, right = way_of_sphere(917, radius, nu, time);
  EXPECT_GT(way, 0.85 * right);
  EXPECT_LT(way, 1.05 * right);
}

// What lies on the floor has the weight that water leaves it, by the force of its contact: liquid's pressure under it has no gradient there.
TEST(HydrostaticField, WhatLiesOnTheFloorWeighsWhatWaterLeaves) {
  MELTSIM_NEEDS_BACKEND();
  for (const bool field : {false, true}) {
    Tank t = tank(1.2, 1.6, 2.4);
    const BodyId cube = body(t.world, 3000, Motion::rigid, Shape::box({0.4, 0, 0.4}, {0.8, 0.4, 0.8}));
    if (field) require(t.world.add_force_field(below(1.2)));
    require(t.world.watch_forces(cube));
    for (int k = 0; k < 40; ++k) require(t.world.step(0.01));
    require(t.world.take_forces());
    for (int k = 0; k < 40; ++k) require(t.world.step(0.01));
    const auto f = t.world.take_forces();
    ASSERT_TRUE(f && f->size() == 1u);
    // Liquid's pressure under it is known to some 5 % (limits.md); with the field it has nothing to be wrong by.
    const double weight = 2000 * g * 0.064;
    EXPECT_NEAR((*f)[0].contact.linear.y / (*f)[0].seconds, weight, (field ? 0.02 : 0.07) * weight) << field;
  }
}

// Single precision takes such a radius for 0, and a particle right in the level would be 0/0 below it.
TEST(HydrostaticField, TakesAnyRadius) {
  MELTSIM_NEEDS_BACKEND();
  Tank t = tank(2, 0, 4);
  body(t.world, 500, Motion::rigid, Shape::box({1, 2, 1}, {1 + dx, 2 + dx, 1 + dx}));
  ForceFieldDesc f = below((*t.world.pieces())[0].center.y);
  f.radius = 1e-60;
  require(t.world.add_force_field(f));
  require(t.world.step(1e-3));
  EXPECT_FALSE(t.world.synchronize().halted);
  EXPECT_NEAR((*t.world.pieces())[0].velocity.y, -g * 1e-3, 1e-6);
}

// Along any axis; with lighter liquid above, of which less is taken out than it weighs; where the weight sets in at once, too.
TEST(HydrostaticField, LeavesLayersAtRestAlongAnyAxis) {
  MELTSIM_NEEDS_BACKEND();
  for (const int axis : {0, 1, 2})
    for (const double radius : {0.0, 1e-60}) {
      const auto up = [axis](double along, double across) {
        Vec3d v{across, across, across};
        (axis == 0 ? v.x : axis == 1 ? v.y : v.z) = along;
        return v;
      };
      WorldDesc d = describe();
      d.spacing = dx;
      d.gravity = up(-g, 0);
      d.domain.bounded = true;
      d.domain.max = up(3, 0.8);
      d.heat.model = HeatModel::none;
      d.max_substeps = 1000;
      World w = std::move(*World::create(d));
      MaterialDesc m;
      m.name = "water";
      const MaterialId water = *w.add_material(m);
      m.name = "oil";
      m.density = 850;
      const MaterialId oil = *w.add_material(m);
      FluidDesc f;
      f.material = water;
      f.shape = Shape::box({0, 0, 0}, up(1.6, 0.8));
      require(w.add_fluid(f));
      f.material = oil;
      f.shape = Shape::box(up(1.6, 0), up(2.4, 0.8));
      require(w.add_fluid(f));
      ForceFieldDesc field = below(0);
      field.center = up(1.1, 0);
      field.radius = radius;
      require(w.add_force_field(field));
      double fastest = 0;
      for (int k = 0; k < 20; ++k) {
        require(w.step(0.01));
        const StepResult r = w.synchronize();
        ASSERT_FALSE(r.halted || r.level_bared) << r.halt_reason;
        fastest = std::max(fastest, r.max_speed);
      }
      // Where the weight sets in at once the layer across the level is not in balance at first.
      EXPECT_LT(fastest, (radius > 0 ? 0.1 : 0.05) * std::sqrt(g * 1.3)) << axis << ' ' << radius;
    }
}

TEST(HydrostaticField, ActsWithoutLiquidsForces) {
  MELTSIM_NEEDS_BACKEND();
  Tank t = tank(0.8, 0.8, 1.6);
  body(t.world, 500, Motion::rigid, Shape::box({0.3, 1.0, 0.3}, {0.5, 1.2, 0.5}));  // or no field acts at all
  require(t.world.add_force_field(below(0.6)));
  require(t.world.scheduler().enable("sph", false));
  for (int k = 0; k < 3; ++k) require(t.world.step(1e-3));
  const StepResult r = t.world.synchronize();
  EXPECT_FALSE(r.halted);
  EXPECT_FALSE(r.level_bared);  // no density says so
}

TEST(HydrostaticField, WhatMeansNothingIsRefused) {
  MELTSIM_NEEDS_BACKEND();
  Tank t = tank(0.8, 0.4, 1);
  const auto said = [&](ForceFieldDesc f) {
    const auto id = t.world.add_force_field(f);
    return id ? std::string() : id.error().message;
  };
  ForceFieldDesc f = below(0.2);
  f.density = 0;
  EXPECT_NE(said(f).find("density: "), std::string::npos) << said(f);
  f = below(0.2);
  f.center.reset();
  EXPECT_NE(said(f).find("center: is not given"), std::string::npos) << said(f);
  f = below(0.2);
  f.bodies = false;
  EXPECT_NE(said(f).find("bodies: is false"), std::string::npos) << said(f);
  f = below(0.2);
  f.liquid = false;
  EXPECT_NE(said(f).find("liquid: is false"), std::string::npos) << said(f);
  EXPECT_EQ(said(below(0.2)), "");
}

}  // namespace
}  // namespace meltsim_test
