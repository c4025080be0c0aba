// SPDX-License-Identifier: Apache-2.0
// Bodies that melt apart, and the paper's index arrays as the World hands them out.
#include <set>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

TEST(Topology, ABarMeltedThroughBecomesTwoBodies) {
  MELTSIM_NEEDS_BACKEND();
  IceScene scene;
  scene.block = 0;
  scene.box = 3.2;
  scene.depth = 2.0;
  Scene s = ice_in_water(describe(), scene);
  SolidDesc b;
  b.name = "dumbbell";
  // Two 4-site cubes joined by a neck one site thick: the neck goes first.
  b.shape = Shape::unite({Shape::box({0.4, 0.6, 1.0}, {1.2, 1.4, 1.8}),
                          Shape::box({1.2, 1.0, 1.4}, {2.0, 1.2, 1.6}),
                          Shape::box({2.0, 0.6, 1.0}, {2.8, 1.4, 1.8})});
  b.material = s.ice;
  b.temperature = -1;
  require(s.world.add_solid(b));
  EXPECT_EQ(s.world.pieces()->size(), 1u);
  std::vector<PieceInfo> pieces;
  for (int k = 0; k < 2000 && pieces.size() != 2; ++k) {
    require(s.world.step(0.005));
    ASSERT_FALSE(s.world.synchronize().halted);
    pieces = *s.world.pieces();
  }
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_EQ(pieces[0].name, "dumbbell");
  EXPECT_EQ(pieces[1].name, "dumbbell.2");
  EXPECT_GT(pieces[1].center.x - pieces[0].center.x, 0.8);
  // No region reaches across: every member of a region belongs to the vertex's own piece.
  const auto lattice = *s.world.lattice();
  const auto particles = *s.world.particles();
  std::vector<std::uint32_t> piece_of(lattice.live.size());
  for (std::size_t v = 0; v < piece_of.size(); ++v) piece_of[v] = particles.piece[lattice.particle_id[v]];
  const std::size_t side = static_cast<std::size_t>(2 * lattice.region_half_width + 1),
                    box = side * side * side;
  for (std::size_t v = 0; v < piece_of.size(); ++v) {
    if (!lattice.live[v]) continue;
    for (std::size_t k = 0; k < box; ++k) {
      const std::uint32_t member = lattice.arrayR[v * box + k];
      if (member != 0) {
        EXPECT_EQ(piece_of[member - 1], piece_of[v]);
      }
    }
  }
}

TEST(Topology, IndexArraysAreHandedOutInEveryKindOfScene) {
  MELTSIM_NEEDS_BACKEND();
  for (const bool fixed : {false, true}) {
    auto w = World::create(describe());
    ASSERT_TRUE(w);
    MaterialDesc m;
    m.name = "stone";
    m.region_half_width = 1;
    const auto stone = *w->add_material(m);
    SolidDesc b;
    b.shape = Shape::box({0, 0, 0}, {0.6, 0.6, 0.6});  // 3^3: the middle one is internal
    b.material = stone;
    b.fixed = fixed;
    require(w->add_solid(b));
    const auto l = *w->lattice();
    ASSERT_EQ(l.live.size(), 27u);
    for (std::uint32_t v = 0; v < 27; ++v) {
      EXPECT_EQ(l.arrayN[v * 27 + 13], v + 1);  // itself, numbered from 1
      std::set<std::uint32_t> n(l.arrayN.begin() + v * 27, l.arrayN.begin() + (v + 1) * 27);
      std::set<std::uint32_t> r(l.arrayR.begin() + v * 27, l.arrayR.begin() + (v + 1) * 27);
      EXPECT_EQ(n, r);  // w = 1: the region is the direct neighbourhood
      EXPECT_EQ(n.count(0), v == 13 ? 0u : 1u);
    }
  }
}

}  // namespace
}  // namespace meltsim_test
