// SPDX-License-Identifier: Apache-2.0
// What a frame looks like: surfaces where they are known, balls where only particles are.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <type_traits>
#include <vector>

#include "meltsim/types.hpp"
#include "particle_files.hpp"
#include "scene.hpp"
#include "show/camera.hpp"

namespace runner {

/// A surface; arrays per vertex are parallel.
struct Mesh {
  std::vector<meltsim::Vec3f> position,
      normal;                            ///< [m] relative to the origin of its FrameShapes; unit, outward
  std::vector<float> temperature;        ///< [degrees Celsius]
  std::vector<float> liquid_fraction;    ///< 0 solid .. 1 liquid; nothing where it is not known, as in files
  std::vector<std::uint32_t> body;       ///< 1 + index; 0 = liquid
  std::vector<std::uint32_t> material;   ///< index
  std::vector<std::uint32_t> triangles;  ///< 3 vertices each, counter-clockwise from outside
  std::vector<meltsim::Vec3f> color;     ///< linear light; of FrameShapes::paint alone
  std::vector<std::uint32_t> species;    ///< material indices of those in `contents`
  std::vector<std::vector<float>> contents;  ///< per species: mass fraction at every vertex; of liquid alone
  bool empty() const { return triangles.empty(); }
};

struct Ball {
  meltsim::Vec3f center;
  float radius;
  float temperature;
  std::uint32_t body;
  bool solid;
  std::uint32_t material = 0;
};

struct FrameShapes {
  double time = 0;        ///< [s]
  meltsim::Vec3d origin;  ///< [m]; what follows is relative to it
  Mesh liquid, solid;
  Mesh paint;  ///< liquid that nothing shines through, once split_liquid has told it from clear one
  Mesh tank;   ///< walls, as far as they are shown
  std::vector<Ball> balls;  ///< what the meshes do not show
};

/// Drops vertices that no triangle has, and numbers the others anew, in their order.
void drop_unused(Mesh& mesh);
/// Particles as balls; those of phases that a mesh shows are left out.
void add_balls(FrameShapes& shapes, const std::vector<FrameParticle>& particles, double spacing);
/// In place of a species' material where what is dissolved of it is clear.
inline constexpr std::uint32_t clear_species = 0xffffffffu;
/// What the liquid shows of a species: its colour where it mixes in any ratio; what dissolves from a body, such as sugar, has
/// the colour of its crystals, and its solution is clear.
inline std::uint32_t shown_species(std::uint32_t material, const meltsim::MaterialDesc& desc) {
  return desc.solubility < 1 || !desc.solubility_points.empty() ? clear_species : material;
}
/// Of each species of a scene, in the order of its materials and so of the contents of particles.
std::vector<std::uint32_t> shown_species(const Scene& scene);
/// Mass fractions at the vertices of the liquid, from the particles nearby; nothing where a frame has no species.
void add_contents(FrameShapes& shapes, const std::vector<FrameParticle>& particles,
                  const std::vector<std::uint32_t>& species, double spacing);
/// Moves liquid of materials that have a colour from `liquid` to `paint`. Colours, and whether there is one, are
/// averaged over neighbouring vertices; triangles are cut where half of the neighbourhood has a colour. Colours mix by content;
/// a clear liquid shows a species that has one from a content of 2.5 % on.
FrameShapes split_liquid(FrameShapes shapes, const std::vector<SceneLook>& looks);
/// What a vertex shows; null = its material has no colour.
inline const std::array<double, 3>* color_of(const std::vector<SceneLook>& looks, std::uint32_t material) {
  return material < looks.size() && looks[material].color ? &*looks[material].color : nullptr;
}
/// Triangles of a mesh by what group(a triangle's first entry) says, ascending.
template <class Group>
auto grouped(const Mesh& mesh, const Group& group) {
  std::map<std::decay_t<decltype(group(std::size_t{0}))>, std::vector<std::uint32_t>> parts;
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    auto& part = parts[group(t)];
    part.insert(part.end(), {mesh.triangles[t], mesh.triangles[t + 1], mesh.triangles[t + 2]});
  }
  return parts;
}
/// The material of most of a triangle's corners; of three that differ the first one's.
std::uint32_t material_of_triangle(const Mesh& mesh, std::size_t first);
/// Whether a body (1 + index; 0: none) is left out; bodies beyond the list are not.
inline bool is_hidden(const std::vector<bool>& visible, std::uint32_t body) {
  return body != 0 && body <= visible.size() && !visible[body - 1];
}
/// Without the solids of bodies that are hidden.
FrameShapes visible_part(FrameShapes shapes, const std::vector<bool>& visible);
/// In world coordinates.
Box box_of(const FrameShapes& shapes);

}  // namespace runner
