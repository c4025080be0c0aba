// SPDX-License-Identifier: Apache-2.0
// What a scene begins with, where it is so large that the host's threads share it: the same for any number of them, and as it is
// where they do not.
#include <cmath>
#include <set>
#include <string>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

/// Water beside and below two bodies of an odd shape, one of which displaces some; a nozzle.
Result<std::uint64_t> start(int threads, double spacing) {
  WorldDesc d = describe();
  d.threads = threads;
  d.spacing = spacing;
  d.domain.bounded = true;
  d.domain.max = {4, 3, 3};
  d.heat.model = HeatModel::enthalpy;
  auto world = World::create(d);
  if (!world) return world.error();
  MaterialDesc m;
  m.name = "water";
  m.density = 1000;
  m.conductivity = 0.6;
  m.heat_capacity = 4186;
  const auto water = world->add_material(m);
  m.name = "ice";
  m.density = 900;
  m.melting_point = 0;
  m.latent_heat = 3.3e5;
  m.melts_into = *water;
  const auto ice = world->add_material(m);
  if (!ice) return ice.error();
  FluidDesc f;
  f.shape = Shape::box({0, 0, 0}, {4, 1, 3});
  f.material = *water;
  f.temperature = 20;
  if (const auto added = world->add_fluid(f); !added) return added.error();
  const Shape odd = Shape::blend({{{0, 0, 0}, {0.6, 0.4, 0.5}}, {{0.5, 0.4, 0}, {0.3, 0.3, 0.3}}}, 0.2);
  for (const double x : {1.0, 3.0}) {
    SolidDesc s;
    s.shape = odd.transformed({x, 0.6 + 0.4 * x, 1.5}, {0, 1, 0}, 20 * x);
    s.material = *ice;
    s.temperature = -5;
    if (const auto added = world->add_solid(s); !added) return added.error();
  }
  EmitterDesc e;
  e.center = {2, 2.5, 1.5};
  e.axis = {0, -1, 0};
  e.radius = 0.2;
  e.speed = 2;
  e.material = *water;
  e.until = 1;
  if (const auto added = world->add_emitter(e); !added) return added.error();
  if (const Status s = world->prepare(); !s) return s.error();
  return world->state_hash();
}

TEST(Start, StateDoesNotDependOnTheNumberOfThreads) {
  MELTSIM_NEEDS_BACKEND();
  std::set<std::uint64_t> hashes;
  for (const int threads : {1, 2, 7}) {
    const auto hash = start(threads, 0.04);  // 190,000 particles
    ASSERT_TRUE(hash) << hash.error().message;
    hashes.insert(*hash);
  }
  EXPECT_EQ(hashes.size(), 1u);
}

TEST(Start, BodiesInEachOthersPlaceAreNamedLargeAndSmall) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.threads = 2;
  d.spacing = 0.05;
  auto world = World::create(d);
  require(world);
  MaterialDesc m;
  m.name = "stone";
  const auto stone = world->add_material(m);
  require(stone);
  SolidDesc s;
  s.material = *stone;
  s.name = "first";
  s.shape = Shape::box({0, 0, 0}, {1, 1, 1});
  require(world->add_solid(s));
  for (const double size : {1.0, 0.2}) {  // most of all particles, and few of them
    s.name = "second";
    s.shape = Shape::box({0.5, 0.5, 0.5}, {0.5 + size, 0.5 + size, 0.5 + size});
    const auto refused = world->add_solid(s);
    ASSERT_FALSE(refused) << size;
    EXPECT_NE(refused.error().message.find("overlaps body \"first\" at (0.525, 0.525, 0.525)"),
              std::string::npos)
        << refused.error().message;
  }
}

/// Heights of the lowest and topmost particles of liquid at x < 1.
std::set<double> heights(World& world) {
  std::set<double> at;
  const auto particles = world.particles();
  EXPECT_TRUE(particles);
  for (const Vec3d& p : particles->position)
    if (p.x < 1) at.insert(p.y);
  return at;
}

TEST(Start, ColumnsFarApartArePressedAsAlone) {
  MELTSIM_NEEDS_BACKEND();
  const auto fill = [](bool both) {
    WorldDesc d = describe();
    d.precision = Precision::double_precision;
    d.spacing = 0.1;
    d.domain.bounded = true;
    d.domain.max = {2000, 3, 0.6};
    d.sound_speed = 60;
    auto world = World::create(d);
    EXPECT_TRUE(world) << world.error().message;
    MaterialDesc m;
    m.name = "water";
    const auto water = world->add_material(m);
    FluidDesc f;
    f.material = *water;
    f.shape = Shape::box({0, 0, 0}, {0.6, 2, 0.6});
    require(world->add_fluid(f));
    f.shape = Shape::box({1999.4, 0, 0}, {2000, 2, 0.6});  // many more columns between them than there are
    if (both) require(world->add_fluid(f));
    require(world->prepare());
    return heights(*world);
  };
  const std::set<double> alone = fill(false);
  EXPECT_EQ(alone.size(), 20u);
  EXPECT_LT(*alone.begin(), 0.0499);  // pressed
  EXPECT_EQ(fill(true), alone);
}

}  // namespace
}  // namespace meltsim_test
