// SPDX-License-Identifier: Apache-2.0
// arrayN, arrayR and SBP after uploads with holes and after melting, exactly.
#include <gtest/gtest.h>

#include "modules/lattice_oracle.hpp"

namespace {

using namespace modules_test;

constexpr core::FactSet facts = core::fact_particles | core::fact_fluid | core::fact_solid |
                                core::fact_mobile | core::fact_lattice | core::fact_contact | core::fact_melt;

struct Bodies {
  core::SceneConstants constants = plain_constants();
  core::SceneLattice lattice;
  core::SceneState state;
  void add(const std::vector<Vec3i>& points, int w) { add_body(lattice, state, constants, points, w); }
  std::uint32_t vertices() const { return static_cast<std::uint32_t>(lattice.vertex_site.size()); }
  int half_width(std::uint32_t v) const { return lattice.bodies[lattice.vertex_body[v]].region_half_width; }
};

core::LatticeMasks masks(const Bodies& b) {
  Rig<float> rig;
  rig.upload(b.constants, b.lattice, b.state, facts);
  core::LatticeMasks m;
  rig.engine->download(m);
  return m;
}

void expect_equal(const Bodies& b, const std::vector<std::uint32_t>& state, const core::LatticeMasks& m) {
  const LatticeOracle oracle(b.lattice, state);
  for (std::uint32_t v = 0; v < b.vertices(); ++v) {
    ASSERT_EQ(m.neighbour_mask[v], oracle.neighbour_mask(v)) << "vertex " << v;
    ASSERT_EQ(offsets(m, v, b.half_width(v)), oracle.region(v, b.half_width(v))) << "vertex " << v;
  }
}

// w = 0..8 with 30 % of the vertices gone: enough for gaps to cut, few enough to stay connected in parts.
TEST(Regions, EqualBreadthFirstSearch) {
  for (int w = 0; w <= 8; ++w) {
    Random random(90 + static_cast<std::uint32_t>(w));
    Bodies b;
    b.add(block(5, 4, 4), w);
    for (auto& s : b.state.vertex_state) s = random.uniform() < 0.3 ? 0 : 1;
    SCOPED_TRACE("w " + std::to_string(w));
    expect_equal(b, b.state.vertex_state, masks(b));
  }
}

// Masks are as wide as the largest w; each body uses its own.
TEST(Regions, BodiesOfDifferentWidths) {
  Bodies b;
  b.add(block(4, 4, 4), 1);
  b.add(block(5, 3, 3), 3);
  b.add(block(3, 3, 3), 0);
  expect_equal(b, b.state.vertex_state, masks(b));
}

TEST(Regions, SmallBodies) {
  Bodies b;
  b.add({{5, -3, 2}}, 2);
  b.add({{0, 0, 0}, {1, 1, 1}}, 4);
  b.add({{0, 0, 0}, {2, 0, 0}}, 4);  // not neighbours
  expect_equal(b, b.state.vertex_state, masks(b));
}

// The paper's Fig. 3 in kind: a plate with a slit that starts at the edge. (2, 4) and (4, 4) on its two sides
// are two columns apart, but the way round its end takes four steps: w = 3 must not see across, w = 4 must.
TEST(Regions, ASlitCuts) {
  std::vector<Vec3i> plate;
  for (int y = 0; y < 7; ++y)
    for (int x = 0; x < 7; ++x)
      if (x != 3 || y == 6) plate.push_back({x, y, 0});
  for (const int w : {3, 4}) {
    Bodies b;
    b.add(plate, w);
    const core::LatticeMasks m = masks(b);
    const std::uint32_t left = vertex_at(b.lattice, 0, {2, 4, 0});
    EXPECT_EQ(offsets(m, left, w).count({2, 0, 0}), w == 4 ? 1u : 0u);
    expect_equal(b, b.state.vertex_state, m);
  }
}

// Twelve steps in which a random tenth is made hot. Exactly the surface particles that hold their latent heat
// melt; arrays kept up to date equal those of a search on what is left, and of an upload of it.
TEST(Melting, IncrementalEqualsFullRebuild) {
  for (const int w : {1, 2, 4}) {
    Random random(100 + static_cast<std::uint32_t>(w));
    Bodies b;
    b.add(block(6, 5, 5), w);
    b.add(block(3, 3, 4), 1);
    b.add(ball(4.2), w);  // regions beside its surface have rows of which no vertex is the middle
    Rig<float> rig;
    rig.upload(b.constants, b.lattice, b.state, facts);
    const core::Frame<float>& f = rig.frame();
    rig.run({"step.begin", "spatial", "spatial.neighbours", "topology"});
    std::uint64_t melted = 0;
    for (int round = 0; round < 12; ++round) {
      SCOPED_TRACE("w " + std::to_string(w) + ", round " + std::to_string(round));
      std::vector<std::uint32_t> before(f.f.vertex_state, f.f.vertex_state + f.vertices), expected = before;
      for (std::uint32_t v = 0; v < f.vertices; ++v) {
        if (expected[v] != 1u) expected[v] = 0;
        const std::uint32_t slot = f.f.slot_of_id[f.f.vertex_id[v]];
        const bool hot = random.uniform() < 0.1;
        // Solid at 0 J/kg is all liquid: 1000 of latent heat above -1000.
        if (hot) f.f.enthalpy[slot] = 1.0 * static_cast<double>(f.f.mass[slot]);
        const bool melts = f.f.enthalpy[slot] > 0 && (f.f.tag[slot] & tag_surface) != 0u;
        if (before[v] == 1u && melts) {
          expected[v] = 2;
          ++melted;
        }
      }
      rig.run({"step.begin", "spatial", "spatial.neighbours", "topology"});
      const std::vector<std::uint32_t> after(f.f.vertex_state, f.f.vertex_state + f.vertices);
      ASSERT_EQ(after, expected);
      ASSERT_EQ(static_cast<std::size_t>(f.f.status->melted), melted);
      core::LatticeMasks kept;
      rig.engine->download(kept);
      ASSERT_NO_FATAL_FAILURE(expect_equal(b, after, kept));
      for (std::uint32_t v = 0; v < f.vertices; ++v) {
        const std::uint32_t tag = f.f.tag[f.f.slot_of_id[f.f.vertex_id[v]]];
        ASSERT_EQ(is_solid(tag), after[v] == 1u);
        ASSERT_EQ(material_of(tag), after[v] == 1u ? 1u : 0u);
        ASSERT_EQ((tag & tag_surface) != 0u, after[v] == 1u && popcount(kept.neighbour_mask[v]) < 27u);
      }
      // How many melted in this round: what asks for it has nothing to do where nobody has.
      ASSERT_EQ(f.f.status->died, std::count(after.begin(), after.end(), 2u));
      Bodies fresh = b;
      rig.engine->download(fresh.state);
      const core::LatticeMasks full = masks(fresh);
      ASSERT_EQ(kept.neighbour_mask, full.neighbour_mask);
      ASSERT_EQ(kept.region_mask, full.region_mask);
    }
    EXPECT_GT(melted, 50u);
  }
}

// Heat everything far beyond melting: an internal particle may hold it, but leaves only once exposed; layer
// by layer, 7^3 takes four steps.
TEST(Melting, FromTheOutsideIn) {
  Bodies b;
  b.add(block(7, 7, 7), 2);
  b.state.enthalpy.assign(b.state.enthalpy.size(), 1e9);
  Rig<double> rig;
  rig.upload(b.constants, b.lattice, b.state, facts);
  for (int step = 1; step <= 5; ++step) {
    rig.run({"step.begin", "spatial", "spatial.neighbours", "topology"});
    const auto& f = rig.frame();
    for (std::uint32_t v = 0; v < f.vertices; ++v) {
      const Vec3i p = b.lattice.vertex_coordinates[v];
      const int depth = std::min({p.x, p.y, p.z, 6 - p.x, 6 - p.y, 6 - p.z});
      ASSERT_EQ(f.f.vertex_state[v], depth >= step ? 1u : depth == step - 1 ? 2u : 0u) << "step " << step;
    }
    ASSERT_TRUE(step < 4 || f.f.status->melted == 343);
  }
}

}  // namespace
