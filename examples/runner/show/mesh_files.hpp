// SPDX-License-Identifier: Apache-2.0
// Surfaces as files other programs open: binary PLY, OBJ and binary glTF, in world coordinates, with normals
// and temperature. A surface of nothing is written as a triangle too small to be seen, because importers stop
// at empty meshes.
#pragma once

#include <string>

#include "show/shapes.hpp"

namespace runner {

/// A word in the comments of the file (PLY, OBJ) or a name (glTF) that says it holds no surface.
inline const char* const placeholder_word = "placeholder";

/// Vertices x, y, z, nx, ny, nz, temperature (float), body (int, from 0, -1 = liquid), material (int, from
/// 0) and, of a mesh that has contents, a column (float) for each; then the triangles. `contents` names the columns.
std::string mesh_ply_text(const Mesh& mesh, const meltsim::Vec3d& origin, double time,
                          const std::vector<std::string>& contents = {});
/// `v` with the temperature's colour, `vt` with the temperature itself as its first number, `vn`; faces by
/// material, whose name `usemtl` says.
std::string mesh_obj_text(const Mesh& mesh, const meltsim::Vec3d& origin, double time,
                          const std::string& name, double cold, double hot,
                          const std::vector<SceneLook>& looks);
/// Liquid and solid of a frame as two nodes, with the attributes _TEMPERATURE and _MATERIAL. What is of a
/// material that has a colour is a primitive of that colour, the rest has the temperature's. Liquids of several
/// colours are one primitive, `dyed`, whose vertices have them, cut off from the clear one where half is clear.
/// Where `up`, a unit vector, is not +y, a node above both turns it there: that is up in glTF.
std::string glb_text(const FrameShapes& shapes, double cold, double hot, const std::vector<SceneLook>& looks,
                     const meltsim::Vec3d& up = {0, 1, 0});

}  // namespace runner
