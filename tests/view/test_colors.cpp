// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <set>
#include <tuple>

#include "color_map.hpp"
#include "meltsim/particle_tag.hpp"

namespace {

using namespace view;

TEST(Colors, ColdIsBlueWarmIsYellowHotIsRed) {
  const Range range{-10, 40};
  const auto at = [&range](double t) { return color_of(ColorBy::temperature, t, 0, 0, range); };
  EXPECT_GT(at(-10).b, 2 * at(-10).r);
  EXPECT_GT(std::min(at(17).r, at(17).g), 200);
  EXPECT_LT(at(17).b, 200);
  EXPECT_GT(at(40).r, 4 * at(40).b);
  EXPECT_GT(at(40).r, 4 * at(40).g);
}

TEST(Colors, BeyondTheRangeItsEnds) {
  const Range range{0, 1};
  EXPECT_EQ(ramp_index(-5, range), 0);
  EXPECT_EQ(ramp_index(0.5, range), 128);
  EXPECT_EQ(ramp_index(7, range), table_width - 1);
  EXPECT_EQ(ramp_index(3, {3, 3}), 128);  // no range: the middle
}

TEST(Colors, PhasesByTag) {
  const std::uint32_t body = 3u << meltsim::tag_body_shift;
  EXPECT_EQ(phase_of(0), Phase::liquid);
  EXPECT_EQ(phase_of(body), Phase::melted);
  EXPECT_EQ(phase_of(body | meltsim::tag_solid), Phase::solid);
}

TEST(Colors, FirstBodiesDifferFromEachOtherAndFromLiquid) {
  std::set<std::tuple<int, int, int>> seen;
  for (std::uint32_t body = 0; body < 24; ++body) {
    const Rgb c = color_of(ColorBy::body, 0, 0, body << meltsim::tag_body_shift, {});
    EXPECT_TRUE(seen.emplace(c.r, c.g, c.b).second) << body;
  }
  EXPECT_EQ(body_index(256), 1);
}

TEST(Colors, BodiesTakeTheScenesColors) {
  const ColorTable table = color_table({std::nullopt, std::array<double, 3>{1, 0.5, 0}});
  EXPECT_EQ(table[2][1].g, color_table()[2][1].g);
  EXPECT_EQ(table[2][2].r, 255);
  EXPECT_EQ(table[2][2].b, 0);
}

TEST(Colors, MaterialsTakeTheScenesColorsOrThoseOfWaterAndIce) {
  const ColorTable table = color_table({}, {std::nullopt, std::array<double, 3>{1, 0.5, 0}});
  const auto at = [&](std::uint32_t tag) { return table[4][static_cast<std::size_t>(material_index(tag))]; };
  EXPECT_GT(at(0).b, at(0).r);
  EXPECT_GT(at(meltsim::tag_solid).r, 200);
  for (const std::uint32_t phase : {0u, meltsim::tag_solid}) {
    EXPECT_EQ(at(1 | phase).r, 255);
    EXPECT_EQ(at(1 | phase).b, 0);
  }
}

TEST(Colors, TicksAreRoundAndInside) {
  EXPECT_EQ(ticks({-10, 40}, 7), (std::vector<double>{-10, 0, 10, 20, 30, 40}));
  EXPECT_EQ(ticks({0, 2.8}, 7), (std::vector<double>{0, 0.5, 1, 1.5, 2, 2.5}));
  EXPECT_EQ(ticks({5, 5}, 7), (std::vector<double>{5}));
  for (const double high : {0.013, 1.0, 7.3, 99.0, 12345.0}) {
    const auto at = ticks({0, high}, 7);
    EXPECT_GE(at.size(), 3u) << high;
    EXPECT_LE(at.size(), 7u) << high;
    EXPECT_LE(at.back(), high * (1 + 1e-9));
  }
}

}  // namespace
