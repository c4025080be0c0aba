// SPDX-License-Identifier: Apache-2.0
// Heat regions that move: how much heat they leave where, what moves them, and what a host may do with them.
#include <cmath>
#include <functional>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double dx = 0.1, width = 0.8;  // 8 cells sideways: the least that a periodic axis may have
constexpr double rho_c = 1e6;            // J/(m^3 K)

/// A fixed bar, 16 cells long, between walls at -x and +x, which does not conduct: what a cell got shows in its temperature.
struct Bar {
  World world;
  HeatRegionId region;
};
WorldDesc bar_desc() {
  WorldDesc d = describe();
  d.precision = Precision::double_precision;
  d.spacing = dx;
  d.domain.bounded = true;
  d.domain.max = {16 * dx, width, width};
  d.domain.faces = {Face::wall, Face::wall, Face::periodic, Face::periodic, Face::periodic, Face::periodic};
  return d;
}
World bare_bar() {
  World w = *World::create(bar_desc());
  MaterialDesc m;
  m.density = 1000;
  m.heat_capacity = rho_c / m.density;
  m.conductivity = 1e-9;
  SolidDesc s;
  s.material = *w.add_material(m);
  s.shape = Shape::box({0, 0, 0}, {16 * dx, width, width});
  s.temperature = 0;
  s.fixed = true;
  require(w.add_solid(s));
  return w;
}
HeatRegionDesc spot(const Shape& shape, std::vector<PathPoint> path = {}) {
  HeatRegionDesc r;
  r.shape = shape;
  r.source = 1e6;  // 1 K/s
  r.path = std::move(path);
  return r;
}
/// Two cells along x of the whole section.
Shape slice(double at) { return Shape::box({at, 0, 0}, {at + 2 * dx, width, width}); }
Bar bar(const HeatRegionDesc& r) {
  World w = bare_bar();
  auto id = w.add_heat_region(r);
  EXPECT_TRUE(id) << id.error().message;
  return {std::move(w), *id};
}
void run(World& w, int steps, double dt) {
  for (int i = 0; i < steps; ++i) require(w.step(dt));
}
/// Largest difference from the temperatures that something has by its place.
double worst(World& w, const std::function<double(Vec3d)>& expected) {
  const auto p = *w.particles();
  double far = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    far = std::max(far, std::fabs(p.temperature[i] - expected(p.position[i])));
  return far;
}

// Two cells wide at 0.1 m/s: it is 2 s over each cell that it passes, 2 K. In each straight part of a step it is looked for a quarter of a
// cell apart, so that the ends of those 2 s are right to a quarter of the time that a cell takes, 0.25 K each, however long the steps are.
TEST(MovingRegion, LeavesHeatForAsLongAsItIsOverAPlace) {
  MELTSIM_NEEDS_BACKEND();
  for (const auto& [steps, dt] : std::vector<std::pair<int, double>>{{1, 14.0}, {14, 1.0}, {280, 0.05}}) {
    Bar b = bar(spot(slice(0), {{0, {0, 0, 0}}, {14, {1.4, 0, 0}}}));
    run(b.world, steps, dt);
    // The cells at either end are left, or reached, before it has passed.
    const double off = worst(b.world, [](Vec3d x) {
      const double from = std::max(0.0, (x.x - 2 * dx) / 0.1), until = std::min(14.0, x.x / 0.1);
      return until - from;
    });
    EXPECT_LE(off, 0.5) << dt;
    const double in = 1e6 * 2 * dx * width * width * 14;  // it never leaves the bar
    EXPECT_NEAR(b.world.totals()->heat_in / in, 1, 0.01) << dt;
    EXPECT_NEAR(b.world.totals()->thermal / b.world.totals()->heat_in, 1, 1e-12);
  }
}

// Steps of a twentieth of a cell's time: 1/20 K at either end.
TEST(MovingRegion, RestsBeforeItsPathAndAfterItAndTurnsInIt) {
  MELTSIM_NEEDS_BACKEND();
  // 2 s over cells 0 and 1, then to cells 8 and 9 and back to 4 and 5 within a blink, where it stays for 3 s.
  Bar b = bar(spot(slice(0), {{2, {0, 0, 0}}, {2.0001, {0.8, 0, 0}}, {2.0002, {0.4, 0, 0}}}));
  run(b.world, 100, 0.05);
  const double off = worst(b.world, [](Vec3d x) {
    return x.x < 0.2 ? 2.0 : x.x > 0.4 && x.x < 0.6 ? 3.0 : 0.0;
  });
  EXPECT_LE(off, 0.05 + 2e-4);
}

TEST(MovingRegion, ComesInThroughWallsAndBehindPeriodicFaces) {
  MELTSIM_NEEDS_BACKEND();
  // From beyond the wall at -x through the bar and out at +x: every cell is passed.
  Bar b = bar(spot(slice(-0.4), {{0, {0, 0, 0}}, {24, {2.4, 0, 0}}}));
  run(b.world, 480, 0.05);
  EXPECT_LE(worst(b.world, [](Vec3d) { return 2.0; }), 0.1);
  // Two cells along y, once around the period and a half: every cell is passed, and half of them twice.
  Bar y = bar(spot(Shape::box({0, 0, 0}, {1.6, 2 * dx, width}), {{0, {0, 0, 0}}, {12, {0, 1.2, 0}}}));
  run(y.world, 240, 0.05);
  const double off = worst(y.world, [](Vec3d x) {
    double sum = 0;
    for (const double period : {-width, 0.0, width}) {
      const double from = std::max(0.0, (x.y - period - 2 * dx) / 0.1),
                   until = std::min(12.0, (x.y - period) / 0.1);
      sum += std::max(0.0, until - from);
    }
    return sum;
  });
  EXPECT_LE(off, 0.15);
  // One that reaches across the face from the start.
  Bar z = bar(spot(Shape::box({0, 0, 0.7}, {1.6, width, 0.9}), {{0, {0, 0, 0}}, {8, {0, 0, -0.8}}}));
  run(z.world, 160, 0.05);
  EXPECT_LE(worst(z.world, [](Vec3d) { return 2.0; }), 0.15);
}

// A host that says the line of the path gets the path: the same places, up to the rounding of a time.
TEST(MovingRegion, AHostMovesItAsAPathDoes) {
  MELTSIM_NEEDS_BACKEND();
  Bar path = bar(spot(slice(0), {{0, {0, 0, 0}}, {5, {0.5, 0, 0}}, {10, {0.25, 0, 0}}}));
  Bar host = bar(spot(slice(0)));
  require(host.world.move_heat_region(host.region, {}, {0.1, 0, 0}));
  run(path.world, 100, 0.05);
  run(host.world, 100, 0.05);
  require(host.world.move_heat_region(host.region, {0.5, 0, 0}, {-0.05, 0, 0}));
  run(path.world, 100, 0.05);
  run(host.world, 100, 0.05);
  const auto a = *path.world.particles(), b = *host.world.particles();
  for (std::size_t i = 0; i < a.id.size(); ++i) ASSERT_NEAR(a.temperature[i], b.temperature[i], 0.05) << i;
  // It stays where it is put, and what a host says counts for more than a path.
  require(path.world.move_heat_region(path.region, {1.4, 0, 0}));
  run(path.world, 20, 0.05);
  const auto after = *path.world.particles();
  for (std::size_t i = 0; i < a.id.size(); ++i)
    ASSERT_NEAR(after.temperature[i] - a.temperature[i], a.position[i].x > 1.4 ? 1 : 0, 1e-9)
        << a.position[i].x;
}

TEST(MovingRegion, HoldsAllThatItPassesAndAccountsForIt) {
  MELTSIM_NEEDS_BACKEND();
  HeatRegionDesc r = spot(slice(0), {{0, {0, 0, 0}}, {10, {1, 0, 0}}});
  r.source = 0;
  r.temperature = 50;
  Bar b = bar(r);
  run(b.world, 3, 3);  // it comes to 1.1 m at its front
  EXPECT_LE(worst(b.world, [](Vec3d x) { return x.x < 1.1 - 0.01   ? 50.0
                                                : x.x > 1.1 + 0.01 ? 0.0
                                                                   : 50.0; }),
            1e-9);
  EXPECT_NEAR(b.world.totals()->thermal / b.world.totals()->heat_in, 1, 1e-12);
}

// Where it is follows from the time alone: what goes on from a state goes on as it did.
TEST(MovingRegion, GoesOnFromASnapshotWithTheSameBits) {
  MELTSIM_NEEDS_BACKEND();
  Bar b = bar(spot(slice(0), {{0, {0, 0, 0}}, {14, {1.4, 0, 0}}}));
  run(b.world, 30, 0.1);
  const auto state = *b.world.snapshot();
  run(b.world, 30, 0.1);
  const std::uint64_t hash = *b.world.state_hash();
  require(b.world.restore(state.data(), state.size()));
  run(b.world, 30, 0.1);
  EXPECT_EQ(*b.world.state_hash(), hash);
  Bar other = bar(spot(slice(0), {{0, {0, 0, 0}}, {14, {1.4, 0, 0}}}));
  require(other.world.restore(state.data(), state.size()));
  run(other.world, 30, 0.1);
  EXPECT_EQ(*other.world.state_hash(), hash);
}

// As far and as fast as may be, within a blink too: it is over soon, and heats nothing.
TEST(MovingRegion, IsGoneAtOnceWhereItIsFasterThanAnything) {
  MELTSIM_NEEDS_BACKEND();
  Bar path = bar(spot(slice(0), {{1, {}}, {1 + 1e-15, {1e12, 0, 0}}}));
  run(path.world, 30, 0.1);
  EXPECT_LE(worst(path.world, [](Vec3d x) { return x.x < 0.2 ? 1.0 : 0.0; }), 1e-9);
  Bar host = bar(spot(slice(0)));
  require(host.world.move_heat_region(host.region, {}, {1e12, 0, 0}));
  run(host.world, 3, 1);
  EXPECT_LE(worst(host.world, [](Vec3d) { return 0.0; }),
            1.0 / 4096);  // the first of its places, half a share from where it was
}

// One that begins to act later is by then where its path, or the host, has it.
TEST(MovingRegion, MovesBeforeItActs) {
  MELTSIM_NEEDS_BACKEND();
  for (const bool by_host : {false, true}) {
    HeatRegionDesc r = spot(slice(0));
    if (!by_host) r.path = {{0, {0, 0, 0}}, {4, {0.8, 0, 0}}};
    r.from = 4;
    Bar b = bar(r);
    run(b.world, 10, 0.1);
    if (by_host) require(b.world.move_heat_region(b.region, {0.8, 0, 0}));
    run(b.world, 50, 0.1);
    EXPECT_LE(worst(b.world, [](Vec3d x) { return x.x > 0.8 && x.x < 1.0 ? 2.0 : 0.0; }), 1e-9) << by_host;
  }
}

TEST(MovingRegion, RefusesWhatCannotBeAndChangesNothing) {
  MELTSIM_NEEDS_BACKEND();
  Bar b = bar(spot(slice(0))), other = bar(spot(slice(0)));
  run(b.world, 10, 0.1);
  const std::uint64_t hash = *b.world.state_hash();
  const auto refused = [](const auto& r, const std::string& part) {
    ASSERT_FALSE(r) << part;
    EXPECT_EQ(r.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(r.error().message.find(part), std::string::npos) << r.error().message;
  };
  refused(b.world.move_heat_region(b.region, {std::nan(""), 0, 0}), "displacement: must be finite");
  refused(b.world.move_heat_region(b.region, {0, 1e300, 0}),
          "displacement: must be finite and at most 1e+12 m");
  refused(b.world.move_heat_region(b.region, {}, {0, infinity, 0}), "velocity: must be finite");
  refused(b.world.move_heat_region(other.region, {}), "no heat region of this World");
  HeatRegionDesc r = spot(slice(0), {{0, {}}, {0, {1, 0, 0}}});
  refused(b.world.add_heat_region(r), "path: point 1 is at 0 s, not after the one before it");
  r.path = {{0, {0, std::nan(""), 0}}};
  refused(b.world.add_heat_region(r), "path: point 0");
  r.path = {{0, {0, 1e300, 0}}};
  refused(b.world.add_heat_region(r), "at most 1e+12 m away");
  r.path = {{infinity, {}}};
  refused(b.world.add_heat_region(r), "path: point 0");
  r.path.assign((1u << 20) + 1, {});
  refused(b.world.add_heat_region(r), "path: at most 1048576 points");
  EXPECT_EQ(*b.world.state_hash(), hash);
  run(b.world, 10, 0.1);
  EXPECT_LE(worst(b.world, [](Vec3d x) { return x.x < 0.2 ? 2.0 : 0.0; }), 1e-9);
}

}  // namespace
}  // namespace meltsim_test
