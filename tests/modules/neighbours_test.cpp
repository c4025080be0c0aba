// SPDX-License-Identifier: Apache-2.0
// Neighbour sets equal those of all pairs. Distances are taken in the World's precision by both; pairs within
// 1e-5 of H are left out: at the border of a cell a rounded coordinate may fall on either side, and W is
// below 1e-19 of its peak there.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <set>

#include "modules/engine.hpp"
#include "spatial/neighbours.hpp"
#include "spatial/tree_bodies.hpp"

namespace {

using namespace modules_test;

constexpr double spacing = 0.2, support = 0.5;

struct Cloud {
  core::SceneConstants constants = plain_constants(spacing);
  core::SceneState state;
  void add(Vec3d x, std::uint32_t tag = 0) { add_particle(state, constants, x, tag); }
  void bound(Vec3d max, bool px = false, bool py = false, bool pz = false) {
    DomainDesc& d = constants.domain;
    d.bounded = true;
    d.max = max;
    const bool periodic[3] = {px, py, pz};
    for (std::size_t a = 0; a < 3; ++a)
      if (periodic[a]) d.faces[2 * a] = d.faces[2 * a + 1] = Face::periodic;
  }
};

template <class T>
class Neighbours : public testing::Test {
 protected:
  /// Largest number of candidates in a row.
  static std::uint32_t check(const Cloud& cloud) {
    if (cloud.constants.domain.bounded) check(cloud, core::fact_packed);
    check(cloud, core::fact_tree);
    return check(cloud, core::fact_sparse);
  }
  static std::uint32_t check(const Cloud& cloud, std::uint32_t search) {
    Rig<T> rig;
    rig.upload(cloud.constants, {}, cloud.state, core::fact_particles | search);
    rig.run({"step.begin", "spatial"});
    return compare(cloud, rig.frame());
  }
  static std::uint32_t compare(const Cloud& cloud, const core::Frame<T>& w) {
    std::uint32_t widest = 0;
    EXPECT_EQ(w.particles, cloud.state.position.size());
    for (std::uint32_t i = 0; i < w.particles; ++i) {
      if (w.slots_of_all || is_removed(w.f.tag[i])) {
        EXPECT_EQ(w.f.slot_of_id[w.f.id[i]], i);
      }
      if (is_removed(w.f.tag[i])) {
        EXPECT_EQ(w.f.group_of[i], core::none);
        continue;
      }
      std::vector<std::uint32_t> found, up, down;
      spatial::for_each_neighbour(w, i, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& d, T r2) {
        EXPECT_EQ(xj.x, w.f.position[j].x);
        EXPECT_EQ(r2, dot(d, d));
        found.push_back(j);
      });
      spatial::with_periods(w, [&](auto p) {
        const auto note = [](auto& list) {
          return [&list](std::uint32_t j, const Vec4<T>&, const Vec3<T>&, T) { list.push_back(j); };
        };
        spatial::for_each_in_row_order<p(), true>(w, i, note(up));
        spatial::for_each_in_row_order<p(), false>(w, i, note(down));
      });
      EXPECT_TRUE(by_rows(w, i, up)) << "order of " << i;
      if (w.grid.periodic == 0u) {
        EXPECT_TRUE(std::is_sorted(up.begin(), up.end())) << "order of " << i;
      }
      std::reverse(down.begin(), down.end());
      EXPECT_EQ(down, up) << "reversed order of " << i;
      auto words = found, rows = up;
      std::sort(words.begin(), words.end());
      std::sort(rows.begin(), rows.end());
      EXPECT_EQ(words, rows) << "neighbours of " << i;
      for (const std::uint32_t room : {16u, 2u}) compare_shared(w, i, words, room);
      const spatial::Rows<true, T> ranges(w, i);
      for (std::uint32_t r = 0; r < w.grid.rows; ++r) {
        const core::Range row = ranges[r];
        widest = std::max(widest, row.end - row.begin);
      }
      const std::set<std::uint32_t> unique(found.begin(), found.end());
      EXPECT_EQ(unique.size(), found.size()) << "a neighbour of " << i << " comes twice";
      for (std::uint32_t j = 0; j < w.particles; ++j) {
        const double r = distance(cloud.constants, w, i, j);
        if (std::fabs(r / support - 1) < 1e-5) continue;
        const bool expected = r < support && !is_removed(w.f.tag[j]);
        if (expected == (unique.count(j) != 0)) continue;
        ADD_FAILURE() << i << " and " << j << " at distance " << r;
        return widest;
      }
    }
    return widest;
  }
  /// Three parts search, their words are joined and shared out: as where threads share sums. In too little room
  /// rows are searched again.
  static void compare_shared(core::Frame<T> w, std::uint32_t i, const std::vector<std::uint32_t>& expected,
                             std::uint32_t room) {
    static std::vector<core::NeighbourWord> table;
    w.words_parts = 3;
    w.words_room = room;
    table.assign(w.words_column / sizeof(core::NeighbourWord) * 3 * (room + 1), {0u, 0u});
    w.f.neighbour_words = table.data();
    spatial::with_search(w, [&](auto kind) {
      std::vector<std::uint32_t> found;
      const auto note = [&found](std::uint32_t j, const Vec4<T>&, const Vec3<T>&, T) { found.push_back(j); };
      const auto is_all = [&](const char* what) {
        std::sort(found.begin(), found.end());
        EXPECT_EQ(found, expected) << what << " of " << i << ", room for " << room;
        found.clear();
      };
      for (std::uint32_t k = 0; k < 3; ++k) spatial::find_part<kind()>(w, i, k, 3u, [](const Vec4<T>&, T) {});
      spatial::join_words(w, i);
      // Everyone but the neighbours marked, then one of them, too.
      std::vector<std::uint32_t> marks(w.particles / 32 + 2, ~0u);
      for (const std::uint32_t j : expected) marks[j / 32] &= ~(1u << j % 32);
      EXPECT_FALSE(spatial::any_marked(w, i, marks.data())) << i;
      const std::uint32_t one = expected[i % expected.size()];
      marks[one / 32] |= 1u << one % 32;
      EXPECT_TRUE(spatial::any_marked(w, i, marks.data())) << i << ", marked " << one;
      const bool fits = table[i].first != spatial::too_many;
      if (fits) {
        EXPECT_EQ(spatial::neighbours_in(table[i]), expected.size());
      }
      for (const std::uint32_t parts : {1u, 3u, 9u}) {
        for (std::uint32_t k = 0; k < parts; ++k) {
          const std::size_t before = found.size();
          spatial::sweep_part<kind() == spatial::SearchKind::periodic>(w, i, k, parts, note);
          if (!fits) continue;
          EXPECT_LE(found.size() - before, expected.size() / parts + 1) << "share " << k << " of " << i;
          EXPECT_GE(found.size() - before, expected.size() / parts) << "share " << k << " of " << i;
        }
        is_all("shares");
      }
    });
  }
  /// Whether a list goes through the rows of i, slots ascending in each.
  static bool by_rows(const core::Frame<T>& w, std::uint32_t i, const std::vector<std::uint32_t>& list) {
    std::size_t at = 0;
    const spatial::Rows<true, T> rows(w, i);
    for (std::uint32_t r = 0; r < w.grid.rows; ++r) {
      const core::Range row = rows[spatial::row_upwards(w, r)];
      for (std::uint32_t j = row.begin; j < row.end; ++j)
        if (at < list.size() && list[at] == j) ++at;
    }
    return at == list.size();
  }
  /// Shortest, over all images, without the library's own wrapping.
  static double distance(const core::SceneConstants& c, const core::Frame<T>& w, std::uint32_t i,
                         std::uint32_t j) {
    const Vec3d d = cast<double>(xyz(w.f.position[i]) - xyz(w.f.position[j]));
    const Vec3d e = c.domain.max - c.domain.min;
    const auto shortest = [&](double a, double period, std::size_t face) {
      if (!c.domain.bounded || c.domain.faces[face] != Face::periodic) return std::fabs(a);
      return std::min({std::fabs(a), std::fabs(a - period), std::fabs(a + period)});
    };
    return length(Vec3d{shortest(d.x, e.x, 0), shortest(d.y, e.y, 2), shortest(d.z, e.z, 4)});
  }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Neighbours, Scalars);

TYPED_TEST(Neighbours, RandomCloud) {
  Random random(71);
  Cloud c;
  c.bound({2, 3, 2.5});
  for (int n = 0; n < 1200; ++n) c.add({random.uniform(0, 2), random.uniform(0, 3), random.uniform(0, 2.5)});
  this->check(c);
}

TYPED_TEST(Neighbours, Lattice) {
  Cloud c;
  c.bound({2, 2, 2});
  for (const Vec3i& p : block(10, 10, 10)) c.add(Vec3d{p.x + 0.5, p.y + 0.5, p.z + 0.5} * spacing);
  this->check(c);
}

// Rows longer than a word, some with as many words as there is room for (16 of 32 candidates), some with more,
// which are searched again.
TYPED_TEST(Neighbours, CrowdedCellsExceedTheWords) {
  Random random(72);
  for (const int crowd : {150, 300, 700}) {
    Cloud c;
    c.bound({3, 3, 3});
    for (int n = 0; n < crowd; ++n) c.add(Vec3d{1.25, 1.25, 1.25} + random.vector(0.24));      // one cell
    for (int n = 0; n < crowd / 2; ++n) c.add(Vec3d{1.75, 1.25, 1.25} + random.vector(0.24));  // the next
    for (int n = 0; n < 300; ++n) c.add(Vec3d{1.5, 1.5, 1.5} + random.vector(1.4));
    const std::size_t most = this->check(c);
    EXPECT_GT(most, static_cast<std::size_t>(crowd));
    if (crowd == 700) {
      EXPECT_GT(most, 16u * 32u);
    }
  }
}

TYPED_TEST(Neighbours, SparseUnbounded) {
  Random random(73);
  Cloud c;
  for (int n = 0; n < 100; ++n) {
    const Vec3d x = random.vector(200);
    c.add(x);
    c.add(x + random.vector(0.4));
  }
  this->check(c);
}

TYPED_TEST(Neighbours, UnboundedAroundTheOrigin) {
  Random random(74);
  Cloud c;
  for (int n = 0; n < 800; ++n) c.add(random.vector(1.2));
  this->check(c);
}

// Three cells an axis, the fewest there can be, up to seven; along one axis and all.
TYPED_TEST(Neighbours, Periodic) {
  Random random(75);
  for (int which = 1; which < 8; ++which) {
    Cloud c;
    const Vec3d max{which % 2 ? 1.5 : 3.4, 2.1, which > 3 ? 1.6 : 2.7};
    c.bound(max, which & 1, which & 2, which & 4);
    for (int n = 0; n < 500; ++n)
      c.add({random.uniform(0, max.x), random.uniform(0, max.y), random.uniform(0, max.z)});
    c.add({0, 0, 0});
    this->check(c);
  }
}

// Outside a bounded domain: counted to the border cells, still found.
TYPED_TEST(Neighbours, OutsideTheDomain) {
  Random random(76);
  Cloud c;
  c.bound({2, 2, 2});
  for (int n = 0; n < 400; ++n) c.add(Vec3d{1, 1, 1} + random.vector(1.3));
  this->check(c);
}

TYPED_TEST(Neighbours, RemovedParticlesAreNobodysNeighbours) {
  Random random(77);
  for (const bool bounded : {true, false}) {
    Cloud c;
    if (bounded) c.bound({2, 2, 2});
    for (std::uint32_t n = 0; n < 400; ++n)
      c.add(Vec3d{1, 1, 1} + random.vector(0.9), n % 3 ? 0 : tag_removed);
    this->check(c);
    Cloud gone;
    for (int n = 0; n < 5; ++n) gone.add({1, 1, 1}, tag_removed);
    this->check(gone);
  }
}

TYPED_TEST(Neighbours, FewParticles) {
  Cloud none, one, two, coincident;
  one.add({0.3, 0.2, 0.1});
  two.add({-0.1, 0, 0});
  two.add({0.2, 0.1, 0});
  for (int n = 0; n < 40; ++n) coincident.add({0.5, 0.5, 0.5});
  for (Cloud* c : {&none, &one, &two, &coincident}) this->check(*c);
}

// Ids ascend within a cell whatever order the state came in: sums then have one order only.
TYPED_TEST(Neighbours, SlotsAreInOrderOfCellThenId) {
  Random random(78);
  Cloud c;
  c.bound({2, 2, 2});
  for (int n = 0; n < 500; ++n) c.add(Vec3d{1, 1, 1} + random.vector(1));
  for (const std::uint32_t search : {core::fact_packed, core::fact_sparse}) {
    Rig<TypeParam> rig;
    rig.upload(c.constants, {}, c.state, core::fact_particles | search);
    for (int n = 0; n < 3; ++n) rig.run({"step.begin", "spatial"});
    const auto& w = rig.frame();
    for (std::uint32_t i = 1; i < w.particles; ++i) {
      ASSERT_LE(w.f.group_of[i - 1], w.f.group_of[i]);
      ASSERT_TRUE(w.f.group_of[i - 1] != w.f.group_of[i] || w.f.id[i - 1] < w.f.id[i]);
    }
  }
}

// What integration counts ahead for the next sub-step: everyone once; but not who has no place to be counted at, which
// as an index would be anything.
TYPED_TEST(Neighbours, CountedAheadIsWhoHasAPlace) {
  for (const bool good : {true, false}) {
    Cloud c;
    c.bound({2, 2, 2});
    for (int n = 0; n < 100; ++n) c.add({0.3 + 0.1 * (n % 10), 0.3 + 0.1 * (n / 10), 1});
    if (!good) c.constants.surroundings.gravity.y = std::numeric_limits<double>::quiet_NaN();
    Rig<TypeParam> rig;
    rig.upload(c.constants, {}, c.state, core::fact_particles | core::fact_fluid | core::fact_packed);
    rig.run({"step", "spatial", "sph"}, 1e-6);
    const auto& w = rig.frame();
    std::uint32_t counted = 0;
    for (std::uint32_t k = 0; k <= w.cells; ++k) counted += w.f.cell_count[k];
    EXPECT_EQ(counted, good ? 100u : 0u);
    EXPECT_EQ(w.f.status->halted != 0u, !good);
  }
}

// Two droplets 1000 H apart, and a gas of single particles 20 H apart.
TYPED_TEST(Neighbours, DropletsFarApart) {
  Random random(79);
  Cloud c;
  for (const double x : {-250.0, 250.0})
    for (int n = 0; n < 300; ++n) c.add(Vec3d{x, 0, 0} + random.vector(0.8));
  for (int n = 0; n < 60; ++n) c.add(random.vector(40));
  this->check(c);
}

// 150 particles within 0.2 H, far more than fit a leaf or the bits of a row, and strings of them.
TYPED_TEST(Neighbours, DenseClumps) {
  Random random(80);
  Cloud c;
  c.bound({4, 4, 4});
  for (int clump = 0; clump < 5; ++clump) {
    const Vec3d at = Vec3d{2, 2, 2} + random.vector(1.7);
    for (int n = 0; n < 150; ++n) c.add(at + random.vector(0.05));
  }
  for (int n = 0; n < 300; ++n) c.add({0.5 + 0.01 * n, 2, 2});
  this->check(c);
}

TYPED_TEST(Neighbours, ClumpsThatCoincide) {
  Cloud c;
  c.bound({3, 3, 3});
  for (int n = 0; n < 200; ++n) c.add(n % 3 ? Vec3d{1, 1, 1} : Vec3d{1.3, 1.1, 1});
  this->check(c);
}

// Leaves hold few particles, ids ascend among those at one place, and the order forgets its history.
TYPED_TEST(Neighbours, LeavesOfTheTree) {
  Random random(82);
  Cloud c;
  for (int n = 0; n < 700; ++n) c.add(random.vector(1.2));
  for (int n = 0; n < 40; ++n) c.add({0.01, 0.01, 0.01});
  Rig<TypeParam> rig;
  rig.upload(c.constants, {}, c.state, core::fact_particles | core::fact_tree);
  std::vector<std::uint32_t> first;
  for (int k = 0; k < 3; ++k) {
    rig.run({"step.begin", "spatial"});
    const auto& w = rig.frame();
    const std::vector<std::uint32_t> ids(w.f.id, w.f.id + w.particles);
    if (k == 0) first = ids;
    EXPECT_EQ(ids, first);
    for (std::uint32_t g = 0; g < w.f.status->groups; ++g) {
      const std::uint32_t size = w.f.group_begin[g + 1] - w.f.group_begin[g];
      EXPECT_GE(size, 1u);
      EXPECT_LE(size, spatial::leaf_size);
      for (std::uint32_t i = w.f.group_begin[g]; i < w.f.group_begin[g + 1]; ++i) {
        EXPECT_EQ(w.f.group_of[i], g);
        if (i > w.f.group_begin[g] && w.f.sort_key_alt[i] == w.f.sort_key_alt[i - 1]) {
          EXPECT_LT(w.f.id[i - 1], w.f.id[i]);
        }
      }
    }
  }
}

// However many runs there are: no slot is lost or comes twice, and what rows cover ascends.
TEST(RowList, KeepsEverySlot) {
  Random random(83);
  for (int n = 0; n < 300; ++n) {
    std::vector<core::Range> rows(18, core::Range{7, 7});
    spatial::RowList list(rows.data(), 18);
    std::set<std::uint32_t> wanted;
    std::uint32_t at = 0;
    const int runs = n % 60;
    for (int k = 0; k < runs; ++k) {
      at += static_cast<std::uint32_t>(random.uniform(0, 30));
      const auto length = static_cast<std::uint32_t>(random.uniform(1, n % 2 ? 9 : 150));
      for (std::uint32_t j = at; j < at + length; ++j) wanted.insert(j);
      list.add({at, at + length});
      at += length;
    }
    list.finish();
    std::set<std::uint32_t> found;
    std::uint32_t end = 0;
    for (const core::Range& row : rows) {
      ASSERT_LE(row.begin, row.end);
      if (row.begin == row.end) continue;
      ASSERT_GE(row.begin, end);
      end = row.end;
      for (std::uint32_t j = row.begin; j < row.end; ++j) found.insert(j);
    }
    for (const std::uint32_t j : wanted) ASSERT_TRUE(found.count(j)) << n;
    if (runs <= 18) {
      EXPECT_EQ(found, wanted);
    }
  }
}

}  // namespace
