// SPDX-License-Identifier: Apache-2.0
// Rays against exact answers (planes, a sphere, a lattice box, walls), shapes against counts, colours of the render pack.
#include <algorithm>
#include <cmath>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

class Query : public testing::Test {
 protected:
  void SetUp() override { MELTSIM_NEEDS_BACKEND(); }
};

constexpr double dx = 0.05;

World made(const WorldDesc& d) {
  auto w = World::create(d);
  if (!w) ADD_FAILURE() << w.error().message;
  return w ? std::move(*w) : *World::create();
}

WorldDesc box_of(Vec3d size) {
  WorldDesc d = describe();
  d.spacing = dx;
  d.domain.bounded = true;
  d.domain.max = size;
  d.heat.model = HeatModel::none;
  return d;
}

BodyId body(World& w, const Shape& shape, Motion motion = Motion::free) {
  MaterialDesc m;
  m.name = "stone" + std::to_string(w.resolved().stiffness.size());
  m.density = 2000;
  SolidDesc s;
  s.material = *w.add_material(m);
  s.shape = shape;
  s.motion = motion;
  s.fixed = motion == Motion::free;
  const auto id = w.add_solid(s);
  EXPECT_TRUE(id) << id.error().message;
  return id ? *id : BodyId{};
}

RayHit one(World& w, Ray ray, std::uint32_t sought = ray_all) {
  const auto hits = w.cast_rays({ray}, sought);
  EXPECT_TRUE(hits) << hits.error().message;
  return hits ? hits->at(0) : RayHit{};
}

void expect_near(Vec3d a, Vec3d b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

/// A box of the lattice: its faces lie half a spacing outside the outermost particles, where the level of a flat face is. A
/// twentieth of a spacing is what the sum over a lattice differs from an integral by.
TEST_F(Query, ABoxIsHitAtItsFaces) {
  World w = made(box_of({2, 2, 2}));
  const BodyId id = body(w, Shape::box({0.8, 0.8, 0.8}, {1.2, 1.2, 1.2}));
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
      for (const double off : {0.0, 0.013, 0.08}) {  // over a particle, between particles, off the middle
        double from[3] = {1 + off, 1 + off, 1 + off}, along[3] = {0, 0, 0};
        from[axis] = 1 + 0.9 * side;
        along[axis] = -3 * side;  // of any length
        const RayHit h = one(w, {{from[0], from[1], from[2]}, {along[0], along[1], along[2]}, infinity});
        ASSERT_EQ(h.what, RayTarget::body);
        EXPECT_EQ(h.body.index, id.index);
        EXPECT_NEAR(h.distance, 0.7, 0.05 * dx);
        double normal[3] = {0, 0, 0};
        normal[axis] = side;
        expect_near(h.normal, {normal[0], normal[1], normal[2]}, 0.05);
        from[axis] -= side * h.distance;
        expect_near(h.point, {from[0], from[1], from[2]}, 1e-6);
      }
}

/// A sphere of eight spacings, whose sampled surface is rough: half a spacing. 200 rays to places on it, from all sides; the mean is
/// nearer.
TEST_F(Query, ASphereIsHitToHalfASpacing) {
  World w = made(box_of({2, 2, 2}));
  const Vec3d center{1.01, 0.98, 1.02};
  const double radius = 8 * dx;
  const BodyId id = body(w, Shape::sphere(center, radius));
  std::vector<Ray> rays;
  std::vector<double> exact;
  for (int k = 0; k < 200; ++k) {
    // Points spread evenly over the sphere (a spiral of the golden angle), aimed past the centre by up to half the radius.
    const double y = 1 - 2 * (k + 0.5) / 200, r = std::sqrt(1 - y * y), angle = 2.39996323 * k;
    const Vec3d out{r * std::cos(angle), y, r * std::sin(angle)};
    const Vec3d side = cross(out, Vec3d{0.3, 0.5, 0.8});
    const Vec3d from = center + out * 0.6, aim = center + side * (0.5 * radius * (k % 5) / 4 / length(side));
    const Vec3d u = (aim - from) * (1 / length(aim - from));
    const double along = dot(center - from, u), off2 = dot(center - from, center - from) - along * along;
    exact.push_back(along - std::sqrt(radius * radius - off2));
    rays.push_back({from, u, infinity});
  }
  const auto hits = w.cast_rays(rays);
  require(hits);
  double sum = 0, cosines = 0;
  for (std::size_t k = 0; k < rays.size(); ++k) {
    const RayHit& h = (*hits)[k];
    ASSERT_EQ(h.what, RayTarget::body) << k;
    EXPECT_EQ(h.body.index, id.index);
    EXPECT_NEAR(h.distance, exact[k], 0.5 * dx) << k;
    sum += h.distance - exact[k];
    const Vec3d radial = (h.point - center) * (1 / length(h.point - center));
    cosines += dot(h.normal, radial);
    EXPECT_GT(dot(h.normal, radial), 0.8) << k;  // terraces of the lattice: up to 37 degrees
    EXPECT_NEAR(length(h.normal), 1, 1e-6);
  }
  EXPECT_NEAR(sum / 200, 0, 0.15 * dx);
  EXPECT_GT(cosines / 200, 0.97);  // 14 degrees
}

/// Parts too thin for the level: a row of particles is hit where it is, within half a spacing.
TEST_F(Query, AThinRodIsHit) {
  World w = made(box_of({2, 2, 2}));
  const BodyId id = body(w, Shape::box({0.5, 1, 1}, {1.5, 1 + dx, 1 + dx}));
  for (const double x : {0.625, 1.0, 1.3}) {
    const RayHit h = one(w, {{x, 1.7, 1 + 0.5 * dx}, {0, -1, 0}, infinity});
    ASSERT_EQ(h.what, RayTarget::body);
    EXPECT_EQ(h.body.index, id.index);
    EXPECT_NEAR(h.point.y, 1 + dx, 0.5 * dx);
  }
}

/// Still water 0.6 m deep, as it was filled in: the level is the fill's. With bodies alone sought the ray goes through it to the
/// body, with walls alone to the floor.
TEST_F(Query, WaterIsHitAtItsLevelAndSeenThrough) {
  World w = made(box_of({1, 1, 1}));
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0, 0, 0}, {1, 0.6, 1});
  require(w.add_fluid(f));
  const BodyId id = body(w, Shape::box({0.4, 0.1, 0.4}, {0.6, 0.3, 0.6}));
  const Ray down{{0.52, 0.95, 0.47}, {0, -1, 0}, infinity};
  const RayHit surface = one(w, down);
  ASSERT_EQ(surface.what, RayTarget::liquid);
  EXPECT_NEAR(surface.point.y, 0.6, 0.1 * dx);
  expect_near(surface.normal, {0, 1, 0}, 0.05);
  EXPECT_FALSE(surface.body);
  EXPECT_LT(surface.particle, w.synchronize().fluid + w.synchronize().solid);
  const RayHit under = one(w, down, ray_bodies | ray_walls);
  ASSERT_EQ(under.what, RayTarget::body);
  EXPECT_EQ(under.body.index, id.index);
  EXPECT_NEAR(under.point.y, 0.3, 0.1 * dx);
  const RayHit floor = one(w, down, ray_walls);
  ASSERT_EQ(floor.what, RayTarget::wall);
  EXPECT_EQ(floor.wall, 2);
  EXPECT_NEAR(floor.distance, 0.95, 1e-9);
  expect_near(floor.normal, {0, 1, 0}, 0);
  // One that begins in the liquid is in it; one that is too short meets nothing.
  EXPECT_EQ(one(w, {{0.2, 0.3, 0.2}, {1, 0, 0}, infinity}).distance, 0);
  EXPECT_EQ(one(w, {{0.52, 0.95, 0.47}, {0, -1, 0}, 0.3}).what, RayTarget::nothing);
  EXPECT_EQ(one(w, {{0.52, 0.95, 0.47}, {0, -1, 0}, 0.36}).what, RayTarget::liquid);
  // Near a wall images complete the liquid.
  EXPECT_NEAR(one(w, {{0.01, 0.95, 0.5}, {0, -1, 0}, infinity}).point.y, 0.6, 0.1 * dx);
}

/// Walls from inside, in every direction; from outside, through open faces and in an unbounded World there are none.
TEST_F(Query, WallsAreHitFromInside) {
  WorldDesc d = box_of({2, 1, 1});
  d.domain.faces[1] = Face::open;
  World w = made(d);
  const Vec3d from{0.5, 0.25, 0.4};
  const Vec3d along[6] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
  const double distance[6] = {0.5, 0, 0.25, 0.75, 0.4, 0.6};
  for (int face = 0; face < 6; ++face) {
    const RayHit h = one(w, {from, along[face], infinity});
    if (face == 1) {
      EXPECT_EQ(h.what, RayTarget::nothing);
      EXPECT_EQ(h.distance, infinity);
      continue;
    }
    ASSERT_EQ(h.what, RayTarget::wall);
    EXPECT_EQ(h.wall, face);
    EXPECT_NEAR(h.distance, distance[face], 1e-12);
    expect_near(h.normal, along[face] * -1.0, 0);
  }
  EXPECT_EQ(one(w, {{-1, 0.5, 0.5}, {1, 0, 0}, infinity}).what, RayTarget::nothing);
  const RayHit slanted = one(w, {{0.5, 0.5, 0.5}, {-3, -4, 0}, infinity});
  EXPECT_EQ(slanted.wall, 2);
  EXPECT_NEAR(slanted.distance, 0.625, 1e-9);
}

/// Far from everything, in an unbounded World: cells without particles are passed at once.
TEST_F(Query, ADistantBodyIsFound) {
  WorldDesc d = describe();
  d.spacing = dx;
  d.heat.model = HeatModel::none;
  World w = made(d);
  const BodyId one_body = body(w, Shape::box({0, 0, 0}, {0.2, 0.2, 0.2}));
  const BodyId other = body(w, Shape::box({60, 0, 0}, {60.2, 0.2, 0.2}));
  const RayHit h = one(w, {{30, 0.1, 0.1}, {1, 0, 0}, infinity});
  ASSERT_EQ(h.what, RayTarget::body);
  EXPECT_EQ(h.body.index, other.index);
  EXPECT_NEAR(h.distance, 30, 0.1 * dx);
  EXPECT_EQ(one(w, {{30, 0.1, 0.1}, {-1, 0, 0}, infinity}).body.index, one_body.index);
  EXPECT_EQ(one(w, {{30, 0.1, 0.1}, {0, 1, 0}, infinity}).what, RayTarget::nothing);
  EXPECT_EQ(one(w, {{30, 5, 0.1}, {1, 0, 0}, infinity}).what, RayTarget::nothing);
}

/// Rays sort particles by themselves: whichever search the steps use, also across a periodic face, before and after a step.
TEST_F(Query, EverySearchAndPrecisionFindsTheSame) {
  for (const NeighbourSearch search : {NeighbourSearch::grid, NeighbourSearch::tree})
    for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
      WorldDesc d = box_of({1, 1, 1});
      d.neighbour_search = search;
      d.precision = precision;
      d.domain.faces[0] = d.domain.faces[1] = Face::periodic;
      World w = made(d);
      FluidDesc f;
      f.material = *w.add_material({});
      f.shape = Shape::box({0, 0, 0}, {1, 0.6, 1});
      require(w.add_fluid(f));
      for (int k = 0; k < 2; ++k) {
        for (const double x : {0.005, 0.5, 0.995}) {  // beside the periodic faces, too
          const RayHit h = one(w, {{x, 0.9, 0.5}, {0, -1, 0}, infinity});
          ASSERT_EQ(h.what, RayTarget::liquid);
          EXPECT_NEAR(h.point.y, 0.6, 0.1 * dx);
        }
        EXPECT_EQ(one(w, {{0.5, 0.9, 0.5}, {1, 0, 0}, infinity}).what, RayTarget::nothing);  // no wall there
        require(w.step(1e-4));
      }
    }
}

TEST_F(Query, RaysFollowWhatMoves) {
  WorldDesc d = box_of({2, 2, 2});
  d.gravity = {};
  World w = made(d);
  const BodyId id = body(w, Shape::box({0.8, 0.8, 0.8}, {1.2, 1.2, 1.2}), Motion::kinematic);
  BodyMotion m;
  m.velocity = {0, 0.5, 0};
  require(w.set_motion(id, m));
  require(w.step(0.1));
  const RayHit h = one(w, {{1, 0.2, 1}, {0, 1, 0}, infinity});
  EXPECT_EQ(h.body.index, id.index);
  EXPECT_NEAR(h.point.y, 0.85, 0.1 * dx);
  const std::uint64_t hash = *w.state_hash();
  (void)one(w, {{1, 0.2, 1}, {0, 1, 0}, infinity});
  EXPECT_EQ(*w.state_hash(), hash);
}

/// What has its centre in a shape, counted here from particles().
void expect_overlap(World& w, const Shape& shape, std::size_t bodies, const char* when) {
  SCOPED_TRACE(when);
  // First, so that the World has not copied its particles for particles().
  const auto o = w.overlap(shape);
  require(o);
  const auto all = *w.particles();
  std::uint64_t liquid = 0;
  std::vector<std::uint64_t> solid(bodies, 0), found(bodies, 0);
  for (std::size_t i = 0; i < all.id.size(); ++i) {
    if (is_removed(all.tag[i]) || !shape.contains(all.position[i])) continue;
    if (is_solid(all.tag[i])) ++solid[body_of(all.tag[i]) - 1u];
    else ++liquid;
  }
  EXPECT_EQ(o->liquid, liquid);
  EXPECT_NEAR(o->liquid_volume, static_cast<double>(liquid) * dx * dx * dx, 1e-6);  // single precision
  for (const BodyOverlap& b : o->bodies) found[b.body.index] = b.particles;
  EXPECT_EQ(found, solid);
  EXPECT_EQ(o->bodies.size(),
            bodies - static_cast<std::size_t>(std::count(solid.begin(), solid.end(), std::uint64_t{0})));
}

/// Before the first step the host has the state; later the backend lists what is in the shape's box, which it finds by cells, also
/// what was added since the cells were filled and what went across a periodic face.
TEST_F(Query, OverlapCountsWhatIsInAShape) {
  WorldDesc d = box_of({1, 1, 1});
  d.domain.faces[0] = d.domain.faces[1] = Face::periodic;
  d.reserved_particles = 4000;
  World w = made(d);
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0, 0, 0}, {1, 0.6, 1});
  f.velocity = {0.5, 0, 0};
  require(w.add_fluid(f));
  const BodyId id = body(w, Shape::box({0.4, 0.1, 0.4}, {0.6, 0.3, 0.6}));
  body(w, Shape::box({0.8, 0.8, 0.8}, {0.9, 0.9, 0.9}));
  const auto look = [&w](std::size_t bodies, const char* when) {
    for (const Shape& shape :
         {Shape::sphere({0.55, 0.3, 0.55}, 0.2), Shape::box({0, 0, 0}, {1, 1, 1}),
          Shape::sphere({0.2, 0.9, 0.2}, 0.05), Shape::box({-1, 0.1, 0.2}, {0.2, 2, 0.5}),
          Shape::sphere({0.2, 0.9, 0.2}, 0.001)})
      expect_overlap(w, shape, bodies, when);
  };
  look(2, "before a step");
  require(w.step(0.07));
  look(2, "after steps");
  f.shape = Shape::box({0.1, 0.8, 0.1}, {0.3, 0.95, 0.3});
  require(w.add_fluid(f));
  body(w, Shape::box({0.4, 0.8, 0.4}, {0.6, 0.9, 0.6}));
  look(3, "after additions");
  require(w.remove(id));
  require(w.remove_liquid(Shape::sphere({0.6, 0.4, 0.5}, 0.15)));
  look(3, "after removals");
  require(w.step(0.02));
  look(3, "after a step with all of it");
}

template <class R>
std::string refusal(const R& r) {
  EXPECT_FALSE(r);
  return r ? "" : r.error().message;
}

TEST_F(Query, WhatIsNoRayIsRefused) {
  World w = made(box_of({1, 1, 1}));
  const Ray good;
  EXPECT_NE(refusal(w.cast_rays({})).find("rays"), std::string::npos);
  EXPECT_NE(refusal(w.cast_rays({good, {{0, 0, 0}, {0, 0, 0}, 1}})).find("rays[1]: direction"),
            std::string::npos);
  EXPECT_NE(refusal(w.cast_rays({{{0, NAN, 0}, {0, 0, 1}, 1}})).find("origin"), std::string::npos);
  EXPECT_NE(refusal(w.cast_rays({{{0, 0, 0}, {0, infinity, 1}, 1}})).find("direction"), std::string::npos);
  EXPECT_NE(refusal(w.cast_rays({{{0, 0, 0}, {0, 0, 1}, -1}})).find("length"), std::string::npos);
  EXPECT_NE(refusal(w.cast_rays({{{0, 0, 0}, {0, 0, 1}, NAN}})).find("length"), std::string::npos);
  EXPECT_NE(refusal(w.cast_rays({good}, 0)).find("sought: "), std::string::npos);
  EXPECT_NE(refusal(w.cast_rays({good}, 8)).find("sought: "), std::string::npos);
  EXPECT_NE(refusal(w.cast_rays(std::vector<Ray>((1u << 20) + 1))).find("at most"), std::string::npos);
  EXPECT_NE(refusal(w.overlap(Shape::sphere({0, 0, 0}, NAN))).find("shape"), std::string::npos);
  // Directions whose squares leave the range of a double.
  EXPECT_EQ(one(w, {{0.5, 0.5, 0.5}, {0, 1e-300, 0}, infinity}).wall, 3);
  EXPECT_EQ(one(w, {{0.5, 0.5, 0.5}, {0, 1e300, 0}, infinity}).wall, 3);
}

// --- colours ----------------------------------------------------------------------------------------------

/// The device's memory is the host's on the CPU; elsewhere the values are not read.
std::vector<std::uint32_t> colors(World& w, const RenderDesc& d) {
  const auto view = w.render_view(d);
  EXPECT_TRUE(view) << view.error().message;
  if (!view || view->backend != Backend::cpu || view->color == nullptr) return {};
  return {view->color, view->color + view->count};
}

TEST_F(Query, ColoursAreThoseOfTheTable) {
  if (backend() == Backend::cuda) GTEST_SKIP() << "device memory";
  IceScene scene;
  scene.block_floor = 0.6;
  Scene s = ice_in_water(describe(), scene);
  require(s.world.step(2e-3));
  EXPECT_TRUE(colors(s.world, {}).empty());
  RenderDesc by_material;
  by_material.color = ColorBy::material;
  by_material.colors = {0xff0000ffu, 0xff00ff00u};  // water, ice
  RenderDesc by_temperature;
  by_temperature.color = ColorBy::temperature;
  by_temperature.coldest = -10;
  by_temperature.hottest = 80;
  for (std::uint32_t k = 0; k < 256; ++k) by_temperature.colors.push_back(k);
  const auto all = *s.world.particles();
  const auto m = colors(s.world, by_material);
  ASSERT_EQ(m.size(), all.id.size());
  for (std::size_t i = 0; i < m.size(); ++i) EXPECT_EQ(m[i], by_material.colors[material_of(all.tag[i])]);
  const auto t = colors(s.world, by_temperature);
  ASSERT_EQ(t.size(), all.id.size());
  for (std::size_t i = 0; i < t.size(); ++i)
    EXPECT_NEAR(t[i], std::min(255.0, (all.temperature[i] + 10) * 256 / 90), 1) << all.temperature[i];
  EXPECT_EQ(m, colors(s.world, by_material));  // the table before comes back
  by_temperature.colors.clear();               // the ramp: cold is blue, hot is red
  const auto ramp = colors(s.world, by_temperature);
  const auto red = [](std::uint32_t c) { return c & 0xffu; };
  const auto blue = [](std::uint32_t c) { return c >> 16u & 0xffu; };
  for (std::size_t i = 0; i < ramp.size(); ++i) {
    EXPECT_EQ(ramp[i] >> 24u, 0xffu);
    if (all.temperature[i] < -5) {
      EXPECT_GT(blue(ramp[i]), red(ramp[i]));
    }
    if (all.temperature[i] > 75) {
      EXPECT_LT(blue(ramp[i]), red(ramp[i]));
    }
  }
  by_temperature.hottest = -10;
  EXPECT_NE(refusal(s.world.render_view(by_temperature)).find("hottest"), std::string::npos);
  by_material.colors.resize(257);
  EXPECT_NE(refusal(s.world.render_view(by_material)).find("colors"), std::string::npos);
}

}  // namespace
}  // namespace meltsim_test
