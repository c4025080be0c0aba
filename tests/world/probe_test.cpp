// SPDX-License-Identifier: Apache-2.0
// Probes and samples: what they read, when, and that nothing else notices.
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "scenes.hpp"
#include "support/random.hpp"

namespace meltsim_test {
namespace {

const double nan = std::numeric_limits<double>::quiet_NaN();
const std::vector<std::string> all_fields{"temperature", "pressure", "density",
                                          "speed",       "velocity", "liquid_fraction"};

/// W without scale (Wendland C2).
double weight(double r, double support) {
  const double a = 1 - r / support;
  return a > 0 ? a * a * a * a * (5 - 4 * a) : 0;
}

/// What fields read at x by their definition: a sum over all particles, in double. Positions of p as given.
std::vector<double> by_definition(const ParticleData& p, Vec3d x, double support, Vec3d period = {}) {
  double all = 0, liquid = 0;
  std::vector<double> s(8, 0.0);
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    Vec3d d = p.position[i] - x;
    if (period.x > 0) d.x -= period.x * std::rint(d.x / period.x);
    const double w = weight(length(d), support);
    if (w == 0) continue;
    all += w;
    s[0] += w * p.temperature[i];
    s[2] += w * p.density[i];
    s[7] += w * p.liquid_fraction[i];
    if (is_solid(p.tag[i])) continue;
    liquid += w;
    s[1] += w * p.pressure[i];
    s[3] += w * length(p.velocity[i]);
    s[4] += w * p.velocity[i].x;
    s[5] += w * p.velocity[i].y;
    s[6] += w * p.velocity[i].z;
  }
  for (const std::size_t k : {0u, 2u, 7u}) s[k] = all > 0 ? s[k] / all : nan;
  for (const std::size_t k : {1u, 3u, 4u, 5u, 6u}) s[k] = liquid > 0 ? s[k] / liquid : nan;
  return s;
}

/// Sizes of the fields' values in the scenes here: 100 degrees, 10 kPa, 1000 kg/m^3, 1 m/s, 1.
constexpr double size_of[8] = {100, 1e4, 1000, 1, 1, 1, 1, 1};

/// Rounding of a few hundred single-precision terms and of distances: some 1e-6 of a field's size. Where the only weights
/// are those at the rim of the kernel, (1 - r/H)^4 makes more of what a distance is rounded by; such points are left out.
void expect_values(const double* got, const std::vector<double>& expected, const std::string& where,
                   double coarser = 1) {
  for (std::size_t k = 0; k < 8; ++k) {
    if (std::isnan(expected[k])) EXPECT_TRUE(std::isnan(got[k])) << where << ", value " << k;
    else EXPECT_NEAR(got[k], expected[k], 1e-5 * coarser * size_of[k]) << where << ", value " << k;
  }
}

/// Whether a particle lies in the outer tenth of the support of x, and none deeper.
bool at_rim(const ParticleData& p, Vec3d x, double support, Vec3d period = {}) {
  double nearest_any = 2 * support, nearest_liquid = 2 * support;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    Vec3d d = p.position[i] - x;
    if (period.x > 0) d.x -= period.x * std::rint(d.x / period.x);
    nearest_any = std::min(nearest_any, length(d));
    if (!is_solid(p.tag[i])) nearest_liquid = std::min(nearest_liquid, length(d));
  }
  const auto rim = [&](double r) { return r > 0.9 * support && r < 1.01 * support; };
  return rim(nearest_any) || rim(nearest_liquid);
}

struct Variant {
  const char* name;
  NeighbourSearch search = NeighbourSearch::grid;
  bool periodic = false, unbounded = false;
  Precision precision = Precision::single_precision;
  bool mostly_empty = false;
  /// Positions and points are stored relative to the middle of a domain of 240 m: 50 times as coarsely.
  double coarser() const { return mostly_empty ? 50 : 1; }
};
const Variant variants[] = {
    {"grid"},
    {"grid, periodic", NeighbourSearch::grid, true},
    {"grid, double", NeighbourSearch::grid, false, false, Precision::double_precision},
    {"grid, mostly empty", NeighbourSearch::grid, false, false, Precision::single_precision, true},
    {"grid, unbounded", NeighbourSearch::grid, false, true},
    {"tree", NeighbourSearch::tree},
    {"tree, periodic", NeighbourSearch::tree, true},
    {"tree, unbounded", NeighbourSearch::tree, false, true},
};

/// Warm water that moves, around a block of ice that melts.
World make_world(const Variant& v) {
  WorldDesc d = describe();
  d.neighbour_search = v.search;
  d.precision = v.precision;
  d.spacing = 0.2;
  d.sound_speed = 40;
  d.heat.time_scale = 2e4;
  if (!v.unbounded) {
    d.domain.bounded = true;
    d.domain.max = {2.4, v.mostly_empty ? 240.0 : 2.4, v.mostly_empty ? 24.0 : 2.4};
    if (v.periodic) d.domain.faces[0] = d.domain.faces[1] = Face::periodic;
  }
  auto made = World::create(d);
  EXPECT_TRUE(made) << made.error().message;
  World w = std::move(*made);
  const MaterialId water = *w.add_material({});
  MaterialDesc ice;
  ice.name = "ice";
  ice.density = 917;
  ice.heat_capacity = 2100;
  ice.conductivity = 2.2;
  ice.melting_point = 0;
  ice.latent_heat = 1e4;
  ice.melts_into = water;
  const MaterialId frozen = *w.add_material(ice);
  FluidDesc f;
  f.shape = Shape::box({0, 0, 0}, {2.4, 1.2, 2.4});
  f.material = water;
  f.temperature = 60;
  f.velocity = {0.4, 0.2, -0.3};
  require(w.add_fluid(f));
  SolidDesc s;
  s.shape = Shape::box({0.8, 0.4, 0.8}, {1.6, 1.0, 1.6});
  s.material = frozen;
  s.temperature = -10;
  require(w.add_solid(s));
  return w;
}

/// Everywhere in and around the liquid, on walls and corners, and where there is nothing.
std::vector<Vec3d> some_points(bool inside) {
  test_support::Random random(3);
  std::vector<Vec3d> x{{0, 0, 0}, {2.4, 0, 2.4}, {1.2, 0.7, 1.2}, {0, 0.6, 1.2}, {1.2, 2.2, 1.2}};
  for (int k = 0; k < 45; ++k)
    x.push_back({random.uniform(0, 2.4), random.uniform(0, 1.9), random.uniform(0, 2.4)});
  if (!inside) x.insert(x.end(), {{-0.3, 0.5, 1}, {1.2, -0.4, 1.2}, {50, 50, 50}, {-1e6, 3, 3}});
  return x;
}

// Of the state between sub-steps, whichever search the sub-steps use.
TEST(Sample, IsTheAverageOverEveryParticleWithinReach) {
  MELTSIM_NEEDS_BACKEND();
  for (const Variant& v : variants) {
    World w = make_world(v);
    const Vec3d period{v.periodic ? 2.4 : 0.0, 0, 0};
    for (int k = 0; k < 12; ++k) require(w.step(0.004));
    ASSERT_FALSE(w.synchronize().halted) << v.name;
    const ParticleData p = *w.particles();
    const double support = w.resolved().support_radius;
    const auto points = some_points(false);
    const auto values = w.sample(points, all_fields);
    require(values);
    ASSERT_EQ(values->size(), 8 * points.size());
    int checked = 0;
    for (std::size_t n = 0; n < points.size(); ++n) {
      if (at_rim(p, points[n], support, period)) continue;
      ++checked;
      expect_values(values->data() + 8 * n, by_definition(p, points[n], support, period),
                    std::string(v.name) + ", point " + std::to_string(n), v.coarser());
    }
    EXPECT_GT(checked, 40) << v.name;
    // Fewer fields or points give the same numbers.
    EXPECT_EQ((*w.sample({points[7]}, {"density", "speed"})),
              (std::vector<double>{(*values)[8 * 7 + 2], (*values)[8 * 7 + 3]}));
    EXPECT_EQ((*w.sample({points[7]}, "temperature")).at(0), (*values)[8 * 7]);
    EXPECT_EQ(*w.sample({points[7]}, std::string("velocity")), std::vector<double>{(*values)[8 * 7 + 3]});
  }
}

// A probe samples the middle of a sub-step: particles half a step on from where they were, with the velocities and
// temperatures that they had, and the density and pressure that this sub-step finds there.
TEST(Probe, ReadsTheAverageInTheMiddleOfTheSubStep) {
  MELTSIM_NEEDS_BACKEND();
  for (const Variant& v : variants) {
    World w = make_world(v);
    const Vec3d period{v.periodic ? 2.4 : 0.0, 0, 0};
    const auto points = some_points(true);
    ProbeDesc d;
    d.points = points;
    d.fields = all_fields;
    require(w.add_probe(d));
    ASSERT_LT(0.004, w.stable_dt() > 0 ? w.resolved().stable_dt : 0) << "steps are sub-steps here";
    for (int k = 0; k < 9; ++k) require(w.step(0.004));
    require(w.take_samples());
    const ParticleData before = *w.particles();
    const double start = w.time();
    require(w.step(0.004));
    const auto series = w.take_samples();
    require(series);
    const ParticleData after = *w.particles();
    ASSERT_EQ(series->size(), 1u);
    ASSERT_EQ(series->at(0).width, 8u);
    ASSERT_EQ(series->at(0).time.size(), 1u) << v.name;
    EXPECT_DOUBLE_EQ(series->at(0).time[0], start + 0.002);
    ParticleData middle = before;
    for (std::size_t i = 0; i < middle.id.size(); ++i) {
      middle.position[i] += middle.velocity[i] * 0.002;
      middle.density[i] = after.density[i];
      middle.pressure[i] = after.pressure[i];
      // One that melts in this sub-step is a solid in its middle.
      if (is_solid(before.tag[i])) middle.density[i] = before.density[i];
    }
    int checked = 0;
    const double support = w.resolved().support_radius;
    for (std::size_t n = 0; n < points.size(); ++n) {
      if (at_rim(middle, points[n], support, period)) continue;
      ++checked;
      expect_values(series->at(0).values.data() + 8 * n, by_definition(middle, points[n], support, period),
                    std::string(v.name) + ", point " + std::to_string(n), v.coarser());
    }
    EXPECT_GT(checked, 40) << v.name;
  }
}

// Solids have no pressure of their own: beside a body a probe reads that of the liquid.
TEST(Probe, PressureBesideABodyIsThatOfTheLiquid) {
  MELTSIM_NEEDS_BACKEND();
  World w = make_world({"grid"});
  for (int k = 0; k < 12; ++k) require(w.step(0.004));
  const ParticleData p = *w.particles();
  const Vec3d beside{0.78, 0.7, 1.2};
  double least = infinity;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (!is_solid(p.tag[i]) && length(p.position[i] - beside) < 0.5) least = std::min(least, p.pressure[i]);
  EXPECT_GE((*w.sample({beside}, {"pressure"})).at(0), least * (1 - 1e-6));
  EXPECT_TRUE(std::isnan((*w.sample({{1.2, 2.2, 1.2}}, {"pressure"})).at(0)));
}

ProbeDesc gauge(std::vector<Vec3d> points) {
  ProbeDesc d;
  d.kind = ProbeKind::level;
  d.points = std::move(points);
  return d;
}

std::vector<ProbeSeries> samples_of(World& w) {
  auto taken = w.take_samples();
  EXPECT_TRUE(taken);
  return taken ? std::move(*taken) : std::vector<ProbeSeries>{};
}

ProbeDesc thermometer(Vec3d x, double every = 0) {
  ProbeDesc d;
  d.points = {x};
  d.fields = {"temperature"};
  d.every = every;
  return d;
}

// No bit of the state may hang on whether somebody samples, or begins to in the middle of a run.
TEST(Probe, ChangesNoBitOfTheState) {
  MELTSIM_NEEDS_BACKEND();
  for (const Variant& v : variants) {
    World plain = make_world(v), probed = make_world(v), later = make_world(v);
    require(probed.add_probe(thermometer({1, 0.5, 1}, 0.01)));
    require(probed.add_probe(gauge({{0.3, 0, 0.3}, {2.4, 1, 1}})));
    for (int k = 0; k < 40; ++k) {
      require(plain.step(0.004));
      require(probed.step(0.004));
      if (k == 17) require(later.add_probe(gauge({{0.5, 0.5, 0.5}})));
      require(later.step(0.004));
    }
    EXPECT_EQ(*plain.state_hash(), *probed.state_hash()) << v.name;
    EXPECT_EQ(*plain.state_hash(), *later.state_hash()) << v.name;
    const auto series = *probed.take_samples();
    EXPECT_EQ(series.at(0).time.size(), 16u) << v.name;
    EXPECT_EQ(series.at(1).time.size(), 40u) << v.name;
    EXPECT_EQ(later.take_samples()->at(0).time.size(), 23u) << v.name;
  }
}

/// Water alone, `depth` deep, of which neither sides nor floor are whole layers away from where probes are.
World make_pool(double depth, double support_in_spacings = 2.5, bool sideways = false,
                Precision precision = Precision::single_precision) {
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.support_radius = support_in_spacings * d.spacing;
  d.precision = precision;
  d.sound_speed = 30;
  d.hydrostatic_start = false;  // its depth is that of its layers
  d.domain.bounded = true;
  d.domain.min = {-0.4, -0.3, 0.2};
  d.domain.max = {0.8, 1.7, 1.4};
  if (sideways) {
    d.gravity = {9.81, 0, 0};
    d.domain.max = {1.6, 0.9, 1.4};
  }
  World w = std::move(*World::create(d));
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = sideways ? Shape::box({1.6 - depth, -0.3, 0.2}, {1.6, 0.9, 1.4})
                     : Shape::box({-0.4, -0.3, 0.2}, {0.8, -0.3 + depth, 1.4});
  require(w.add_fluid(f));
  return w;
}

// Anywhere in a pool, on its walls, edges included. A lattice's own ripple, as the point lies between its columns, is
// 0.02 dx.
TEST(Probe, LevelOfAPoolIsItsDepth) {
  MELTSIM_NEEDS_BACKEND();
  for (const double support : {2.0, 2.5, 3.0})
    for (const double layers : {3.0, 5.0, 9.0}) {
      World w = make_pool(0.1 * layers, support);
      require(w.add_probe(gauge({{0.2, 0.5, 0.8}, {0.23, -0.3, 0.77}, {0.25, 1.7, 0.85}})));
      require(w.add_probe(gauge({{-0.4, 0, 0.8}, {0.1, 0, 1.4}, {-0.4, 0, 0.2}, {-0.38, 0, 0.24}})));
      require(w.step(1e-6));  // before anything moves
      for (const ProbeSeries& s : samples_of(w))
        for (const double level : s.values)
          EXPECT_NEAR(level, -0.3 + 0.1 * layers, 0.005) << support << " spacings, " << layers << " layers";
    }
}

// Four seconds later, when its layers have dissolved and it has settled by 1 % of its depth (docs/limits.md): twice the height of its
// centre of mass.
TEST(Probe, LevelOfASettledPoolIsItsDepthToATenthOfASpacing) {
  MELTSIM_NEEDS_BACKEND();
  World w = make_pool(0.6);
  require(w.add_probe(gauge({{0.2, 0.5, 0.8}, {-0.4, 0, 0.8}, {0.61, 0, 0.43}})));
  while (w.time() < 4) require(w.step(2e-3));
  ASSERT_FALSE(w.synchronize().halted);
  const ProbeSeries s = w.take_samples()->at(0);
  ASSERT_GT(s.time.size(), 500u);
  double mean[3] = {};
  const std::size_t last = 100;
  for (std::size_t n = s.time.size() - last; n < s.time.size(); ++n)
    for (std::size_t k = 0; k < 3; ++k) mean[k] += s.values[3 * n + k] / double(last);
  const ParticleData p = *w.particles();
  double centre = 0;
  for (const Vec3d& x : p.position) centre += x.y / double(p.position.size());
  const double depth = 2 * (centre + 0.3);
  EXPECT_NEAR(depth, 0.6, 0.01);
  for (const double level : mean) EXPECT_NEAR(level + 0.3, depth, 0.01);
}

TEST(Probe, LevelGoesAgainstGravity) {
  MELTSIM_NEEDS_BACKEND();
  World w = make_pool(0.5, 2.5, true);
  require(w.add_probe(gauge({{0, 0.2, 0.7}})));
  require(w.step(1e-6));
  // "Up" is -x: the surface at x = 1.1 is at height -1.1.
  EXPECT_NEAR(w.take_samples()->at(0).values.at(0), -1.1, 0.005);
}

TEST(Probe, LevelWhereLiquidEndsOtherwise) {
  MELTSIM_NEEDS_BACKEND();
  World full = make_pool(2.0);
  require(full.add_probe(gauge({{0.2, 0, 0.8}})));
  require(full.step(1e-6));
  EXPECT_NEAR(full.take_samples()->at(0).values.at(0), 1.7, 1e-6) << "up to the ceiling";

  // Beside a wall of a fixed body, under a shelf that stands out of the water, and where it is dry.
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.sound_speed = 30;
  d.domain.bounded = true;
  d.domain.max = {2, 2, 2};
  World w = std::move(*World::create(d));
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0, 0, 0}, {1, 0.6, 2});
  MaterialDesc stone;
  stone.name = "stone";
  stone.density = 2000;
  SolidDesc s;
  s.material = *w.add_material(stone);
  s.shape = Shape::box({1, 0, 0}, {1.5, 1.5, 2});
  s.fixed = true;
  require(w.add_solid(s));
  require(w.add_fluid(f));
  // A drop of one particle above it does not count, one of 27 does.
  f.shape = Shape::box({0.2, 1.2, 0.2}, {0.3, 1.3, 0.3});
  require(w.add_fluid(f));
  f.shape = Shape::box({0.3, 1.2, 1.3}, {0.6, 1.5, 1.6});
  require(w.add_fluid(f));
  require(w.add_probe(
      gauge({{0.95, 1, 1}, {0.9, 1, 1.03}, {0.25, 1, 0.25}, {0.45, 1, 1.45}, {1.8, 1, 1}, {1.25, 1, 1}})));
  require(w.step(1e-6));
  const auto level = w.take_samples()->at(0).values;
  EXPECT_NEAR(level.at(0), 0.6, 0.01);
  EXPECT_NEAR(level.at(1), 0.6, 0.01);
  EXPECT_NEAR(level.at(2), 0.6, 0.01);
  EXPECT_NEAR(level.at(3), 1.5, 0.03) << "a small cube's corners are round";
  EXPECT_TRUE(std::isnan(level.at(4)));
  EXPECT_TRUE(std::isnan(level.at(5))) << "inside a body";

  // Without a domain, and far from the origin of coordinates.
  for (const NeighbourSearch search : {NeighbourSearch::grid, NeighbourSearch::tree}) {
    WorldDesc u = describe();
    u.spacing = 0.1;
    u.gravity = {};
    u.sound_speed = 30;
    u.neighbour_search = search;
    World free = std::move(*World::create(u));
    f.material = *free.add_material({});
    f.shape = Shape::box({1e5, 2e5, 0}, {1e5 + 1, 2e5 + 1, 1});
    require(free.add_probe(gauge({{1e5 + 0.5, 2e5 - 7, 0.5}, {1e5 + 3, 2e5, 0.5}})));
    require(free.add_fluid(f));
    require(free.step(1e-6));
    const auto high = free.take_samples()->at(0).values;
    EXPECT_NEAR(high.at(0), 2e5 + 1, 0.005);
    EXPECT_TRUE(std::isnan(high.at(1)));
  }
}

/// Steps of irregular lengths to t = 0.5 s; the times of all samples.
std::vector<std::vector<double>> times_of(World& w, double until, test_support::Random& random) {
  while (w.time() < until) require(w.step(std::min(random.uniform(1e-4, 0.02), until - w.time())));
  std::vector<std::vector<double>> times;
  for (const ProbeSeries& s : samples_of(w)) {
    times.push_back(s.time);
    EXPECT_EQ(s.values.size(), s.time.size() * s.points * s.width);
  }
  return times;
}

// Every due time has its sample, in the sub-step that it lies in.
TEST(Probe, SamplesAreTakenWhenTheyAreDue) {
  MELTSIM_NEEDS_BACKEND();
  World w = make_pool(0.3);
  ProbeDesc d = thermometer({0, 0, 1}, 0.03);
  require(w.add_probe(d));
  d.from = 0.1;
  d.until = 0.22;
  require(w.add_probe(d));
  d.every = 0;
  require(w.add_probe(d));
  d.every = 1e-9;
  require(w.add_probe(d));
  d.until = d.from;
  d.every = 5;
  require(w.add_probe(d));
  const double dt = 1e-3;
  for (int k = 0; k < 500; ++k)
    require(w.step(dt));  // boundaries of sub-steps meet due times but for rounding
  ASSERT_EQ(w.steps(), 500u);
  const auto series = *w.take_samples();
  const auto expect_due = [&](const ProbeSeries& s, double from, double every, std::size_t n) {
    ASSERT_EQ(s.time.size(), n);
    for (std::size_t k = 0; k < n; ++k) {
      EXPECT_GT(s.time[k], from + every * double(k));
      EXPECT_LT(s.time[k], from + every * double(k) + dt);
    }
  };
  expect_due(series.at(0), 0, 0.03, 17);
  expect_due(series.at(1), 0.1, 0.03, 5);
  for (const std::size_t often : {2u, 3u}) expect_due(series.at(often), 0.1, dt, 121);
  expect_due(series.at(4), 0.1, 5, 1);
}

TEST(Probe, NothingIsLostOrDoubledAcrossASnapshot) {
  MELTSIM_NEEDS_BACKEND();
  const auto with_probes = [] {
    World w = make_pool(0.3);
    require(w.add_probe(thermometer({0, 0, 1}, 0.007)));
    require(w.add_probe(gauge({{0, 0, 1}, {0.2, 0, 1}})));
    return w;
  };
  for (const double stop : {0.07, 0.0931}) {  // where a sample is due, and not
    test_support::Random one(5), other(5);
    World whole = with_probes();
    auto expected = times_of(whole, stop, one);
    const auto more = times_of(whole, 0.3, one);
    for (std::size_t k = 0; k < 2; ++k) expected[k].insert(expected[k].end(), more[k].begin(), more[k].end());

    World first = with_probes();
    auto got = times_of(first, stop, other);
    const auto bytes = *first.snapshot();
    World second = with_probes();
    require(second.restore(bytes.data(), bytes.size()));
    const auto rest = times_of(second, 0.3, other);
    for (std::size_t k = 0; k < 2; ++k) {
      got[k].insert(got[k].end(), rest[k].begin(), rest[k].end());
      EXPECT_EQ(got[k], expected[k]) << "stopped at " << stop << ", probe " << k;
    }

    // The same World back in time, with samples that nobody took: those of what happens again are dropped.
    for (int k = 0; k < 20; ++k) require(first.step(0.004));
    require(first.restore(bytes.data(), bytes.size()));
    for (const ProbeSeries& s : samples_of(first)) EXPECT_TRUE(s.time.empty());
  }
}

// Readings hold the samples of their intervals, however many are open and in whatever order they are taken; the World goes
// on meanwhile, and other readings, probes and taking what is there do not mix them up.
TEST(Probe, ReadingsBringTheSamplesOfTheirIntervals) {
  MELTSIM_NEEDS_BACKEND();
  const auto make = [] {
    World w = make_pool(0.3);
    require(w.add_probe(thermometer({0, 0, 1}, 0.003)));
    require(w.add_probe(gauge({{0, 0, 1}, {0.2, 0, 1}})));
    return w;
  };
  World w = make(), twin = make();
  ReadRequest with, without;
  with.probes = true;
  without.particles = true;
  std::vector<ProbeSeries> got(2);
  const auto add = [&](const std::vector<ProbeSeries>& more) {
    for (std::size_t k = 0; k < 2; ++k) {
      got[k].time.insert(got[k].time.end(), more[k].time.begin(), more[k].time.end());
      got[k].values.insert(got[k].values.end(), more[k].values.begin(), more[k].values.end());
    }
  };
  const auto step = [](World& world, int times) {
    for (int k = 0; k < times; ++k) require(world.step(1e-3));
  };
  for (int round = 0; round < 6; ++round) {
    std::vector<ReadTicket> tickets;
    for (int k = 0; k < 3; ++k) {
      step(w, 5 + k);
      tickets.push_back(*w.request(with));
      if (k == 1) {
        step(w, 1);  // an interval that another reading ends in the middle
        tickets.push_back(*w.request(without));
      }
    }
    step(w, 4);
    if (round == 2) require(w.add_probe(thermometer({0, 0.1, 1}, 0.01)));
    std::vector<std::vector<ProbeSeries>> taken(4);
    for (const std::size_t k : {2u, 0u, 3u, 1u}) taken[k] = w.take(tickets[k])->probes;
    EXPECT_TRUE(taken[2].empty()) << "not asked for";
    for (const std::size_t k : {0u, 1u, 3u}) add(taken[k]);
    add(samples_of(w));
  }
  step(twin, 6 * (5 + 6 + 1 + 7 + 4));
  const auto expected = samples_of(twin);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(got[k].time, expected[k].time);
    EXPECT_EQ(got[k].values, expected[k].values);
  }
}

TEST(Probe, AHaltKeepsTheSamplesOfTheStepsThatCount) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.2;
  d.sound_speed = 5;
  d.gravity = {0, 1000, 0};
  d.domain.bounded = true;
  d.domain.max = {3, 3, 3};
  d.domain.faces[3] = Face::open;  // it falls upwards; onto a wall, so slow a sound is refused
  World w = std::move(*World::create(d));
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0, 0, 0}, {3, 0.6, 3});
  require(w.add_fluid(f));
  require(w.add_probe(thermometer({1, 2.1, 1})));
  for (int k = 0; k < 60; ++k) require(w.step(1e-3));  // 60 m/s, 1.8 m up
  require(w.step(8.9e-3));                             // 0.57 m at once: more than H
  require(w.step(1e-3));                               // enqueued behind it, does nothing
  const auto series = *w.take_samples();
  ASSERT_EQ(series.at(0).time.size(), 60u);
  EXPECT_NEAR(series.at(0).time[59], 59.5e-3, 1e-12);
  EXPECT_TRUE(w.synchronize().halted);
  // What is sampled at once is the last good state, with the density of the step that halted.
  const ParticleData p = *w.particles();
  const double support = w.resolved().support_radius;
  for (const Vec3d x : {Vec3d{1, 2.1, 1}, Vec3d{2.1, 2.0, 0.7}})
    expect_values(w.sample({x}, all_fields)->data(), by_definition(p, x, support), "after a halt");
  EXPECT_TRUE(w.take_samples()->at(0).time.empty());
}

// Room for samples is a few hundred of such a probe: the World puts them aside by itself.
TEST(Probe, MoreSamplesThanThereIsRoomForAreNotLost) {
  MELTSIM_NEEDS_BACKEND();
  World w = make_pool(0.3);
  ProbeDesc d;
  d.fields = {"temperature", "velocity"};
  for (int k = 0; k < 1000; ++k) d.points.push_back({-0.4 + 1.2e-3 * k, 1.5, 1});  // dry, hence quick
  d.points[500] = {0, 0, 1};
  require(w.add_probe(d));
  require(w.add_probe(thermometer({0, 0, 1}, 0.01)));
  const std::size_t steps = 600;
  for (std::size_t k = 0; k < steps; ++k) require(w.step(1e-3));
  const auto series = *w.take_samples();
  ASSERT_EQ(series.at(0).time.size(), steps);
  ASSERT_EQ(series.at(0).values.size(), steps * 4000);
  for (std::size_t k = 0; k < steps; ++k) {
    EXPECT_NEAR(series.at(0).time[k], 1e-3 * (double(k) + 0.5), 1e-9);
    EXPECT_NEAR(series.at(0).values[4000 * k + 2000], 20, 1e-4);
    EXPECT_TRUE(std::isnan(series.at(0).values[4000 * k]));
  }
  ASSERT_EQ(series.at(1).time.size(), 60u);
  for (const double t : series.at(1).values) EXPECT_NEAR(t, 20, 1e-4);
}

TEST(Probe, AnEmptyWorldReadsNothing) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = describe();
  d.spacing = 0.1;
  d.domain.bounded = true;
  d.domain.max = {1, 1, 1};
  d.sound_speed = 20;
  World w = std::move(*World::create(d));
  require(w.add_probe(thermometer({0.5, 0.8, 0.5})));
  require(w.step(1e-3));
  EXPECT_TRUE(std::isnan(w.sample({{0.5, 0.5, 0.5}}, {"density"})->at(0)));
  EmitterDesc e;
  e.center = {0.5, 0.9, 0.5};
  e.radius = 0.2;
  e.speed = 2;
  e.from = 0.0105;
  e.until = 1;
  e.material = *w.add_material({});
  e.temperature = 35;
  require(w.add_emitter(e));
  for (int k = 0; k < 99; ++k) require(w.step(1e-3));
  const ProbeSeries s = w.take_samples()->at(0);
  ASSERT_EQ(s.values.size(), 100u);
  for (std::size_t k = 0; k < 9; ++k) EXPECT_TRUE(std::isnan(s.values[k])) << k;
  EXPECT_NEAR(s.values.back(), 35, 1e-3);
}

TEST(Probe, BadOnesAreRefusedAndChangeNothing) {
  MELTSIM_NEEDS_BACKEND();
  World w = make_pool(0.3);
  require(w.add_probe(thermometer({0, 0, 1}, 0.002)));
  for (int k = 0; k < 5; ++k) require(w.step(1e-3));
  const auto refused = [&](const char* words, auto change) {
    ProbeDesc d = thermometer({0, 0, 1});
    d.name = "other";
    change(d);
    const auto id = w.add_probe(d);
    ASSERT_FALSE(id) << words;
    EXPECT_NE(id.error().message.find(words), std::string::npos) << id.error().message;
  };
  refused("name", [](ProbeDesc& d) { d.name = "probe1"; });
  refused("points", [](ProbeDesc& d) { d.points.clear(); });
  refused("points: must be finite", [](ProbeDesc& d) { d.points.push_back({0, nan, 1}); });
  refused("outside the domain", [](ProbeDesc& d) { d.points.push_back({0, 1.8, 1}); });
  refused("fields: none", [](ProbeDesc& d) { d.fields.clear(); });
  refused(
      "\"heat\"; use temperature, pressure, density, speed, velocity, liquid_fraction or solute1 to solute3",
      [](ProbeDesc& d) {
        d.fields = {"pressure", "heat"};
      });
  refused("twice", [](ProbeDesc& d) { d.fields = {"pressure", "pressure"}; });
  refused("kind: is no ProbeKind, got 7", [](ProbeDesc& d) { d.kind = static_cast<ProbeKind>(7); });
  refused("a level has none", [](ProbeDesc& d) { d.kind = ProbeKind::level; });
  for (const double bad : {-1.0, nan, double(infinity)})
    refused("every", [=](ProbeDesc& d) { d.every = bad; });
  for (const double bad : {nan, double(infinity)}) refused("from", [=](ProbeDesc& d) { d.from = bad; });
  for (const double bad : {-1.0, nan}) refused("until", [=](ProbeDesc& d) { d.until = bad; });
  refused("values", [](ProbeDesc& d) {
    d.fields = {"velocity", "speed"};
    d.points.assign(150000, {0, 0, 1});
  });
  refused("heights", [](ProbeDesc& d) {
    d = gauge(std::vector<Vec3d>(150000, {0, 0, 1}));
    d.name = "many";
  });
  const auto unsampled = w.sample({{0, 0, nan}}, {"pressure"});
  ASSERT_FALSE(unsampled);
  EXPECT_NE(unsampled.error().message.find("points"), std::string::npos);
  EXPECT_FALSE(w.sample({{0, 0, 1}}, {"color"}));
  EXPECT_FALSE(w.sample({{0, 0, 1}}, std::vector<std::string>{}));
  for (int k = 0; k < 5; ++k) require(w.step(1e-3));
  World untroubled = make_pool(0.3);
  require(untroubled.add_probe(thermometer({0, 0, 1}, 0.002)));
  for (int k = 0; k < 10; ++k) require(untroubled.step(1e-3));
  EXPECT_EQ(*w.state_hash(), *untroubled.state_hash());
  const auto got = *w.take_samples(), expected = *untroubled.take_samples();
  ASSERT_EQ(got.size(), 1u);
  EXPECT_EQ(got[0].time, expected[0].time);
  EXPECT_EQ(got[0].values, expected[0].values);
  for (int k = 1; k < 64; ++k) require(w.add_probe(thermometer({0, 0, 1}, 1)));
  EXPECT_FALSE(w.add_probe(thermometer({0, 0, 1}, 1))) << "64 at most";
}

// The order of sums does not hang on threads, and a probe's values not on the others that are due with it.
TEST(Probe, ValuesAreTheSameWhateverTheThreads) {
  MELTSIM_NEEDS_BACKEND();
  std::vector<double> expected;
  for (const int threads : {1, 2, 5}) {
    WorldDesc d = describe();
    d.threads = threads;
    Scene s = ice_in_water(d);
    ProbeDesc p;
    p.points = {{1, 0.5, 1}, {0.7, 0.9, 1.3}, {2.4, 0.1, 0}};
    p.fields = all_fields;
    p.every = 0.01;
    if (threads == 2) require(s.world.add_probe(gauge({{1, 1, 1}})));
    const ProbeId id = *s.world.add_probe(p);
    if (threads == 5) require(s.world.add_probe(thermometer({1, 1, 1})));
    for (int k = 0; k < 20; ++k) require(s.world.step(0.005));
    const auto values = s.world.take_samples()->at(id.index).values;
    EXPECT_GE(values.size(), 10 * 3 * 8u);
    if (expected.empty()) expected = values;
    EXPECT_EQ(values, expected) << threads << " threads";
  }
}

// Sub-steps with and without samples are two graphs each, not one per sample.
TEST(Probe, SamplesDoNotMakeGraphsAnew) {
  MELTSIM_NEEDS_BACKEND();
  World plain = make_pool(0.3), probed = make_pool(0.3);
  require(probed.add_probe(thermometer({0, 0, 1}, 0.003)));
  for (int k = 0; k < 200; ++k) {
    require(plain.step(1e-3));
    require(probed.step(1e-3));
  }
  EXPECT_LE(probed.plan().graphs, 4 * plain.plan().graphs);
  bool runs = false;
  for (const StageReport& s : probed.plan().stages) runs = runs || (s.name == "sampling.probes" && s.runs);
  EXPECT_TRUE(runs);
}

TEST(Probe, ColumnsNameEveryValue) {
  EXPECT_EQ(sample_columns({"speed", "velocity", "temperature"}),
            (std::vector<std::string>{"speed", "velocity_x", "velocity_y", "velocity_z", "temperature"}));
}

// What others read is what they read without it, and it reads nothing any more; names and the room for 64 come back.
TEST(Probe, ARemovedOneTakesItsSamplesAlongAndNoOthers) {
  MELTSIM_NEEDS_BACKEND();
  Scene a = ice_in_water(describe()), b = ice_in_water(describe());
  ProbeDesc p;
  p.points = {{1, 0.5, 1}, {0.7, 0.9, 1.3}};
  p.fields = all_fields;
  ProbeId removed, kept;
  for (Scene* s : {&a, &b}) {
    require(s->world.add_probe(p));
    if (s == &a) {
      ProbeDesc g = gauge({{1, 1, 1}, {0.5, 1, 0.5}});
      g.name = "gauge";
      removed = *s->world.add_probe(g);
    }
    kept = *s->world.add_probe(thermometer({1, 1, 1}));
    for (int k = 0; k < 5; ++k) require(s->world.step(0.005));
  }
  ReadRequest what;
  what.probes = true;
  const auto ticket = a.world.request(what);
  ASSERT_TRUE(ticket);
  const Status early = a.world.remove(removed);
  ASSERT_FALSE(early);
  EXPECT_NE(early.error().message.find("reading"), std::string::npos) << early.error().message;
  const auto read = a.world.take(*ticket);
  ASSERT_TRUE(read);
  auto before = b.world.take_samples();
  EXPECT_EQ(read->probes.at(2).values, before->at(1).values);
  for (Scene* s : {&a, &b}) require(s->world.step(0.005));
  require(a.world.remove(removed));
  EXPECT_FALSE(a.world.remove(removed));
  EXPECT_FALSE(b.world.remove(removed));  // of another World
  for (Scene* s : {&a, &b}) require(s->world.step(0.005));
  const auto x = a.world.take_samples(), y = b.world.take_samples();
  ASSERT_TRUE(x && y);
  ASSERT_EQ(x->size(), 2u);
  ASSERT_EQ(y->size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ((*x)[k].values, (*y)[k].values);
    EXPECT_EQ((*x)[k].time, (*y)[k].time);
    EXPECT_GE((*x)[k].time.size(), 2u);  // a step each side of the removal
  }
  EXPECT_EQ((*y)[1].probe, kept);
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
  for (int k = 0; k < 70; ++k) {
    ProbeDesc g = gauge({{1, 1, 1}});
    g.name = "gauge";
    const auto again = a.world.add_probe(g);
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_FALSE(*again == removed);
    if (k % 7 == 0) require(a.world.step(0.005));
    require(a.world.remove(*again));
  }
  // The last ones, ahead of a step and of an upload.
  const auto last = a.world.take_samples();
  for (const ProbeSeries& s : *last) require(a.world.remove(s.probe));
  require(a.world.step(0.005));
  EXPECT_TRUE(a.world.take_samples()->empty());
  EXPECT_FALSE(a.world.synchronize().halted);
}

}  // namespace
}  // namespace meltsim_test
