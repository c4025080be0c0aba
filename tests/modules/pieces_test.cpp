// SPDX-License-Identifier: Apache-2.0
// Labels of connected pieces equal those of a flood fill: the smallest vertex of each.
#include <gtest/gtest.h>

#include "modules/lattice_oracle.hpp"

namespace {

using namespace modules_test;

constexpr std::uint32_t facts = core::fact_particles | core::fact_fluid | core::fact_solid |
                                core::fact_mobile | core::fact_contact | core::fact_melt;

/// Uploads, searches once, and returns whether the labels were taken over.
bool search(const core::SceneConstants& c, const core::SceneLattice& l, const core::SceneState& s) {
  Rig<float> rig;
  rig.upload(c, l, s, facts);
  rig.run({"step.begin", "spatial", "topology.pieces"});
  const core::Frame<float>& f = rig.frame();
  const LatticeOracle oracle(l, s.vertex_state);
  if (f.f.status->labels_unsettled != 0u) {
    for (std::uint32_t v = 0; v < f.vertices; ++v) EXPECT_EQ(f.f.vertex_piece[v], s.vertex_piece[v]);
    return false;
  }
  for (std::uint32_t v = 0; v < f.vertices; ++v)
    if (s.vertex_state[v] == 1u && f.f.vertex_piece[v] != oracle.piece(v)) {
      ADD_FAILURE() << "vertex " << v << ": " << f.f.vertex_piece[v] << ", not " << oracle.piece(v);
      break;
    }
  return true;
}

// From whole over the percolation threshold of 26 neighbours (about 10 % live) to dust.
TEST(Pieces, EqualFloodFill) {
  for (const double gone : {0.0, 0.3, 0.7, 0.85, 0.9, 0.95}) {
    Random random(111);
    const auto c = plain_constants();
    core::SceneLattice l;
    core::SceneState s;
    add_body(l, s, c, block(9, 8, 8), 1);
    add_body(l, s, c, block(4, 4, 4), 2);
    for (auto& state : s.vertex_state) state = random.uniform() < gone ? 0 : 1;
    EXPECT_TRUE(search(c, l, s)) << gone;
  }
}

// A bar melted through in the middle: two labels.
TEST(Pieces, ABarComesApart) {
  const auto c = plain_constants();
  core::SceneLattice l;
  core::SceneState s;
  add_body(l, s, c, block(9, 2, 2), 1);
  EXPECT_TRUE(search(c, l, s));
  for (std::uint32_t v = 0; v < s.vertex_state.size(); ++v)
    if (l.vertex_coordinates[v].x == 4) s.vertex_state[v] = 0;
  EXPECT_TRUE(search(c, l, s));
}

/// A body with two arms of this many layers towards -z, where the smallest vertices of each arm lie.
bool arms_settle(int layers) {
  const auto c = plain_constants();
  core::SceneLattice l;
  core::SceneState s;
  std::vector<Vec3i> body;
  for (int z = 0; z <= layers; ++z)
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 9; ++x)
        if (z == layers || x < 3 || x > 5) body.push_back({x, y, z});
  add_body(l, s, c, body, 1);
  return search(c, l, s);
}

TEST(Pieces, ArmsAreOnePiece) { EXPECT_TRUE(arms_settle(12)); }

// Known limit: the labels of the second arm gather at its own smallest vertex at once, but the first arm's
// label then advances one step a round. 24 rounds do not cross 20 layers.
TEST(Pieces, LongArmsAreOnePiece) { EXPECT_TRUE(arms_settle(60)); }

// Whether or not a winding path is crossed in the rounds there are: old labels stay, or the new ones are
// right.
TEST(Pieces, AnUnfinishedSearchChangesNothing) {
  const auto c = plain_constants();
  core::SceneLattice l;
  core::SceneState s;
  std::vector<Vec3i> path;
  for (int row = 0; row < 12; ++row) {
    for (int x = 0; x < 24; ++x) path.push_back({x, 2 * row, 0});
    if (row < 11) path.push_back({row % 2 == 0 ? 24 : -1, 2 * row + 1, 0});
  }
  add_body(l, s, c, path, 1);
  for (std::uint32_t v = 0; v < s.vertex_piece.size(); ++v) s.vertex_piece[v] = v / 7;
  search(c, l, s);
}

}  // namespace
