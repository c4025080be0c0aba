// SPDX-License-Identifier: Apache-2.0
// Bodies that touch bodies: at the start, and in a heap.
#include <algorithm>
#include <cmath>
#include <vector>

#include "scenes.hpp"
#include "support/random.hpp"

namespace meltsim_test {
namespace {

using test_support::Random;

constexpr double spacing = 0.1, sound_speed = 20;

/// A box of whole spacings, from its lowest corner [spacings].
struct Place {
  Vec3d low, size;
};

/// Gap between two boxes along the axis on which they are furthest apart [spacings]; negative where they overlap.
double gap(const Place& a, const Place& b) {
  const auto along = [](double low, double size, double other_low, double other_size) {
    return std::max(other_low - (low + size), low - (other_low + other_size));
  };
  return std::max({along(a.low.x, a.size.x, b.low.x, b.size.x), along(a.low.y, a.size.y, b.low.y, b.size.y),
                   along(a.low.z, a.size.z, b.low.z, b.size.z)});
}

/// Boxes of 1 to 5 spacings that touch at least one other each: on one lattice, or shifted by quarters of a spacing.
std::vector<Place> cluster(Random& random, bool shifted) {
  std::vector<Place> all;
  const auto whole = [&](int from, int to) {
    return double(from + int(random.below(std::uint32_t(to - from + 1))));
  };
  for (int tries = 0; tries < 60 && all.size() < 7; ++tries) {
    Place p{{whole(4, 14), whole(4, 14), whole(4, 14)}, {whole(1, 5), whole(1, 5), whole(1, 5)}};
    if (shifted) p.low += Vec3d{whole(0, 3), whole(0, 3), whole(0, 3)} * 0.25;
    double nearest = 100;
    for (const Place& other : all) nearest = std::min(nearest, gap(p, other));
    if (nearest >= 0 && (all.empty() || nearest < 1)) all.push_back(p);
  }
  return all;
}

WorldDesc weightless() {
  WorldDesc d = describe();
  d.spacing = spacing;
  d.precision = Precision::double_precision;
  d.gravity = {};
  d.sound_speed = sound_speed;
  d.heat.model = HeatModel::none;
  return d;
}

BodyId add(World& w, MaterialId material, Motion motion, const Shape& shape) {
  SolidDesc s;
  s.material = material;
  s.motion = motion;
  s.shape = shape;
  auto id = w.add_solid(s);
  EXPECT_TRUE(id) << id.error().message;
  return *id;
}

class SideBySide : public ::testing::TestWithParam<Motion> {};

// Whatever edges and corners meet, particles of two boxes are a spacing apart or more, so no spring is pressed in. Were an edge's
// diagonal normal taken, springs of 0.3 spacings would throw them at a tenth of the speed of sound. 1e-9 of it is rounding: shape
// matching's, in double precision.
TEST_P(SideBySide, BoxesStay) {
  MELTSIM_NEEDS_BACKEND();
  Random random(71);
  for (int n = 0; n < 24; ++n) {
    World w = std::move(*World::create(weightless()));
    const MaterialId ice = *w.add_material({});
    const auto all = cluster(random, n % 2 == 1);
    ASSERT_GE(all.size(), 2u);
    for (const Place& p : all)
      add(w, ice, GetParam(), Shape::box(p.low * spacing, (p.low + p.size) * spacing));
    for (int k = 0; k < 20; ++k) {
      require(w.step(0.002));
      ASSERT_LT(w.totals()->max_speed, 1e-9 * sound_speed) << "cluster " << n << ", step " << k;
    }
  }
}

// As a user met it: a cube on a floor beside a smaller one, flush with its edge, with its corner or with neither. Both settle by
// their own weight: of what that presses the springs of the floor in, at most d = a twentieth of a spacing stays (standing_dt), so
// that the largest speed of a mass let go on them is sqrt(g d) = 0.22 m/s.
TEST_P(SideBySide, ASmallCubeBesideALargerOneStaysOnTheFloor) {
  MELTSIM_NEEDS_BACKEND();
  for (const double shift : {0.0, 1.0, 2.0}) {
    WorldDesc d = weightless();
    d.gravity = {0, -9.81, 0};
    d.domain.bounded = true;
    d.domain.max = {2, 1.5, 1};
    World w = std::move(*World::create(d));
    const MaterialId ice = *w.add_material({});
    add(w, ice, GetParam(), Shape::box({0.2, 0, 0.2}, {0.6, 0.4, 0.6}));
    const double z = 0.2 + shift * spacing;
    add(w, ice, GetParam(), Shape::box({0.6, 0, z}, {0.8, 0.2, z + 0.2}));
    double speed = 0;
    for (int k = 0; k < 100; ++k) {
      require(w.step(0.005));
      speed = std::max(speed, w.totals()->max_speed);
    }
    const auto p = *w.pieces();
    ASSERT_EQ(p.size(), 2u);
    EXPECT_NEAR(p[0].center.x, 0.4, 0.01 * spacing) << shift;
    EXPECT_NEAR(p[1].center.x, 0.7, 0.01 * spacing) << shift;
    EXPECT_NEAR(p[1].center.z, z + 0.1, 0.01 * spacing) << shift;
    EXPECT_LT(speed, 0.22) << shift;
  }
}
INSTANTIATE_TEST_SUITE_P(Motions, SideBySide, ::testing::Values(Motion::free, Motion::rigid));

// Fourteen boxes of 2 to 4 spacings fall into a heap. Springs, dashpots and friction give no energy, and the heap comes to rest:
// 4 s after the last has fallen, what moves moves at less than a twentieth of the fall (a box that still tilts).
/// A slab that is turned by an angle against the lattice, a box of 12 x 3 x 12 spacings on it, turned alike, and gravity at a slope to the slab.
struct Ramp {
  World world;
  Vec3d up, down;  ///< off the slab; along it
  double x() { return dot(world.pieces()->back().center, down); }
  void lean(double degrees) {
    const double a = degrees * 3.14159265358979323846 / 180;
    require(world.set_gravity((down * std::sin(a) - up * std::cos(a)) * 9.81));
  }
};

Ramp ramp(double degrees, double friction) {
  const double turn = degrees * 3.14159265358979323846 / 180;
  WorldDesc d = weightless();
  d.sound_speed = 0;
  d.precision = Precision::single_precision;
  d.domain.bounded = true;
  d.domain.min = {-2.4, -2.4, 0};
  d.domain.max = {2.4, 2.4, 2};
  d.gravity = {0, -9.81, 0};
  Ramp r{std::move(*World::create(d)),
         {std::sin(turn), std::cos(turn), 0},
         {std::cos(turn), -std::sin(turn), 0}};
  r.lean(0);
  MaterialDesc m;
  m.name = "stone";
  m.density = 2000;
  m.friction = friction;
  const MaterialId stone = *r.world.add_material(m);
  const auto turned = [&](Vec3d low, Vec3d high) {
    return Shape::box(low, high).transformed({}, {0, 0, 1}, -turn);
  };
  add(r.world, stone, Motion::fixed, turned({-1.8, -0.4, 0.2}, {1.8, 0, 1.8}));
  add(r.world, stone, Motion::rigid, turned({-1.0, 0.03, 0.4}, {0.2, 0.33, 1.6}));
  for (int k = 0; k < 30; ++k) require(r.world.step(0.05));
  return r;
}

// Faces that are turned against the lattice are staircases of particles, which held a box on slopes of up to 36 degrees where friction should
// hold it up to 16.7: contacts have the normal of the shape. At 12 degrees it creeps by less than half a spacing in a second; at 25 it slides as
// Coulomb says, to a tenth: it starts from where friction has turned it.
TEST(Ramp, ABoxOnAFaceTurnedAgainstTheLatticeSlidesAsFrictionSays) {
  MELTSIM_NEEDS_BACKEND();
  constexpr double friction = 0.3, g = 9.81;
  for (const double turn : {10.0, 20.0, 35.0, 45.0}) {
    SCOPED_TRACE(turn);
    Ramp r = ramp(turn, friction);
    const double before = r.x();
    r.lean(12);
    for (int k = 0; k < 20; ++k) require(r.world.step(0.05));
    EXPECT_LT(r.x() - before, 0.5 * spacing);
    r.lean(25);
    const double start = r.x(), a = 25 * 3.14159265358979323846 / 180;
    for (int k = 0; k < 10; ++k) require(r.world.step(0.05));
    EXPECT_NEAR((r.x() - start) / (0.5 * g * (std::sin(a) - friction * std::cos(a)) * 0.25), 1, 0.1);
  }
}

/// The largest kinetic energy over that of the start, within 3 s, of four balls without friction in a turned box without gravity.
double gain(std::uint32_t seed) {
  WorldDesc d = weightless();
  d.precision = Precision::single_precision;
  d.sound_speed = 40;
  World w = std::move(*World::create(d));
  MaterialDesc m;
  m.name = "ice";
  m.density = 2000;
  m.friction = 0;
  const MaterialId ice = *w.add_material(m);
  const Vec3d inner{1.2, 1.2, 1.2}, outer{1.4, 1.4, 1.4};
  add(w, ice, Motion::fixed,
      Shape::subtract(Shape::box(-outer, outer), Shape::box(-inner, inner))
          .transformed({}, {1, 0.5, 0.2}, 0.5));
  Random random(seed);
  const auto any = [&](double size) { return size * (double(random.below(2001)) / 1000 - 1); };
  for (int k = 0; k < 4; ++k) {
    SolidDesc s;
    s.material = ice;
    s.motion = Motion::rigid;
    const Vec3d at{k % 2 != 0 ? 0.55 : -0.55, k / 2 != 0 ? 0.55 : -0.55, 0};
    s.shape = Shape::sphere(at + Vec3d{any(0.05), any(0.05), any(0.05)}, 0.3);
    s.velocity = {any(2), any(2), any(2)};
    require(w.add_solid(s));
  }
  const double start = w.ledger()->kinetic;
  double most = 0;
  for (int k = 0; k < 30; ++k) {
    require(w.step(0.1));
    most = std::max(most, w.ledger()->kinetic);
  }
  return most / start;
}

// On staircases they gained a third to two thirds. A tenth: springs between the spheres of particles that come and go beneath a ball are still no
// gradient, so that balls may gain some per cent before their dashpots have taken them.
TEST(Ramp, BallsInATurnedBoxGainNoEnergy) {
  MELTSIM_NEEDS_BACKEND();
  for (const std::uint32_t seed : {6u, 8u}) EXPECT_LT(gain(seed), 1.1) << seed;
}

TEST(Heap, OfSmallBoxesComesToRest) {
  MELTSIM_NEEDS_BACKEND();
  Random random(72);
  for (const Motion motion : {Motion::free, Motion::rigid}) {
    WorldDesc d = weightless();
    d.gravity = {0, -9.81, 0};
    d.sound_speed = 80;
    d.domain.bounded = true;
    d.domain.max = {1.2, 6, 1.2};
    World w = std::move(*World::create(d));
    MaterialDesc m;
    m.friction = 0.4;
    const MaterialId ice = *w.add_material(m);
    double floor = 0;
    const auto whole = [&](int from, int to) {
      return from + int(random.below(std::uint32_t(to - from + 1)));
    };
    for (int k = 0; k < 14; ++k) {
      const Vec3d size{double(whole(2, 4)), double(whole(2, 4)), double(whole(2, 4))};
      const Vec3d low{double(whole(0, 12 - int(size.x))), floor, double(whole(0, 12 - int(size.z)))};
      add(w, ice, motion, Shape::box(low * spacing, (low + size) * spacing));
      floor += size.y + 1;
    }
    const double fall = std::sqrt(2 * 9.81 * floor * spacing);
    double most = 0, energy = 0;
    for (int k = 0; k < 250; ++k) {
      require(w.step(0.02));
      const auto t = *w.totals();
      energy = t.kinetic + t.potential;
      if (k == 0) most = energy;
      ASSERT_LE(energy, 1.002 * most) << "step " << k;
    }
    EXPECT_LT(w.totals()->max_speed, 0.05 * fall);
  }
}

}  // namespace
}  // namespace meltsim_test
