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

/// What a cube lies on, in place of the floor: a body of 8 x 4 x 8 spacings or one as wide as the cube, held or free.
struct Below {
  const char* name;
  Motion motion;
  int edge;
};
constexpr Below below[] = {{"a held slab", Motion::fixed, 8},
                           {"a held pedestal", Motion::fixed, 4},
                           {"a slab", Motion::free, 8},
                           {"a rigid block", Motion::rigid, 4}};

/// Water 16 spacings deep, and a cube of 4 on what lies on the floor.
World make_stacked(const Below& under, double density, Motion motion, BodyId& cube) {
  WorldDesc d = describe();
  d.spacing = dx;
  d.sound_speed = 40;
  d.heat.model = HeatModel::none;
  d.domain.bounded = true;
  d.domain.no_slip = false;
  d.domain.max = {1.6, 2.4, 1.6};
  World w = std::move(*World::create(d));
  MaterialDesc m;
  m.name = "heavy";
  m.density = 5000;
  SolidDesc s;
  s.material = *w.add_material(m);
  s.motion = under.motion;
  const double half = 0.5 * under.edge * dx;
  s.shape = Shape::box({0.8 - half, 0, 0.8 - half}, {0.8 + half, 0.4, 0.8 + half});
  require(w.add_solid(s));
  m.name = "cube";
  m.density = density;
  s.material = *w.add_material(m);
  s.motion = motion;
  s.shape = Shape::box({0.6, 0.4, 0.6}, {1, 0.8, 1});
  cube = *w.add_solid(s);
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0, 0, 0}, {1.6, 1.6, 1.6});
  require(w.add_fluid(f));
  return w;
}

double height_of(World& w, BodyId body) {
  for (const PieceInfo& p : *w.pieces())
    if (p.body == body) return p.center.y;
  return 0;
}

// As from the floor: in 1.5 s, without what seeps between them the cube stays where it is.
TEST(Seepage, LightBodiesRiseFromOtherBodies) {
  MELTSIM_NEEDS_BACKEND();
  for (const Below& under : below)
    for (const auto& [density, motion] : {std::pair{500.0, Motion::rigid}, std::pair{850.0, Motion::free}}) {
      if ((motion == Motion::rigid) == (under.edge == 8))
        continue;  // each with wide and narrow, held and free: half of the pairs
      BodyId cube;
      World w = make_stacked(under, density, motion, cube);
      const double start = height_of(w, cube);
      double risen = 0;
      for (int k = 0; k < 75 && risen < 2 * dx; ++k) {
        require(w.step(0.02));
        risen = height_of(w, cube) - start;
      }
      EXPECT_GE(risen, 2 * dx) << density << " on " << under.name;
    }
}

// What lies there loses the weight of the water that it displaces, which the reading counts as pressure, to within 0.06 of the pressure
// beneath it times its area: twice what the cube of twice the width on the floor is allowed, since half as many particles know their
// rim. And it stays.
TEST(Seepage, HeavyBodiesOnOthersLoseTheWeightOfTheWaterTheyDisplace) {
  MELTSIM_NEEDS_BACKEND();
  for (const Below& under : below)
    for (const Motion motion : {Motion::free, Motion::rigid}) {
      if ((motion == Motion::rigid) != (under.edge == 8)) continue;  // the other half of the pairs
      BodyId cube;
      World w = make_stacked(under, 2500, motion, cube);
      require(w.watch_forces(cube));
      const double start = height_of(w, cube);
      for (int k = 0; k < 10; ++k) require(w.step(0.02));
      require(w.take_forces());
      for (int k = 0; k < 30; ++k) require(w.step(0.02));
      const auto forces = *w.take_forces();
      ASSERT_EQ(forces.size(), 1u);
      const double area = 16 * dx * dx, displaced = water_density * g * area * 4 * dx,
                   beneath = water_density * g * area * 12 * dx;
      EXPECT_NEAR(forces[0].pressure.linear.y / forces[0].seconds, displaced, 0.06 * beneath)
          << (motion == Motion::rigid ? "rigid" : "free") << " on " << under.name;
      EXPECT_LT(std::fabs(height_of(w, cube) - start), 0.1 * dx) << under.name;
    }
}

}  // namespace
}  // namespace meltsim_test
