// SPDX-License-Identifier: Apache-2.0
// Parts of pictures: what a replay keeps, cameras, rays, packing.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "failure.hpp"
#include "files.hpp"
#include "show/bvh.hpp"
#include "show/camera.hpp"
#include "show/deflate.hpp"
#include "show/image.hpp"
#include "show/mesh_files.hpp"
#include "show/ply_reader.hpp"
#include "show/replay.hpp"
#include "show/run_frames.hpp"
#include "show/surfaces.hpp"
#include "show/tracer.hpp"

namespace runner {
namespace {

using meltsim::Vec3d;
using meltsim::Vec3f;

meltsim::ParticleFrame particles(std::uint32_t count) {
  meltsim::ParticleFrame frame;
  for (std::uint32_t id = 0; id < count; ++id) frame.id.push_back(id);
  frame.position.resize(count);
  frame.velocity.resize(count);
  frame.temperature.assign(count, 20);
  frame.liquid_fraction.assign(count, 1);
  frame.tag.resize(count);
  return frame;
}

TEST(Replay, KeepsTheSameParticlesOfTheSameFramesWhateverWasPlanned) {
  // 150,000 particles are more than are shown: one in four is the first power of two below 60,000. Frames
  // beyond 4,000,000 particles in all are thinned; ~37,500 a frame make 106 of them, so of 120 every second
  // is left.
  const meltsim::ParticleFrame all = particles(150000);
  Replay planned(120, all.id.size()), surprised;
  for (std::uint64_t i = 0; i < 120; ++i) {
    for (Replay* replay : {&planned, &surprised}) {
      if (replay->wants(i)) replay->add(i, 0.04 * static_cast<double>(i), all);
    }
  }
  EXPECT_EQ(planned.share(), 4u);
  EXPECT_EQ(surprised.share(), 4u);
  EXPECT_EQ(planned.every(), surprised.every());
  ASSERT_EQ(planned.frames().size(), surprised.frames().size());
  EXPECT_LE(planned.particles(), 4000000u);
  for (std::size_t i = 0; i < planned.frames().size(); ++i) {
    EXPECT_EQ(planned.frames()[i].index, i * planned.every());
    ASSERT_EQ(planned.frames()[i].particles.size(), surprised.frames()[i].particles.size());
  }
  // A hash picks them, so it is a quarter within some standard deviations of 170.
  EXPECT_NEAR(static_cast<double>(planned.frames()[0].particles.size()), 37500, 1000);
}

TEST(Replay, ComesBackFromItsFileUpToTheTimeOfTheCheckpoint) {
  std::string name = (std::filesystem::temp_directory_path() / "meltsim-XXXXXX").string();
  const std::string directory = mkdtemp(name.data()), path = directory + "/replay.bin";
  for (const double unit : {1e-10, 1e6}) {  // whatever a scene's times are
    Replay replay, back;
    for (std::uint64_t i = 0; i < 5; ++i) replay.add(i, unit * static_cast<double>(i), particles(10));
    replay.save(path, 1);
    ASSERT_TRUE(back.load(path, unit * 2));
    EXPECT_EQ(back.frames().size(), 3u) << unit;
  }
  Replay replay;
  for (std::uint64_t i = 0; i < 5; ++i)
    replay.add(i, 0.5 * static_cast<double>(i), particles(10 + static_cast<std::uint32_t>(i)));
  replay.save(path, 1);
  Replay back;
  ASSERT_TRUE(back.load(path, 1.0));
  ASSERT_EQ(back.frames().size(), 3u);
  EXPECT_EQ(back.frames()[2].particles.size(), 12u);
  EXPECT_EQ(back.frames()[2].particles[11].id, 11u);
  std::string file = read_file(path);
  for (const std::size_t cut : {std::size_t{0}, std::size_t{7}, std::size_t{20}, file.size() - 1}) {
    write_file(path, file.substr(0, cut));
    EXPECT_FALSE(Replay().load(path, 1.0)) << cut;
  }
  std::string odd = file;
  odd[16] = 3;  // the share, which only ever doubles
  write_file(path, odd);
  EXPECT_FALSE(Replay().load(path, 1.0));
  EXPECT_FALSE(Replay().load(directory + "/none", 1.0));
  std::filesystem::remove_all(directory);
}

Mesh one_triangle() {
  Mesh mesh;
  mesh.position = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.normal.assign(3, {0, 0, 1});
  mesh.temperature = {1, 2, 3};
  mesh.body = {0, 1, 2};
  mesh.material = {3, 4, 5};
  mesh.triangles = {0, 1, 2};
  return mesh;
}

// Frames of runs before materials were written are read, too; what they lack is 0.
TEST(Ply, MaterialsComeBackAndMayBeMissing) {
  std::string name = (std::filesystem::temp_directory_path() / "meltsim-XXXXXX").string();
  const std::string directory = mkdtemp(name.data()), path = directory + "/a.ply";
  const Mesh mesh = one_triangle();
  std::vector<FrameParticle> list = frame_particles(particles(3));
  for (std::size_t i = 0; i < 3; ++i) list[i].material = 7 + static_cast<std::int32_t>(i);
  // As earlier versions wrote it: without the last properties' lines and the last bytes of every vertex.
  const auto without = [](std::string text, std::size_t stride, std::size_t bytes) {
    for (const std::string line : {"property int material\n", "property float liquid_fraction\n"})
      if (text.find(line) != std::string::npos) text.erase(text.find(line), line.size());
    const std::size_t data = text.find("end_header\n") + 11;
    for (std::size_t i = 3; i-- > 0;) text.erase(data + i * stride + stride - bytes, bytes);
    return text;
  };
  double time = 0;
  for (const bool has : {true, false}) {
    const std::string surface = mesh_ply_text(mesh, {}, 0.5), balls = ply_text(list, 0.5);
    write_file(path, has ? surface : without(surface, 36, 4));
    const Mesh back = read_mesh_ply(path, {}, time);
    EXPECT_EQ(back.material, has ? mesh.material : std::vector<std::uint32_t>(3, 0));
    EXPECT_EQ(back.body, mesh.body);
    EXPECT_EQ(back.triangles, mesh.triangles);
    write_file(path, has ? balls : without(balls, 45, 8));
    const std::vector<FrameParticle> read = read_particles_ply(path, time);
    ASSERT_EQ(read.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(read[i].id, i);
      EXPECT_EQ(read[i].material, has ? list[i].material : 0);
    }
  }
  std::filesystem::remove_all(directory);
}

// Surfaces keep what is dissolved, so that `meltsim render` shows it without particles.
TEST(Ply, ContentsOfASurfaceComeBack) {
  std::string name = (std::filesystem::temp_directory_path() / "meltsim-XXXXXX").string();
  const std::string directory = mkdtemp(name.data()), path = directory + "/a.ply";
  Mesh mesh = one_triangle();
  mesh.contents = {{0.25f, 0.5f, 0.75f}, {1, 0, 0.125f}};
  std::string text;
  for (const bool has_fraction : {false, true}) {  // surfaces of earlier versions have none
    if (has_fraction) mesh.liquid_fraction = {0, 0.5f, 1};
    const std::string fraction = has_fraction ? "property float liquid_fraction\n" : "";
    text = mesh_ply_text(mesh, {}, 0.5, {"w_milk", "w_sugar"});
    EXPECT_NE(text.find("property int material\n" + fraction +
                        "property float w_milk\nproperty float w_sugar\nelement face"),
              std::string::npos);
    write_file(path, text);
    double time = 0;
    const Mesh back = read_mesh_ply(path, {}, time);
    EXPECT_EQ(back.contents, mesh.contents);
    EXPECT_EQ(back.liquid_fraction, mesh.liquid_fraction);
    EXPECT_EQ(back.material, mesh.material);
    EXPECT_EQ(back.triangles, mesh.triangles);
  }
  double time = 0;
  write_file(path, text.substr(0, text.size() - 1));
  EXPECT_THROW(read_mesh_ply(path, {}, time), Failure);
  std::filesystem::remove_all(directory);
}

// A square of liquid over particles of which the left ones hold a species: its colour mixes with the solvent's, and a clear
// solvent is split where enough of it is there.
TEST(Shapes, ColoursOfAMixtureFollowItsContents) {
  FrameShapes shapes;
  for (int i = 0; i <= 10; ++i)
    for (int j = 0; j <= 1; ++j) {
      shapes.liquid.position.push_back({static_cast<float>(i), static_cast<float>(j), 0});
      shapes.liquid.normal.push_back({0, 0, 1});
      shapes.liquid.temperature.push_back(0);
      shapes.liquid.body.push_back(0);
      shapes.liquid.material.push_back(0);
    }
  for (std::uint32_t i = 0; i < 10; ++i)
    for (const std::uint32_t v : {2 * i, 2 * i + 2, 2 * i + 1, 2 * i + 1, 2 * i + 2, 2 * i + 3})
      shapes.liquid.triangles.push_back(v);
  std::vector<FrameParticle> particles;
  for (int i = 0; i <= 10; ++i)
    for (int j = 0; j <= 1; ++j) {
      FrameParticle p{};
      p.position[0] = static_cast<float>(i);
      p.position[1] = static_cast<float>(j);
      p.contents[0] = i < 5 ? 0.5f : 0.0f;
      particles.push_back(p);
    }
  add_contents(shapes, particles, {1}, 1);
  ASSERT_EQ(shapes.liquid.contents.size(), 1u);
  EXPECT_NEAR(shapes.liquid.contents[0][0], 0.5f, 1e-6);
  EXPECT_NEAR(shapes.liquid.contents[0][20], 0.0f, 1e-6);
  const std::array<double, 3> black{0, 0, 0}, white{1, 1, 1};
  // A solvent that has a colour: all of it is opaque, in between the two.
  const FrameShapes coffee = split_liquid(shapes, {{"coffee", black}, {"milk", white}});
  EXPECT_EQ(coffee.paint.triangles.size(), shapes.liquid.triangles.size());
  EXPECT_NEAR(coffee.paint.color[0].x, 0.5f, 1e-4);  // averaged along the surface
  EXPECT_NEAR(coffee.paint.color[20].x, 0.0f, 1e-4);
  // A clear one: opaque where the species is, in its own colour.
  const FrameShapes water = split_liquid(shapes, {{"water", std::nullopt}, {"ink", white}});
  ASSERT_FALSE(water.paint.empty());
  ASSERT_FALSE(water.liquid.empty());
  EXPECT_GT(water.paint.position.size(), shapes.liquid.position.size());  // of the cut
  EXPECT_EQ(water.paint.contents[0].size(), water.paint.position.size());
  for (const std::uint32_t v : water.paint.triangles) {
    EXPECT_LT(water.paint.position[v].x, 7);
    EXPECT_NEAR(water.paint.color[v].x, 1, 1e-5);
  }
  for (const std::uint32_t v : water.liquid.triangles) EXPECT_GT(water.liquid.position[v].x, 4);
  // A solution of crystals is clear.
  meltsim::MaterialDesc sugar;
  sugar.solubility = 0.6;
  EXPECT_EQ(shown_species(1, sugar), clear_species);
  sugar.solubility = 1;
  EXPECT_EQ(shown_species(1, sugar), 1u);
  // A species without a colour shows nothing.
  EXPECT_TRUE(split_liquid(shapes, {{"water", std::nullopt}, {"salt", std::nullopt}}).paint.empty());
}

TEST(Pictures, RowsOfNothingDoNotWidenTheRangeOfTemperatures) {
  std::string name = (std::filesystem::temp_directory_path() / "meltsim-XXXXXX").string();
  const std::string directory = mkdtemp(name.data());
  const std::string header = "step,n_fluid,n_solid,T_min,T_mean,T_max\n", nothing = "0,0,0,0,0,0\n";
  const auto range_of = [&directory](const std::string& table) {
    write_file(directory + "/stats.csv", table);
    return range_on_disk({directory, {}});
  };
  using Range = std::pair<double, double>;
  EXPECT_EQ(range_of(header + nothing + "1,5,0,60,70,90\n2,0,3,50,60,80\n"), Range(50, 90));
  EXPECT_EQ(range_of(header + nothing), Range(0, 1));
  EXPECT_EQ(range_of(header + "0,1,0,0,0,0\n"), Range(-0.5, 0.5));  // a particle of 0 degrees
  EXPECT_EQ(range_of("step,T_min,T_max\n0,10,20\n"), Range(10, 20));
  std::filesystem::remove_all(directory);
}

TEST(Deflate, GivesBackWhatWasPackedWhateverItsParts) {
  std::uint32_t state = 5;
  const auto next = [&state] {
    state = state * 1664525u + 1013904223u;
    return static_cast<char>(state >> 24);
  };
  constexpr std::size_t period = 30000;  // as far back as deflate looks, nearly
  std::string once;
  while (once.size() < period) once += next();
  for (const std::size_t size : {0u, 1u, 262143u, 262144u, 262145u, 1000000u})  // around the size of a part
    for (const bool repeats : {false, true}) {
      std::string data;
      while (data.size() < size) data += repeats ? once[data.size() % period] : next();
      for (const int level : {1, 6}) {
        const std::string packed = deflated(data, level, 0);
        std::string back;
        ASSERT_TRUE(inflated(packed, size, back)) << size << ' ' << repeats << ' ' << level;
        EXPECT_EQ(back, data);
        EXPECT_EQ(deflated(data, level, 1), packed);
        if (!repeats) continue;
        // Parts know what comes before them: each on its own would hold the period once more.
        EXPECT_LT(packed.size(), period + size / 50 + 1000) << size << ' ' << level;
      }
    }
}

TEST(Replay, BytesAreBase64) {
  // RFC 4648, section 10.
  const char* words[] = {"", "f", "fo", "foo", "foob", "fooba", "foobar"};
  const char* coded[] = {"", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"};
  for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(base64(words[i]), coded[i]);
}

TEST(Legend, LavaIsNotWrittenInPowersOfTen) {
  EXPECT_EQ(legend_number(1140), "1140");
  EXPECT_EQ(legend_number(-1e5), "-100000");
  EXPECT_EQ(legend_number(999.6), "1000");
  EXPECT_EQ(legend_number(0.5 * 31.46), "15.7");
  EXPECT_EQ(legend_number(0), "0");
}

TEST(Camera, SeesAllThereIsAndStandsAboveTheFloor) {
  const Vec3d gravities[] = {{0, -9.81, 0}, {0, 0, -9.81}, {0, 0, 0}};
  const double aspects[] = {16.0 / 9, 1, 9.0 / 16, 4};
  for (int i = 0; i < 12; ++i) {
    const double aspect = aspects[i % 4];
    Scene scene;
    scene.world.gravity = gravities[i / 4];
    Box box;
    box.add({-3, 1, 2});
    box.add({5, 2, 4});
    const Camera camera = scene_camera(scene, box, aspect);
    const Vec3d front = (camera.look_at - camera.eye) * (1 / length(camera.look_at - camera.eye));
    EXPECT_LT(dot(front, camera.up), -0.1);
    const double widest = std::tan(0.5 * camera.fov * 3.14159265 / 180);
    for (const double x : {-3.0, 5.0}) {
      for (const double y : {1.0, 2.0}) {
        for (const double z : {2.0, 4.0}) {
          const Vec3d off = Vec3d{x, y, z} - camera.eye, right = cross(front, camera.up);
          const double deep = dot(off, front), wide = std::abs(dot(off, right)) / length(right);
          EXPECT_LT(wide, 0.95 * aspect * widest * deep);
          EXPECT_LT(std::abs(dot(off, cross(right, front))) / length(right), widest * deep);
        }
      }
    }
  }
}

TEST(Camera, TurnsUpToY) {
  for (const Vec3d& up : {Vec3d{0, 1, 0}, Vec3d{0, 0, 1}, Vec3d{1, 0, 0}, Vec3d{0, 0, -1}, Vec3d{0, -1, 0},
                          Vec3d{0.6, 0, 0.8}}) {
    const std::array<double, 4> q = turn_upright(up);
    const Vec3d axis{q[0], q[1], q[2]}, across = cross(axis, up) * 2.0,
                                        turned = up + across * q[3] + cross(axis, across);
    EXPECT_NEAR(dot(axis, axis) + q[3] * q[3], 1, 1e-12);
    EXPECT_NEAR(length(turned - Vec3d{0, 1, 0}), 0, 1e-12);
  }
}

/// A cube of 12 triangles, from -1 to 1.
Mesh cube() {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    const Vec3f x{(i & 1) != 0 ? 1.0f : -1.0f, (i & 2) != 0 ? 1.0f : -1.0f, (i & 4) != 0 ? 1.0f : -1.0f};
    mesh.position.push_back(x);
    mesh.normal.push_back(x * (1 / std::sqrt(3.0f)));
    mesh.temperature.push_back(0);
    mesh.body.push_back(1);
    mesh.material.push_back(0);
  }
  mesh.triangles = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                    2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
  return mesh;
}

TEST(Shapes, VerticesWithoutATriangleAreDropped) {
  Mesh mesh = cube();
  for (std::size_t v = 0; v < 8; ++v) mesh.temperature[v] = static_cast<float>(v);
  mesh.contents = {std::vector<float>{0, 1, 2, 3, 4, 5, 6, 7}};
  drop_unused(mesh);
  EXPECT_EQ(mesh.position.size(), 8u);  // all are used
  mesh.triangles = {7, 2, 5};
  drop_unused(mesh);
  EXPECT_EQ(mesh.triangles, (std::vector<std::uint32_t>{2, 0, 1}));
  EXPECT_EQ(mesh.temperature, (std::vector<float>{2, 5, 7}));
  EXPECT_EQ(mesh.contents[0], mesh.temperature);
  EXPECT_EQ(mesh.position.size(), 3u);
  EXPECT_EQ(mesh.normal.size(), 3u);
  EXPECT_EQ(mesh.body.size(), 3u);
  EXPECT_EQ(mesh.material.size(), 3u);
  EXPECT_TRUE(mesh.liquid_fraction.empty());
}

TEST(Shapes, BodiesThatAreNotVisibleAreLeftOut) {
  FrameShapes shapes;
  shapes.liquid = cube();
  shapes.solid = cube();
  const std::size_t whole = shapes.solid.triangles.size();
  for (std::size_t v = 0; v < 8; ++v) shapes.solid.body[v] = 2;
  shapes.balls = {{{0, 0, 0}, 1, 0, 1, true},
                  {{0, 0, 0}, 1, 0, 2, true},
                  {{0, 0, 0}, 1, 0, 3, true},
                  {{0, 0, 0}, 1, 0, 0, false}};
  const FrameShapes second = visible_part(shapes, {true, false});
  EXPECT_TRUE(second.solid.empty());
  EXPECT_EQ(second.liquid.triangles, shapes.liquid.triangles);
  ASSERT_EQ(second.balls.size(), 3u);
  EXPECT_EQ(second.balls[1].body, 3u);  // beyond the list
  const FrameShapes first = visible_part(shapes, {false, true});
  EXPECT_EQ(first.solid.triangles.size(), whole);
  ASSERT_EQ(first.balls.size(), 3u);
  EXPECT_EQ(first.balls[0].body, 2u);
}

TEST(Shapes, PicturesShowOneSheetWhereTwoLieOnEachOther) {
  FrameShapes shapes;
  shapes.liquid = cube();
  shapes.solid = cube();
  for (Vec3f& x : shapes.liquid.position)
    if (x.y > 0) x.y = 2;  // all but the floor of it lies elsewhere
  Scene scene;
  scene.world.spacing = 0.1;
  EXPECT_EQ(picture_shapes(shapes, scene).liquid.triangles.size(), 36u);
  scene.output.surface = {{"closed_at_solids", true}};
  EXPECT_EQ(picture_shapes(shapes, scene).liquid.triangles.size(), 30u);
  EXPECT_EQ(picture_shapes(shapes, scene).solid.triangles.size(), 36u);
}

TEST(Rays, MeetTheNearestOfManyBallsAsAllPairsDo) {
  FrameShapes shapes;
  std::uint32_t state = 1;
  const auto next = [&state] {
    state = state * 1664525u + 1013904223u;
    return static_cast<float>(state >> 8) / 16777216.0f;
  };
  for (int i = 0; i < 300; ++i)
    shapes.balls.push_back({{next(), next(), next()}, 0.01f + 0.05f * next(), 0, 0, i % 2 == 0});
  const Bvh bvh(shapes);
  int met = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec3f from{3 * next() - 1, 3 * next() - 1, 3 * next() - 1}, to{next(), next(), next()};
    const Ray ray{from, (to - from) * (1 / length(to - from))};
    float nearest = 1e30f;
    for (const Ball& ball : shapes.balls) {  // in double, from the formula
      const double b = dot(meltsim::cast<double>(ray.along), meltsim::cast<double>(ball.center - from));
      const double c =
          dot(meltsim::cast<double>(ball.center - from), meltsim::cast<double>(ball.center - from)) -
          static_cast<double>(ball.radius) * ball.radius;
      if (b * b < c) continue;
      const double t = b - std::sqrt(b * b - c) > 0 ? b - std::sqrt(b * b - c) : b + std::sqrt(b * b - c);
      if (t > 0) nearest = std::min(nearest, static_cast<float>(t));
    }
    const Hit hit = bvh.nearest(ray);
    ASSERT_EQ(hit.any(), nearest < 1e29f);
    EXPECT_EQ(bvh.blocked(ray, Seen::all), hit.any());
    if (!hit.any()) continue;
    ++met;
    EXPECT_NEAR(hit.distance, nearest, 1e-4);
  }
  EXPECT_GT(met, 100);
}

/// How far a ray goes to a triangle, in double; infinity where it does not meet it.
double distance_to(const Ray& ray, const Mesh& mesh, std::size_t t) {
  const auto corner = [&](std::size_t k) {
    return meltsim::cast<double>(mesh.position[mesh.triangles[t + k]]);
  };
  const meltsim::Vec3d ab = corner(1) - corner(0), ac = corner(2) - corner(0),
                       s = meltsim::cast<double>(ray.from) - corner(0), d = meltsim::cast<double>(ray.along),
                       p = cross(d, ac), q = cross(s, ab);
  const double det = dot(ab, p), u = dot(s, p) / det, v = dot(d, q) / det, far = dot(ac, q) / det;
  return det != 0 && u >= 0 && v >= 0 && u + v <= 1 && far > 0 ? far : meltsim::infinity;
}

TEST(Rays, MeetTheNearestOfMixedTrianglesAndBallsAsAllPairsDo) {
  // Solids, liquid and balls in one place, few enough that leaves with fewer than four and of two kinds come up.
  std::uint32_t state = 7;
  const auto next = [&state] {
    state = state * 1664525u + 1013904223u;
    return static_cast<float>(state >> 8) / 16777216.0f;
  };
  const auto scatter = [&](Mesh& mesh, int count) {
    for (int i = 0; i < count; ++i) {
      const Vec3f middle{next(), next(), next()};
      for (int k = 0; k < 3; ++k) {
        mesh.triangles.push_back(static_cast<std::uint32_t>(mesh.position.size()));
        mesh.position.push_back(middle + Vec3f{next() - 0.5f, next() - 0.5f, next() - 0.5f} * 0.3f);
      }
    }
  };
  FrameShapes shapes;
  scatter(shapes.solid, 37);
  scatter(shapes.liquid, 61);
  for (int i = 0; i < 30; ++i) shapes.balls.push_back({{next(), next(), next()}, 0.03f, 0, 0, i % 2 == 0});
  const Bvh bvh(shapes);
  const auto all_pairs = [&](const Ray& ray, Seen seen) {
    double nearest = meltsim::infinity;
    const auto look = [&](const Mesh& mesh) {
      for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
        nearest = std::min(nearest, distance_to(ray, mesh, t));
    };
    if (seen != Seen::liquid) look(shapes.solid);
    if (seen != Seen::solid) look(shapes.liquid);
    for (const Ball& ball : shapes.balls) {
      if (seen != Seen::all && ball.solid != (seen == Seen::solid)) continue;
      FrameShapes one;
      one.balls = {ball};
      const Hit hit = Bvh(one).nearest(ray);  // balls alone have a test above
      if (hit.any()) nearest = std::min(nearest, static_cast<double>(hit.distance));
    }
    return nearest;
  };
  int met = 0;
  for (int i = 0; i < 600; ++i) {
    const Vec3f from{3 * next() - 1, 3 * next() - 1, 3 * next() - 1}, to{next(), next(), next()};
    Ray ray{from, (to - from) * (1 / length(to - from))};
    // One in three along an axis, as floors and walls are looked at: a component of exactly zero, of either sign.
    if (i % 3 == 0)
      ray = {{next(), next(), i % 2 == 0 ? -1.0f : 2.0f}, {0, -0.0f, i % 2 == 0 ? 1.0f : -1.0f}};
    for (const Seen seen : {Seen::all, Seen::solid, Seen::liquid}) {
      const double nearest = all_pairs(ray, seen);
      const Hit hit = bvh.nearest(ray, seen);
      ASSERT_EQ(hit.any(), nearest < meltsim::infinity);
      ASSERT_EQ(bvh.blocked(ray, seen), hit.any());
      if (!hit.any()) continue;
      ++met;
      ASSERT_NEAR(hit.distance, nearest,
                  1e-4);  // of rays some 3 long, in single precision, at grazing triangles
    }
  }
  EXPECT_GT(met, 300);
}

TEST(Rays, MeetACubeAndKnowItsInside) {
  FrameShapes shapes;
  shapes.solid = cube();
  const Bvh bvh(shapes);
  const Hit hit = bvh.nearest({{0.2f, 0.3f, 5}, {0, 0, -1}});
  EXPECT_NEAR(hit.distance, 4, 1e-5);
  EXPECT_FALSE(bvh.nearest({{1.2f, 0.3f, 5}, {0, 0, -1}}).any());
  Ray ray{{0.2f, 0.3f, 5}, {0, 0, -1}};
  ray.most = 3.9f;
  EXPECT_FALSE(bvh.blocked(ray, Seen::all));
  Camera camera;
  camera.eye = {0.1, 0.2, 0.3};
  camera.look_at = {5, 5, 5};
  EXPECT_TRUE(eye_in_solid(shapes, camera));
  camera.eye = {0.1, 0.2, 3};
  camera.look_at = {0, 0, 0};
  EXPECT_FALSE(eye_in_solid(shapes, camera));
}

TEST(Shapes, LiquidOfAColourIsTakenFromTheClearOne) {
  const std::vector<SceneLook> looks{{"water", std::nullopt}, {"syrup", std::array<double, 3>{0.5, 0.2, 0}}};
  FrameShapes shapes;
  shapes.liquid = cube();
  EXPECT_TRUE(split_liquid(shapes, looks).paint.empty());
  for (std::size_t v = 0; v < 8; ++v) shapes.liquid.material[v] = v < 4 ? 1 : 0;  // z = -1 is syrup
  const FrameShapes split = split_liquid(shapes, looks);
  // Both parts together are the cube: its area, and every edge between two triangles.
  double area = 0;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
  for (const Mesh* mesh : {&split.paint, &split.liquid}) {
    for (std::size_t t = 0; t < mesh->triangles.size(); t += 3) {
      const std::uint32_t v[3] = {mesh->triangles[t], mesh->triangles[t + 1], mesh->triangles[t + 2]};
      area += 0.5 * length(cross(mesh->position[v[1]] - mesh->position[v[0]],
                                 mesh->position[v[2]] - mesh->position[v[0]]));
      for (std::size_t k = 0; k < 3; ++k) ++sides[{v[k], v[(k + 1) % 3]}];
    }
  }
  EXPECT_NEAR(area, 24, 1e-4);  // six faces of 2 x 2 in single precision
  for (const auto& [side, count] : sides) {
    ASSERT_EQ(count, 1);
    ASSERT_EQ(sides.count({side.second, side.first}), 1u);
  }
  // Cut between the two kinds of corners, and of the one colour there is.
  for (const std::uint32_t v : split.paint.triangles) {
    EXPECT_LT(split.paint.position[v].z, 0.999f);
    EXPECT_NEAR(split.paint.color[v].x, linear(0.5), 1e-5);
    EXPECT_NEAR(split.paint.color[v].z, 0, 1e-6);
  }
  for (const std::uint32_t v : split.liquid.triangles) EXPECT_GT(split.liquid.position[v].z, -0.999f);
  // Where they are, and what light passes.
  const Bvh bvh(split);
  const Hit below = bvh.nearest({{0.2f, 0.3f, -5}, {0, 0, 1}}),
            above = bvh.nearest({{0.2f, 0.3f, 5}, {0, 0, -1}});
  EXPECT_NEAR(below.distance, 4, 1e-5);
  EXPECT_NEAR(above.distance, 4, 1e-5);
  EXPECT_TRUE(bvh.is_solid(below.primitive) && bvh.is_paint(below.primitive));
  EXPECT_FALSE(bvh.is_solid(above.primitive));
  EXPECT_NEAR(bvh.nearest({{0.2f, 0.3f, 5}, {0, 0, -1}}, Seen::solid).distance, 6, 1e-5);
}

TEST(Shapes, WallsAreBarsAlongTheirEdges) {
  Scene scene;
  scene.world.domain.bounded = true;
  scene.world.domain.max = {1, 2, 3};
  const meltsim::Vec3d inside{0.5, 1, 1.5};
  EXPECT_EQ(tank_bars(scene, inside).size(), 12u);
  EXPECT_EQ(tank_bars(scene, {0.5, 1, 9}).size(), 12u);  // one face is turned to the eye
  // From a corner three faces are, and the three edges between them are left out: none is beyond two of the faces.
  const std::vector<Bar> seen = tank_bars(scene, {5, 5, 5});
  EXPECT_EQ(seen.size(), 9u);
  for (const Bar& bar : seen)
    EXPECT_LT((bar.min.x >= 1 ? 1 : 0) + (bar.min.y >= 2 ? 1 : 0) + (bar.min.z >= 3 ? 1 : 0), 2);
  for (const Bar& bar : tank_bars(scene, inside)) {  // outside of what may be full of liquid
    const bool beside = bar.max.x <= 0 || bar.min.x >= 1 || bar.max.y <= 0 || bar.min.y >= 2 ||
                        bar.max.z <= 0 || bar.min.z >= 3;
    EXPECT_TRUE(beside);
  }
  scene.world.domain.faces.fill(meltsim::Face::open);
  EXPECT_TRUE(tank_bars(scene, inside).empty());
  scene.world.domain.faces[2] = meltsim::Face::wall;  // a floor alone
  EXPECT_EQ(tank_bars(scene, inside).size(), 4u);
}

TEST(Tracer, NothingShinesThroughLiquidOfAColour) {
  FrameShapes shapes;
  shapes.liquid = cube();
  shapes.balls.push_back({{0, 0, 0}, 0.5f, 10, 1, true, 1});
  Camera camera;
  camera.eye = {0, 0, 6};
  camera.look_at = {0, 0, 0};
  TraceSettings settings;
  settings.width = settings.height = 9;
  settings.has_floor = false;
  settings.bodies = {{0, 0.8, 0}};
  Image clear = traced(shapes, camera, settings);
  EXPECT_GT(clear.at(4, 4)[1], clear.at(4, 4)[0] + 40);  // the green ball
  settings.looks = {{"chocolate", std::array<double, 3>{0.6, 0.2, 0.05}}};
  Image opaque = traced(shapes, camera, settings);
  EXPECT_GT(opaque.at(4, 4)[0], opaque.at(4, 4)[1] + 40);
  settings.look = Look::temperature;  // there colours are temperatures
  const Image warm = traced(shapes, camera, settings);
  settings.looks.clear();
  EXPECT_EQ(traced(shapes, camera, settings).rgb, warm.rgb);
}

TEST(Tracer, PicturesDoNotDependOnThreads) {
  FrameShapes shapes;
  shapes.liquid = cube();
  shapes.balls.push_back({{0, 0, 0}, 0.5f, 10, 1, true});
  Camera camera;
  camera.eye = {3, 4, 6};
  camera.look_at = {0, 0, 0};
  TraceSettings settings;
  settings.width = 40;
  settings.height = 30;
  settings.spacing = 0.1;
  settings.floor = -1;
  settings.threads = 1;
  const Image one = traced(shapes, camera, settings);
  settings.threads = 3;
  EXPECT_EQ(one.rgb, traced(shapes, camera, settings).rgb);
}

TEST(Image, SheetIsAGridAndPngComesBack) {
  Image red(40, 20), blue(40, 20);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 40; ++x) {
      red.set(x, y, {1, 0, 0});
      blue.set(x, y, {0, 0, 1});
    }
  }
  Image sheet = contact_sheet({red, blue, red}, 2, 20);
  EXPECT_EQ(sheet.width, 2 * 24 + 4);
  EXPECT_EQ(sheet.height, 2 * 14 + 4);
  EXPECT_EQ(sheet.at(5, 5)[0], 255);
  EXPECT_EQ(sheet.at(30, 5)[2], 255);
  EXPECT_EQ(sheet.at(5, 20)[0], 255);
  EXPECT_EQ(sheet.at(30, 20)[1], 255);  // white where there is no fourth
  std::string name = (std::filesystem::temp_directory_path() / "meltsim-XXXXXX").string();
  const std::string directory = mkdtemp(name.data());
  write_file(directory + "/sheet.png", png_text(sheet));
  EXPECT_EQ(read_png(directory + "/sheet.png").rgb, sheet.rgb);
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace runner
