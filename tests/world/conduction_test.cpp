// SPDX-License-Identifier: Apache-2.0
// Conduction along bodies beside other matter and walls.
#include <optional>
#include <utility>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double dx = 0.01;

/// Heat per second through the wall at x = 0, held at 100 degrees, the other at 0, over what a bar of n x m cells alone should pass by k A dT/L.
/// The rest of a box of 9 x 9 cells holds `around` W/(m K), none: nothing. floor: heat of the wall below, on which the bar then lies.
double passed(int n, int m, std::optional<double> around, const SurfaceHeatDesc* floor = nullptr) {
  constexpr double k = 200;
  constexpr int along = 12, wide = 9;
  WorldDesc d = describe();
  d.spacing = dx;
  d.gravity = {0, 0, 0};
  d.domain.bounded = true;
  d.domain.max = {along * dx, wide * dx, wide * dx};
  d.heat.max_supersteps = 100000;
  World w = std::move(*World::create(d));
  for (int face = 0; face < 2; ++face) {
    SurfaceHeatDesc end;
    end.temperature = face == 0 ? 100 : 0;
    require(w.set_wall_heat(face, end));
  }
  if (floor != nullptr) require(w.set_wall_heat(2, *floor));
  MaterialDesc metal;
  metal.name = "metal";
  metal.density = 2000;
  metal.heat_capacity = 500;
  metal.conductivity = k;
  const double y = floor != nullptr ? 0 : (wide - n) / 2 * dx, z = (wide - m) / 2 * dx;
  SolidDesc bar;
  bar.material = *w.add_material(metal);
  bar.shape = Shape::box({0, y, z}, {along * dx, y + n * dx, z + m * dx});
  bar.temperature = 50;
  bar.fixed = true;
  require(w.add_solid(bar));
  if (around) {
    MaterialDesc wool = metal;
    wool.name = "wool";
    wool.conductivity = *around;
    wool.heat_capacity *= *around / k;  // both are steady at the same time
    SolidDesc rest = bar;
    rest.material = *w.add_material(wool);
    rest.shape = Shape::subtract(Shape::box({0, 0, 0}, d.domain.max), bar.shape);
    require(w.add_solid(rest));
  }
  ProbeDesc p;
  p.kind = ProbeKind::heat;
  p.wall = 0;
  const auto id = w.add_probe(p);
  require(id);
  for (int step = 0; step < 60; ++step) require(w.step(3));  // L^2/alpha is 72 s
  const auto series = w.take_samples();
  EXPECT_TRUE(series && !series->empty());
  const double all = series->front().values.back();
  const double others = around ? *around * (wide * wide - n * m) : 0;
  return all / ((k * n * m + others) * dx * dx * 100 / (along * dx));
}

// A body conducts along itself as its conductivity says whatever surrounds it: nothing, an insulator, a conductor half as good. What is not
// corrected passes 0.67 (2 x 2 cells), 0.81 (a plate of two) and 0.986 of it. Corrections are fitted to planes and bars of the lattice:
// 3 %.
TEST(Conduction, OfABarIsItsOwnWhateverSurroundsIt) {
  MELTSIM_NEEDS_BACKEND();
  for (const auto& [n, m] : {std::pair{2, 2}, std::pair{3, 3}, std::pair{2, 9}})
    for (const std::optional<double> around :
         {std::optional<double>(), std::optional<double>(0.2), std::optional<double>(100)})
      EXPECT_NEAR(passed(n, m, around), 1, 0.03) << n << " x " << m << " in " << around.value_or(0);
}

// Nor does a floor that takes next to nothing hold heat back in what lies on it: 0.81 of a sheet, 0.90 of a plate of two.
TEST(Conduction, OfAPlateIsItsOwnOnAFloorThatHardlyExchanges) {
  MELTSIM_NEEDS_BACKEND();
  SurfaceHeatDesc weak[3];
  weak[1].convection = weak[2].flux = 1e-6;
  weak[1].ambient = 50;
  for (const int layers : {1, 2})
    for (const SurfaceHeatDesc& floor : weak) EXPECT_NEAR(passed(layers, 9, {}, &floor), 1, 0.02) << layers;
}

}  // namespace
}  // namespace meltsim_test
