// SPDX-License-Identifier: Apache-2.0
// Bodies that lie on walls under water (physics/seepage.hpp): Archimedes holds there as well.
#include <algorithm>
#include <cmath>
#include <string>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double dx = 0.1, g = 9.81, water_density = 1000;

/// Water in a tank of 16 x 16 spacings, `layers` deep, and a cube on the floor or below the lid.
struct Lying {
  double density;
  Motion motion = Motion::free;
  int edge = 4, layers = 12;
  bool in_corner = false, below_lid = false;
};

World make(const Lying& l, BodyId* body_id = nullptr) {
  WorldDesc d = describe();
  d.spacing = dx;
  d.sound_speed = 40;  // compresses water of 1.2 m by 0.7 %
  d.heat.model = HeatModel::none;
  d.domain.bounded = true;
  d.domain.no_slip = false;
  d.domain.max = {1.6, l.below_lid ? l.layers * dx : 2.4, 1.6};
  World w = std::move(*World::create(d));
  MaterialDesc body;
  body.name = "body";
  body.density = l.density;
  SolidDesc s;
  s.material = *w.add_material(body);
  s.motion = l.motion;
  const double size = l.edge * dx, side = l.in_corner ? 0 : 0.5 * (1.6 - size);
  const double low = l.below_lid ? l.layers * dx - size : 0;
  s.shape = Shape::box({side, low, side}, {side + size, low + size, side + size});
  const BodyId id = *w.add_solid(s);
  if (body_id != nullptr) *body_id = id;
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0, 0, 0}, {1.6, l.layers * dx, 1.6});
  require(w.add_fluid(f));
  return w;
}

double height(World& w) { return w.pieces()->at(0).center.y; }

std::string name(const Lying& l) {
  return std::to_string(l.density) + (l.motion == Motion::rigid ? ", rigid" : ", free") +
         (l.in_corner ? ", in a corner" : "") + (l.below_lid ? ", below the lid" : "");
}

// Without what seeps beneath, all of these stay where they are: the water above presses them on. They begin to rise at
// (1 - rho/rho_water) g or less, as water follows them: two spacings in 0.35 s without that, for 900 kg/m^3 in 0.63 s.
TEST(Seepage, LightBodiesRiseFromTheFloor) {
  MELTSIM_NEEDS_BACKEND();
  for (const Lying& l : {Lying{500, Motion::rigid}, Lying{900}, Lying{500, Motion::free, 4, 12, true}}) {
    World w = make(l);
    const double start = height(w);
    for (int k = 0; k < 75; ++k) require(w.step(0.02));
    EXPECT_GT(height(w) - start, 2 * dx) << name(l);
  }
}

TEST(Seepage, OtherBodiesStay) {
  MELTSIM_NEEDS_BACKEND();
  // Liquid enters from a gap of a spacing on; the tank swings at its start, by as much as the water weighs, and bodies with it.
  for (const Lying& l : {Lying{1500, Motion::rigid}, Lying{600, Motion::free, 4, 12, false, true}}) {
    World w = make(l);
    const double start = height(w);
    double farthest = 0;
    for (int k = 0; k < 75; ++k) {
      require(w.step(0.02));
      farthest = std::max(farthest, std::fabs(height(w) - start));
    }
    EXPECT_LT(farthest, 0.5 * dx) << name(l);
  }
}

// Swings of the tank, of 0.12 s, are averaged over ten periods. What presses from above and from below is known to 3 % of the pressure
// at the floor, a twentieth of the water displaced: beneath the free body 2 % are missing.
TEST(Seepage, ABodyOnTheFloorLosesTheWeightOfTheWaterItDisplaces) {
  MELTSIM_NEEDS_BACKEND();
  for (const Motion motion : {Motion::free, Motion::rigid}) {
    const Lying l{2500, motion, 8, 12};
    ProbeDesc d;
    World w = make(l, &d.body);
    d.kind = ProbeKind::force;
    d.fields = {"force"};
    require(w.add_probe(d));
    double liquid = 0;
    std::size_t samples = 0;
    for (int k = 0; k < 100; ++k) {
      require(w.step(0.02));
      const auto taken = w.take_samples();
      ASSERT_TRUE(taken);
      if (k < 40) continue;
      const ProbeSeries& s = taken->at(0);
      for (std::size_t n = 0; n < s.time.size(); ++n) {
        liquid += s.values[n * s.width + 1];
        ++samples;
      }
    }
    const double area = std::pow(l.edge * dx, 2), displaced = water_density * g * area * l.edge * dx;
    EXPECT_NEAR(liquid / static_cast<double>(samples), displaced,
                0.03 * water_density * g * area * l.layers * dx)
        << name(l);
  }
}

}  // namespace
}  // namespace meltsim_test
