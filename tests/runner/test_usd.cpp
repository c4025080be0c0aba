// SPDX-License-Identifier: Apache-2.0
// USD text: what stands in it, number by number, and that brackets close. What USD itself makes of it, tests/runner/usd_reader.py
// says where usd-core is installed.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "meltsim/particle_tag.hpp"
#include "show/usd_file.hpp"

namespace {

meltsim::ParticleFrame particles() {
  meltsim::ParticleFrame p;
  p.origin = {1, 2, 3};
  p.id = {0, 4};
  p.position = {{0, 0, 0}, {0.1F, 0.25F, -0.5F}};
  p.velocity = {{0, 0, 0}, {0, -1.5F, 0}};
  p.temperature = {-10, 20.5F};
  p.liquid_fraction = {0, 1};
  p.tag = {meltsim::tag_solid | 1u | (3u << meltsim::tag_body_shift), 0u};
  return p;
}

runner::FrameShapes shapes() {
  runner::FrameShapes s;
  s.origin = {0, 1, 0};
  s.liquid.position = {{0, 0, 0}, {1, 0, 0}, {0, 0.5F, 0}};
  s.liquid.normal.assign(3, {0, 0, 1});
  s.liquid.temperature = {1, 2, 3};
  s.liquid.liquid_fraction = {0.25F, 0.5F, 1};
  s.liquid.body.assign(3, 0);
  s.liquid.material.assign(3, 0);
  s.liquid.triangles = {0, 1, 2};
  return s;
}

/// What stands between "= [" and "]" behind a declaration that follows `within`.
std::string array(const std::string& text, const std::string& within, const std::string& declaration) {
  const std::size_t at = text.find(declaration + " = [", text.find(within));
  if (at == std::string::npos) return "missing";
  const std::size_t from = at + declaration.size() + 4;
  return text.substr(from, text.find(']', from) - from);
}

TEST(Usd, HasEveryValueAtItsPlace) {
  const std::string text = runner::usd_text(particles(), shapes(), 0.04, 1.25, {0, 1, 0});
  EXPECT_EQ(text.rfind("#usda 1.0\n", 0), 0u);
  EXPECT_NE(text.find("double time_s = 1.25\n"), std::string::npos);
  EXPECT_NE(text.find("metersPerUnit = 1\n"), std::string::npos);
  EXPECT_NE(text.find("upAxis = \"Y\"\n"), std::string::npos);
  EXPECT_NE(runner::usd_text({}, {}, 1, 0, {0, 0, 1}).find("upAxis = \"Z\"\n"), std::string::npos);
  const char* const points = "def Points \"particles\"";
  EXPECT_EQ(array(text, points, "point3f[] points"), "(1, 2, 3), (1.1, 2.25, 2.5)");
  EXPECT_EQ(array(text, points, "vector3f[] velocities"), "(0, 0, 0), (0, -1.5, 0)");
  EXPECT_EQ(array(text, points, "float[] widths"), "0.04");
  EXPECT_EQ(array(text, points, "int64[] ids"), "0, 4");
  EXPECT_EQ(array(text, points, "float[] primvars:temperature"), "-10, 20.5");
  EXPECT_EQ(array(text, points, "float[] primvars:liquid_fraction"), "0, 1");
  EXPECT_EQ(array(text, points, "int[] primvars:body"), "2, -1");
  EXPECT_EQ(array(text, points, "int[] primvars:material"), "1, 0");
  const char* const liquid = "def Mesh \"liquid\"";
  EXPECT_EQ(array(text, liquid, "int[] faceVertexCounts"), "3");
  EXPECT_EQ(array(text, liquid, "int[] faceVertexIndices"), "0, 1, 2");
  EXPECT_EQ(array(text, liquid, "point3f[] points"), "(0, 1, 0), (1, 1, 0), (0, 1.5, 0)");
  EXPECT_EQ(array(text, liquid, "float3[] extent"), "(0, 1, 0), (1, 1.5, 0)");
  EXPECT_EQ(array(text, liquid, "float[] primvars:temperature"), "1, 2, 3");
  EXPECT_EQ(array(text, liquid, "float[] primvars:liquid_fraction"), "0.25, 0.5, 1");
  EXPECT_EQ(array(text, liquid, "int[] primvars:body"), "-1, -1, -1");
  EXPECT_EQ(array(text, "def Mesh \"solid\"", "point3f[] points"), "");
}

// USD knows y and z as up; for others the stage is turned.
TEST(Usd, WhatIsUpIsUpForReaders) {
  const auto of = [](const meltsim::Vec3d& up) { return runner::usd_text({}, {}, 1, 0, up); };
  for (const meltsim::Vec3d& up : {meltsim::Vec3d{0, 1, 0}, {0, 0, 1}})
    EXPECT_EQ(of(up).find("xformOp"), std::string::npos);
  EXPECT_NE(of({1, 0, 0}).find("quatf xformOp:orient = (0.707106781, 0, 0, 0.707106781)\n"),
            std::string::npos);
  EXPECT_NE(of({0, -1, 0}).find("quatf xformOp:orient = (0, 1, 0, 0)\n"), std::string::npos);
  EXPECT_NE(of({0, 0, -1}).find("uniform token[] xformOpOrder = [\"xformOp:orient\"]\n"), std::string::npos);
  EXPECT_NE(of({0, 0, -1}).find("upAxis = \"Y\"\n"), std::string::npos);
}

TEST(Usd, BracketsClose) {
  for (const std::string& text : {runner::usd_text(particles(), shapes(), 0.04, 1.25, {0, 1, 0}),
                                  runner::usd_text({}, {}, 0.04, 0, {-1, 0, 0})}) {
    std::string open;
    for (const char c : text) {
      if (c == '(' || c == '[' || c == '{') open += c;
      if (c != ')' && c != ']' && c != '}') continue;
      ASSERT_FALSE(open.empty());
      EXPECT_EQ(open.back(), c == ')' ? '(' : c == ']' ? '[' : '{');
      open.pop_back();
    }
    EXPECT_TRUE(open.empty());
  }
}

}  // namespace
