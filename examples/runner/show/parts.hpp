// SPDX-License-Identifier: Apache-2.0
// What surfaces look like in other programs: parts of one material each, coloured as pictures of the scene are.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "scene.hpp"
#include "show/draw.hpp"
#include "show/ramp.hpp"
#include "show/shapes.hpp"

namespace runner {

inline constexpr double water_ior = 1.333;  ///< index of refraction of water at visible light

/// A material of a renderer.
struct PartLook {
  std::string name;
  Rgb color{1, 1, 1};  ///< linear light
  double opacity = 1;  ///< for renderers that do not refract
  double roughness = 0.4;
  bool clear = false;      ///< it refracts light as water does
  bool by_vertex = false;  ///< its colour is that of the vertices
};

/// The materials of a scene. They are the same in every frame, so that a sequence of frames keeps them.
struct PartLooks {
  bool by_temperature = false;  ///< all vertices have the colour of their temperature
  double cold = 0, hot = 1;     ///< ends of the ramp [degrees Celsius]
  std::vector<SceneLook> materials;
  std::vector<PartLook> all;               ///< names are unique
  std::vector<std::size_t> liquid, solid;  ///< entries of `all` that each surface may have; one at least
  std::map<std::uint32_t, std::size_t> of_material;  ///< of materials that have a colour
  std::vector<std::size_t> of_body;                  ///< of each body
  bool mixed = false;  ///< liquids of several colours, and mixtures: their vertices carry the colour
};
/// As pictures of this wish show them.
PartLooks part_looks(const Scene& scene, const PictureWish& wish);

/// A surface whose triangles are sorted by material.
struct PartedMesh {
  Mesh mesh;                                                    ///< `color` of every vertex is there
  std::map<std::size_t, std::vector<std::uint32_t>> triangles;  ///< by entry of PartLooks::all
};
PartedMesh liquid_parts(const FrameShapes& shapes, const PartLooks& looks);
PartedMesh solid_parts(const FrameShapes& shapes, const PartLooks& looks);

}  // namespace runner
