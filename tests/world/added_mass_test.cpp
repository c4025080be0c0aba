// SPDX-License-Identifier: Apache-2.0
// A sphere set in motion in liquid at rest: how much of its momentum the liquid takes.
#include <cmath>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

// One sphere in a periodic cube is a cubic array of spheres, whose added mass in potential flow is
// (1/2)(1 + 2f)/(1 - f) of the displaced mass, f its share of the volume (Zuber 1964, Chem. Eng. Sci. 19:897).
TEST(AddedMass, OfASphereThatHasJustBegunToMove_MatchesPotentialFlow) {
  MELTSIM_NEEDS_BACKEND();
  constexpr double dx = 0.1, edge = 15 * dx, sound = 20, ratio = 2;  // 4.5 spacings of liquid on each side
  WorldDesc d = describe();
  d.spacing = dx;
  d.gravity = {0, 0, 0};
  d.sound_speed = sound;
  d.artificial_viscosity = 0;
  d.tension = true;  // the liquid fills the domain
  d.domain.bounded = true;
  d.domain.max = {edge, edge, edge};
  d.domain.faces.fill(Face::periodic);
  World w = *World::create(d);
  MaterialDesc water;
  water.viscosity = 0;
  const MaterialId liquid = *w.add_material(water);
  MaterialDesc heavy;
  heavy.name = "heavy";
  heavy.density = 1000 * ratio;
  // Sound crosses the box in `passage`; in 11 of them the sphere moves by less than a tenth of a spacing, so the lattice
  // around it is still the one at the start.
  const double passage = edge / sound, start = 0.1 * dx / (11 * passage);
  SolidDesc sphere;
  sphere.shape = Shape::sphere({0.5 * edge, 0.5 * edge, 0.5 * edge}, 3 * dx);
  sphere.material = *w.add_material(heavy);
  sphere.velocity = {0, start, 0};
  require(w.add_solid(sphere));
  FluidDesc fill;
  fill.shape = Shape::box({0, 0, 0}, {edge, edge, edge});
  fill.material = liquid;
  require(w.add_fluid(fill));
  const Totals before = *w.totals();
  const double volume = static_cast<double>(before.solid) * dx * dx * dx,
               share = volume / (edge * edge * edge);

  // The sound of the start stays in the box: the speed is the mean over ten passages.
  double mean = 0;
  int samples = 0;
  for (int tenth = 1; tenth <= 110; ++tenth) {
    require(w.step(0.1 * passage));
    if (tenth <= 10) continue;
    mean += (*w.pieces())[0].velocity.y;
    ++samples;
  }
  mean /= samples;
  const double added = ratio * (start / mean - 1), right = 0.5 * (1 + 2 * share) / (1 - share);
  // 6 spacings to a diameter; a body half a spacing larger or smaller all around would take 1.6 or 0.6 times as much.
  EXPECT_NEAR(added, right, 0.15 * right);
  // Pair forces are antisymmetric: what the sphere loses the liquid has, to rounding in single precision.
  EXPECT_NEAR(w.totals()->momentum.y, before.momentum.y, 1e-5 * before.momentum.y);
}

}  // namespace
}  // namespace meltsim_test
