// SPDX-License-Identifier: Apache-2.0
#include "show/surfaces.hpp"

#include <fmt/format.h>

namespace runner {

namespace {

/// Fewer particles than this are shown with finer cells: they are large in the picture, and it costs little.
constexpr std::size_t few_particles = 10000;

meltsim::SurfaceDesc desc_of(const Scene& scene, std::size_t particles) {
  const Json& wish = scene.output.surface;
  meltsim::SurfaceDesc desc;
  if (particles < few_particles) desc.cell = scene.world.spacing / 3;
  if (!wish.is_object()) return desc;
  desc.cell = wish.value("cell", desc.cell);
  desc.smoothing = wish.value("smoothing", desc.smoothing);
  if (wish.value("kernel", "isotropic") == std::string("anisotropic"))
    desc.kernel = meltsim::SurfaceKernel::anisotropic;
  return desc;
}

Mesh mesh_of(meltsim::World& world, meltsim::SurfaceDesc desc, meltsim::SurfaceOf of,
             const meltsim::Vec3d& origin, std::string& problem) {
  desc.of = of;
  meltsim::Result<meltsim::SurfaceMesh> made = world.surface(desc);
  if (!made) {
    problem = made.error().message;
    return {};
  }
  Mesh mesh;
  const meltsim::Vec3f shift = meltsim::cast<float>(made->origin - origin);
  mesh.position = std::move(made->position);
  for (meltsim::Vec3f& x : mesh.position) x = x + shift;
  mesh.normal = std::move(made->normal);
  mesh.temperature = std::move(made->temperature);
  mesh.body = std::move(made->body);
  mesh.material = std::move(made->material);
  mesh.triangles = std::move(made->triangles);
  return mesh;
}

}  // namespace

FrameShapes world_shapes(meltsim::World& world, const Scene& scene, double time,
                         const std::vector<FrameParticle>& particles, std::string& problem) {
  FrameShapes shapes;
  shapes.time = time;
  // Files hold single precision: far from zero, only what is relative to something near is exact.
  const FrameParticle& first = particles.front();
  shapes.origin = scene.world.domain.bounded
                      ? scene.world.domain.min
                      : meltsim::Vec3d{first.position[0], first.position[1], first.position[2]};
  const meltsim::SurfaceDesc desc = desc_of(scene, particles.size());
  shapes.liquid = mesh_of(world, desc, meltsim::SurfaceOf::liquid, shapes.origin, problem);
  shapes.solid = mesh_of(world, desc, meltsim::SurfaceOf::solids, shapes.origin, problem);
  add_balls(shapes, particles, scene.world.spacing);
  return shapes;
}

}  // namespace runner
