// SPDX-License-Identifier: Apache-2.0
#include "show/surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>

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
                         const meltsim::ParticleFrame& particles, std::string& problem) {
  FrameShapes shapes;
  shapes.time = time;
  // Files hold single precision: far from zero, only what is relative to something near is exact.
  if (scene.world.domain.bounded) {
    shapes.origin = scene.world.domain.min;
  } else if (!particles.id.empty()) {
    const FrameParticle first = ParticleColumns(particles).particle(0);
    shapes.origin = {first.position[0], first.position[1], first.position[2]};
  }
  const meltsim::SurfaceDesc desc = desc_of(scene, particles.id.size());
  shapes.liquid = mesh_of(world, desc, meltsim::SurfaceOf::liquid, shapes.origin, problem);
  shapes.solid = mesh_of(world, desc, meltsim::SurfaceOf::solids, shapes.origin, problem);
  if (!particles.species.empty()) {
    std::vector<std::uint32_t> species;
    for (const meltsim::MaterialId id : particles.species)
      species.push_back(shown_species(id.index, world.material(id)));
    add_contents(shapes, frame_particles(particles), species, scene.world.spacing);
  }
  const auto has_no_mesh = [&shapes](meltsim::ParticleTag tag) {
    return (meltsim::is_solid(tag) ? shapes.solid : shapes.liquid).empty();
  };
  if (std::any_of(particles.tag.begin(), particles.tag.end(), has_no_mesh))
    add_balls(shapes, frame_particles(particles), scene.world.spacing);
  return shapes;
}

}  // namespace runner
