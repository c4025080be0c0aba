// SPDX-License-Identifier: Apache-2.0
#include "show/shapes.hpp"

namespace runner {

using meltsim::Vec3d;
using meltsim::Vec3f;

void add_balls(FrameShapes& shapes, const std::vector<FrameParticle>& particles, double spacing) {
  for (const FrameParticle& p : particles) {
    const bool solid = p.phase == 1;
    if (p.phase > 1 || !(solid ? shapes.solid : shapes.liquid).empty()) continue;
    const Vec3d x{p.position[0], p.position[1], p.position[2]};
    // A little more than touching: gaps between balls are noise in a picture.
    shapes.balls.push_back({meltsim::cast<float>(x - shapes.origin), static_cast<float>(0.56 * spacing),
                            p.temperature, static_cast<std::uint32_t>(p.body + 1), solid,
                            static_cast<std::uint32_t>(p.material)});
  }
}

const std::array<double, 3>* color_of(const std::vector<SceneLook>& looks, std::uint32_t material) {
  return material < looks.size() && looks[material].color ? &*looks[material].color : nullptr;
}

std::uint32_t material_of_triangle(const Mesh& mesh, std::size_t first) {
  const auto at = [&](std::size_t k) { return mesh.material[mesh.triangles[first + k]]; };
  return at(1) == at(2) ? at(1) : at(0);
}

FrameShapes split_liquid(FrameShapes shapes, const std::vector<SceneLook>& looks) {
  auto parts = grouped(shapes.liquid, [&](std::size_t t) {
    int colored = 0;
    for (std::size_t k = 0; k < 3; ++k)
      colored += color_of(looks, shapes.liquid.material[shapes.liquid.triangles[t + k]]) != nullptr ? 1 : 0;
    return colored > 1;
  });
  if (parts[true].empty()) return shapes;
  shapes.paint = shapes.liquid;  // vertices of others do no harm
  shapes.paint.triangles = std::move(parts[true]);
  shapes.liquid.triangles = std::move(parts[false]);
  return shapes;
}

Box box_of(const FrameShapes& shapes) {
  Box box;
  const auto add = [&](const Vec3f& x) { box.add(shapes.origin + meltsim::cast<double>(x)); };
  for (const Mesh* mesh : {&shapes.liquid, &shapes.solid}) {
    for (const Vec3f& x : mesh->position) add(x);
  }
  for (const Ball& ball : shapes.balls) {
    const Vec3f r{ball.radius, ball.radius, ball.radius};
    add(ball.center - r);
    add(ball.center + r);
  }
  return box;
}

}  // namespace runner
