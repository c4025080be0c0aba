// SPDX-License-Identifier: Apache-2.0
// Probes of forces, heat and fluxes: momentum, angular momentum and heat balance in every sub-step, and known answers.
#include <cmath>
#include <string>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

ProbeDesc on_wall(ProbeKind kind, int wall, std::vector<std::string> fields = {}) {
  ProbeDesc d;
  d.kind = kind;
  d.wall = wall;
  d.fields = std::move(fields);
  return d;
}
ProbeDesc on_body(ProbeKind kind, BodyId body, std::vector<std::string> fields = {}) {
  ProbeDesc d;
  d.kind = kind;
  d.body = body;
  d.fields = std::move(fields);
  return d;
}

/// The values of the last sample of every probe.
std::vector<std::vector<double>> last_values(World& w) {
  std::vector<std::vector<double>> last;
  auto taken = w.take_samples();
  EXPECT_TRUE(taken);
  for (const ProbeSeries& s : *taken) {
    EXPECT_FALSE(s.time.empty());
    last.emplace_back(s.values.end() - s.width, s.values.end());
  }
  return last;
}
Vec3d vector_at(const std::vector<double>& v, std::size_t at = 0) {
  return {v.at(at), v.at(at + 1), v.at(at + 2)};
}

struct Search {
  const char* name;
  NeighbourSearch search = NeighbourSearch::grid;
  bool periodic = false;
  Precision precision = Precision::double_precision;
  bool isotropic_pressure = false;
};
const Search searches[] = {
    {"grid"},
    {"grid, single", NeighbourSearch::grid, false, Precision::single_precision},
    {"grid, periodic", NeighbourSearch::grid, true},
    {"tree, periodic", NeighbourSearch::tree, true},
    {"grid, isotropic pressure", NeighbourSearch::grid, false, Precision::double_precision, true},
};

/// A cube of 2.4 m between walls, without heat.
WorldDesc walled(const Search& s) {
  WorldDesc d = describe();
  d.neighbour_search = s.search;
  d.precision = s.precision;
  d.spacing = 0.2;
  d.sound_speed = 40;
  d.isotropic_pressure = s.isotropic_pressure;
  d.heat.model = HeatModel::none;
  d.domain.bounded = true;
  d.domain.max = {2.4, 2.4, 2.4};
  if (s.periodic) d.domain.faces[0] = d.domain.faces[1] = Face::periodic;
  return d;
}

/// A tank of moving water, a post in it that is held, and on the post a block that slides.
struct Tank {
  World world;
  BodyId post, block;
};
Tank make_tank(const Search& s, double viscosity, bool no_slip) {
  WorldDesc d = walled(s);
  d.domain.no_slip = no_slip;
  World w = std::move(*World::create(d));
  MaterialDesc water;
  water.viscosity = viscosity;
  MaterialDesc stone;
  stone.name = "stone";
  stone.density = 2000;
  SolidDesc b;
  b.material = *w.add_material(stone);
  b.shape = Shape::box({0.8, 0, 0.8}, {1.6, 1.0, 1.6});
  b.fixed = true;
  const BodyId post = *w.add_solid(b);
  b.fixed = false;
  b.shape = Shape::box({0.8, 1.0, 0.8}, {1.6, 1.6, 1.6});
  b.velocity = {0.3, -0.2, 0.1};
  const BodyId block = *w.add_solid(b);
  FluidDesc f;
  f.material = *w.add_material(water);
  f.shape = Shape::box({0, 0, 0}, {2.4, 1.2, 2.4});
  f.velocity = {0.4, 0.2, -0.3};
  require(w.add_fluid(f));
  return {std::move(w), post, block};
}

/// Rounding of velocities in the difference of two momenta over a sub-step, of N particles of mass m at speeds up to 1 m/s:
/// eps m sqrt(N)/dt, m = 8 kg (16), N = 1000, dt = 2 ms; and that of the forces, of which the largest is 7e4 N. In double,
/// units of the exact sums by which shape matching keeps a piece's momentum add 1e-8.
double tolerance(Precision p) { return p == Precision::double_precision ? 1e-6 : 0.5; }

// Everything that moves is moved by gravity, walls and the post: their forces are the change of momentum. A force that is
// left out, counted twice or taken of another moment shows here.
TEST(Load, MomentumBalancesInEverySubStep) {
  MELTSIM_NEEDS_BACKEND();
  for (const Search& s : searches) {
    Tank t = make_tank(s, 0.5, true);
    World& w = t.world;
    const std::vector<std::string> both{"force", "contact_force"};
    for (int face = s.periodic ? 2 : 0; face < 6; ++face)
      require(w.add_probe(on_wall(ProbeKind::force, face, both)));
    require(w.add_probe(on_body(ProbeKind::force, t.post, both)));
    require(w.add_probe(on_body(ProbeKind::force, t.block, both)));
    const double dt = 2e-3, weight = 9.81;
    double pressed = 0, drawn = 0, on_post = 0;
    for (int k = 0; k < 60; ++k) {
      const Totals before = *w.totals();
      const Vec3d block_before = w.pieces()->at(1).velocity;
      require(w.step(dt));
      const Totals after = *w.totals();
      const auto values = last_values(w);
      double moving = 0, block_mass = 0;
      Vec3d block_after;
      const std::vector<PieceInfo> pieces = *w.pieces();
      for (const PieceInfo& p : pieces)
        if (p.body == t.block) {
          block_mass = p.mass;
          block_after = p.velocity;
        }
      // The post counts in `mass`, and does not fall.
      moving = after.mass - pieces.at(0).mass;
      Vec3d outside = Vec3d{0, -weight * moving, 0};
      for (std::size_t n = 0; n + 1 < values.size(); ++n)
        outside = outside - vector_at(values[n]) - vector_at(values[n], 3);
      const Vec3d rate = (after.momentum - before.momentum) * (1 / dt);
      EXPECT_LT(length(rate - outside), tolerance(s.precision)) << s.name << ", sub-step " << k;
      const std::vector<double>& of_block = values.back();
      const Vec3d got = vector_at(of_block) + vector_at(of_block, 3) - Vec3d{0, weight * block_mass, 0};
      EXPECT_LT(length((block_after - block_before) * (block_mass / dt) - got), tolerance(s.precision))
          << s.name << ", sub-step " << k;
      // What the block and the post do to each other is equal and opposite: neither touches anything else.
      const Vec3d post = vector_at(values[values.size() - 2], 3), block = vector_at(of_block, 3);
      EXPECT_LT(length(post + block), 1e-5 * length(post) + 1e-9) << s.name;
      pressed = std::max(pressed, -vector_at(values[s.periodic ? 0 : 2]).y);
      drawn = std::max(drawn, std::fabs(vector_at(values[s.periodic ? 0 : 2]).x));
      on_post = std::max(on_post, length(post));
    }
    // The scene has what the balance is about: water on the floor, traction along it, the block on the post.
    EXPECT_GT(pressed, 1e4) << s.name;
    EXPECT_GT(drawn, 1) << s.name;
    EXPECT_GT(on_post, 1e3) << s.name;
  }
}

/// 216 kg of water, or a body of as much, in flight into a corner.
World thrown(const Search& s, bool solid, double speed) {
  WorldDesc d = walled(s);
  d.gravity = {};
  d.domain.no_slip = false;
  World w = std::move(*World::create(d));
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0.6, 0.6, 0.6}, {1.2, 1.2, 1.2});
  f.velocity = {1, -speed, -3};
  SolidDesc b;
  b.material = f.material;
  b.shape = f.shape;
  b.velocity = f.velocity;
  if (solid) require(w.add_probe(on_body(ProbeKind::force, *w.add_solid(b), {"force", "contact_force"})));
  else require(w.add_fluid(f));
  for (int face = s.periodic ? 2 : 0; face < 6; ++face)
    require(w.add_probe(on_wall(ProbeKind::force, face, {"force", "contact_force"})));
  return w;
}

// At a tenth of the speed of sound the outermost particles of water reach the walls before any pressure turns them, and at 0.3 of it a
// body comes nearer than its contact lets it: they are held inside (physics::hold_inside), which walls feel as well.
TEST(Load, WallsFeelWhatTheyHoldInside) {
  MELTSIM_NEEDS_BACKEND();
  for (const Search& s : searches)
    for (const bool solid : {false, true}) {
      World w = thrown(s, solid, solid ? 12 : 4);
      const std::string what = std::string(s.name) + (solid ? ", body" : ", water");
      // The rounding of velocities, of 216 kg at 5 m/s, is 0.3 N in single precision.
      const double dt = 2e-3, mass = 216, allowed = s.precision == Precision::double_precision ? 1e-6 : 0.5;
      double impulse = 0;
      for (int k = 0; k < 150; ++k) {
        const Vec3d before = w.totals()->momentum;
        require(w.step(dt));
        const Vec3d rate = (w.totals()->momentum - before) * (1 / dt);
        const auto values = last_values(w);
        Vec3d on_walls;
        for (std::size_t n = solid ? 1 : 0; n < values.size(); ++n)
          on_walls = on_walls + vector_at(values[n]) + vector_at(values[n], 3);
        EXPECT_LT(length(on_walls + rate), allowed) << what << ", sub-step " << k;
        if (solid) {
          EXPECT_LT(length(vector_at(values[0], 3) - rate), allowed) << what << ", sub-step " << k;
        }
        impulse += on_walls.y * dt;
      }
      EXPECT_LT(impulse, -3 * mass) << what << ": it has hit the floor";
    }
}

// What seeps beneath a body presses it off the wall, and the wall as much the other way.
TEST(Load, WallsFeelWhatSeepsBeneathBodies) {
  MELTSIM_NEEDS_BACKEND();
  for (const Search& s : searches)
    for (const Motion motion : {Motion::free, Motion::rigid}) {
      World w = std::move(*World::create(walled(s)));
      MaterialDesc wood;
      wood.name = "wood";
      wood.density = 800;
      SolidDesc b;
      b.material = *w.add_material(wood);
      b.motion = motion;
      b.shape = Shape::box({0, 0, 0.8}, {0.8, 0.8, 1.6});
      const BodyId body = *w.add_solid(b);
      FluidDesc f;
      f.material = *w.add_material({});
      f.shape = Shape::box({0, 0, 0}, {2.4, 1.6, 2.4});
      require(w.add_fluid(f));
      require(w.add_probe(on_body(ProbeKind::force, body, {"force", "contact_force"})));
      for (int face = s.periodic ? 2 : 0; face < 6; ++face)
        require(w.add_probe(on_wall(ProbeKind::force, face, {"force", "contact_force"})));
      const double dt = 2e-3, weight = 9.81, mass = w.totals()->mass, of_body = w.pieces()->at(0).mass;
      const std::string what = std::string(s.name) + (motion == Motion::rigid ? ", rigid" : ", free");
      for (int k = 0; k < 60; ++k) {
        const Vec3d before = w.totals()->momentum, body_before = w.pieces()->at(0).velocity;
        require(w.step(dt));
        const Vec3d rate = (w.totals()->momentum - before) * (1 / dt);
        const auto values = last_values(w);
        Vec3d on_walls;
        for (std::size_t n = 1; n < values.size(); ++n)
          on_walls = on_walls + vector_at(values[n]) + vector_at(values[n], 3);
        EXPECT_LT(length(on_walls + rate + Vec3d{0, weight * mass, 0}), tolerance(s.precision))
            << what << ", " << k;
        const Vec3d got = vector_at(values[0]) + vector_at(values[0], 3) - Vec3d{0, weight * of_body, 0};
        EXPECT_LT(length((w.pieces()->at(0).velocity - body_before) * (of_body / dt) - got),
                  tolerance(s.precision))
            << what << ", " << k;
      }
      EXPECT_GT(w.pieces()->at(0).velocity.y, 0.01) << what << ": it rises";
    }
}

// The gap between two bodies takes from one what it gives the other: walls and weight alone change the momentum of all there is.
TEST(Load, WhatSeepsBetweenBodiesIsMutual) {
  MELTSIM_NEEDS_BACKEND();
  for (const Search& s : searches)
    for (const Motion motion : {Motion::free, Motion::rigid}) {
      World w = std::move(*World::create(walled(s)));
      MaterialDesc stone;
      stone.name = "stone";
      stone.density = 4000;
      SolidDesc b;
      b.material = *w.add_material(stone);
      b.motion = motion;
      b.shape = Shape::box({0.4, 0, 0.6}, {1.6, 0.8, 1.8});
      require(w.add_solid(b));
      MaterialDesc wood;
      wood.name = "wood";
      wood.density = 500;
      b.material = *w.add_material(wood);
      b.shape = Shape::box({0.6, 0.8, 0.8}, {1.4, 1.4, 1.6});
      require(w.add_solid(b));
      FluidDesc f;
      f.material = *w.add_material({});
      f.shape = Shape::box({0, 0, 0}, {2.4, 2, 2.4});
      require(w.add_fluid(f));
      for (int face = s.periodic ? 2 : 0; face < 6; ++face)
        require(w.add_probe(on_wall(ProbeKind::force, face, {"force", "contact_force"})));
      const double dt = 2e-3, weight = 9.81, mass = w.totals()->mass;
      const std::string what = std::string(s.name) + (motion == Motion::rigid ? ", rigid" : ", free");
      for (int k = 0; k < 60; ++k) {
        const Vec3d before = w.totals()->momentum;
        require(w.step(dt));
        const Vec3d rate = (w.totals()->momentum - before) * (1 / dt);
        Vec3d on_walls;
        for (const auto& v : last_values(w)) on_walls = on_walls + vector_at(v) + vector_at(v, 3);
        EXPECT_LT(length(on_walls + rate + Vec3d{0, weight * mass, 0}), tolerance(s.precision))
            << what << ", " << k;
      }
      EXPECT_GT(w.pieces()->at(1).velocity.y, 0.05) << what << ": the gap lifts it off the stone";
    }
}

// Without viscosity all forces between particles are central. Moments about the origin of coordinates.
TEST(Load, AngularMomentumBalancesInEverySubStep) {
  MELTSIM_NEEDS_BACKEND();
  Tank t = make_tank(searches[0], 0, false);
  World& w = t.world;
  for (int face = 0; face < 6; ++face) {
    ProbeDesc d = on_wall(ProbeKind::force, face, {"contact_moment", "moment"});
    d.points = {{0, 0, 0}};
    require(w.add_probe(d));
  }
  ProbeDesc post = on_body(ProbeKind::force, t.post, {"moment"});
  post.points = {{0, 0, 0}};
  require(w.add_probe(post));
  // Contact acts along the surface's normal, at the particle on either side: of the two moments the block's moves it.
  ProbeDesc block = on_body(ProbeKind::force, t.block, {"contact_moment"});
  block.points = {{0, 0, 0}};
  require(w.add_probe(block));
  const double dt = 2e-3;
  for (int k = 0; k < 40; ++k) {
    const ParticleData p = *w.particles();
    const Vec3d before = w.totals()->angular_momentum;
    require(w.step(dt));
    Vec3d expected{};
    for (std::size_t i = 0; i < p.id.size(); ++i)
      if ((p.tag[i] & tag_fixed) == 0u)
        expected += cross(p.position[i] + p.velocity[i] * (0.5 * dt), Vec3d{0, -9.81 * p.mass[i], 0});
    const auto values = last_values(w);
    for (std::size_t face = 0; face < 6; ++face)
      expected = expected - vector_at(values[face]) - vector_at(values[face], 3);
    expected = expected - vector_at(values[6]) + vector_at(values[7]);
    const Vec3d rate = (w.totals()->angular_momentum - before) * (1 / dt);
    // As above, with arms of up to 4 m.
    EXPECT_LT(length(rate - expected), 4e-6) << "sub-step " << k;
  }
}

TEST(Load, MomentsAboutDifferentPointsDifferByTheForce) {
  MELTSIM_NEEDS_BACKEND();
  Tank t = make_tank(searches[0], 0.5, true);
  World& w = t.world;
  ProbeDesc d = on_body(ProbeKind::force, t.block, {"force", "moment"});
  require(w.add_probe(d));  // about the centre of mass
  const Vec3d point{0.3, 2, -1};
  d.points = {point};
  d.fields = {"moment"};
  require(w.add_probe(d));
  d = on_wall(ProbeKind::force, 2, {"moment", "force"});
  require(w.add_probe(d));  // about the middle of the floor
  d.points = {point};
  require(w.add_probe(d));
  for (int k = 0; k < 20; ++k) require(w.step(2e-3));
  const PieceInfo before = w.pieces()->at(1);
  ASSERT_EQ(before.body, t.block);
  require(w.step(2e-3));
  const auto v = last_values(w);
  const Vec3d center = before.center + before.velocity * 1e-3, force = vector_at(v[0]);
  EXPECT_LT(length(vector_at(v[1]) - vector_at(v[0], 3) - cross(center - point, force)),
            1e-8 * length(force));
  const Vec3d floor = vector_at(v[2], 3);
  EXPECT_EQ(length(vector_at(v[3], 3) - floor), 0);
  EXPECT_LT(length(vector_at(v[3]) - vector_at(v[2]) - cross(Vec3d{1.2, 0, 1.2} - point, floor)),
            1e-9 * length(floor));
}

// Traction acts in the plane of the wall: about a point of it, without pressure, nothing turns.
TEST(Load, TractionActsInThePlaneOfItsWall) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.sound_speed = 30;
  d.gravity = {};
  d.precision = Precision::double_precision;
  d.domain.bounded = true;
  d.domain.max = {1.2, 1.6, 1.2};
  World w = std::move(*World::create(d));
  MaterialDesc oil;
  oil.viscosity = 2;
  FluidDesc f;
  f.material = *w.add_material(oil);
  f.shape = Shape::box({0, 0, 0}, {1.2, 0.6, 1.2});
  f.velocity = {0.5, 0, 0};
  require(w.add_fluid(f));
  ProbeDesc floor = on_wall(ProbeKind::force, 2, {"force", "moment"});
  floor.points = {{0.2, 0, 0.3}};
  require(w.add_probe(floor));
  require(w.step(1e-8));
  const auto v = last_values(w);
  EXPECT_GT(v[0][0], 1);
  // Beside a wall that it moves towards, liquid is compressed by rho c^2 v dt/2 /dx = 0.02 Pa, on 0.12 m^2 a metre away.
  EXPECT_NEAR(v[0][3], 0, 0.01);
  EXPECT_NEAR(v[0][5], 0, 0.01);
  EXPECT_NEAR(v[0][4], (0.6 - 0.3) * v[0][0], 0.02 * v[0][0]) << "its middle is where the floor's is";
}

/// Water at rest in a tank of 1.2 m, `layers` of 0.1 m deep; 2 s later.
World still_water(int layers, bool with_cube, BodyId& cube) {
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.sound_speed = 30;
  d.heat.model = HeatModel::none;
  d.domain.bounded = true;
  d.domain.max = {1.2, 1.6, 1.2};
  World w = std::move(*World::create(d));
  if (with_cube) {
    MaterialDesc stone;
    stone.name = "stone";
    stone.density = 2000;
    SolidDesc b;
    b.material = *w.add_material(stone);
    b.shape = Shape::box({0.4, 0.4, 0.4}, {0.8, 0.8, 0.8});
    b.fixed = true;
    cube = *w.add_solid(b);
  }
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0, 0, 0}, {1.2, 0.1 * layers, 1.2});
  require(w.add_fluid(f));
  return w;
}

/// Means over the second second of each value of each probe.
std::vector<std::vector<double>> means_at_rest(World& w) {
  while (w.time() < 1) require(w.step(2e-3));
  require(w.take_samples());
  while (w.time() < 2) require(w.step(2e-3));
  EXPECT_FALSE(w.synchronize().halted);
  std::vector<std::vector<double>> means;
  const std::vector<ProbeSeries> all = *w.take_samples();
  for (const ProbeSeries& s : all) {
    std::vector<double> mean(s.width, 0.0);
    for (std::size_t n = 0; n < s.time.size(); ++n)
      for (std::size_t k = 0; k < s.width; ++k) mean[k] += s.values[n * s.width + k] / double(s.time.size());
    means.push_back(std::move(mean));
  }
  return means;
}

// A floor carries the water's weight, but for what traction along the sides carries and for momentum that is left, both below
// a hundredth. A wall feels rho g h^2 b/2, and its moment about the floor is that times h/3: the liquid's pressure is right
// to 4 % for this many layers (docs/limits.md), and half a layer of the surface is uncertain, h^2 by 1/9, h^3 by 1/6.
TEST(Load, StillWaterPressesAsItsWeightAndDepthSay) {
  MELTSIM_NEEDS_BACKEND();
  BodyId none;
  World w = still_water(9, false, none);
  require(w.add_probe(on_wall(ProbeKind::force, 2, {"force"})));
  ProbeDesc wall = on_wall(ProbeKind::force, 1, {"force", "moment"});
  wall.points = {{1.2, 0, 0.6}};
  require(w.add_probe(wall));
  const double weight = w.totals()->mass * 9.81;
  const auto mean = means_at_rest(w);
  EXPECT_NEAR(mean[0][1], -weight, 0.01 * weight);
  EXPECT_NEAR(mean[0][0], 0, 1e-3 * weight);
  const double h = 0.9, push = 1000 * 9.81 * h * h / 2 * 1.2;
  EXPECT_NEAR(mean[1][0], push, 0.11 * push);
  EXPECT_NEAR(mean[1][5], -push * h / 3, 0.17 * push * h / 3);
}

// Archimedes: pressure below less pressure above, each right to 4 % of the difference and a tenth of a spacing of the depth.
TEST(Load, AHeldBodyLosesTheWeightOfWhatItDisplaces) {
  MELTSIM_NEEDS_BACKEND();
  BodyId cube;
  World w = still_water(12, true, cube);
  require(w.add_probe(on_body(ProbeKind::force, cube, {"force", "contact_force"})));
  require(w.add_probe(on_wall(ProbeKind::force, 2, {"force"})));
  const double water = (w.totals()->mass - 64 * 2.0) * 9.81;
  const auto mean = means_at_rest(w);
  const double displaced = 0.064 * 1000 * 9.81;
  EXPECT_NEAR(mean[0][1], displaced, 0.06 * displaced);
  EXPECT_NEAR(mean[0][0], 0, 0.02 * displaced);
  EXPECT_EQ(mean[0][4], 0) << "it touches nothing";
  EXPECT_NEAR(mean[1][1], -(water + mean[0][1]), 0.01 * water) << "the floor carries both";
}

// Dry bodies: heat goes from one into the other, and through the walls.
TEST(Load, HeatIsWhatBodiesGainAndWallsGive) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.gravity = {};
  d.heat.time_scale = 100;
  d.domain.bounded = true;
  d.domain.max = {1, 1, 1};
  d.domain.heat[0].flux = 2000;
  d.domain.heat[3].temperature = 90;
  World w = std::move(*World::create(d));
  MaterialDesc stone;
  stone.name = "stone";
  stone.density = 2000;
  stone.heat_capacity = 800;
  stone.conductivity = 3;
  SolidDesc b;
  b.material = *w.add_material(stone);
  b.fixed = true;
  b.shape = Shape::box({0, 0, 0}, {0.5, 1, 1});
  b.temperature = 0;
  const BodyId cold = *w.add_solid(b);
  b.shape = Shape::box({0.5, 0, 0}, {1, 1, 1});
  b.temperature = 50;
  const BodyId hot = *w.add_solid(b);
  require(w.add_probe(on_body(ProbeKind::heat, cold)));
  require(w.add_probe(on_body(ProbeKind::heat, hot)));
  for (int face = 0; face < 6; ++face) require(w.add_probe(on_wall(ProbeKind::heat, face)));
  const auto heat_of = [&](BodyId body) {
    const ParticleData p = *w.particles();
    double h = 0;
    for (std::size_t i = 0; i < p.id.size(); ++i)
      if (body_of(p.tag[i]) == body.index + 1) h += p.enthalpy[i];
    return h;
  };
  const double dt = 0.05, steps = 100;
  double gained[2] = {}, through[6] = {};
  const double before[2] = {heat_of(cold), heat_of(hot)}, in_before = w.ledger()->heat_in;
  for (int k = 0; k < steps; ++k) {
    require(w.step(dt));
    const auto v = w.take_samples();
    for (std::size_t n = 0; n < 8; ++n)
      for (const double value : v->at(n).values)
        (n < 2 ? gained[n] : through[n - 2]) += value * dt / double(v->at(n).values.size());
  }
  const double cold_gain = heat_of(cold) - before[0], hot_gain = heat_of(hot) - before[1];
  // The sub-step is kept in single precision.
  EXPECT_NEAR(gained[0], cold_gain, 1e-7 * std::fabs(cold_gain));
  EXPECT_NEAR(gained[1], hot_gain, 1e-7 * std::fabs(hot_gain));
  EXPECT_LT(hot_gain, 0) << "it warms the other";
  // A flux is a flux: 2000 W/m^2 on 1 m^2, a hundred times as fast as motion. The lattice serves the area to rounding.
  EXPECT_NEAR(through[0], 2000 * 100 * dt * steps, 1e-5 * 2e5 * dt * steps);
  // The ledger has all of it. The ceiling's is taken at the end of each sub-step: low by half of what it falls in one, and it
  // falls from start to end by less than its first value.
  const double in = w.ledger()->heat_in - in_before;
  EXPECT_NEAR(in, cold_gain + hot_gain, 1e-9 * std::fabs(in) + 1e-3);
  EXPECT_GT(through[3], 0.1 * in);
  EXPECT_NEAR(through[0] + through[3], in, 0.03 * in);
  for (const int insulated : {1, 2, 4, 5}) EXPECT_EQ(through[insulated], 0);
}

// Water that moves as a whole: rho A v.n. A disc 8 spacings wide holds 52 of the lattice's columns, not 50.3; a rectangle along
// the lattice as many as its area says; one that is turned to within a column along its sides, 2 in 60.
TEST(Load, FluxOfAStreamIsDensityTimesAreaTimesSpeed) {
  MELTSIM_NEEDS_BACKEND();
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    WorldDesc d = describe();
    d.precision = precision;
    d.spacing = 0.1;
    d.gravity = {};
    d.sound_speed = 30;
    World w = std::move(*World::create(d));
    FluidDesc f;
    f.material = *w.add_material({});
    f.shape = Shape::box({-2, -1, -1}, {2, 1, 1});
    f.velocity = {1.5, 0.2, 0};
    require(w.add_fluid(f));
    ProbeDesc p;
    p.kind = ProbeKind::flux;
    p.points = {{0.02, 0, 0}};
    p.normal = {2, 0, 0};
    p.radius = 0.4;
    p.fields = {"mass_flux", "volume_flux"};
    require(w.add_probe(p));
    p.normal = {-1, 0, 0};
    p.radius = 0;
    p.along = {0.3, 0, 1};  // what lies along the normal does not count
    p.size[0] = 0.6;
    p.size[1] = 1.0;
    p.fields = {"volume_flux", "mass_flux"};
    require(w.add_probe(p));
    p.normal = {0, 1, 0};
    p.fields = {"volume_flux"};
    require(w.add_probe(p));
    p.points = {{0, 8, 0}};
    require(w.add_probe(p));
    require(w.step(1e-6));  // before anything else moves
    const auto v = last_values(w);
    EXPECT_NEAR(v[0][0], 1000 * 0.52 * 1.5, 0.005 * 1000 * 0.52 * 1.5);
    EXPECT_NEAR(v[0][1] * 1000, v[0][0], 1e-5 * v[0][0]);
    // A plane's share, summed over layers a spacing apart, is its integral to 0.33 %.
    EXPECT_NEAR(v[1][0], -0.6 * 1.5, 0.005 * 0.6 * 1.5);
    EXPECT_NEAR(v[1][1], -600 * 1.5, 0.005 * 600 * 1.5);
    EXPECT_NEAR(v[2][0], 0.6 * 0.2, 0.033 * 0.6 * 0.2);
    EXPECT_EQ(v[3][0], 0) << "nothing there";
  }
}

// What an emitter puts out comes through an opening across its jet: over a second the mass that it emitted, less what still
// lies before the opening.
TEST(Load, FluxOfAJetIsWhatItsEmitterEmits) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.02;
  d.gravity = {};
  d.sound_speed = 20;
  World w = std::move(*World::create(d));
  EmitterDesc e;
  e.material = *w.add_material({});
  e.axis = {1, 0, 0};
  e.radius = 0.08;
  e.speed = 1;
  e.max_particles = 20000;
  require(w.add_emitter(e));
  ProbeDesc p;
  p.kind = ProbeKind::flux;
  p.points = {{0.2, 0, 0}};
  p.normal = {1, 0, 0};
  p.radius = 0.2;
  p.fields = {"mass_flux"};
  require(w.add_probe(p));
  while (w.time() < 0.6) require(w.step(1e-3));
  require(w.take_samples());
  const double mass = w.totals()->mass;
  while (w.time() < 1) require(w.step(1e-3));
  const double emitted = w.totals()->mass - mass;
  const ProbeSeries s = w.take_samples()->at(0);
  double through = 0;
  for (std::size_t k = 0; k < s.time.size(); ++k) through += s.values[k] * 0.4 / double(s.time.size());
  EXPECT_GT(emitted, 0.9 * 1000 * 0.4 * 3.1416 * 0.0064);
  // A layer of the nozzle is a twentieth of what comes in 0.4 s; a fifth of one for the moment the interval begins.
  EXPECT_NEAR(through, emitted, 0.03 * emitted);
}

TEST(Load, ChangesNoBitOfTheState) {
  MELTSIM_NEEDS_BACKEND();
  for (const Search& s : searches) {
    Tank plain = make_tank(s, 0.5, true), probed = make_tank(s, 0.5, true);
    World& w = probed.world;
    ProbeDesc force = on_body(ProbeKind::force, probed.block, {"force", "contact_moment"});
    force.every = 7e-3;
    require(w.add_probe(force));
    require(w.add_probe(on_wall(ProbeKind::force, 2, {"force", "contact_force"})));
    require(w.add_probe(on_wall(ProbeKind::heat, 2)));
    for (int k = 0; k < 40; ++k) {
      require(plain.world.step(2e-3));
      require(w.step(2e-3));
    }
    EXPECT_EQ(*plain.world.state_hash(), *w.state_hash()) << s.name;
    const auto series = *w.take_samples();
    EXPECT_EQ(series.at(0).time.size(), 12u) << s.name;
    EXPECT_EQ(series.at(0).values.size(), 12u * 6) << s.name;
    EXPECT_EQ(series.at(1).time.size(), 40u) << s.name;
  }
}

// Water alone on a GPU takes forces and motion in one sweep, but in sub-steps in which a force is due.
TEST(Load, ChangesNoBitOfLiquidAlone) {
  MELTSIM_NEEDS_BACKEND();
  BodyId none;
  World plain = still_water(5, false, none), probed = still_water(5, false, none);
  ProbeDesc d = on_wall(ProbeKind::force, 2, {"force"});
  d.every = 5e-3;
  require(probed.add_probe(d));
  for (int k = 0; k < 50; ++k) {
    require(plain.step(2e-3));
    require(probed.step(2e-3));
  }
  EXPECT_EQ(*plain.state_hash(), *probed.state_hash());
  EXPECT_EQ(probed.take_samples()->at(0).time.size(), 20u);
}

TEST(Load, ThePlanSaysWhetherItRuns) {
  MELTSIM_NEEDS_BACKEND();
  BodyId none;
  World w = still_water(3, false, none);
  const auto runs = [&](const std::string& stage) {
    const Plan plan = w.plan();
    for (const StageReport& r : plan.stages)
      if (r.name == stage) return r.runs;
    ADD_FAILURE() << stage << " is not in the plan";
    return false;
  };
  EXPECT_FALSE(runs("sampling.loads"));
  require(w.add_probe(on_wall(ProbeKind::force, 2, {"force"})));
  EXPECT_TRUE(runs("sampling.loads"));
  EXPECT_FALSE(runs("sampling.probes"));
}

TEST(Load, NothingThereIsNoForceAndNoHeat) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.sound_speed = 20;
  d.domain.bounded = true;
  d.domain.max = {1, 1, 1};
  World w = std::move(*World::create(d));
  require(w.add_probe(on_wall(ProbeKind::force, 0, {"force", "moment", "contact_force", "contact_moment"})));
  require(w.add_probe(on_wall(ProbeKind::heat, 0)));
  require(w.step(1e-3));
  for (const auto& values : last_values(w))
    for (const double v : values) EXPECT_EQ(v, 0);
}

TEST(Load, BadDescriptionsAreRefusedByName) {
  MELTSIM_NEEDS_BACKEND();
  Tank t = make_tank(searches[2], 0, true);  // -x and +x are periodic
  World& w = t.world;
  const auto refused = [&](ProbeDesc d, const std::string& part) {
    const auto id = w.add_probe(d);
    ASSERT_FALSE(id) << part;
    EXPECT_EQ(id.error().code, ErrorCode::invalid_argument) << part;
    EXPECT_NE(id.error().message.find(part), std::string::npos) << id.error().message;
  };
  const auto force = [&] { return on_wall(ProbeKind::force, 2, {"force"}); };
  ProbeDesc d = force();
  d.wall = 0;
  refused(d, "wall: face -x is periodic");
  d.wall = 6;
  refused(d, "wall: must be 0 to 5");
  d = force();
  d.body = t.block;
  refused(d, "body: give either a body or a wall, not both");
  d.wall.reset();
  d.body = BodyId{9, 1};
  refused(d, "body: no body of this World has index 9");
  d.body = {};
  refused(d, "body: give either a body or a wall, got neither");
  d = force();
  d.fields = {"force", "pressure"};
  refused(d, "fields: unknown \"pressure\"");
  d.fields = {"force", "force"};
  refused(d, "fields: \"force\" is listed twice");
  d.fields = {};
  refused(d, "fields: none is given");
  d = force();
  d.points = {{1, 1, 1}, {1, 1, 2}};
  refused(d, "points: kind force has one");
  d.points = {{1, infinity, 1}};
  refused(d, "points: must be finite");
  d = force();
  d.radius = 0.1;
  refused(d, "radius: kind force has none");
  d = on_wall(ProbeKind::heat, 2);
  d.points = {{1, 1, 1}};
  refused(d, "points: kind heat has none");
  d = on_wall(ProbeKind::heat, 2, {"force"});
  refused(d, "fields: of heat there is one value");
  const auto flux = [] {
    ProbeDesc f;
    f.kind = ProbeKind::flux;
    f.points = {{1, 1, 1}};
    f.normal = {1, 0, 0};
    f.radius = 0.2;
    f.fields = {"mass_flux"};
    return f;
  };
  d = flux();
  d.wall = 2;
  refused(d, "wall: a flux has none");
  d = flux();
  d.points = {{1, 1, 9}};
  refused(d, "points: (1, 1, 9) is outside the domain");
  d.points.clear();
  refused(d, "points: a flux has one");
  d = flux();
  d.normal = {};
  refused(d, "normal: must be finite and not 0");
  d.normal = {infinity, 0, 0};
  refused(d, "normal: must be finite and not 0");
  d = flux();
  d.radius = -1;
  refused(d, "radius: must be finite and >= 0");
  d.radius = 0;
  refused(d, "size: must be finite and > 0");
  d.size[0] = d.size[1] = 1;
  refused(d, "along: must be finite and not along the normal");
  d.along = {-3, 0, 0};
  refused(d, "along: must be finite and not along the normal");
  d.along = {0, 1, 0};
  d.radius = 1;
  refused(d, "size: a disc");
  d.radius = 0;
  d.fields = {"force"};
  refused(d, "fields: unknown \"force\"; of kind flux there are mass_flux, volume_flux");
  ProbeDesc point;
  point.points = {{1, 1, 1}};
  point.fields = {"pressure"};
  point.wall = 2;
  refused(point, "wall: only kinds force and heat");
  point.wall.reset();
  point.fields = {"force"};
  refused(point, "fields: unknown \"force\"");
  WorldDesc open = describe();
  open.spacing = 0.1;
  World unbounded = std::move(*World::create(open));
  EXPECT_FALSE(unbounded.add_probe(force()));
  // Nothing was added.
  require(w.step(1e-3));
  EXPECT_TRUE(w.take_samples()->empty());
}

}  // namespace
}  // namespace meltsim_test
