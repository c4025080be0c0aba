// SPDX-License-Identifier: Apache-2.0
// A body that joins the scene on the backend: its part of every channel of the lattice is what an upload of both makes of it.
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "engine.hpp"

namespace modules_test {
namespace {

constexpr core::FactSet facts = core::fact_particles | core::fact_fluid | core::fact_solid |
                                core::fact_mobile | core::fact_lattice | core::fact_contact |
                                core::fact_melt | core::fact_freeze | core::fact_events;

struct Bodies {
  core::SceneConstants constants = plain_constants();
  core::SceneLattice lattice;
  core::SceneState state;
  void add(const std::vector<Vec3i>& points, int w, const std::vector<Vec3i>& free) {
    add_body(lattice, state, constants, points, w, free);
    state.forces.push_back({});
    state.motion.push_back({});
    lattice.rests.push_back({});
  }
};

core::EngineSetup setup_with_room(std::uint64_t particles) {
  core::EngineSetup setup = setup_for(facts, particles);
  setup.room = {2000, 20000, 4};
  setup.searched = particles;
  return setup;
}

/// What differs: the name of a channel, and where.
template <class V>
void same(const char* name, const V* a, const V* b, std::size_t first, std::size_t end) {
  ASSERT_EQ(a == nullptr, b == nullptr) << name;
  ASSERT_NE(a, nullptr) << name;
  for (std::size_t k = first; k < end; ++k)
    ASSERT_EQ(std::memcmp(a + k, b + k, sizeof(V)), 0) << name << " at " << k;
}

TEST(AddedBody, HasTheLatticeThatAnUploadMakes) {
  for (const int w : {1, 2, 3}) {
    SCOPED_TRACE(w);
    Bodies first;
    first.constants.event_kinds = 127;
    first.constants.event_capacity = 16;
    first.add(block(5, 4, 3), w, {});
    Bodies both = first;
    // A ball, so that rows and planes beside it are empty; sites to grow into, and labels of their own there.
    std::vector<Vec3i> points = ball(3.2), free;
    for (Vec3i& p : points) p = {p.x + 20, p.y, p.z};
    for (int y = -1; y <= 1; ++y) free.push_back({20, y, 5});
    both.add(points, w, free);
    const std::uint64_t old = first.state.position.size(), all = both.state.position.size();
    core::AddedBody added;
    added.body = 1;
    added.first_vertex = static_cast<std::uint32_t>(first.lattice.vertex_site.size());
    added.first_site = first.lattice.site_vertex.size();
    added.largest_mass = both.constants.largest_mass;
    core::SceneState more;
    for (std::uint64_t i = old; i < all; ++i) {
      more.position.push_back(both.state.position[i]);
      more.velocity.push_back(both.state.velocity[i]);
      more.volume.push_back(both.state.volume[i]);
      more.mass.push_back(both.state.mass[i]);
      more.enthalpy.push_back(both.state.enthalpy[i]);
      more.tag.push_back(both.state.tag[i]);
      more.vertex_of_id.push_back(both.state.vertex_of_id[i]);
    }
    Rig<float> joined, uploaded;
    ASSERT_TRUE(joined.engine->upload(first.constants, first.lattice, first.state, setup_with_room(all)));
    ASSERT_TRUE(joined.engine->append(more, false, added.first_vertex));
    ASSERT_TRUE(joined.engine->add_body(both.lattice, both.state, added));
    ASSERT_TRUE(uploaded.engine->upload(both.constants, both.lattice, both.state, setup_with_room(all)));
    const auto &a = joined.frame().f, &b = uploaded.frame().f;
    const std::size_t from = added.first_vertex, vertices = both.lattice.vertex_site.size(),
                      sites = both.lattice.site_vertex.size(), words = joined.frame().region_words;
    ASSERT_EQ(words, uploaded.frame().region_words);
#define SAME(name, first, end) same(#name, a.name, b.name, first, end)
    SAME(vertex_id, 0, vertices);
    SAME(vertex_site, 0, vertices);
    SAME(vertex_body, 0, vertices);
    SAME(contact_shape, 0, vertices);
    SAME(vertex_state, 0, vertices);
    SAME(vertex_piece, 0, vertices);
    SAME(seen_piece, 0, vertices);
    SAME(neighbour_mask, 0, vertices);
    SAME(region_mask, 0, vertices * words);
    SAME(region_members, 0, vertices);
    SAME(region_rotation, 0, vertices);
    SAME(contact_slip, 0, vertices);
    SAME(site_vertex, 0, sites);
    SAME(bodies, 0, 2);
    SAME(vertex_of_id, 0, all);
    SAME(seen_tag, 0, all);
    // Bits of sites beyond the last word are not both bodies' own.
    SAME(site_live, 0, sites / 32);
#undef SAME
    // Otherwise nothing above says that marks are made.
    std::size_t marked = 0;
    for (std::size_t s = added.first_site; s < sites; ++s)
      marked += a.site_vertex[s] == core::empty_row || a.site_vertex[s] == core::empty_plane;
    EXPECT_GT(marked, 0u);
    for (std::size_t v = from; v < vertices; ++v) {
      const bool free_site = both.state.vertex_state[v] == core::vertex_free;
      EXPECT_EQ(a.seen_piece[v], free_site ? v : from);
    }
  }
}

// A checked engine counts the mass of what was appended, too: if some of that is lost, it says so.
TEST(AddedBody, CountsInTheMassOfCheckedEngines) {
  const auto c = plain_constants();
  core::SceneState s, more;
  for (int i = 0; i < 3; ++i) add_particle(s, c, {0.2 * i, 0, 0}, 0);
  for (int i = 0; i < 2; ++i) add_particle(more, c, {0.2 * i, 0.2, 0}, 0);
  Rig<double> rig;
  core::EngineSetup setup = setup_for(core::fact_particles | core::fact_fluid, 5);
  setup.searched = 5;
  ASSERT_TRUE(rig.engine->upload(c, {}, s, setup));
  ASSERT_TRUE(rig.engine->append(more, false, core::none));
  core::SubstepArguments a;
  a.dt = 1e-6;
  for (const char* module : {"step.begin", "spatial"}) a.stages |= stage_bits(module, setup.facts);
  a.index = 1;
  rig.engine->substep(a);
  EXPECT_EQ(rig.engine->fault(), "");
  const auto& f = rig.frame().f;
  f.mass[f.slot_of_id[4]] *= 0.5;
  a.index = 2;
  rig.engine->substep(a);
  EXPECT_NE(rig.engine->fault().find("mass fell"), std::string::npos);
}

}  // namespace
}  // namespace modules_test
