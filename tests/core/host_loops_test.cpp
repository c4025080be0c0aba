// SPDX-License-Identifier: Apache-2.0
// Loops of the host: the same for any number of threads, and what a part throws reaches the caller.
#include "exec/host_loops.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <numeric>
#include <vector>

#include "engine/empty_sites.hpp"

using namespace meltsim;
using namespace meltsim::core;

namespace {

constexpr int threads[] = {1, 2, 7};
constexpr std::size_t many = 100000;  // several pieces

TEST(HostLoops, EveryItemIsVisitedOnce) {
  for (const int n : threads) {
    std::vector<int> times(many, 0);
    HostLoops(n).pieces(many, [&](std::size_t i, std::size_t end) {
      for (; i < end; ++i) ++times[i];
    });
    EXPECT_EQ(times, std::vector<int>(many, 1)) << n;
    HostLoops(n).pieces(0, [](std::size_t, std::size_t) { FAIL(); });
  }
}

TEST(HostLoops, ResultsOfPiecesComeInOrderAndAreTheSame) {
  const auto first_of = [](std::size_t begin, std::size_t) { return begin; };
  const std::vector<std::size_t> alone = HostLoops(1).of_pieces<std::size_t>(many, first_of);
  EXPECT_GT(alone.size(), 2u);
  EXPECT_TRUE(std::is_sorted(alone.begin(), alone.end()));
  for (const int n : threads) EXPECT_EQ(HostLoops(n).of_pieces<std::size_t>(many, first_of), alone);
}

TEST(HostLoops, OneThatFailsIsFound) {
  for (const int n : threads)
    for (const std::size_t bad : {std::size_t{0}, std::size_t{50000}, many - 1})
      EXPECT_FALSE(HostLoops(n).all_of(many, [bad](std::size_t i) { return i != bad; })) << n << ' ' << bad;
  EXPECT_TRUE(HostLoops(7).all_of(many, [](std::size_t) { return true; }));
}

TEST(HostLoops, WhatAPartThrowsIsThrownByTheCaller) {
  for (const int n : threads) {
    const HostLoops loops(n);
    EXPECT_THROW(loops.each(64,
                            [](std::int64_t k) {
                              if (k == 40) throw std::bad_alloc();
                            }),
                 std::bad_alloc)
        << n;
    EXPECT_THROW(loops.each(64, [](std::int64_t) { throw std::bad_alloc(); }), std::bad_alloc) << n;
    std::atomic<int> done{0};
    loops.each(64, [&done](std::int64_t) { ++done; });  // and goes on
    EXPECT_EQ(done, 64) << n;
  }
}

TEST(HostLoops, VectorsGrowAndKeepWhatTheyHold) {
  for (const int n : threads) {
    const HostLoops loops(n);
    std::vector<double> v(1000);
    std::iota(v.begin(), v.end(), 0.0);
    loops.make_room(v, many);
    const double* const where = v.data();
    loops.resize(v, 1000 + many, -1.0);
    EXPECT_EQ(v.data(), where) << "there was room";
    ASSERT_EQ(v.size(), 1000 + many);
    for (std::size_t i = 0; i < v.size(); ++i) ASSERT_EQ(v[i], i < 1000 ? double(i) : -1.0);
    loops.make_room(v, 1);  // doubles
    EXPECT_GE(v.capacity(), 2 * v.size());
    EXPECT_EQ(v[999], 999.0);
    loops.resize(v, 10);
    EXPECT_EQ(v.size(), 10u);
  }
}

/// Bars of a body, in a box of 40 x 40 x 40 sites.
SceneLattice bars() {
  constexpr std::uint32_t side = 40;
  SceneLattice l;
  BodyRow b;
  b.stride_y = side;
  b.stride_z = side * side;
  b.region_half_width = 2;
  l.bodies.push_back(b);
  l.site_vertex.assign(side * side * side, none);
  const auto add = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    const std::uint32_t site = x + side * (y + side * z);
    l.site_vertex[site] = static_cast<std::uint32_t>(l.vertex_site.size());
    l.vertex_site.push_back(site);
    l.vertex_body.push_back(0);
  };
  for (std::uint32_t x = 5; x < 30; ++x) add(x, 10, 10);
  for (std::uint32_t z = 3; z < 30; ++z) add(33, 30, z);
  for (std::uint32_t x = 28; x < 32; ++x) add(x, 4, 5);  // up to the end of a piece
  add(16, 14, 15);                                       // at the beginning of another
  return l;
}

TEST(EmptySites, AreMarkedWhereNothingIsNear) {
  const SceneLattice l = bars();
  const int w = 2;
  for (const int n : threads) {
    const std::vector<std::uint32_t> marked = mark_empty_sites(l, {}, HostLoops(n));
    for (int site = 0; site < 64000; ++site) {
      const auto is = [&](int s) {
        return s >= 0 && s < 64000 && l.site_vertex[static_cast<std::size_t>(s)] != none;
      };
      bool row = false, plane = false;
      for (int dx = -w; dx <= w; ++dx) {
        row = row || is(site + dx);
        for (int dy = -w; dy <= w; ++dy) plane = plane || is(site + dx + 40 * dy);
      }
      const std::uint32_t there = l.site_vertex[static_cast<std::size_t>(site)];
      const std::uint32_t expected = there != none || row ? there : plane ? empty_row : empty_plane;
      ASSERT_EQ(marked[static_cast<std::size_t>(site)], expected) << site << ", threads " << n;
    }
  }
}

}  // namespace
