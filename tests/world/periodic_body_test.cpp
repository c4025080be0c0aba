// SPDX-License-Identifier: Apache-2.0
// Bodies that reach around a periodic axis: at the seam they go on, as if nothing were there.
#include <algorithm>
#include <cmath>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double dx = 0.05;

/// n cells around x, and around z where `twice`; walls across the others.
World tube(int n, bool twice, double gravity = 0) {
  WorldDesc d = describe();
  d.spacing = dx;
  d.gravity = {0, gravity, 0};
  d.sound_speed = 10;
  d.domain.bounded = true;
  d.domain.max = {n * dx, 0.8, n * dx};
  d.domain.friction = 0;
  const Face z = twice ? Face::periodic : Face::wall;
  d.domain.faces = {Face::periodic, Face::periodic, Face::wall, Face::wall, z, z};
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  return std::move(*w);
}

MaterialDesc metal() {
  MaterialDesc m;
  m.name = "metal";
  m.conductivity = 1e3;
  m.heat_capacity = 1000;
  m.friction = 0;
  return m;
}

// 1000 W/m^2 through the two faces of a slab, which are planes of the lattice: exact. With a surface at the seam it took 1.50 and
// 1.18 times as much, 8 and 20 cells around.
TEST(PeriodicBody, ASlabTakesHeatThroughItsFacesAlone) {
  MELTSIM_NEEDS_BACKEND();
  for (const int n : {8, 20})
    for (const Motion motion : {Motion::fixed, Motion::rigid, Motion::free, Motion::kinematic}) {
      SCOPED_TRACE(n);
      SCOPED_TRACE(static_cast<int>(motion));
      World w = tube(n, true);
      SolidDesc s;
      s.shape = Shape::box({0, 0.3, 0}, {n * dx, 0.5, n * dx});
      s.material = *w.add_material(metal());
      s.motion = motion;
      s.surface.flux = 1000;
      require(w.add_solid(s));
      for (int k = 0; k < 10; ++k) require(w.step(0.01));
      const double exact = 1000 * 2 * (n * dx) * (n * dx) * 0.1;
      EXPECT_NEAR(w.ledger()->heat_in, exact, 1e-5 * exact);  // float areas
    }
}

// All direct neighbours are there but those beyond the two faces: 18 of 27 in the outer layers.
TEST(PeriodicBody, NeighboursGoOnAcrossTheSeam) {
  MELTSIM_NEEDS_BACKEND();
  World w = tube(8, true);
  SolidDesc s;
  s.shape = Shape::box({0, 0.3, 0}, {8 * dx, 0.5, 8 * dx});
  s.material = *w.add_material(metal());
  s.motion = Motion::rigid;
  require(w.add_solid(s));
  require(w.step(1e-3));
  const LatticeData l = *w.lattice();
  ASSERT_EQ(l.particle_id.size(), 8u * 4 * 8);
  std::size_t faces = 0, inside = 0;
  for (std::size_t v = 0; v < l.particle_id.size(); ++v) {
    const auto n = std::count_if(l.arrayN.begin() + static_cast<std::ptrdiff_t>(27 * v),
                                 l.arrayN.begin() + static_cast<std::ptrdiff_t>(27 * v + 27),
                                 [](std::uint32_t u) { return u != 0; });
    faces += n == 18 ? 1 : 0;
    inside += n == 27 ? 1 : 0;
  }
  EXPECT_EQ(faces, 2u * 8 * 8);
  EXPECT_EQ(inside, 2u * 8 * 8);
}

// Without friction nothing brakes it. The ends of the plate leant against it once per round: it lost 5 % there.
TEST(PeriodicBody, ABoxSlidesOverTheSeam) {
  MELTSIM_NEEDS_BACKEND();
  for (const Motion motion : {Motion::rigid, Motion::free}) {
    SCOPED_TRACE(static_cast<int>(motion));
    World w = tube(12, false, -9.81);
    const auto m = *w.add_material(metal());
    SolidDesc plate;
    plate.shape = Shape::box({0, 0, 0}, {12 * dx, 2 * dx, 12 * dx});
    plate.material = m;
    plate.motion = Motion::fixed;
    require(w.add_solid(plate));
    SolidDesc box;
    box.shape = Shape::box({0.1, 2 * dx, 0.2}, {0.3, 0.3, 0.4});
    box.material = m;
    box.motion = motion;
    box.velocity = {1, 0, 0};
    require(w.add_solid(box));
    for (int k = 0; k < 120; ++k) require(w.step(0.01));  // twice around
    const auto pieces = *w.pieces();
    ASSERT_EQ(pieces.size(), 2u);
    EXPECT_NEAR(pieces[1].velocity.x, 1, 1e-4);  // rounding of 1.2 m in single precision
  }
}

// A ring that is cut once stays one piece, a bar between walls becomes two.
TEST(PeriodicBody, ARingCutOnceIsOnePiece) {
  MELTSIM_NEEDS_BACKEND();
  for (const bool around : {true, false}) {
    SCOPED_TRACE(around);
    WorldDesc d = describe();
    d.spacing = dx;
    d.gravity = {0, 0, 0};
    d.sound_speed = 10;
    d.domain.bounded = true;
    d.domain.max = {12 * dx, 12 * dx, 12 * dx};
    if (around) d.domain.faces[0] = d.domain.faces[1] = Face::periodic;
    d.heat.time_scale = 1e4;
    auto w = World::create(d);
    require(w);
    MaterialDesc ice;
    ice.name = "ice";
    ice.melting_point = 0;
    ice.latent_heat = 1e4;
    ice.melts_into = *w->add_material({});
    SolidDesc bar;
    bar.shape = Shape::box({0, 4 * dx, 4 * dx}, {12 * dx, 8 * dx, 8 * dx});
    bar.material = *w->add_material(ice);
    bar.temperature = -10;
    bar.motion = Motion::rigid;
    require(w->add_solid(bar));
    HeatRegionDesc knife;
    knife.shape = Shape::box({5 * dx, 0, 0}, {7 * dx, 12 * dx, 12 * dx});
    knife.temperature = 500;
    knife.until = 0.05;
    require(w->add_heat_region(knife));
    for (int k = 0; k < 10; ++k) require(w->step(0.01));
    EXPECT_GE(w->synchronize().melted, 2u * 4 * 4);
    EXPECT_EQ(w->pieces()->size(), around ? 1u : 2u);
  }
}

/// A plank of so many cells along x, of 24 around.
SolidDesc plank(MaterialId material, int length, Motion motion) {
  SolidDesc s;
  s.material = material;
  s.motion = motion;
  const double low = 0.5 * (24 - length) * dx;
  s.shape = Shape::box({low, 0.3, 0.5}, {low + length * dx, 0.5, 0.7});
  return s;
}

// Longer than half a period, and as long: which image of its far end is meant, the lattice and its rotation say. A free plank of 16 of 24
// cells gained energy of its own spin, and all readings of pieces were of another body.
TEST(PeriodicBody, OneLongerThanHalfAPeriodSpinsAsOneThatIsShorter) {
  MELTSIM_NEEDS_BACKEND();
  for (const Motion motion : {Motion::free, Motion::rigid, Motion::kinematic})
    for (const int length : {8, 12, 13, 16, 20}) {
      SCOPED_TRACE(length);
      SCOPED_TRACE(static_cast<int>(motion));
      World w = tube(24, true);
      const BodyId body = *w.add_solid(plank(*w.add_material(metal()), length, motion));
      const auto start = w.pieces();
      ASSERT_TRUE(start);
      const PieceInfo& at = start->front();
      const double middle = (length % 2 == 0 ? 0.6 : 0.575);  // the lattice's
      EXPECT_NEAR(at.center.x, middle, 1e-6);
      EXPECT_NEAR(at.bounds.max.x - at.bounds.min.x, length * dx, 1e-6);
      // Of points, and their own spin: (L^2 - 1 + 15)/12 spacings squared.
      const double inertia = at.mass * (length * length + 14) / 12.0 * dx * dx;
      EXPECT_NEAR(at.inertia.m[1][1], inertia, 1e-4 * inertia);
      if (motion == Motion::kinematic) {
        BodyMotion spin;
        spin.angular_velocity = {0, 1, 0};
        require(w.set_motion(body, spin));
      } else {
        require(w.set_velocity(body, {}, {0, 0.5, 0}));
        require(w.apply_impulse(body, {}, {0, 0.5 * inertia, 0}));
        const double energy = w.ledger()->kinetic;
        EXPECT_NEAR(energy, 0.5 * inertia, 1e-3 * energy);  // float velocities
        for (int k = 0; k < 40; ++k) require(w.step(0.025));
        // A free plank stretches by its spin, once: less than a thousandth of the energy.
        EXPECT_NEAR(w.ledger()->kinetic, energy, 1e-3 * energy);
      }
      for (int k = 0; k < 40 && motion == Motion::kinematic; ++k) require(w.step(0.025));
      const auto end = w.pieces();
      ASSERT_TRUE(end);
      // Half a radian, as well as the sum of a thousand rounded rotations has it.
      EXPECT_NEAR(end->front().orientation.w, std::cos(0.5), 1e-3);
      EXPECT_NEAR(end->front().orientation.y, std::sin(0.5), 1e-3);
      EXPECT_NEAR(end->front().angular_velocity.y, 1, 1e-3);
      EXPECT_NEAR(end->front().center.x, middle, 1e-5);
      EXPECT_NEAR(end->front().center.z, 0.6, 1e-5);
    }
}

}  // namespace
}  // namespace meltsim_test
