// SPDX-License-Identifier: Apache-2.0
// USD text: what stands in it, number by number, and that brackets close. What USD itself makes of it, tests/runner/usd_reader.py
// says where usd-core is installed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

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

/// Clear water and a body of ice, of 50 frames a second.
runner::UsdRun run_of(const meltsim::Vec3d& up = {0, 1, 0}) {
  runner::Scene scene;
  scene.materials.resize(2);
  scene.materials[1].becomes = "water";
  scene.output.looks = {{"water", std::nullopt}, {"ice", std::nullopt}};
  scene.bodies.resize(1);
  scene.bodies[0].material = "ice";
  runner::UsdRun run;
  run.looks = runner::part_looks(scene, {});
  run.spacing = 0.04;
  run.fps = 50;
  run.up = up;
  return run;
}

std::string text_of(const runner::UsdRun& run) {
  return runner::usd_text(run, 7, 1.25, particles(), shapes());
}

/// The values of a declaration that follows `within`: those of frame 7, or what is the same in all frames.
std::string array(const std::string& text, const std::string& within, const std::string& declaration) {
  const std::size_t prim = text.find(within), sampled = text.find(declaration + ".timeSamples = {\n", prim),
                    fixed = text.find(declaration + " = [", prim);
  if (prim == std::string::npos || (sampled == std::string::npos && fixed == std::string::npos))
    return "missing";
  const std::string begin = sampled == std::string::npos ? " = [" : " 7: [";
  const std::size_t from = text.find(begin, std::min(sampled, fixed)) + begin.size();
  return text.substr(from, text.find(']', from) - from);
}

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Usd, HasEveryValueAtItsPlace) {
  const std::string text = text_of(run_of());
  EXPECT_EQ(text.rfind("#usda 1.0\n", 0), 0u);
  for (const char* said :
       {"double time_s = 1.25\n", "metersPerUnit = 1\n", "upAxis = \"Y\"\n", "timeCodesPerSecond = 50\n",
        "framesPerSecond = 50\n", "startTimeCode = 7\n", "endTimeCode = 7\n"})
    EXPECT_TRUE(holds(text, said)) << said;
  EXPECT_TRUE(holds(text_of(run_of({0, 0, 1})), "upAxis = \"Z\"\n"));
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

// Value clips read time samples alone; what is the same in all frames stands in the file that joins them.
TEST(Usd, FramesAreJoinedByValueClips) {
  const runner::UsdRun run = run_of();
  const std::string clips = runner::usd_clips(run, 3, 120), manifest = runner::usd_manifest(run);
  for (const char* said :
       {"string templateAssetPath = \"./frames/scene.#####.usda\"\n", "double templateStartTime = 3\n",
        "double templateEndTime = 120\n", "asset manifestAssetPath = @./frames/manifest.usda@\n",
        "startTimeCode = 3\n", "endTimeCode = 120\n", "timeCodesPerSecond = 50\n", "float[] widths = [0.04]",
        "rel material:binding = </meltsim/materials/ice>\n"})
    EXPECT_TRUE(holds(clips, said)) << said;
  EXPECT_EQ(runner::usd_frame_file(12), "frames/scene.00012.usda");
  EXPECT_FALSE(holds(clips, "timeSamples"));
  EXPECT_FALSE(holds(manifest, "timeSamples"));
  EXPECT_FALSE(holds(manifest, "widths"));
  EXPECT_FALSE(holds(manifest, "material:binding"));
  for (const char* declared :
       {"point3f[] points\n", "int[] faceVertexIndices\n", "float[] primvars:temperature (\n"})
    for (const std::string& text : {clips, manifest}) EXPECT_TRUE(holds(text, declared)) << declared;
}

TEST(Usd, MaterialsAreThoseOfPictures) {
  runner::UsdRun run = run_of();
  std::string text = text_of(run);
  EXPECT_EQ(array(text, "def Mesh \"liquid\"", "color3f[] primvars:displayColor"), "(0.86, 0.94, 0.97)");
  EXPECT_EQ(array(text, "def Mesh \"liquid\"", "float[] primvars:displayOpacity"), "0.2");
  EXPECT_EQ(array(text, "def Mesh \"solid\"", "color3f[] primvars:displayColor"), "(0.66, 0.8, 0.9)");
  EXPECT_EQ(array(text, "def Mesh \"solid\"", "float[] primvars:displayOpacity"), "missing");
  EXPECT_TRUE(holds(text, "float inputs:ior = 1.333\n"));
  EXPECT_TRUE(holds(text, "float inputs:opacity = 0.2\n"));
  // Two materials on one surface: a part of the faces for each, and colours by vertex.
  run.looks.liquid.push_back(run.looks.all.size());
  run.looks.all.push_back({"ink (1 kg/m^3)", {0, 0, 1}});
  run.looks.materials.push_back({"ink", std::nullopt});
  run.looks.of_material[2] = run.looks.liquid.back();
  runner::FrameShapes two = shapes();
  two.liquid.material = {2, 2, 2};
  text = runner::usd_text(run, 7, 1.25, particles(), two);
  EXPECT_EQ(array(text, "def GeomSubset \"ink__1_kg_m_3_\"", "int[] indices"), "0");
  EXPECT_EQ(array(text, "def GeomSubset \"liquid\"", "int[] indices"), "");
  EXPECT_EQ(array(text, "def Mesh \"liquid\"", "color3f[] primvars:displayColor"),
            "(0, 0, 1), (0, 0, 1), (0, 0, 1)");
  EXPECT_EQ(array(text, "def Mesh \"liquid\"", "float[] primvars:displayOpacity"), "1, 1, 1");
  for (const char* name :
       {"liquid", "ink__1_kg_m_3_"})  // Blender does not follow the parts from frame to frame
    for (const char* reader :
         {"color3f inputs:diffuseColor.connect = </meltsim/materials/%/displayColor.outputs:result>\n",
          "float inputs:opacity.connect = </meltsim/materials/%/displayOpacity.outputs:result>\n"})
      EXPECT_TRUE(holds(text, std::string(reader).replace(std::string(reader).find('%'), 1, name))) << name;
  EXPECT_FALSE(holds(text, "materials/ice/displayColor"));
  EXPECT_TRUE(holds(runner::usd_clips(run, 0, 1), "def GeomSubset \"ink__1_kg_m_3_\""));
}

// USD would mix surfaces of equally many vertices between two frames, whose triangles differ.
TEST(Usd, SurfacesOfNeighbouringFramesHaveDifferentNumbersOfVertices) {
  const char* const liquid = "def Mesh \"liquid\"";
  for (const bool even : {false, true}) {
    const std::string text = runner::usd_text(run_of(), even ? 8 : 7, 1.25, particles(), shapes());
    const auto count = [&](const char* declaration, const char* item) {
      const std::size_t from = text.find(std::string(declaration) + ".timeSamples", text.find(liquid));
      const std::string values = text.substr(from, text.find(']', text.find(": [", from)) - from);
      std::size_t found = 0;
      for (std::size_t at = values.find(item); at != std::string::npos; at = values.find(item, at + 1))
        ++found;
      return found;
    };
    const std::size_t vertices = even ? 4 : 3;
    EXPECT_EQ(count("point3f[] points", "("), vertices);
    EXPECT_EQ(count("normal3f[] normals", "("), vertices);
    EXPECT_EQ(count("float[] primvars:temperature", ","), vertices - 1);
    EXPECT_EQ(count("int[] faceVertexIndices", ","), 2u);
  }
}

// Between two frames points stay, and readers interpolate extents: that of a frame bounds the one before, too.
TEST(Usd, ExtentsBoundTheFrameBefore) {
  const runner::UsdRun run = run_of();
  const char* const liquid = "def Mesh \"liquid\"";
  runner::FrameShapes moved = shapes();
  for (meltsim::Vec3f& x : moved.liquid.position) x = x + meltsim::Vec3f{2, 0, 0};
  const runner::UsdBounds before = runner::usd_bounds(run, particles(), shapes());
  std::string text = runner::usd_text(run, 7, 1.25, particles(), moved, before);
  EXPECT_EQ(array(text, liquid, "float3[] extent"), "(0, 1, 0), (3, 1.5, 0)");
  // What a resumed run knows of the frame before is its text.
  text = runner::usd_text(run, 7, 1.25, particles(), moved, runner::usd_bounds_in(text_of(run)));
  EXPECT_EQ(array(text, liquid, "float3[] extent"), "(0, 1, 0), (3, 1.5, 0)");
  EXPECT_EQ(array(text, "def Points \"particles\"", "float3[] extent"),
            "(0.98, 1.98, 2.48), (1.12, 2.27, 3.02)");
  // A surface that has vanished, and one that never was: no numbers at the end of what a float holds.
  text = runner::usd_text(run, 7, 1.25, {}, {}, before);
  EXPECT_EQ(array(text, liquid, "float3[] extent"), "(0, 1, 0), (1, 1.5, 0)");
  EXPECT_EQ(array(text, "def Mesh \"solid\"", "float3[] extent"), "(0, 0, 0), (0, 0, 0)");
}

// IEC 61966-2-1, not a power of 2.2: dark colours differ by more than half, 0.1 is 0.0100 and not 0.0063.
TEST(Usd, ColoursAreLinearLightBySrgb) {
  for (const auto& [shown, light] :
       {std::pair<double, double>{0, 0}, {0.04, 0.0030960}, {0.1, 0.0100228}, {0.5, 0.2140411}, {1, 1}}) {
    EXPECT_NEAR(runner::linear(shown), light, 1e-6) << shown;
    EXPECT_NEAR(runner::monitor(light), shown, 1e-5) << light;
  }
  runner::Scene scene;
  scene.materials.resize(1);
  scene.output.looks = {{"paint", runner::Rgb{0.5, 0.1, 1}}};
  scene.bodies.resize(1);
  scene.bodies[0].material = "paint";
  runner::UsdRun run;
  run.looks = runner::part_looks(scene, {});
  EXPECT_TRUE(holds(text_of(run), "inputs:diffuseColor = (0.214, 0.01002, 1)\n"));
}

TEST(Usd, TemperaturesAreColoursWherePicturesHaveThem) {
  runner::UsdRun run = run_of();
  runner::PictureWish wish;
  wish.look = runner::Look::temperature;
  wish.cold = 1;
  wish.hot = 3;
  run.looks = runner::part_looks({}, wish);
  const std::string text = text_of(run);
  const auto ramped = [](double x) {
    const runner::Rgb c = runner::linear(runner::ramp(x));
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", c[0], c[1], c[2]);
  };
  EXPECT_EQ(array(text, "def Mesh \"liquid\"", "color3f[] primvars:displayColor"),
            ramped(0) + ", " + ramped(0.5) + ", " + ramped(1));
  EXPECT_TRUE(holds(text, "</meltsim/materials/solid/displayColor.outputs:result>"));
  EXPECT_FALSE(holds(text, "inputs:ior"));
}

TEST(Usd, ContentsAreOfParticlesAndLiquid) {
  runner::UsdRun run = run_of();
  run.contents = {"w_sugar"};
  meltsim::ParticleFrame sweet = particles();
  sweet.fractions = {{0, 0.5F}};
  runner::FrameShapes surface = shapes();
  surface.liquid.contents = {{0.25F, 0.5F, 0.75F}};
  const std::string text = runner::usd_text(run, 7, 1.25, sweet, surface);
  EXPECT_EQ(array(text, "def Points \"particles\"", "float[] primvars:w_sugar"), "0, 0.5");
  EXPECT_EQ(array(text, "def Mesh \"liquid\"", "float[] primvars:w_sugar"), "0.25, 0.5, 0.75");
  EXPECT_EQ(array(text, "def Mesh \"solid\"", "float[] primvars:w_sugar"), "missing");
}

// USD knows y and z as up; for others the stage is turned, in each of the files that show something.
TEST(Usd, WhatIsUpIsUpForReaders) {
  for (const meltsim::Vec3d& up : {meltsim::Vec3d{0, 1, 0}, {0, 0, 1}})
    EXPECT_FALSE(holds(text_of(run_of(up)), "xformOp"));
  for (const bool joined : {false, true}) {
    const auto of = [joined](const meltsim::Vec3d& up) {
      return joined ? runner::usd_clips(run_of(up), 0, 1) : text_of(run_of(up));
    };
    EXPECT_TRUE(holds(of({1, 0, 0}), "quatf xformOp:orient = (0.707106781, 0, 0, 0.707106781)\n"));
    EXPECT_TRUE(holds(of({0, -1, 0}), "quatf xformOp:orient = (0, 1, 0, 0)\n"));
    EXPECT_TRUE(holds(of({0, 0, -1}), "uniform token[] xformOpOrder = [\"xformOp:orient\"]\n"));
    EXPECT_TRUE(holds(of({0, 0, -1}), "upAxis = \"Y\"\n"));
  }
}

TEST(Usd, BracketsClose) {
  for (const std::string& text : {text_of(run_of()), runner::usd_text(run_of({-1, 0, 0}), 0, 0, {}, {}),
                                  runner::usd_clips(run_of(), 0, 9), runner::usd_manifest(run_of())}) {
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
