// SPDX-License-Identifier: Apache-2.0
// Melting over a range of temperatures: profiles against the similarity solution, mixtures against calorimetry, and where a
// particle changes its phase.
#include <cmath>
#include <limits>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double dx = 0.1, side = 8 * dx, capacity = 1000, rho = 1000, diffusivity = 1e-3;
constexpr double time_scale = 1e9;  // heat alone: what has melted stays where it is
constexpr double begin = 0, range = 40, latent = 1e5;

MaterialDesc substance(const char* name) {
  MaterialDesc m;
  m.name = name;
  m.density = rho;
  m.heat_capacity = capacity;
  m.conductivity = diffusivity * rho * capacity;
  return m;
}

MaterialDesc alloy(MaterialId melt) {
  MaterialDesc m = substance("alloy");
  m.melting_point = begin;
  m.melting_range = range;
  m.latent_heat = latent;
  m.melts_into = melt;
  return m;
}

World bar(double from, double to) {
  WorldDesc d = describe();
  d.spacing = dx;
  d.gravity = {0, 0, 0};
  d.sound_speed = 1;
  d.heat.time_scale = time_scale;
  d.domain.bounded = true;
  d.domain.min = {from, 0, 0};
  d.domain.max = {to, side, side};
  d.domain.faces = {Face::open, Face::open, Face::periodic, Face::periodic, Face::periodic, Face::periodic};
  return *World::create(d);
}

SolidDesc block(MaterialId material, double from, double to, double temperature) {
  SolidDesc s;
  s.shape = Shape::box({from, 0, 0}, {to, side, side});
  s.material = material;
  s.temperature = temperature;
  s.fixed = true;
  return s;
}

// Two half-spaces, x < 0 at `hot` and never molten, x > 0 an alloy at `cold`, all of one conductivity and capacity. Its melt is warmer
// than `begin + range`, left of x = 2 l sqrt(alpha t); solid is right of 2 s sqrt(alpha t). In between the capacity is c + L/range,
// the diffusivity smaller by r^2. T is a + b erf(xi) in each, xi = x / (2 sqrt(alpha t)), in between of r xi; it and its
// slope are continuous at both ends. (Carslaw & Jaeger 1959, sec. 11.2, with three regions; no latent heat is set free at either
// end, as the liquid fraction is 1 and 0 there.)
struct Similarity {
  double hot, cold, l = 0, s = 0;
  double r = std::sqrt(1 + latent / range / capacity);

  double end_of_melt(double at) const {  // s that makes the slopes equal at l
    const double slope = (hot - begin - range) / (1 + std::erf(at)) * std::exp(-at * at);
    const double width = range * r * std::exp(-r * r * at * at) / slope, to = std::erf(r * at) + width;
    double low = at, high = 10;
    if (to >= 1) return high;
    for (int k = 0; k < 200; ++k) (std::erf(r * 0.5 * (low + high)) < to ? low : high) = 0.5 * (low + high);
    return low;
  }
  /// Slope of the solid less that of the mush at s: falls with l.
  double mismatch(double at) const {
    const double to = end_of_melt(at);
    const double mush = range * r * std::exp(-r * r * to * to) / (std::erf(r * to) - std::erf(r * at));
    return (begin - cold) * std::exp(-to * to) / std::erfc(to) - mush;
  }
  Similarity(double hot_, double cold_) : hot(hot_), cold(cold_) {
    double low = -3, high = 3;
    for (int k = 0; k < 200; ++k) (mismatch(0.5 * (low + high)) < 0 ? low : high) = 0.5 * (low + high);
    l = low;
    s = end_of_melt(l);
  }
  double operator()(double xi) const {
    const double end = begin + range;
    if (xi < l) return hot - (hot - end) * (1 + std::erf(xi)) / (1 + std::erf(l));
    if (xi > s) return cold + (begin - cold) * std::erfc(xi) / std::erfc(s);
    return end - range * (std::erf(r * xi) - std::erf(r * l)) / (std::erf(r * s) - std::erf(r * l));
  }
};

// The diffusion length is 12 spacings, that of the mush 6: a relative error of second order in a spacing over it, 1/36 of what bends
// the profile there, a tenth of all, in the L2 norm: 2e-3.
TEST(MeltingRange, ABarFollowsTheSimilaritySolution) {
  MELTSIM_NEEDS_BACKEND();
  constexpr int half = 52;
  World world = bar(-half * dx, half * dx);
  const MaterialId melt = *world.add_material(substance("melt"));
  const MaterialId solid = *world.add_material(alloy(melt)), iron = *world.add_material(substance("iron"));
  const double hot = 200, cold = -60;
  require(world.add_solid(block(iron, -half * dx, 0, hot)));
  require(world.add_solid(block(solid, 0, half * dx, cold)));
  const double dt = 2 * dx * dx / diffusivity;
  constexpr int steps = 72;
  for (int k = 0; k < steps; ++k) require(world.step(dt / time_scale));
  const StepResult r = world.synchronize();
  ASSERT_FALSE(r.halted) << r.halt_reason;
  const Similarity exact(hot, cold);
  ASSERT_GT(exact.l, 0.05);  // some is wholly molten
  const ParticleData p = *world.particles();
  double error = 0, norm = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    const double t = exact(p.position[i].x / (2 * std::sqrt(diffusivity * dt * steps)));
    error += std::pow(p.temperature[i] - t, 2);
    norm += std::pow(t - cold, 2);
  }
  EXPECT_LT(std::sqrt(error / norm), 2e-3);
  // Liquid by tag is what is liquid to the last: a layer when its middle is.
  const double molten = 2 * exact.l * std::sqrt(diffusivity * dt * steps) / dx;
  EXPECT_NEAR(double(r.fluid) / 64, molten, 1.0);
}

/// A closed tank in which everything comes to one temperature: where what it holds says, and how much of the alloy is liquid.
struct Mixed {
  double temperature = 0, fraction = 0, spread = 0, lost = 0;
  std::uint64_t liquid = 0, solid = 0;
};

Mixed mixed(World& world, MaterialId of, int steps) {
  const double before = world.totals()->thermal;
  for (int k = 0; k < steps; ++k) require(world.step(20 * dx * dx / diffusivity / time_scale));
  const StepResult r = world.synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  Mixed m;
  const Totals t = *world.totals();
  m.spread = t.temperature_max - t.temperature_min;
  m.lost = t.thermal - before;
  m.liquid = r.fluid;
  m.solid = r.solid;
  const ParticleData p = *world.particles();
  double n = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    m.temperature += p.temperature[i] / double(p.id.size());
    if (material_of(p.tag[i]) != of.index) continue;
    m.fraction += p.liquid_fraction[i];
    n += 1;
  }
  if (n > 0) m.fraction /= n;
  return m;
}

// As many particles of an alloy at -20 degrees as of iron at 150: the alloy takes 20 c, then (c + L/range) per degree of the range,
// which leaves both at (150 - 20) c / (2 c + L/range) = 28.9 degrees, 72 % liquid, and none of it by tag: all is
// as warm. 1e-3: a step of 4000 s and 80 of them leave exp(-20) of the difference.
TEST(MeltingRange, AMixtureEndsWithinTheRange) {
  MELTSIM_NEEDS_BACKEND();
  World world = bar(0, 8 * dx);
  const MaterialId melt = *world.add_material(substance("melt"));
  const MaterialId solid = *world.add_material(alloy(melt)), iron = *world.add_material(substance("iron"));
  require(world.add_solid(block(iron, 0, 4 * dx, 150)));
  require(world.add_solid(block(solid, 4 * dx, 8 * dx, -20)));
  const Mixed m = mixed(world, solid, 80);
  const double right = (150 - 20) * capacity / (2 * capacity + latent / range);
  EXPECT_NEAR(m.temperature, right, 1e-3);
  EXPECT_NEAR(m.fraction, right / range, 1e-4);
  EXPECT_LT(m.spread, 1e-2);
  EXPECT_NEAR(m.lost, 0, 1e-6 * 170 * rho * capacity * side * side * 4 * dx);
}

// What freezes joins its body at the cold end of the range, what melts leaves it at the warm one; in between both stay what they are.
TEST(MeltingRange, PhaseChangesAtTheEnds) {
  MELTSIM_NEEDS_BACKEND();
  for (const double iron_at : {-140.0, -40.0, 400.0}) {
    World world = bar(0, 8 * dx);
    const MaterialId melt = *world.add_material(substance("melt"));
    MaterialDesc a = alloy(melt);
    a.freezes = true;
    const MaterialId solid = *world.add_material(a), iron = *world.add_material(substance("iron"));
    require(world.add_solid(block(iron, 0, 4 * dx, iron_at)));
    SolidDesc seed = block(solid, 4 * dx, 6 * dx, 20);
    seed.growth = 4;
    require(world.add_solid(seed));
    FluidDesc liquid;
    liquid.shape = Shape::box({6 * dx, 0, 0}, {8 * dx, side, side});
    liquid.material = melt;
    liquid.temperature = 20;  // half of it is liquid
    require(world.add_fluid(liquid));
    const Mixed m = mixed(world, melt, 120);
    const std::uint64_t all = 4 * 64, sites = 4 * 64;  // of the alloy; of iron
    EXPECT_LT(m.spread, 1e-2);
    if (iron_at == -140) {  // 20 (c + L/range) < (140 - ...) c: colder than the range
      EXPECT_NEAR(m.temperature, (20 * (latent / range + capacity) - 140 * capacity) / (2 * capacity), 1e-3);
      EXPECT_EQ(m.solid, all + sites);
    } else if (iron_at == -40) {  // within the range: nothing changes its phase
      EXPECT_NEAR(m.temperature,
                  (20 * (latent / range + capacity) - 40 * capacity) / (2 * capacity + latent / range), 1e-3);
      EXPECT_NEAR(m.fraction, m.temperature / range, 1e-4);
      EXPECT_EQ(m.liquid, all / 2);
    } else {
      EXPECT_GT(m.temperature, range);
      EXPECT_EQ(m.liquid, all);
    }
  }
}

// A table of capacities that is constant is that constant.
TEST(MeltingRange, ATableOfCapacitiesIsNoOtherSubstance) {
  MELTSIM_NEEDS_BACKEND();
  double temperature[2];
  for (const bool table : {false, true}) {
    World world = bar(0, 8 * dx);
    MaterialDesc liquid = substance("melt");
    if (table) liquid.heat_capacity_points = {{0, capacity}, {100, capacity}};
    const MaterialId melt = *world.add_material(liquid);
    MaterialDesc a = alloy(melt);
    if (table) a.heat_capacity_points = {{-50, capacity}, {10, capacity}};
    const MaterialId solid = *world.add_material(a), iron = *world.add_material(substance("iron"));
    require(world.add_solid(block(iron, 0, 4 * dx, 150)));
    require(world.add_solid(block(solid, 4 * dx, 8 * dx, -20)));
    temperature[table ? 1 : 0] = mixed(world, solid, 40).temperature;
  }
  EXPECT_NEAR(temperature[0], temperature[1], 1e-5);
}

TEST(MeltingRange, BadRangesAreRefused) {
  MELTSIM_NEEDS_BACKEND();
  World world = bar(0, 8 * dx);
  const MaterialId melt = *world.add_material(substance("melt"));
  MaterialDesc a = alloy(melt);
  a.melting_range = -1;
  EXPECT_NE(world.add_material(a).error().message.find("melting_range"), std::string::npos);
  a.melting_range = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(world.add_material(a).error().message.find("melting_range"), std::string::npos);
  MaterialDesc never = substance("stone");
  never.melting_range = 5;
  EXPECT_NE(world.add_material(never).error().message.find("melting_range"), std::string::npos);
  a.melting_range = 5;
  const MaterialId solid = *world.add_material(a);
  a.melting_range = 6;
  EXPECT_NE(world.set_material(solid, a).error().message.find("melting_range"), std::string::npos);
}

// A slab at its melting point beneath a wall at `hot` (Neumann's solution with one phase: Carslaw & Jaeger 1959, sec. 11.2, s = 2 l sqrt(a t),
// l exp(l^2) erf(l) = c T/(L sqrt(pi))). The liquid conducts `ratio` times as well as the solid, which takes no heat and so has no say in it:
// not where the first layer of particles melts, either. A tenth of a spacing: as far as the front is known inside a cell. With the solid's
// conductivity between the wall and the first layer, as it was, the front was 1.9 spacings behind at a ratio of 100.
TEST(Melting, OfASlabBeneathAWallDependsOnTheLiquidsConductivityAlone) {
  MELTSIM_NEEDS_BACKEND();
  constexpr int cells = 20;
  constexpr double hot = 10, heat = 20, c = 1, alpha = 1, length = cells * dx;
  double low = 0, high = 2;
  for (int k = 0; k < 60; ++k) {
    const double l = (low + high) / 2;
    (l * std::exp(l * l) * std::erf(l) < c * hot / (heat * std::sqrt(std::acos(-1.0))) ? low : high) = l;
  }
  for (const double ratio : {1.0, 4.0, 100.0}) {
    WorldDesc d = describe();
    d.spacing = dx;
    d.gravity = {0, 0, 0};
    d.sound_speed = 1e-2;  // nothing moves
    d.domain.bounded = true;
    d.domain.max = {length, side, side};
    d.domain.faces = {Face::wall, Face::wall, Face::periodic, Face::periodic, Face::periodic, Face::periodic};
    d.domain.heat[0].temperature = hot;
    World w = *World::create(d);
    MaterialDesc melt = substance("melt"), solid = substance("solid");
    melt.heat_capacity = solid.heat_capacity = c;
    melt.conductivity = alpha * rho * c;
    melt.viscosity = 1;
    solid.conductivity = melt.conductivity / ratio;
    solid.melting_point = 0;
    solid.latent_heat = heat;
    solid.melts_into = *w.add_material(melt);
    require(w.add_solid(block(*w.add_material(solid), 0, length, 0)));
    const Totals start = *w.totals();
    EXPECT_NEAR(start.latent_max / (start.mass * heat), 1, 1e-6);
    EXPECT_NEAR(start.latent, 0, 1e-6 * start.latent_max);
    for (const double front : {0.25, 0.5}) {
      const double until = std::pow(front * length / (2 * low), 2) / alpha;
      for (int k = 0; k < 40; ++k) require(w.step((until - w.time()) / (40 - k)));
      const Totals now = *w.totals();
      EXPECT_NEAR(now.latent / now.latent_max * cells, front * cells, 0.1) << ratio;
      EXPECT_NEAR(now.latent_max / start.latent_max, 1, 1e-12);
    }
  }
}

}  // namespace
}  // namespace meltsim_test
