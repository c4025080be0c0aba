// SPDX-License-Identifier: Apache-2.0
// A sphere set in motion in liquid at rest: how much of its momentum the liquid takes.
#include <cmath>

#include "meltsim/physics/artificial_viscosity.hpp"
#include "scenes.hpp"

namespace meltsim_test {
namespace {

/// One sphere in a periodic cube.
struct Moving {
  double share;  ///< of the volume
  double mass;   ///< of the displaced mass
  double added;  ///< of the displaced mass, by its mean speed from `from` to `until` [s]
  double from, until;
};
constexpr double spacing = 0.1, radius = 3 * spacing, sound_speed = 20, pi = 3.14159265358979323846;
Moving moved_through_liquid(double artificial_viscosity) {
  constexpr double dx = spacing, edge = 15 * dx, ratio = 2;  // 4.5 spacings of liquid on each side
  WorldDesc d = describe();
  d.spacing = dx;
  d.gravity = {0, 0, 0};
  d.sound_speed = sound_speed;
  d.artificial_viscosity = artificial_viscosity;
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
  const double passage = edge / sound_speed, start = 0.1 * dx / (11 * passage);
  SolidDesc sphere;
  sphere.shape = Shape::sphere({0.5 * edge, 0.5 * edge, 0.5 * edge}, radius);
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
  // Pair forces are antisymmetric: what the sphere loses the liquid has, to rounding in single precision.
  EXPECT_NEAR(w.totals()->momentum.y, before.momentum.y, 1e-5 * before.momentum.y);
  return {share, ratio, ratio * (start / mean - 1), passage, 11 * passage};
}
/// A cubic array of spheres in potential flow: (1/2)(1 + 2f)/(1 - f) of the displaced mass, f their share of the volume (Zuber 1964,
/// Chem. Eng. Sci. 19:897).
double zuber(double share) { return 0.5 * (1 + 2 * share) / (1 - share); }

// 6 spacings to a diameter; a body half a spacing larger or smaller all around would take 1.6 or 0.6 times as much.
TEST(AddedMass, OfASphereThatHasJustBegunToMove_MatchesPotentialFlow) {
  MELTSIM_NEEDS_BACKEND();
  const Moving sphere = moved_through_liquid(0);
  EXPECT_NEAR(sphere.added, zuber(sphere.share), 0.15 * zuber(sphere.share));
}

// Artificial viscosity damps the liquid, which slides along the sphere: potential flow, with the drag 12 pi mu a U of a bubble (Levich
// 1949), which takes 0.85 of the displaced mass for added here. A tenth for what a pair's viscosity is worth on a lattice;
// liquid that artificial viscosity makes stick to the sphere takes 1.06.
TEST(AddedMass, WithArtificialViscosity_IsThatOfABubblesDrag) {
  MELTSIM_NEEDS_BACKEND();
  const Moving sphere = moved_through_liquid(0.05);
  const double nu = physics::artificial_kinematic_viscosity(0.05, sound_speed, 2.5 * spacing),
               displaced = 1000 * 4 / 3.0 * pi * radius * radius * radius,
               mass = (sphere.mass + zuber(sphere.share)) * displaced,
               rate = 12 * pi * 1000 * nu * radius / mass,
               mean = (std::exp(-rate * sphere.from) - std::exp(-rate * sphere.until)) /
                      (rate * (sphere.until - sphere.from)),
               right = (sphere.mass + zuber(sphere.share)) / mean - sphere.mass;
  EXPECT_NEAR(sphere.added, right, 0.1 * right);
}

}  // namespace
}  // namespace meltsim_test
