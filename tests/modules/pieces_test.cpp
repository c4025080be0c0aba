// SPDX-License-Identifier: Apache-2.0
// Labels of connected pieces equal those of a flood fill: the smallest vertex of each.
#include <gtest/gtest.h>

#include "modules/lattice_oracle.hpp"

namespace {

using namespace modules_test;

constexpr core::FactSet facts = core::fact_particles | core::fact_fluid | core::fact_solid |
                                core::fact_mobile | core::fact_lattice | core::fact_contact | core::fact_melt;

/// Uploads, searches once, and compares.
void search(const core::SceneConstants& c, const core::SceneLattice& l, const core::SceneState& s) {
  Rig<float> rig;
  rig.upload(c, l, s, facts);
  rig.run({"step.begin", "spatial", "topology.pieces"});
  const core::Frame<float>& f = rig.frame();
  const LatticeOracle oracle(l, s.vertex_state);
  for (std::uint32_t v = 0; v < f.vertices; ++v)
    if (s.vertex_state[v] == 1u && f.f.vertex_piece[v] != oracle.piece(v)) {
      ADD_FAILURE() << "vertex " << v << ": " << f.f.vertex_piece[v] << ", not " << oracle.piece(v);
      break;
    }
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
    SCOPED_TRACE(gone);
    search(c, l, s);
  }
}

// A bar melted through in the middle: two labels.
TEST(Pieces, ABarComesApart) {
  const auto c = plain_constants();
  core::SceneLattice l;
  core::SceneState s;
  add_body(l, s, c, block(9, 2, 2), 1);
  search(c, l, s);
  for (std::uint32_t v = 0; v < s.vertex_state.size(); ++v)
    if (l.vertex_coordinates[v].x == 4) s.vertex_state[v] = 0;
  search(c, l, s);
}

/// Two arms of so many layers towards -z, where the smallest vertices of each arm lie: each is a tree of its own
/// until the roots are joined at the far end.
TEST(Pieces, LongArmsAreOnePiece) {
  for (const int layers : {12, 60}) {
    const auto c = plain_constants();
    core::SceneLattice l;
    core::SceneState s;
    std::vector<Vec3i> body;
    for (int z = 0; z <= layers; ++z)
      for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 9; ++x)
          if (z == layers || x < 3 || x > 5) body.push_back({x, y, z});
    add_body(l, s, c, body, 1);
    search(c, l, s);
  }
}

// As far as there is to go: one link wide, 300 links long.
TEST(Pieces, AWindingPathIsOnePiece) {
  const auto c = plain_constants();
  core::SceneLattice l;
  core::SceneState s;
  std::vector<Vec3i> path;
  for (int row = 0; row < 12; ++row) {
    for (int x = 0; x < 24; ++x) path.push_back({x, 2 * row, 0});
    if (row < 11) path.push_back({row % 2 == 0 ? 24 : -1, 2 * row + 1, 0});
  }
  add_body(l, s, c, path, 1);
  search(c, l, s);
}

}  // namespace
