// SPDX-License-Identifier: Apache-2.0
// Ways to find neighbours: the same physics, and each of them as deterministic as the grid.
#include <algorithm>
#include <set>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr NeighbourSearch searches[] = {NeighbourSearch::grid, NeighbourSearch::tree};

WorldDesc with(NeighbourSearch search) {
  WorldDesc d = describe();
  d.neighbour_search = search;
  return d;
}

void run(World& w, int steps) {
  for (int k = 0; k < steps; ++k) require(w.step(0.005));
  EXPECT_FALSE(w.synchronize().halted);
}

bool runs(const Plan& p, const std::string& stage) {
  const auto s =
      std::find_if(p.stages.begin(), p.stages.end(), [&](const auto& r) { return r.name == stage; });
  return s != p.stages.end() && s->runs;
}

// Sums in another order: 1e-16 of each, amplified by stiff liquid over some 40 sub-steps to 1e-12 at most.
TEST(Search, EveryStructureGivesTheSamePhysicsToRounding) {
  MELTSIM_NEEDS_BACKEND();
  std::vector<Vec3d> expected;
  std::vector<double> temperature;
  for (const NeighbourSearch search : searches) {
    WorldDesc d = with(search);
    d.precision = Precision::double_precision;
    Scene s = ice_in_water(d);
    run(s.world, 10);
    EXPECT_EQ(s.world.resolved().neighbour_search, search);
    const auto p = s.world.particles();
    require(p);
    if (search == NeighbourSearch::grid) {
      expected = p->position;
      temperature = p->temperature;
      continue;
    }
    ASSERT_EQ(p->position.size(), expected.size());
    double moved = 0, warmed = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      moved = std::max(moved, length(p->position[i] - expected[i]));
      warmed = std::max(warmed, std::fabs(p->temperature[i] - temperature[i]));
    }
    EXPECT_LT(moved, 1e-10);
    EXPECT_LT(warmed, 1e-8);
  }
}

TEST(Search, BitsDoNotDependOnTheNumberOfThreads) {
  MELTSIM_NEEDS_BACKEND();
  for (const NeighbourSearch search : searches) {
    std::set<std::uint64_t> hashes;
    for (const int threads : {1, 2, 5}) {
      WorldDesc d = with(search);
      d.threads = threads;
      Scene s = ice_in_water(d);
      run(s.world, 60);
      hashes.insert(*s.world.state_hash());
    }
    EXPECT_EQ(hashes.size(), 1u);
  }
}

TEST(Search, ASnapshotGoesOnWithTheSameBits) {
  MELTSIM_NEEDS_BACKEND();
  for (const NeighbourSearch search : searches) {
    Scene a = ice_in_water(with(search)), b = ice_in_water(with(search));
    run(a.world, 37);
    const auto bytes = *a.world.snapshot();
    require(b.world.restore(bytes.data(), bytes.size()));
    run(a.world, 40);
    run(b.world, 40);
    EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
  }
}

TEST(Search, EmissionMeetsEveryStructure) {
  MELTSIM_NEEDS_BACKEND();
  std::vector<double> heights;
  for (const NeighbourSearch search : searches) {
    Scene s = ice_in_water(with(search));
    EmitterDesc e;
    e.material = s.water;
    e.center = {1.2, 2.2, 1.2};
    e.axis = {0, -1, 0};
    e.radius = 0.3;
    e.speed = 3;
    e.temperature = 80;
    e.until = 0.2;
    require(s.world.add_emitter(e));
    run(s.world, 60);
    const auto p = s.world.particles();
    require(p);
    double sum = 0;
    for (const Vec3d& x : p->position) sum += x.y;
    heights.push_back(sum / static_cast<double>(p->position.size()));
  }
  // Single precision, chaotic: the mean height is all that must agree.
  EXPECT_NEAR(heights[1], heights[0], 2e-3 * heights[0]);
}

TEST(Search, ThePlanSaysWhichAndWhy) {
  MELTSIM_NEEDS_BACKEND();
  Scene grid = ice_in_water(describe()), tree = ice_in_water(with(NeighbourSearch::tree));
  EXPECT_TRUE(runs(grid.world.plan(), "spatial.cells"));
  EXPECT_FALSE(runs(grid.world.plan(), "spatial.walk"));
  EXPECT_TRUE(runs(tree.world.plan(), "spatial.walk"));
  EXPECT_FALSE(runs(tree.world.plan(), "spatial.cells"));
  EXPECT_EQ(grid.world.resolved().neighbour_search, NeighbourSearch::grid);
  EXPECT_EQ(tree.world.resolved().neighbour_reason, "asked for");
  // Nothing of the others is allocated.
  for (const ChannelReport& c : grid.world.plan().channels)
    if (c.name == "tree_box" || c.name == "sort_key") {
      EXPECT_EQ(c.bytes, 0u) << c.name;
    }
}

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
TEST(Search, WhatIsRetiredMeansTheGrid) {
  MELTSIM_NEEDS_BACKEND();
  Scene old = ice_in_water(with(NeighbourSearch::verlet)), grid = ice_in_water(with(NeighbourSearch::grid));
  EXPECT_EQ(old.world.resolved().neighbour_search, NeighbourSearch::grid);
  for (World* w : {&old.world, &grid.world}) run(*w, 5);
  EXPECT_EQ(*old.world.state_hash(), *grid.world.state_hash());
}
#pragma GCC diagnostic pop

TEST(Search, AnUnboundedDomainSaysWhatSearchesIt) {
  MELTSIM_NEEDS_BACKEND();
  for (const NeighbourSearch search : searches) {
    World w = *World::create(with(search));
    MaterialDesc water;
    FluidDesc f;
    f.material = *w.add_material(water);
    for (const double x : {-250.0, 250.0}) {  // two droplets 1000 H apart
      f.shape = Shape::sphere({x, 0, 0}, 0.7);
      require(w.add_fluid(f));
    }
    const Resolved r = w.resolved();
    EXPECT_EQ(r.neighbour_search,
              search == NeighbourSearch::tree ? NeighbourSearch::tree : NeighbourSearch::grid);
    EXPECT_NE(r.neighbour_reason, "");
    run(w, 10);
  }
}

}  // namespace
}  // namespace meltsim_test
