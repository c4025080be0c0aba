// SPDX-License-Identifier: Apache-2.0
// What the stability map (`meltsim stress`) found, mended: each of these halted, or gained energy, without a word.
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

/// A tank of 8 x 14 x 8 spacings of 0.2 m, with a cube of 27 particles in or above the liquid.
struct Tank {
  WorldDesc desc = describe();
  double depth = 8, floor = 2;  // in spacings
  MaterialDesc body;
  Tank() {
    desc.domain.bounded = true;
    desc.domain.max = {1.6, 2.8, 1.6};
    body.name = "body";
  }
  Result<World> make() const {
    Result<World> w = World::create(desc);
    if (!w) return w;
    MaterialDesc water;
    const Result<MaterialId> liquid = w->add_material(water);
    if (!liquid) return liquid.error();
    const Result<MaterialId> solid = w->add_material(body);
    if (!solid) return solid.error();
    FluidDesc f;
    f.shape = Shape::box({0, 0, 0}, {1.6, 0.2 * depth, 1.6});
    f.material = *liquid;
    if (const auto r = w->add_fluid(f); !r) return r.error();
    SolidDesc s;
    s.shape = Shape::box({0.4, 0.2 * floor, 0.4}, {1.0, 0.2 * floor + 0.6, 1.0});
    s.material = *solid;
    if (const auto r = w->add_solid(s); !r) return r.error();
    return w;
  }
};

/// The number after `words` in a message.
double number_after(const std::string& message, const std::string& words) {
  const std::size_t at = message.find(words);
  EXPECT_NE(at, std::string::npos) << message;
  return at == std::string::npos ? 0 : std::strtod(message.c_str() + at + words.size(), nullptr);
}

// A hot blade that the host pushes through soft stuff faster than that melts crushes it, and what melted there had 1.6 times the density: it
// left at 40 m/s, three times the speed of sound, and halted the World. Now at most 8 m/s; the bound is the sound's 14.2 m/s.
TEST(Extremes, AHotBladeThroughASoftBlock_MeltsWithoutBlasts) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.005;
  d.domain.bounded = true;
  d.domain.min = {-0.06, 0, -0.06};
  d.domain.max = {0.06, 0.12, 0.06};
  d.domain.faces = {Face::open, Face::open, Face::wall, Face::open, Face::open, Face::open};
  d.heat.time_scale = 100;
  World w = *World::create(d);
  MaterialDesc oil, butter, steel;
  oil.name = "oil";
  oil.density = 910;
  oil.viscosity = 0.1;
  butter.name = "butter";
  butter.density = 920;
  butter.conductivity = 0.2;
  butter.heat_capacity = 2200;
  butter.melting_point = 33;
  butter.latent_heat = 1e5;
  butter.melts_into = *w.add_material(oil);
  steel.name = "steel";
  steel.density = 7800;
  steel.conductivity = 40;
  steel.heat_capacity = 480;
  SolidDesc block;
  block.material = *w.add_material(butter);
  block.shape = Shape::box({-0.03, 0, -0.03}, {0.03, 0.05, 0.03});
  block.temperature = 10;
  require(w.add_solid(block));
  SolidDesc blade;
  blade.material = *w.add_material(steel);
  blade.shape = Shape::box({-0.005, 0.06, -0.05}, {0.005, 0.1, 0.05});
  blade.temperature = 150;
  blade.motion = Motion::kinematic;
  blade.velocity = {0, -0.08, 0};
  blade.max_speed = 0.08;
  require(w.add_solid(blade));
  double fastest = 0;
  std::uint64_t melted = 0;
  for (int k = 0; k < 45; ++k) {  // it halted at 0.37 s
    require(w.step(0.01));
    const StepResult r = w.synchronize();
    ASSERT_FALSE(r.halted) << r.halt_reason;
    fastest = std::max(fastest, r.max_speed);
    melted = r.melted;
  }
  EXPECT_GT(melted, 20u);  // it is about these
  EXPECT_LT(fastest, 14.2);
}

// A body of a fifth to a thousandth of the liquid's density, let go at the bottom: 0.1 halted at sub-step 18 with 331 m/s. A body
// without mass that drags half its volume of liquid along rises at up to 2 g, over 1 m to 6.3 m/s. 250 sub-steps are twelve
// times as many as it took; those of a thousandth are 0.02 s, in which it moves by less than what pressure waves do with it.
TEST(Extremes, LightBodiesRiseFromTheBottom) {
  MELTSIM_NEEDS_BACKEND();
  for (const double ratio : {0.2, 0.1, 0.01, 0.001})
    for (const double modulus : {0.0, 1e3}) {  // as stiff as it gets, and as soft as liquid lets it be
      Tank t;
      t.body.density = 1000 * ratio;
      t.body.youngs_modulus = modulus;
      Result<World> w = t.make();
      require(w);
      const double before = w->totals()->kinetic + w->totals()->potential, y = w->pieces()->front().center.y;
      double fastest = 0;
      for (int k = 0; k < 250; ++k) require(w->step(w->resolved().stable_dt));
      const StepResult r = w->synchronize();
      ASSERT_FALSE(r.halted) << ratio << ": " << r.halt_reason;
      fastest = length(w->pieces()->front().velocity);
      EXPECT_LT(fastest, 6.3) << ratio << ", E " << modulus;
      if (ratio >= 0.01) {
        EXPECT_GT(w->pieces()->front().center.y, y) << ratio << ", E " << modulus;
      }
      EXPECT_EQ(r.body_stiffened, modulus > 0);
      const Totals now = *w->totals();
      EXPECT_LT(now.kinetic + now.potential, before + 1e-3 * std::fabs(before)) << ratio;
    }
}

// What lies in liquid of up to twice its density has the steps that it had.
TEST(Extremes, BodiesOfHalfTheDensityKeepTheirSteps) {
  MELTSIM_NEEDS_BACKEND();
  const auto step = [](double density) {
    Tank t;
    t.body.density = density;
    Result<World> w = t.make();
    EXPECT_TRUE(w);
    return w->stable_dt() / std::pow(std::min(1.0, density / 1000), 0.25);
  };
  EXPECT_NEAR(step(500), step(1000), 1e-12);
  EXPECT_LT(step(200), 0.9 * step(1000));
}

// A block of 0.3 m on a hot plate, at the largest Courant number and 0.35 of the derived sound speed (25.8 m/s): it sank 0.35 spacings
// into the plate before its lowest layer melted there, and halted at sub-step 15. The block falls no faster than sqrt(2 g h) = 2.4 m/s,
// and nothing is thrown faster than twice that.
TEST(Extremes, WhatMeltsOnAHotPlateIsNotThrown) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.05;
  d.courant = 0.6;
  d.sound_speed = 9.03;
  d.domain.bounded = true;
  d.domain.max = {0.6, 0.5, 0.6};
  d.domain.no_slip = false;
  d.domain.heat[2].temperature = 80;
  d.heat.time_scale = 2e4;
  Result<World> w = World::create(d);
  require(w);
  MaterialDesc water;
  water.viscosity = 0.2;
  MaterialDesc ice;
  ice.name = "ice";
  ice.density = 917;
  ice.conductivity = 2.2;
  ice.heat_capacity = 2100;
  ice.melting_point = 0;
  ice.latent_heat = 3.34e5;
  ice.melts_into = *w->add_material(water);
  SolidDesc block;
  block.material = *w->add_material(ice);
  block.temperature = 0;
  block.shape = Shape::box({0.15, 0, 0.15}, {0.45, 0.3, 0.45});
  require(w->add_solid(block));
  double fastest = 0;
  for (int k = 0; k < 20; ++k) {
    require(w->step(0.02));
    const StepResult r = w->synchronize();
    ASSERT_FALSE(r.halted) << r.halt_reason;
    fastest = std::max(fastest, r.max_speed);
  }
  EXPECT_LT(fastest, 2 * std::sqrt(2 * 9.81 * 0.3));
  EXPECT_GE(w->synchronize().melted, 36u);  // a layer
}

// The floor is the domain's lowest corner, however gravity is tilted: towards +x the tank is 1.6 m deep, upwards 2.8. The liquid
// fills 0.8 m of its height, so that it can fall to the other end. sqrt(2 g h) of it, ten times.
TEST(Extremes, TheFallIsMeasuredToTheLowestCorner) {
  MELTSIM_NEEDS_BACKEND();
  const auto sound = [](Vec3d gravity) {
    Tank t;
    t.depth = 4;
    t.floor = 5;
    t.desc.gravity = gravity;
    Result<World> w = t.make();
    EXPECT_TRUE(w);
    return w->resolved().sound_speed;
  };
  // From half a spacing inside one wall to the opposite one, and the spacing that derive_sound_speed() adds.
  EXPECT_NEAR(sound({9.81, 0, 0}), 10 * std::sqrt(2 * 9.81 * (1.5 + 0.2)), 1e-6);
  EXPECT_NEAR(sound({0, 9.81, 0}), 10 * std::sqrt(2 * 9.81 * (2.7 + 0.2)), 1e-6);
  EXPECT_NEAR(sound({0, 0, -9.81}), 10 * std::sqrt(2 * 9.81 * (1.5 + 0.2)), 1e-6);
  EXPECT_NEAR(sound({0, -9.81, 0}), 10 * std::sqrt(2 * 9.81 * (1.5 + 0.2)),
              1e-6);  // the block's top at 1.5 m
}

// What melts takes the room of its liquid at once. Ten times its own, melted within a tenth of a second, made 2.5 times the energy
// that there was; twenty times halted.
TEST(Extremes, ASolidFarDenserThanItsMeltIsRefused) {
  MELTSIM_NEEDS_BACKEND();
  const auto add = [](double ratio, double time_scale, HeatModel model = HeatModel::enthalpy) {
    WorldDesc d = describe();
    d.heat.time_scale = time_scale;
    d.heat.model = model;
    World w = std::move(*World::create(d));
    MaterialDesc melt, solid;
    solid.name = "solid";
    solid.melts_into = *w.add_material(melt);
    solid.melting_point = 0;
    solid.density = ratio * melt.density;
    const Result<MaterialId> r = w.add_material(solid);
    if (!r) return r.error().message;
    const Status s = w.set_heat_time_scale(1);
    return s ? std::string() : s.error().message;
  };
  EXPECT_EQ(add(4, 1), "");
  EXPECT_EQ(add(0.01, 1), "");
  EXPECT_EQ(add(10, 1, HeatModel::none), "");
  for (const double time_scale : {1.0, 0.0}) {  // when it is added; when heat is switched on
    const std::string said = add(10, time_scale);
    EXPECT_NE(said.find("material \"solid\": density: 10000 kg/m^3 is 10 times the 1000 kg/m^3 of \"water\""),
              std::string::npos)
        << said;
    EXPECT_NE(said.find("use at most 4 times"), std::string::npos) << said;
  }
}

TEST(Extremes, SpacingsThatPrecisionCannotHoldAreRefused) {
  MELTSIM_NEEDS_BACKEND();
  const auto refused = [](double spacing, Precision precision) {
    WorldDesc d = describe();
    d.spacing = spacing;
    d.precision = precision;
    const auto w = World::create(d);
    return w ? std::string() : w.error().message;
  };
  for (const double good : {1e-6, 1.0, 1e4}) EXPECT_EQ(refused(good, Precision::single_precision), "");
  for (const double good : {1e-9, 1.0, 1e9}) EXPECT_EQ(refused(good, Precision::double_precision), "");
  for (const double bad : {1e-9, 1e6})
    EXPECT_NE(refused(bad, Precision::single_precision).find("precision double"), std::string::npos) << bad;
  for (const double bad : {1e-12, 1e12}) EXPECT_NE(refused(bad, Precision::double_precision), "") << bad;
}

// Across 8 spacings of a periodic axis regions are at most 3 wide. A fixed body whose material asks for 8 read sites
// outside the lattice, a crash, as soon as a free body made the World build regions.
TEST(Extremes, FixedBodiesOfWideRegionsFitAPeriodicAxis) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.domain.bounded = true;
  d.domain.max = {1.6, 1.6, 8.0};
  d.domain.faces[0] = d.domain.faces[1] = Face::periodic;
  Result<World> w = World::create(d);
  require(w);
  MaterialDesc wide, narrow;
  wide.name = "wide";
  wide.region_half_width = 8;
  wide.youngs_modulus = 1e5;  // room around the body is then as wide as the domain allows
  narrow.name = "narrow";
  const Result<MaterialId> of_fixed = w->add_material(wide), of_free = w->add_material(narrow);
  require(of_fixed);
  require(of_free);
  SolidDesc block;
  block.material = *of_fixed;  // the first in the lattice: nothing is before its sites
  block.motion = Motion::fixed;
  block.shape = Shape::box({0.2, 0.2, 0.2}, {1.4, 0.8, 3.8});
  require(w->add_solid(block));
  block.material = *of_free;
  block.motion = Motion::free;
  block.shape = Shape::box({0.2, 0.2, 4.2}, {1.4, 0.8, 4.8});
  require(w->add_solid(block));
  const auto totals = w->totals();
  require(totals);
  require(w->step(1e-4));
  EXPECT_FALSE(w->synchronize().halted);
}

// Twelve sound speeds, so that the digits of the message are rounded both ways.
TEST(Extremes, TheStepThatIsAdvisedIsTaken) {
  MELTSIM_NEEDS_BACKEND();
  for (int k = 0; k < 12; ++k) {
    Tank t;
    t.desc.sound_speed = 60 + 1.37 * k;
    Result<World> w = t.make();
    require(w);
    const Status s = w->step(10);
    ASSERT_FALSE(s);
    EXPECT_EQ(s.error().code, ErrorCode::step_too_large);
    const double advised = number_after(s.error().message, "step by at most ");
    EXPECT_GT(advised, 63 * w->resolved().stable_dt);
    require(w->step(advised));
  }
}

}  // namespace
}  // namespace meltsim_test
