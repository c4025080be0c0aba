// SPDX-License-Identifier: Apache-2.0
// Steps of heat that several sub-steps share; the sound speed from a density error.
#include <cmath>
#include <string>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double dx = 0.1, flux = 500;  // W/m^2
constexpr Vec3d box{1, 1, 1};
constexpr int substeps = 8;

WorldDesc tank_desc(int interval) {
  WorldDesc d = describe();
  d.precision = Precision::double_precision;
  d.spacing = dx;
  d.domain.bounded = true;
  d.domain.max = box;
  d.domain.heat[2].flux = flux;  // through the floor
  d.gravity = {0, 0, 0};         // at rest, particles serve the areas that they were sampled with
  d.sound_speed = 10;
  d.heat.interval = interval;
  return d;
}

/// A tank full of water at rest.
World tank(const WorldDesc& d) {
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  FluidDesc f;
  f.material = *w->add_material({});
  f.shape = Shape::box({0, 0, 0}, box);
  require(w->add_fluid(f));
  require(w->prepare());
  return std::move(*w);
}

double step_of(World& w) { return 0.999 * substeps * w.resolved().stable_dt; }

// However sub-steps divide by the interval, every step ends with all of its heat: what comes through a wall of 1 m^2 is flux
// times time, but for rounding of a thousand sums.
TEST(HeatInterval, NoHeatIsOwedAtTheEndOfAStep) {
  MELTSIM_NEEDS_BACKEND();
  for (const int interval : {1, 2, 3, 7, 8, 100}) {
    World w = tank(tank_desc(interval));
    const double dt = step_of(w);
    for (int k = 1; k <= 3; ++k) {
      require(w.step(dt));
      EXPECT_NEAR(w.ledger()->heat_in, flux * dt * k, 1e-10 * flux * dt * k) << interval;
    }
    EXPECT_EQ(w.synchronize().steps, 3u * substeps);
  }
}

// Three of eight sub-steps: the interval of eight has no heat yet. What is owed comes with the next step, also from a snapshot.
TEST(HeatInterval, AStepThatIsBrokenOffOwesItsHeat) {
  MELTSIM_NEEDS_BACKEND();
  World w = tank(tank_desc(100));
  const double dt = step_of(w);
  const auto part = w.step_part(dt, 3);
  require(part);
  EXPECT_EQ(w.ledger()->heat_in, 0);
  const auto bytes = *w.snapshot();
  require(w.step(dt));
  const double due = flux * (dt + part->simulated);
  EXPECT_NEAR(w.ledger()->heat_in, due, 1e-10 * due);
  World other = tank(tank_desc(100));
  require(other.restore(bytes.data(), bytes.size()));
  require(other.step(dt));
  EXPECT_EQ(*other.state_hash(), *w.state_hash());
  require(w.restore(bytes.data(), bytes.size()));
  require(w.save_state(0));
  require(w.step(dt));
  const std::uint64_t hash = *w.state_hash();
  require(w.load_state(0));
  require(w.step(dt));
  EXPECT_EQ(*w.state_hash(), hash);
}

// One sub-step of eight at a time, as a host without time takes them: heat comes with every fourth.
TEST(HeatInterval, AStarvedWorldIsHeated) {
  MELTSIM_NEEDS_BACKEND();
  World w = tank(tank_desc(4));
  const double dt = step_of(w);
  for (int k = 0; k < 12; ++k) require(w.step_part(dt, 1));
  const double due = flux * 12 * dt / substeps;
  EXPECT_NEAR(w.ledger()->heat_in, due, 1e-10 * due);
}

// A cosine along x decays as exp(-alpha (pi/L)^2 t) between insulated walls, here to 0.64 in 160 sub-steps. Ten layers and the
// first order of a single stage leave 1 %.
TEST(HeatInterval, ADecayIsRightWithAndWithoutSharing) {
  MELTSIM_NEEDS_BACKEND();
  const auto amplitude = [](int interval) {
    WorldDesc d = tank_desc(interval);
    d.domain.heat[2].flux = 0;
    d.heat.time_scale = 2e5;
    auto made = World::create(d);
    EXPECT_TRUE(made) << made.error().message;
    World w = std::move(*made);
    const auto water = *w.add_material({});
    for (int k = 0; k < 10; ++k) {
      FluidDesc f;
      f.material = water;
      f.temperature = 20 + 10 * std::cos(3.14159265358979 * (k + 0.5) / 10);
      f.shape = Shape::box({k * dx, 0, 0}, {(k + 1) * dx, 1, 1});
      require(w.add_fluid(f));
    }
    require(w.prepare());
    for (int k = 0; k < 20; ++k) require(w.step(step_of(w)));
    double sum = 0;
    const ParticleData p = *w.particles();
    for (std::size_t i = 0; i < p.position.size(); ++i)
      sum += (p.temperature[i] - 20) * std::cos(3.14159265358979 * p.position[i].x);
    const double diffusivity = 0.6 / (1000 * 4186.0), pi = 3.14159265358979;
    return 2 * sum / (10 * double(p.position.size())) /
           std::exp(-diffusivity * d.heat.time_scale * pi * pi * w.synchronize().time);
  };
  EXPECT_NEAR(amplitude(1), 1, 0.01);
  EXPECT_NEAR(amplitude(8), 1, 0.01);
}

// Two stages are enough: water at 0.1 m conducts so slowly that four sub-steps share heat; 1e7 times as fast it does not. The default does not share.
TEST(HeatInterval, IsChosenFromWhatASubStepConducts) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = tank_desc(0);
  World slow = tank(d);
  EXPECT_EQ(slow.resolved().heat_interval, 4);
  EXPECT_EQ(slow.resolved().heat_stages, 1);
  for (const StageReport& r : slow.plan().stages)
    if (r.name == "thermal.exchange") {
      EXPECT_EQ(r.interval, 4);
    }
  d.heat.time_scale = 1e7;
  World fast = tank(d);
  EXPECT_EQ(fast.resolved().heat_interval, 1);
  WorldDesc usual = tank_desc(HeatDesc{}.interval);
  World asked = tank(usual);
  EXPECT_EQ(asked.resolved().heat_interval, 1);
}

// A probe of heat reads what a sub-step brings over its length.
TEST(HeatInterval, AProbeOfHeatReadsEverySubStep) {
  MELTSIM_NEEDS_BACKEND();
  World w = tank(tank_desc(0));
  ProbeDesc probe;
  probe.name = "floor";
  probe.kind = ProbeKind::heat;
  probe.wall = 2;  // by default one sample in every sub-step
  require(w.add_probe(probe));
  require(w.step(step_of(w)));
  EXPECT_EQ(w.resolved().heat_interval, 1);
  const auto series = *w.take_samples();
  ASSERT_EQ(series.size(), 1u);
  for (const double watts : series[0].values) EXPECT_NEAR(watts, flux, 1e-6 * flux);
}

TEST(HeatInterval, IceMeltsAsItDoesWithHeatInEverySubStep) {
  MELTSIM_NEEDS_BACKEND();
  const auto melted_at = [](int interval) {
    WorldDesc d = describe();
    d.heat.interval = interval;
    IceScene s;
    s.time_scale = 2e5;
    Scene scene = ice_in_water(d, s);
    const int most = 4000;
    int k = 0;
    while (k < most && scene.world.synchronize().solid > 0) {
      require(scene.world.step(0.01));
      ++k;
    }
    EXPECT_LT(k, most);
    return k * 0.01;
  };
  const double one = melted_at(1), shared = melted_at(0);
  EXPECT_NEAR(shared, one,
              0.1 * one);  // 27 particles in waves of its own making: the last one leaves by chance
}

// g h/c^2 at the floor; ten layers of half a spacing each are 0.95 m deep.
TEST(DensityError, SetsTheSoundSpeed) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = tank_desc(0);
  d.gravity = {0, -9.81, 0};
  d.sound_speed = 0;
  World usual = tank(d);
  d.density_error = 0.02;
  World soft = tank(d);
  d.density_error = 0.005;
  World same = tank(d);
  EXPECT_NEAR(soft.resolved().sound_speed, usual.resolved().sound_speed / 2, 1e-9);
  EXPECT_EQ(same.resolved().sound_speed, usual.resolved().sound_speed);
  EXPECT_NEAR(soft.resolved().stable_dt, 2 * usual.resolved().stable_dt, 1e-9);
}

TEST(DensityError, BadInputNamesTheField) {
  MELTSIM_NEEDS_BACKEND();
  const auto refused = [](const WorldDesc& d, const char* words) {
    const auto w = World::create(d);
    ASSERT_FALSE(w) << words;
    EXPECT_EQ(w.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(w.error().message.find(words), std::string::npos) << w.error().message;
  };
  WorldDesc d = tank_desc(0);
  d.sound_speed = 0;
  d.density_error = 0.5;
  refused(d, "density_error: must be in 1e-05..0.1");
  d.density_error = std::nan("");
  refused(d, "density_error: must be in 1e-05..0.1");
  d.density_error = 0.01;
  d.sound_speed = 30;
  refused(d, "density_error: a sound_speed of 30 m/s is set, which decides; drop one of them");
  d = tank_desc(-1);
  refused(d, "heat.interval: must be in 0..1000 sub-steps, got -1");
}

}  // namespace
}  // namespace meltsim_test
