// SPDX-License-Identifier: Apache-2.0
// Bad input: an Error that names the field, and a World that is as it was.
#include <cmath>
#include <limits>
#include <string>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

const double nan = std::numeric_limits<double>::quiet_NaN();
const double inf = std::numeric_limits<double>::infinity();

template <class R>
void expect_error(const R& r, const std::string& field) {
  ASSERT_FALSE(r) << "accepted, though " << field << " is bad";
  EXPECT_NE(r.error().message.find(field), std::string::npos) << r.error().message;
}

TEST(Errors, WorldDescriptions) {
  const auto with = [](auto change) {
    WorldDesc d;
    d.backend = Backend::cpu;
    change(d);
    return World::create(d);
  };
  for (const double bad : {0.0, -1.0, nan, inf}) {
    expect_error(with([&](WorldDesc& d) { d.spacing = bad; }), "spacing");
    if (bad != 0.0) {
      expect_error(with([&](WorldDesc& d) { d.support_radius = bad; }), "support_radius");
      expect_error(with([&](WorldDesc& d) { d.sound_speed = bad; }), "sound_speed");
      expect_error(with([&](WorldDesc& d) { d.heat.time_scale = bad; }), "time_scale");
      expect_error(with([&](WorldDesc& d) { d.artificial_viscosity = bad; }), "artificial_viscosity");
    }
    expect_error(with([&](WorldDesc& d) { d.courant = bad; }), "courant");
  }
  expect_error(with([](WorldDesc& d) { d.gravity.y = nan; }), "gravity");
  expect_error(with([](WorldDesc& d) { d.particle_shifting = true; }), "needs tension");
  expect_error(with([](WorldDesc& d) { d.viscosity = static_cast<Viscosity>(7); }),
               "viscosity: is no Viscosity, got 7; automatic is the default");
  expect_error(with([](WorldDesc& d) { d.backend = static_cast<Backend>(7); }),
               "backend: is no Backend, got 7");
  expect_error(with([](WorldDesc& d) { d.precision = static_cast<Precision>(-1); }),
               "precision: is no Precision, got -1; single_precision is the default");
  expect_error(with([](WorldDesc& d) { d.neighbour_search = static_cast<NeighbourSearch>(7); }),
               "neighbour_search: is no");
  expect_error(with([](WorldDesc& d) { d.heat.model = static_cast<HeatModel>(7); }),
               "heat.model: is no HeatModel");
  expect_error(with([](WorldDesc& d) { d.domain.faces[3] = static_cast<Face>(3); }),
               "domain.faces: is no Face, got 3");
  expect_error(with([](WorldDesc& d) { d.support_radius = 1.4 * d.spacing; }), "1.5");
  expect_error(with([](WorldDesc& d) { d.support_radius = 6.01 * d.spacing; }), "1.5..6 spacings");
  for (const double spacing : {0.1, 0.2, 0.3, 0.7})
    for (const double ratio : {1.5, 6.0})  // 6 * 0.2 is above 6 spacings by a bit, 1.5 * 0.7 below
      EXPECT_TRUE(with([&](WorldDesc& d) {
        d.spacing = spacing;
        d.support_radius = ratio * spacing;
      })) << ratio
          << " x " << spacing;
  expect_error(with([](WorldDesc& d) { d.domain.bounded = true; }), "domain.max");
  expect_error(with([](WorldDesc& d) {
                 d.domain.bounded = true;
                 d.domain.max = {0.9, 5, 5};  // two supports are 1.0
               }),
               "support radii");
  expect_error(with([](WorldDesc& d) {
                 d.domain.bounded = true;
                 d.domain.max = {5, 5, 5};
                 d.domain.faces[0] = Face::periodic;
               }),
               "periodic");
  expect_error(with([](WorldDesc& d) { d.max_substeps = 0; }), "max_substeps");
  expect_error(with([](WorldDesc& d) { d.header_version = 90000; }), "header_version");
  expect_error(World::create(describe(), 90000), "header_version: compiled against 90000");
  const auto other = World::create(describe(), MELTSIM_VERSION_NUMBER, layout_of_headers + 1);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, ErrorCode::version_mismatch);
  EXPECT_NE(other.error().message.find("rebuild it with the library's headers"), std::string::npos);
}

TEST(Errors, Materials) {
  auto w = World::create(describe());
  if (!w) GTEST_SKIP();
  const auto with = [&](auto change) {
    MaterialDesc m;
    m.name = "m";
    change(m);
    return w->add_material(m);
  };
  for (const double bad : {0.0, -2.0, nan, inf}) {
    expect_error(with([&](MaterialDesc& m) { m.density = bad; }), "density");
    expect_error(with([&](MaterialDesc& m) { m.heat_capacity = bad; }), "heat_capacity");
    expect_error(with([&](MaterialDesc& m) { m.conductivity = bad; }), "conductivity");
    if (bad == 0.0) continue;
    expect_error(with([&](MaterialDesc& m) { m.viscosity = bad; }), "viscosity");
    expect_error(with([&](MaterialDesc& m) { m.latent_heat = bad; }), "latent_heat");
    expect_error(with([&](MaterialDesc& m) { m.diffusivity = bad; }), "diffusivity");
    expect_error(with([&](MaterialDesc& m) {
                   m.conductivity_points = {{0, 1}, {50, bad}};
                 }),
                 "conductivity_points");
  }
  const auto water = *w->add_material({});
  expect_error(with([&](MaterialDesc& m) { m.melting_point = 0; }), "melts_into");
  expect_error(with([&](MaterialDesc& m) { m.melts_into = water; }), "melting_point");
  expect_error(with([&](MaterialDesc& m) {
                 m.melting_point = -300;
                 m.melts_into = water;
               }),
               "-273.15");
  expect_error(with([&](MaterialDesc& m) {
                 m.melting_point = 0;
                 m.melts_into = MaterialId{7, 1};
               }),
               "melts_into");
  expect_error(with([](MaterialDesc& m) { m.heat_capacity_points = {{10, 1000}, {10, 2000}}; }), "ascend");
  expect_error(with([](MaterialDesc& m) { m.density_points = {{10, 1000}}; }), "density_points");
  expect_error(with([&](MaterialDesc& m) {
                 m.melting_point = 0;
                 m.melts_into = water;
                 m.viscosity_points = {{0, 1}, {1, 2}};
               }),
               "viscosity_points");
  expect_error(with([&](MaterialDesc& m) {
                 m.conductivity_points = {{0, 1}, {1, 2}};
                 m.diffusivity = 1;
               }),
               "one of the two");
  expect_error(with([](MaterialDesc& m) { m.region_half_width = 9; }), "region_half_width");
  expect_error(with([](MaterialDesc& m) { m.stiffness = 0; }), "stiffness");
  for (const double bad : {-1.0, nan, inf})
    expect_error(with([&](MaterialDesc& m) { m.youngs_modulus = bad; }), "youngs_modulus");
  expect_error(with([](MaterialDesc& m) {
                 m.youngs_modulus = 1e6;
                 m.region_half_width = 0;  // loose particles have none
               }),
               "region_half_width");
  expect_error(w->add_material({}), "exists");  // "water" again
}

TEST(Errors, HeatThroughSurfaces) {
  const auto world = [](auto change) {
    WorldDesc d = describe();
    d.domain.bounded = true;
    d.domain.max = {2, 2, 2};
    change(d);
    return World::create(d);
  };
  expect_error(world([](WorldDesc& d) { d.domain.heat[2].temperature = -300; }),
               "domain.heat[-y].temperature");
  expect_error(world([](WorldDesc& d) { d.domain.heat[1].convection = -1; }), "domain.heat[+x].convection");
  expect_error(world([](WorldDesc& d) { d.heat.free_surface.temperature = 1e300; }),
               "heat.free_surface.temperature: must be at most 1e+15 degrees Celsius, got 1e+300");
  expect_error(world([](WorldDesc& d) { d.domain.heat[1].emissivity = 1.5; }), "emissivity");
  expect_error(world([](WorldDesc& d) { d.domain.heat[1].flux = nan; }), "flux");
  expect_error(world([](WorldDesc& d) {
                 d.domain.heat[1].flux = 1;
                 d.domain.heat[1].temperature = 1;
               }),
               "takes neither");
  expect_error(world([](WorldDesc& d) {
                 d.domain.heat[1].flux = 1;
                 d.domain.faces[1] = Face::open;
               }),
               "there is none at +x");
  expect_error(world([](WorldDesc& d) {
                 d.domain.heat[1].flux = 1;
                 d.heat.model = HeatModel::paper;
               }),
               "enthalpy");
  auto w = world([](WorldDesc&) {});
  if (!w) GTEST_SKIP();
  HeatRegionDesc r;
  r.shape = Shape::box({0, 0, 0}, {1, 1, 1});
  expect_error(w->add_heat_region(r), "source");
  r.source = 1;
  r.temperature = 1;
  expect_error(w->add_heat_region(r), "source");
  r.temperature.reset();
  r.until = 0;
  expect_error(w->add_heat_region(r), "until");
  r.until = infinity;
  ASSERT_TRUE(w->add_heat_region(r));
}

// K = 0: heat is on, temperatures differ, and not a bit changes.
TEST(Errors, NoDiffusivityIsNoOperation) {
  MELTSIM_NEEDS_BACKEND();
  auto w = *World::create(describe());
  MaterialDesc m;
  m.diffusivity = 0;
  const auto id = *w.add_material(m);
  for (const double t : {10.0, 50.0}) {
    SolidDesc s;
    s.fixed = true;
    s.material = id;
    s.temperature = t;
    s.shape = Shape::box({t / 10, 0, 0}, {t / 10 + 1, 1, 1});
    ASSERT_TRUE(w.add_solid(s));
  }
  const auto before = *w.state_hash();
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(w.step(1));
  EXPECT_EQ(before, *w.state_hash());
}

TEST(Errors, FluidsBodiesAndEmitters) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = ice_in_water(describe());
  const auto hash = *s.world.state_hash();
  FluidDesc f;
  f.material = s.water;
  expect_error(s.world.add_fluid(f), "shape");  // empty
  f.shape = Shape::box({0, 0, 0}, {9, 1, 1});
  expect_error(s.world.add_fluid(f), "domain");
  f.shape = Shape::box({0, 0, 0}, {1, 1, nan});
  expect_error(s.world.add_fluid(f), "shape");
  f.shape = Shape::box({0, 0, 0}, {1, 0.4, 1});
  expect_error(s.world.add_fluid(f), "taken");
  f.temperature = -300;
  expect_error(s.world.add_fluid(f), "temperature");
  f.temperature = 20;
  f.material = s.ice;
  expect_error(s.world.add_fluid(f), "solid");
  f.material = {};
  expect_error(s.world.add_fluid(f), "material");

  SolidDesc b;
  b.name = "block";
  b.material = s.ice;
  b.shape = Shape::box({0.2, 2, 0.2}, {0.6, 2.2, 0.6});
  expect_error(s.world.add_solid(b), "name");
  b.name = "other";
  b.shape = Shape::box({0.9, 1.3, 0.9}, {1.3, 1.7, 1.3});
  expect_error(s.world.add_solid(b), "overlaps body \"block\"");
  b.shape = Shape::box({2, 2, 2}, {2.6, 2.2, 2.2});
  expect_error(s.world.add_solid(b), "outside the domain");
  b.shape = Shape::box({0.2, 0.2, 0.2}, {0.6, 0.6, 0.6});
  b.carve = false;
  expect_error(s.world.add_solid(b), "carve");
  b.carve = true;
  b.velocity.x = inf;
  expect_error(s.world.add_solid(b), "velocity");
  b.velocity.x = 1;
  b.fixed = true;
  expect_error(s.world.add_solid(b), "fixed");
  b = SolidDesc{};
  b.material = s.ice;
  b.shape = Shape::sphere({1, 2, 1}, 0.01);
  expect_error(s.world.add_solid(b), "no lattice point");
  b.shape = Shape::box({0.2, 2, 0.2}, {0.6, 2.4, 0.6});
  b.motion = static_cast<Motion>(7);
  expect_error(s.world.add_solid(b), "motion: is no Motion, got 7; free is the default");
  b.motion = Motion::kinematic;
  for (const double far : {1e12, nan}) {  // a place reckoned from there would shake
    b.pivot = Vec3d{far, 0, 0};
    expect_error(s.world.add_solid(b), "pivot: must be within a thousand million spacings");
  }

  EmitterDesc e;
  e.material = s.water;
  e.center = {1.2, 2, 1.2};
  expect_error(s.world.add_emitter(e), "radius");
  e.radius = 0.3;
  expect_error(s.world.add_emitter(e), "max_particles");  // never ends
  e.until = 1;
  e.speed = 0;
  expect_error(s.world.add_emitter(e), "speed");
  e.speed = 2;
  e.center = {5, 5, 5};
  expect_error(s.world.add_emitter(e), "domain");
  EXPECT_EQ(*s.world.state_hash(), hash);
}

TEST(Errors, StepsOfEverySize) {
  MELTSIM_NEEDS_BACKEND();
  Scene s = ice_in_water(describe());
  const auto hash = *s.world.state_hash();
  expect_error(s.world.step(-1e-3), "dt");
  expect_error(s.world.step(nan), "dt");
  expect_error(s.world.step(inf), "dt");
  expect_error(s.world.step(1e3), "max_substeps");  // names the step that fits
  require(s.world.step(0));                         // a bitwise no-op
  EXPECT_EQ(*s.world.state_hash(), hash);
  EXPECT_EQ(s.world.steps(), 0u);
  require(s.world.step(1e-9));  // legal
  EXPECT_EQ(s.world.steps(), 1u);
  require(s.world.step(0.05));  // ten times the paper's: split into sub-steps
  EXPECT_GT(s.world.steps(), 5u);
  EXPECT_FALSE(s.world.synchronize().halted);
}

TEST(Errors, CoordinatesThatASingleCannotHoldAreRefusedOrShifted) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.2;
  auto far = World::create(d);
  ASSERT_TRUE(far);
  const auto water = *far->add_material({});
  FluidDesc f;
  f.material = water;
  // A small pool a thousand kilometres out: the origin moves there.
  f.shape = Shape::box({1e6, 1e6, 1e6}, {1e6 + 1, 1e6 + 1, 1e6 + 1});
  require(far->add_fluid(f));
  EXPECT_NEAR(far->resolved().origin.x, 1e6, 2.0);
  // A second one at zero would then be a thousand kilometres from the origin.
  f.shape = Shape::box({0, 0, 0}, {1, 1, 1});
  expect_error(far->add_fluid(f), "double");
}

/// A tank of water, 1 m, whose liquid falls 0.6 m onto the floor: 3.43 m/s.
Result<World> falling_water(double sound_speed, double viscosity, bool stone, Face floor) {
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.sound_speed = sound_speed;
  d.domain.bounded = true;
  d.domain.max = {1, 1, 1};
  d.domain.faces[2] = floor;
  auto w = World::create(d);
  require(w);
  MaterialDesc m;
  m.name = "water";
  m.viscosity = viscosity;
  FluidDesc f;
  f.material = *w->add_material(m);
  f.shape = Shape::box({0, 0, 0}, {1, 0.6, 1});
  require(w->add_fluid(f));
  if (!stone) return w;
  SolidDesc b;
  b.shape = Shape::box({0.4, 0.6, 0.4}, {0.6, 0.8, 0.6});
  MaterialDesc rock;
  rock.name = "rock";
  b.material = *w->add_material(rock);
  require(w->add_solid(b));
  return w;
}

TEST(Errors, SoundSlowerThanTheFallIsRefused) {
  MELTSIM_NEEDS_BACKEND();
  // Particles of the highest layer fall 0.55 m: sqrt(2 * 9.81 * 0.55) = 3.285 m/s.
  auto w = falling_water(3.0, 1e-3, false, Face::wall);
  const auto before = *w->state_hash();
  expect_error(w->prepare(), "sound_speed: 3 m/s is slower than what falls 0.55 m, 3.28");
  expect_error(w->step(1e-3), "use 32.8");
  EXPECT_EQ(*w->state_hash(), before);
  EXPECT_EQ(w->time(), 0.0);
  EXPECT_TRUE(w->totals());  // what reads works
  EXPECT_NE(w->resolved().error.find("sound_speed"), std::string::npos);
  EXPECT_TRUE(falling_water(3.3, 1e-3, false, Face::wall)->prepare());
  EXPECT_TRUE(falling_water(0, 1e-3, false, Face::wall)->prepare());
  // 9.81 * 0.55^2 / (2 nu): nu 0.5 m^2/s keeps it below 3 m/s (2.97), 0.49 does not (3.03); a stone on top falls all the same.
  EXPECT_TRUE(falling_water(3.0, 500, false, Face::wall)->prepare());
  expect_error(falling_water(3.0, 490, false, Face::wall)->prepare(), "0.55 m, 3.02");
  expect_error(falling_water(3.0, 500, true, Face::wall)->prepare(), "0.75 m, 3.83");
  // What leaves through the floor hits nothing.
  EXPECT_TRUE(falling_water(3.0, 1e-3, false, Face::open)->prepare());
}

TEST(Errors, DivergenceKeepsTheLastGoodStateAndNamesTheParticle) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.sound_speed = 5;
  d.gravity = {1000, 0, 0};
  auto w = World::create(d);
  ASSERT_TRUE(w);
  MaterialDesc m;
  m.name = "stone";
  const auto stone = *w->add_material(m);
  SolidDesc b;
  b.name = "bullet";
  b.shape = Shape::box({0, 0, 0}, {0.6, 0.6, 0.6});
  b.material = stone;
  require(w->add_solid(b));
  for (int k = 0; k < 60; ++k) require(w->step(1e-3));  // 60 m/s
  const auto good = *w->state_hash();
  const double time = w->time();
  require(w->step(8.9e-3));           // 0.57 m in one sub-step, H is 0.5: crosses its neighbourhood
  require(w->step(8.9e-3));           // enqueued behind it, does nothing
  EXPECT_EQ(*w->state_hash(), good);  // reads the good one of two buffers before anyone was told
  EXPECT_FALSE(w->step(8.9e-3));      // and finds out in doing so
  EXPECT_EQ(*w->state_hash(), good);
  const StepResult r = w->synchronize();
  EXPECT_TRUE(r.halted);
  EXPECT_NE(r.halt_reason.find("bullet"), std::string::npos) << r.halt_reason;
  EXPECT_NE(r.halt_reason.find("sub-step 61"), std::string::npos) << r.halt_reason;
  EXPECT_EQ(*w->state_hash(), good);
  EXPECT_EQ(w->time(), time);
  EXPECT_EQ(r.steps, 60u);
  const Status s = w->step(0.01);
  ASSERT_FALSE(s);
  EXPECT_EQ(s.error().code, ErrorCode::halted);
}

// The ledger is of the last good state, whichever of two buffers that is in; rotations are written in every sub-step.
TEST(Errors, DivergenceKeepsLedgerAndRotations) {
  MELTSIM_NEEDS_BACKEND();
  for (int steps = 60; steps <= 63; ++steps) {
    WorldDesc d = describe();
    d.sound_speed = 5;
    d.gravity = {1000, 0, 0};
    auto w = World::create(d);
    ASSERT_TRUE(w);
    SolidDesc b;
    b.shape = Shape::box({0, 0, 0}, {0.6, 0.6, 0.6});
    b.material = *w->add_material({});
    b.angular_velocity = {0, 0, 20};
    require(w->add_solid(b));
    for (int k = 0; k < steps; ++k) require(w->step(1e-3));
    const auto good = *w->state_hash();
    const Ledger before = *w->ledger();
    EXPECT_EQ(before.step, static_cast<std::uint64_t>(steps));
    EXPECT_GT(before.kinetic, 0.0);
    EXPECT_NE(before.momentum.x, 0.0);
    for (int k = 0; k < 3; ++k) {
      require(w->step(8.9e-3));
      const Ledger after = *w->ledger();
      EXPECT_EQ(after.step, before.step);
      EXPECT_EQ(after.mass, before.mass);
      EXPECT_EQ(after.momentum.x, before.momentum.x);
      EXPECT_EQ(after.angular_momentum.z, before.angular_momentum.z);
      EXPECT_EQ(after.kinetic, before.kinetic);
      EXPECT_EQ(after.thermal, before.thermal);
    }
    EXPECT_TRUE(w->synchronize().halted);
    EXPECT_EQ(*w->state_hash(), good);
    EXPECT_EQ(w->ledger()->kinetic, before.kinetic);
  }
}

// A stage of the host's that writes nonsense: a particle at no place is near nobody, so no sum shows it for sure. On CUDA:
// tests/gpu/interop_test.cu.
TEST(Errors, APositionThatIsNoNumberHalts) {
  MELTSIM_NEEDS_BACKEND();
  if (backend() == Backend::cuda) GTEST_SKIP() << "the stage below runs on the host";
  WorldDesc d = describe();
  d.precision = Precision::double_precision;
  auto w = World::create(d);
  ASSERT_TRUE(w);
  FluidDesc f;
  f.material = *w->add_material({});
  f.shape = Shape::box({0, 0, 0}, {0.6, 0.6, 0.6});
  require(w->add_fluid(f));
  require(w->step(1e-4));
  const auto good = *w->state_hash();
  CustomStage stage;
  stage.name = "spoil";
  stage.writes = {"position"};
  stage.run = [](const StageContext& c, void*) {
    static_cast<Vec4<double>*>(c.position)[0].y = std::numeric_limits<double>::quiet_NaN();
  };
  require(w->scheduler().insert_after("spatial.neighbours", stage));  // the last of the search
  require(w->step(1e-4));
  const StepResult r = w->synchronize();
  EXPECT_TRUE(r.halted);
  EXPECT_NE(r.halt_reason.find("position is not finite"), std::string::npos) << r.halt_reason;
  EXPECT_EQ(*w->state_hash(), good);
}

/// Behind which stage a host's writes what is no number, where, and of which particles.
struct Nonsense {
  const char* after;
  const char* where;
  std::uint32_t tag;  ///< of its particles
};

void write_nonsense(const StageContext& c, void* user) {
  const Nonsense& n = *static_cast<const Nonsense*>(user);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string where = n.where;
  for (std::uint64_t i = 0; i < c.particles; ++i) {
    if ((c.tag[i] & (tag_fixed | tag_removed)) != n.tag || !((c.tag[i] & tag_solid) != 0u)) continue;
    if (where == "velocity") static_cast<Vec4<double>*>(c.velocity)[i].y = nan;
    if (where == "position") static_cast<Vec4<double>*>(c.position)[i].y = nan;
    if (where == "volume") static_cast<Vec4<double>*>(c.position)[i].w = nan;
  }
}

/// A free body, one that does not move, and one that was removed.
World three_bodies() {
  WorldDesc d = describe();
  d.precision = Precision::double_precision;
  World w = std::move(*World::create(d));
  SolidDesc b;
  b.material = *w.add_material({});
  b.shape = Shape::box({0, 0.4, 0}, {0.6, 1.0, 0.6});
  require(w.add_solid(b));
  b.shape = Shape::box({2, 0.4, 0}, {2.6, 1.0, 0.6});
  const auto gone = w.add_solid(b);
  require(gone);
  b.motion = Motion::fixed;
  b.shape = Shape::box({1, 0.4, 0}, {1.6, 1.0, 0.6});
  require(w.add_solid(b));
  require(w.step(1e-4));
  require(w.remove(*gone));
  require(w.step(1e-4));
  return w;
}

// The sub-step does not count, also where nothing would have moved the particle and no sum have shown it; behind the check the state cannot
// be kept, and the next sub-step halts.
TEST(Errors, WhatAStageWritesOfParticlesThatDoNotMoveIsChecked) {
  MELTSIM_NEEDS_BACKEND();
  if (backend() == Backend::cuda) GTEST_SKIP() << "the stage below runs on the host";
  for (const char* after : {"spatial.neighbours", "step.integrate"})
    for (const char* where : {"velocity", "position", "volume"})
      for (const std::uint32_t tag : {0u, tag_fixed, tag_removed}) {
        SCOPED_TRACE(std::string(after) + ", " + where + ", tag " + std::to_string(tag));
        Nonsense n{after, where, tag};
        World w = three_bodies();
        const auto good = *w.state_hash();
        CustomStage stage;
        stage.name = "spoil";
        stage.run = write_nonsense;
        stage.user = &n;
        stage.writes = {"position", "velocity"};
        require(w.scheduler().insert_after(after, stage));
        require(w.step(1e-4));
        if (std::string(after) == "step.integrate") {
          EXPECT_FALSE(w.synchronize().halted);
          expect_error(w.snapshot(), where);
          expect_error(w.save(), where);
          require(w.step(1e-4));
          EXPECT_TRUE(w.synchronize().halted);
          continue;
        }
        const StepResult r = w.synchronize();
        EXPECT_TRUE(r.halted);
        EXPECT_NE(r.halt_reason.find(where), std::string::npos) << r.halt_reason;
        EXPECT_EQ(*w.state_hash(), good);
        const auto bytes = w.snapshot();
        require(bytes);
        EXPECT_TRUE(w.restore(bytes->data(), bytes->size()));
      }
}

// What one World made is no name for what another has at that place; a bare index is.
TEST(Errors, MaterialsOfAnotherWorldAreRefused) {
  WorldDesc d;
  d.backend = Backend::cpu;
  World one = *World::create(d), other = *World::create(d);
  MaterialDesc liquid;
  const MaterialId foreign = *one.add_material(liquid), own = *other.add_material(liquid);
  EXPECT_NE(foreign, own);
  FluidDesc f;
  f.shape = Shape::box({0, 0, 0}, {0.4, 0.4, 0.4});
  f.material = own;
  require(other.add_fluid(f));
  const std::uint64_t before = *other.state_hash();
  f.shape = Shape::box({1, 0, 0}, {1.4, 0.4, 0.4});
  f.material = foreign;
  expect_error(other.add_fluid(f), "material");
  SolidDesc b;
  b.shape = f.shape;
  b.material = foreign;
  expect_error(other.add_solid(b), "material");
  EmitterDesc e;
  e.material = foreign;
  e.radius = 0.5;
  expect_error(other.add_emitter(e), "material");
  expect_error(other.set_material(foreign, liquid), "of this World");
  MaterialDesc ice;
  ice.name = "ice";
  ice.melting_point = 0;
  ice.melts_into = foreign;
  expect_error(other.add_material(ice), "melts_into");
  MaterialDesc salt;
  salt.name = "salt";
  salt.dissolves_in = foreign;
  salt.diffusivity_in = 1e-9;
  expect_error(other.add_material(salt), "dissolves_in");
  EXPECT_EQ(*other.state_hash(), before);
  f.material = MaterialId{0, 1};
  EXPECT_TRUE(other.add_fluid(f));
}

}  // namespace
}  // namespace meltsim_test
