// SPDX-License-Identifier: Apache-2.0
// Liquid in domains that are no whole number of spacings.
#include <cmath>
#include <string>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double dx = 0.1, g = 9.81, water = 1000, depth = 0.8;

/// A domain without heat, 1.6 m high.
WorldDesc box(double length, double width) {
  WorldDesc d = describe();
  d.spacing = dx;
  d.heat.model = HeatModel::none;
  d.domain.bounded = true;
  d.domain.no_slip = false;
  d.domain.min = {0, 0, 0};
  d.domain.max = {length, 1.6, width};
  d.gravity = {0, -g, 0};
  return d;
}

World with(const WorldDesc& d, const Shape& shape) {
  World w = std::move(*World::create(d));
  FluidDesc f;
  MaterialDesc m;
  m.density = water;
  f.material = *w.add_material(m);
  f.shape = shape;
  require(w.add_fluid(f));
  return w;
}

/// What is left over of a length of 12 spacings [spacings]: little, about a half, where a site lies on a wall, much.
constexpr double rests[] = {0.03, 0.25, 0.48, 0.5, 0.502, 0.509, 0.52, 0.75, 0.97};

// Without that the rest is a gap at one wall, into which liquid falls: it is lost to the depth, and leaves at the height of
// the tank and more. 1e-6: numbers in single precision. What has fallen by a fifth of a spacing is as fast as lattices that differ by up to
// 4 % from a cubic one may make liquid; before, it was 1 to 4 m/s.
TEST(Filling, LiquidFromWallToWallIsAtRest) {
  MELTSIM_NEEDS_BACKEND();
  for (const double rest : rests) {
    SCOPED_TRACE(rest);
    const double length = (12 + rest) * dx, width = 0.8;
    World w = with(box(length, width), Shape::box({0, 0, 0}, {length, depth, width}));
    const double mass = water * length * depth * width;
    EXPECT_NEAR(w.totals()->mass, mass, 1e-6 * mass);
    require(w.step(0.02));
    EXPECT_LT(w.synchronize().max_speed, std::sqrt(2 * g * dx / 5));
    // Of a layer's pressure half, as what is read lies between layers.
    EXPECT_NEAR(w.sample({{length / 2, depth / 2, width / 2}}, {"pressure"})->at(0), water * g * depth / 2,
                water * g * dx / 2);
  }
}

// Both axes, and across periodic faces.
TEST(Filling, OfEveryAxisAndOfPeriods) {
  MELTSIM_NEEDS_BACKEND();
  for (const Face face : {Face::wall, Face::periodic}) {
    WorldDesc d = box(1.23, 0.87);
    d.domain.faces = {face, face, Face::wall, Face::wall, face, face};
    World w = with(d, Shape::box({0, 0, 0}, {1.23, depth, 0.87}));
    const double mass = water * 1.23 * depth * 0.87;
    EXPECT_NEAR(w.totals()->mass, mass, 1e-6 * mass);
    require(w.step(0.02));
    EXPECT_LT(w.synchronize().max_speed, std::sqrt(2 * g * dx / 5));
  }
}

// A layer of another liquid comes to lie on the same columns, before the first step and while the World runs.
TEST(Filling, LayersLieOnEachOther) {
  MELTSIM_NEEDS_BACKEND();
  for (const bool running : {false, true}) {
    WorldDesc d = box(1.24, 0.8);
    d.reserved_particles = 4000;
    World w = with(d, Shape::box({0, 0, 0}, {1.24, 0.4, 0.8}));
    if (running) require(w.step(1e-4));
    FluidDesc oil;
    MaterialDesc m;
    m.name = "oil";
    m.density = 800;
    oil.material = *w.add_material(m);
    oil.shape = Shape::box({0, 0.4, 0}, {1.24, 0.8, 0.8});
    require(w.add_fluid(oil));
    const double mass = (water + 800) * 1.24 * 0.4 * 0.8;
    EXPECT_NEAR(w.totals()->mass, mass, 1e-6 * mass);
    if (running) continue;  // what is put onto liquid falls onto it
    require(w.step(0.02));
    EXPECT_LT(w.synchronize().max_speed, std::sqrt(2 * g * dx / 5));
  }
}

// Liquid that ends ahead of a wall, and bodies, are as they are said to be: cubes of a spacing.
TEST(Filling, OnlyOfWhatReachesBothWalls) {
  MELTSIM_NEEDS_BACKEND();
  World w = with(box(1.25, 0.8), Shape::box({0, 0, 0}, {1.2, depth, 0.8}));
  EXPECT_NEAR(w.totals()->mass, water * 1.2 * depth * 0.8, 1e-3);
  World other = std::move(*World::create(box(1.25, 0.8)));
  MaterialDesc m;
  m.density = water;
  SolidDesc s;
  s.material = *other.add_material(m);
  s.shape = Shape::box({0, 0, 0}, {1.25, depth, 0.8});
  require(other.add_solid(s));
  EXPECT_NEAR(other.totals()->mass, water * 1.2 * depth * 0.8, 1e-3);
}

/// A wall of `material` across a tank, from wall to wall, and water on one side of it.
World with_wall(double width, const MaterialDesc& material) {
  World w = std::move(*World::create(box(2.4, width)));
  SolidDesc s;
  s.material = *w.add_material(material);
  s.fixed = true;
  s.shape = Shape::box({1.2, 0, 0}, {1.4, 1.6, width});
  require(w.add_solid(s));
  MaterialDesc m;
  m.name = "more";
  FluidDesc f;
  f.material = *w.add_material(m);
  f.shape = Shape::box({0, 0, 0}, {1.2, depth, width});
  require(w.add_fluid(f));
  return w;
}

// A fixed body from wall to wall fills what is between, as liquid does: a rest below half a spacing would be a gap that liquid leaks through, one above it a
// layer nearer to the wall than half a spacing, in one place with its image, which threw liquid off at up to 15 m/s. Bounds as of liquid above.
TEST(Filling, FixedBodiesCloseChannels) {
  MELTSIM_NEEDS_BACKEND();
  for (const double rest : {0.25, 0.4, 0.502, 0.6, 0.75, 0.97}) {
    SCOPED_TRACE(rest);
    const double width = (8 + rest) * dx, mass = water * width * (0.2 * 1.6 + 1.2 * depth);
    World w = with_wall(width, {});
    EXPECT_NEAR(w.totals()->mass, mass, 1e-6 * mass);
    require(w.step(0.02));
    EXPECT_LT(w.synchronize().max_speed, std::sqrt(2 * g * dx / 5));
    for (int i = 0; i < 25; ++i) require(w.step(0.02));
    const ParticleData p = *w.particles();
    for (const Vec3d& x : p.position) EXPECT_LT(x.x, 1.4);  // of water: none has come through
  }
}

// What liquid freezes onto keeps the sites of its lattice, and is cut at walls: its layer is up to half a spacing from where the lattice of the liquid beside it is,
// so the bound is what has fallen by so much.
TEST(Filling, WhatFreezesIsCutAtWalls) {
  MELTSIM_NEEDS_BACKEND();
  for (const double rest : {0.502, 0.6, 0.75, 0.97}) {
    SCOPED_TRACE(rest);
    const double width = (8 + rest) * dx;
    World plain = std::move(*World::create(box(2.4, width)));
    MaterialDesc melt, ice;
    melt.name = "melt";
    const auto melted = plain.add_material(melt);
    ASSERT_TRUE(melted);
    ice.melts_into = *melted;
    ice.name = "ice";
    ice.melting_point = 0;
    ice.latent_heat = 3e5;
    ice.freezes = true;
    const auto frozen = plain.add_material(ice);
    ASSERT_TRUE(frozen) << frozen.error().message;
    SolidDesc s;
    s.material = *frozen;
    s.temperature = -1;
    s.fixed = true;
    s.shape = Shape::box({1.2, 0, 0}, {1.4, 1.6, width});
    require(plain.add_solid(s));
    const double mass = water * 0.2 * 1.6 * width;
    EXPECT_NEAR(plain.totals()->mass, mass, 1e-6 * mass);
    FluidDesc f;
    f.material = ice.melts_into;
    f.temperature = 1;
    f.shape = Shape::box({0, 0, 0}, {1.2, depth, width});
    require(plain.add_fluid(f));
    require(plain.step(0.02));
    EXPECT_LT(plain.synchronize().max_speed, std::sqrt(2 * g * dx / 2));
  }
}

// A shape that reaches beyond the domain is refused, whatever the cells are.
TEST(Filling, WhatReachesBeyondTheDomainIsRefused) {
  MELTSIM_NEEDS_BACKEND();
  for (const double rest : rests) {
    const double length = (12 + rest) * dx;
    World w = std::move(*World::create(box(length, 0.8)));
    FluidDesc f;
    f.material = *w.add_material({});
    f.shape = Shape::box({0, 0, 0}, {length + 2 * dx, depth, 0.8});
    const auto added = w.add_fluid(f);
    ASSERT_FALSE(added) << rest;
    EXPECT_NE(added.error().message.find("reaches outside the domain"), std::string::npos) << rest;
  }
}

// The narrowest that there are, of two supports: cells of 5.45 spacings are a tenth longer. With a short support cells would come to differ
// by more than an eighth, and stay as they are.
TEST(Filling, NarrowDomains) {
  MELTSIM_NEEDS_BACKEND();
  const auto width_of = [](double spacings, double support) {
    WorldDesc d = box(0.8, spacings * dx);
    d.support_radius = support * dx;
    World w = with(d, Shape::box({0, 0, 0}, {0.8, depth, spacings * dx}));
    return w.totals()->mass / (water * 0.8 * depth * dx);
  };
  for (const double spacings : {5.0, 5.2, 5.45, 5.6, 6.3})
    EXPECT_NEAR(width_of(spacings, 2.5), spacings, 1e-5);
  EXPECT_NEAR(width_of(3.1, 1.5), 3.1, 1e-5);
  EXPECT_NEAR(width_of(3.45, 1.5), 3, 1e-5);
}

}  // namespace
}  // namespace meltsim_test
