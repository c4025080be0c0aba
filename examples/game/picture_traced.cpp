// SPDX-License-Identifier: Apache-2.0
#include <fstream>

#include "failure.hpp"
#include "picture.hpp"
#include "show/draw.hpp"

namespace game {

namespace {

runner::Mesh mesh_of(const meltsim::SurfaceMesh& s) {
  runner::Mesh m;
  m.position = s.position;
  m.normal = s.normal;
  m.temperature = s.temperature;
  m.body = s.body;
  m.material = s.material;
  m.triangles = s.triangles;
  return m;
}

/// A flat-shaded copy of the triangles, in the colour of `body`.
void add_flag(runner::Mesh& to, const FlagMesh& flag, const Vec3d& origin, std::uint32_t body) {
  for (std::size_t t = 0; t + 2 < flag.triangles.size(); t += 3) {
    const Vec3d a = flag.position[flag.triangles[t]], b = flag.position[flag.triangles[t + 1]],
                c = flag.position[flag.triangles[t + 2]];
    const Vec3d n = cross(b - a, c - a);
    for (const Vec3d& p : {a, b, c}) {
      to.triangles.push_back(static_cast<std::uint32_t>(to.position.size()));
      to.position.push_back(meltsim::cast<float>(p - origin));
      to.normal.push_back(meltsim::cast<float>(n * (1 / length(n))));
      to.temperature.push_back(20);
      to.body.push_back(body);
      to.material.push_back(0);
    }
  }
}

}  // namespace

std::string write_picture(Game& game, const std::string& path) {
  meltsim::SurfaceDesc of;
  const auto liquid = game.world().surface(of);
  if (!liquid) return liquid.error().message;
  of.of = meltsim::SurfaceOf::solids;
  const auto solids = game.world().surface(of);
  if (!solids) return solids.error().message;
  runner::FrameShapes shapes;
  shapes.time = game.world().time();
  shapes.origin = liquid->origin;
  shapes.liquid = mesh_of(*liquid);
  shapes.solid = mesh_of(*solids);
  for (meltsim::Vec3f& p : shapes.solid.position)  // both relative to one origin
    p += meltsim::cast<float>(solids->origin - liquid->origin);
  std::uint32_t color = 5;
  for (const Flag& f : game.flags())
    if (f.planted_in_piece) add_flag(shapes.solid, game.mesh_of(f), shapes.origin, color++);

  runner::Camera camera;
  camera.eye = {1.1, 0.95, 2.1};
  camera.look_at = {0.82, 0.38, 0.3};
  runner::TraceSettings settings;
  settings.width = 960;
  settings.height = 540;
  settings.samples = 2;
  settings.spacing = game.world().desc().spacing;
  settings.extent = length(Game::size);
  // Shelf, ice, cup, iron, then flags.
  settings.bodies = {runner::linear({0.55, 0.5, 0.44}),  runner::linear({0.86, 0.93, 0.98}),
                     runner::linear({0.72, 0.36, 0.2}),  runner::linear({0.9, 0.28, 0.1}),
                     runner::linear({0.85, 0.12, 0.14}), runner::linear({0.12, 0.3, 0.75}),
                     runner::linear({0.95, 0.75, 0.1})};
  settings.floor = -0.02 * settings.spacing;
  try {
    runner::Image image = runner::traced(shapes, camera, settings);
    runner::PictureWish wish;
    runner::annotate(image, shapes.time, wish);
    const std::string text = runner::png_text(image);
    std::ofstream file(path, std::ios::binary);
    file.write(text.data(), static_cast<std::streamsize>(text.size()));
    if (!file.flush()) return "--picture: cannot write " + path;
  } catch (const std::exception& e) {
    return std::string("--picture: ") + e.what();
  }
  return {};
}

}  // namespace game
