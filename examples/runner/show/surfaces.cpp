// SPDX-License-Identifier: Apache-2.0
#include "show/surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <unordered_set>

#include "expect.hpp"

namespace runner {

namespace {

/// Fewer particles than this are shown with finer cells: they are large in the picture, and it costs little.
constexpr std::size_t few_particles = 10000;
/// Sheets of the liquid and of solids where both meet are this near, but at the water line, whose triangles stay [spacings].
constexpr double same_sheet = 0.02;

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
  mesh.liquid_fraction = std::move(made->liquid_fraction);
  mesh.body = std::move(made->body);
  mesh.material = std::move(made->material);
  mesh.triangles = std::move(made->triangles);
  return mesh;
}

void append(Mesh& to, const Mesh& more) {
  const auto first = static_cast<std::uint32_t>(to.position.size());
  const auto put = [](auto& a, const auto& b) { a.insert(a.end(), b.begin(), b.end()); };
  put(to.position, more.position);
  put(to.normal, more.normal);
  put(to.temperature, more.temperature);
  put(to.liquid_fraction, more.liquid_fraction);
  put(to.body, more.body);
  put(to.material, more.material);
  for (const std::uint32_t v : more.triangles) to.triangles.push_back(first + v);
}

/// Of each body its own: one that touches a body has a face there, too.
Mesh meshes_of_bodies(meltsim::World& world, meltsim::SurfaceDesc desc, const meltsim::Vec3d& origin,
                      std::string& problem) {
  std::map<std::uint32_t, meltsim::BodyId> bodies;
  for (const meltsim::PieceInfo& piece : expect(world.pieces())) bodies[piece.body.index] = piece.body;
  Mesh all;
  for (const auto& [index, body] : bodies) {
    desc.body = body;
    append(all, mesh_of(world, desc, meltsim::SurfaceOf::body, origin, problem));
  }
  return all;
}

bool wants_closed(const Scene& scene) {
  return scene.output.surface.is_object() && scene.output.surface.value("closed_at_solids", false);
}

/// Drops triangles all of whose corners are as near as this to vertices of triangles of `other`: one sheet where two would be.
void drop_coincident(Mesh& mesh, const Mesh& other, double tolerance) {
  // Vertices are in all cells that they may be near to, so that a place is looked for in its own cell alone.
  using Cell = std::array<long, 3>;
  const auto cell_of = [edge = 2 * tolerance](const meltsim::Vec3d& x) {
    return Cell{std::lround(x.x / edge), std::lround(x.y / edge), std::lround(x.z / edge)};
  };
  const auto hash = [](const Cell& c) {
    return static_cast<std::size_t>(c[0] * 73856093 ^ c[1] * 19349663 ^ c[2] * 83492791);
  };
  std::unordered_set<Cell, decltype(hash)> near(1024, hash);
  std::vector<char> seen(other.position.size(), 0);
  for (const std::uint32_t v : other.triangles) {
    if (seen[v] != 0) continue;
    seen[v] = 1;
    for (int k = 0; k < 8; ++k) {
      const meltsim::Vec3d aside{k % 2 == 0 ? -1.0 : 1.0, k / 2 % 2 == 0 ? -1.0 : 1.0, k < 4 ? -1.0 : 1.0};
      near.insert(cell_of(meltsim::cast<double>(other.position[v]) + aside * tolerance));
    }
  }
  const auto coincides = [&](std::uint32_t v) {
    return near.count(cell_of(meltsim::cast<double>(mesh.position[v]))) != 0;
  };
  std::vector<std::uint32_t> kept;
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    const std::uint32_t* corner = &mesh.triangles[t];
    if (!coincides(corner[0]) || !coincides(corner[1]) || !coincides(corner[2]))
      kept.insert(kept.end(), corner, corner + 3);
  }
  mesh.triangles = std::move(kept);
  drop_unused(mesh);
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
  meltsim::SurfaceDesc desc = desc_of(scene, particles.id.size());
  const std::vector<bool>& visible = scene.output.body_visible;
  // Beside a body that pictures leave out, the liquid has a face of its own; beside others one sheet is for both.
  const bool hides = std::find(visible.begin(), visible.end(), false) != visible.end(),
             closed = wants_closed(scene);
  desc.closed_at_solids = hides || closed;
  shapes.liquid = mesh_of(world, desc, meltsim::SurfaceOf::liquid, shapes.origin, problem);
  shapes.solid = mesh_of(world, desc, meltsim::SurfaceOf::solids, shapes.origin, problem);
  if (hides) {
    if (!closed)
      drop_coincident(shapes.liquid, visible_part(shapes, visible).solid, same_sheet * scene.world.spacing);
    shapes.solid = meshes_of_bodies(world, desc, shapes.origin, problem);
  }
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

FrameShapes picture_shapes(FrameShapes shapes, const Scene& scene) {
  FrameShapes shown = visible_part(std::move(shapes), scene.output.body_visible);
  if (wants_closed(scene)) drop_coincident(shown.liquid, shown.solid, same_sheet * scene.world.spacing);
  return shown;
}

}  // namespace runner
