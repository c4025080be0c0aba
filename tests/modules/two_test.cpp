// SPDX-License-Identifier: Apache-2.0
// Density of two particles per thread, as a GPU takes it, against one per thread: the same neighbours, the same bits,
// and everyone once. Sums are in the same order; what is not near adds exactly nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "modules/engine.hpp"
#include "sph/bodies.hpp"

namespace {

using namespace modules_test;

constexpr double spacing = 0.2;

struct Cloud {
  core::SceneConstants constants = plain_constants(spacing);
  core::SceneState state;
  explicit Cloud(Vec3d max) {
    constants.support = 2 * spacing;
    constants.domain.bounded = true;
    constants.domain.max = max;
  }
  void add(Vec3d x, std::uint32_t tag = 0) { add_particle(state, constants, x, tag); }
};

template <class T>
class Two : public testing::Test {
 protected:
  using Body = sph::DensityBody<T, spatial::SearchKind::counted>;
  struct Found {
    std::vector<T> density, term;
    std::vector<std::vector<std::uint32_t>> neighbours;  ///< ascending
  };
  /// How often a particle was left over.
  static int check(const Cloud& cloud, std::uint32_t room = 16) {
    Rig<T> rig;
    rig.upload(cloud.constants, {}, cloud.state, core::fact_particles | core::fact_fluid | core::fact_packed);
    rig.run({"step.begin", "spatial"});
    core::Frame<T> w = rig.frame();
    EXPECT_EQ(w.f.group_ranges, nullptr) << "cells are not counted";
    w.words_parts = 1;
    w.words_room = room;
    std::vector<core::NeighbourWord> table(w.words_column / sizeof(core::NeighbourWord) * (room + 1));
    w.f.neighbour_words = table.data();
    const Body body{w};
    const Found alone = found(w, [&] {
      for (std::uint64_t i = 0; i < w.particles; ++i) body.finish(i, core::sum_of(body, i, 1));
    });
    std::vector<int> times(w.particles, 0);
    int left_over = 0;
    const Found by_twos = found(w, [&] {
      const auto take = [&](std::uint64_t i, bool one) {
        typename Body::Sum sums[2]{};
        const std::uint32_t count = body.two(i, one, sums);
        for (std::uint32_t k = 0; k < count; ++k) {
          ++times[i + k];
          if (body.unfinished(i + k)) body.more(i + k, 0, 1, sums[k]);
          body.finish(i + k, sums[k]);
        }
      };
      for (std::uint64_t i = w.particles + w.particles % 2; i != 0; i -= 2) take(i - 2, false);
      for (std::uint64_t line = 0; line < spatial::lines(w.grid); ++line)
        if (body.left_over(line) < w.particles) take(body.left_over(line), true), ++left_over;
    });
    EXPECT_EQ(times, std::vector<int>(w.particles, 1)) << "someone was left out, or came twice";
    for (std::size_t i = 0; i < w.particles; ++i) {
      EXPECT_EQ(by_twos.density[i], alone.density[i]) << i;
      EXPECT_EQ(by_twos.term[i], alone.term[i]) << i;
      EXPECT_EQ(by_twos.neighbours[i], alone.neighbours[i]) << i;
    }
    return left_over;
  }

 private:
  /// What is in the buffers of w afterwards; they are spoilt before.
  template <class Run>
  static Found found(const core::Frame<T>& w, const Run& run) {
    std::fill_n(w.f.density, w.particles, T(-1));
    for (std::size_t i = 0; i < w.particles; ++i) w.f.velocity[i].w = T(-1);
    run();
    Found f;
    f.density.assign(w.f.density, w.f.density + w.particles);
    for (std::size_t i = 0; i < w.particles; ++i) {
      f.term.push_back(w.f.velocity[i].w);
      std::vector<std::uint32_t>& list = f.neighbours.emplace_back();
      if (w.f.group_of[i] == core::none) continue;
      spatial::for_each_neighbour(
          w, i, [&](std::uint32_t j, const Vec4<T>&, const Vec3<T>&, T) { list.push_back(j); });
      std::sort(list.begin(),
                list.end());  // words begin elsewhere: there may be too many of one, not of the other
    }
    return f;
  }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Two, Scalars);

// Of lines of 35 particles every second one begins at an odd slot.
TYPED_TEST(Two, LinesOfOddLength) {
  Random random(31);
  Cloud c({1.8, 2.4, 2});
  for (int z = 0; z < 10; ++z)
    for (int y = 0; y < 12; ++y)
      for (int x = 0; x < 9; ++x)
        if (x != 4 || y % 2 != 0 || z % 2 != 0)
          c.add(Vec3d{x + 0.5, y + 0.5, z + 0.5} * spacing + random.vector(0.03));
  EXPECT_GT(this->check(c), 5);
}

// In one line of cells, but too far apart to have candidates in common: one search after the other.
TYPED_TEST(Two, FarApartInALine) {
  Random random(32);
  Cloud c({40, 0.8, 0.8});
  for (int n = 0; n < 60; ++n) {
    const Vec3d x{random.uniform(0, 40), random.uniform(0, 0.8), random.uniform(0, 0.8)};
    c.add(x);
    if (n % 3 == 0) c.add(x + random.vector(0.1));
  }
  this->check(c);
}

TYPED_TEST(Two, CellsCrowdedBeyondTheirWords) {
  Random random(33);
  Cloud c({3, 3, 3});
  for (int n = 0; n < 500; ++n) c.add(Vec3d{1.3, 1.3, 1.3} + random.vector(0.25));
  for (int n = 0; n < 500; ++n) c.add({random.uniform(0, 3), random.uniform(0, 3), random.uniform(0, 3)});
  for (const std::uint32_t room : {16u, 9u, 2u}) this->check(c, room);
}

TYPED_TEST(Two, RemovedOnesAndFew) {
  Random random(34);
  for (const int n : {1, 2, 3, 31, 32, 33, 200, 201})
    for (const int removed : {0, 1, 2}) {
      Cloud c({1.6, 1.6, 1.6});
      for (int k = 0; k < n; ++k)
        c.add(Vec3d{0.8, 0.8, 0.8} + random.vector(0.8), k < removed ? tag_removed : 0u);
      this->check(c);
    }
}

// The search itself needs all lines, the one by twos pays where they hold a warp and more.
TYPED_TEST(Two, PaysAtShortSupportsInLongLines) {
  for (const double length : {3.0, 30.0})
    for (const double support : {2.0, 2.5}) {
      Cloud c({length, 1.6, 1.6});
      c.constants.support = support * spacing;
      for (int x = 0; x < int(length / spacing); ++x) c.add({(x + 0.5) * spacing, 0.5, 0.5});
      Rig<TypeParam> rig;
      rig.upload(c.constants, {}, c.state, core::fact_particles | core::fact_fluid | core::fact_packed);
      rig.run({"step.begin", "spatial"});
      EXPECT_EQ(spatial::pays_by_twos(rig.frame()), length > 10 && support < 2.25);
    }
}

}  // namespace
