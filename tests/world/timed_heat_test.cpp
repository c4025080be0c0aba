// SPDX-License-Identifier: Apache-2.0
// Heat through surfaces that depends on the time, or that a host changes while the World runs.
#include <cmath>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double dx = 0.1, side = 0.8, rho_c = 1e6, k = 1000, length_x = 1.6;

/// A fixed bar, 16 cells long, between walls at -x and +x.
WorldDesc bar_desc() {
  WorldDesc d = describe();
  d.precision = Precision::double_precision;
  d.spacing = dx;
  d.domain.bounded = true;
  d.domain.max = {length_x, side, side};
  d.domain.faces = {Face::wall, Face::wall, Face::periodic, Face::periodic, Face::periodic, Face::periodic};
  return d;
}
MaterialDesc substance() {
  MaterialDesc m;
  m.density = 1000;
  m.heat_capacity = rho_c / m.density;
  m.conductivity = k;
  return m;
}
World bar(const WorldDesc& d) {
  World w = *World::create(d);
  SolidDesc s;
  s.shape = Shape::box(d.domain.min, d.domain.max);
  s.material = *w.add_material(substance());
  s.temperature = 0;
  s.fixed = true;
  require(w.add_solid(s));
  return w;
}
/// A fixed cube of 4 cells in the open, 0.96 m^2 of surface.
constexpr double area = 6 * 0.4 * 0.4;
struct Cube {
  World world;
  BodyId body;
};
Cube cube(const SurfaceHeatDesc& surface) {
  WorldDesc d = describe();
  d.precision = Precision::double_precision;
  d.spacing = dx;
  World w = *World::create(d);
  SolidDesc s;
  s.shape = Shape::box({0, 0, 0}, {0.4, 0.4, 0.4});
  s.material = *w.add_material(substance());
  s.temperature = 0;
  s.fixed = true;
  s.surface = surface;
  const BodyId body = *w.add_solid(s);
  return {std::move(w), body};
}
void run(World& w, int steps, double dt) {
  for (int i = 0; i < steps; ++i) require(w.step(dt));
}

// A ramp and a fall, whose values in the middles of sub-steps add up to their integral: 1e-9 of rounding, as long as sub-steps end at the
// points, which those of 1 s do.
const std::vector<TimedValue> pulse{{2, 0}, {6, 1000}, {8, 0}};
constexpr double pulse_integral = 3000;

TEST(TimedHeat, FluxThroughAWallIsTheIntegralOfItsValues) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = bar_desc();
  d.domain.heat[0].flux_points = pulse;
  World w = bar(d);
  run(w, 12, 1);
  const double in = pulse_integral * side * side;
  EXPECT_NEAR(w.totals()->heat_in / in, 1, 1e-9);
  EXPECT_NEAR(w.totals()->thermal / in, 1, 1e-9);
}

TEST(TimedHeat, FluxIntoABodyIsTheIntegralOfItsValues) {
  MELTSIM_NEEDS_BACKEND();
  SurfaceHeatDesc s;
  s.flux_points = pulse;
  Cube c = cube(s);
  run(c.world, 12, 1);
  EXPECT_NEAR(c.world.totals()->heat_in / (pulse_integral * area), 1, 1e-9);
}

// Walls that warm at a rate r: once the start has died away, exp(-pi^2 alpha t/L^2) of it, the bar lags behind them by r L^2/(12 alpha) on
// average. At Fo = 1.5 the start is 4e-7 of itself; two walls of 16 cells are right to 1 % of that lag.
TEST(TimedHeat, ABarLagsBehindWallsThatWarmSteadily) {
  MELTSIM_NEEDS_BACKEND();
  const double alpha = k / rho_c, time = 1.5 * length_x * length_x / alpha, rate = 0.01;
  WorldDesc d = bar_desc();
  for (int face : {0, 1}) {
    d.domain.heat[static_cast<std::size_t>(face)].temperature = 0;
    d.domain.heat[static_cast<std::size_t>(face)].temperature_points = {{0, 0}, {2 * time, 2 * time * rate}};
  }
  World w = bar(d);
  run(w, 300, time / 300);
  const auto p = *w.particles();
  double mean = 0;
  for (const double t : p.temperature) mean += t / static_cast<double>(p.id.size());
  EXPECT_NEAR((rate * time - mean) / (rate * length_x * length_x / (12 * alpha)), 1, 0.01);
}

// A lump in an oven that warms at a rate r, Bi = 0.004: T = r (t - tau (1 - exp(-t/tau))), tau = rho c V/(h A). A hundredth of the lag, for
// what the inside lags behind its surface (Bi/3) and for steps of tau/40.
TEST(TimedHeat, ALumpFollowsItsOven) {
  MELTSIM_NEEDS_BACKEND();
  SurfaceHeatDesc s;
  s.convection = 20;
  s.ambient = 0;
  const double tau = rho_c * 0.064 / (20 * area), rate = 100 / tau;
  s.temperature_points = {{0, 0}, {10 * tau, 1000}};
  Cube c = cube(s);
  run(c.world, 80, tau / 40);
  const double t = 2 * tau, exact = rate * (t - tau * (1 - std::exp(-2.0)));
  EXPECT_NEAR(c.world.totals()->thermal / (rho_c * 0.064) / exact, 1, 0.01);
}

// What is set is as if it had been built so, and counts wherever the state comes from.
TEST(TimedHeat, AHostChangesTheHeatOfABody) {
  MELTSIM_NEEDS_BACKEND();
  SurfaceHeatDesc hot, off;
  hot.flux = 500;
  Cube built = cube(hot), set = cube(off);
  run(set.world, 2, 1);  // no heat flows, and nothing of it is there
  EXPECT_EQ(set.world.totals()->heat_in, 0);
  require(set.world.set_body_heat(set.body, hot));
  run(built.world, 4, 1);
  run(set.world, 4, 1);
  const double in = 500 * area * 4;
  EXPECT_NEAR(built.world.totals()->heat_in / in, 1, 1e-9);
  EXPECT_NEAR(set.world.totals()->heat_in / in, 1, 1e-9);
  require(set.world.save_state(0));
  const auto snapshot = *set.world.snapshot();
  require(set.world.set_body_heat(set.body, off, 2000));
  for (const bool saved : {true, false}) {
    if (saved) require(set.world.load_state(0));
    else require(set.world.restore(snapshot.data(), snapshot.size()));
    run(set.world, 3, 1);
    EXPECT_NEAR(set.world.totals()->heat_in, in + 2000 * 0.064 * 3, 1e-6) << saved;
  }
  require(set.world.set_body_heat(set.body, off));
  run(set.world, 3, 1);
  EXPECT_NEAR(set.world.totals()->heat_in, in + 2000 * 0.064 * 3, 1e-6);
}

// Where it is follows from the time alone.
TEST(TimedHeat, GoesOnFromASnapshotWithTheSameBits) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = bar_desc();
  d.domain.heat[0].flux_points = pulse;
  World w = bar(d);
  run(w, 4, 1);
  const auto state = *w.snapshot();
  const auto saved = *w.save();
  run(w, 4, 1);
  const std::uint64_t hash = *w.state_hash();
  require(w.restore(state.data(), state.size()));
  run(w, 4, 1);
  EXPECT_EQ(*w.state_hash(), hash);
  World other = bar(d);
  require(other.load_saved(saved.data(), saved.size()));
  run(other, 4, 1);
  EXPECT_EQ(*other.state_hash(), hash);
}

TEST(TimedHeat, RefusesWhatCannotBeAndChangesNothing) {
  MELTSIM_NEEDS_BACKEND();
  SurfaceHeatDesc s;
  s.flux = 500;
  Cube c = cube(s), other = cube(s);
  run(c.world, 2, 1);
  const std::uint64_t hash = *c.world.state_hash();
  const auto refused = [](const auto& r, const std::string& part) {
    ASSERT_FALSE(r) << part;
    EXPECT_EQ(r.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(r.error().message.find(part), std::string::npos) << r.error().message;
  };
  const auto with = [](std::vector<TimedValue> temperature, std::vector<TimedValue> flux) {
    SurfaceHeatDesc x;
    x.convection = 10;
    x.temperature_points = std::move(temperature);
    x.flux_points = std::move(flux);
    return x;
  };
  refused(c.world.set_body_heat(other.body, s), "no body of this World");
  refused(c.world.set_body_heat(c.body, s, std::nan("")), "source: must be finite");
  refused(c.world.set_body_heat(c.body, with({{1, 0}, {1, 5}}, {})),
          "surface.temperature_points: point 1 is at 1 s");
  refused(c.world.set_body_heat(c.body, with({{1, -300}}, {})), "temperature_points");
  refused(c.world.set_body_heat(c.body, with({}, {{0, infinity}})), "surface.flux_points: point 0");
  SurfaceHeatDesc held;
  held.temperature = 5;
  held.flux_points = pulse;
  refused(c.world.set_body_heat(c.body, held), "a held surface takes no flux");
  refused(c.world.set_wall_heat(0, with({}, std::vector<TimedValue>((1u << 16) + 1))),
          "at most 65536 points");
  EXPECT_EQ(*c.world.state_hash(), hash);
  run(c.world, 2, 1);
  EXPECT_NEAR(c.world.totals()->heat_in / (500 * area * 4), 1, 1e-9);
}

}  // namespace
}  // namespace meltsim_test
