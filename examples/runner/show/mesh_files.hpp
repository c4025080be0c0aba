// SPDX-License-Identifier: Apache-2.0
// Surfaces as files other programs open: binary PLY, OBJ and binary glTF, in world coordinates, with normals
// and temperature. A surface of nothing is written as a triangle too small to be seen, because importers stop
// at empty meshes.
#pragma once

#include <string>

#include "show/parts.hpp"
#include "show/shapes.hpp"

namespace runner {

/// A word in the comments of the file (PLY, OBJ) or a name (glTF) that says it holds no surface.
inline const char* const placeholder_word = "placeholder";

/// Vertices x, y, z, nx, ny, nz, temperature (float), body (int, from 0, -1 = liquid), material (int, from
/// 0), where it is known liquid_fraction (float) and, of a mesh that has contents, a column (float) for each; then the triangles.
/// `contents` names the columns.
std::string mesh_ply_text(const Mesh& mesh, const meltsim::Vec3d& origin, double time,
                          const std::vector<std::string>& contents = {});
/// `v` with the temperature's colour, `vt` with the temperature itself as its first number, `vn`; faces by
/// material, whose name `usemtl` says. Liquid fraction and contents are left out: OBJ has no vertex attributes of one's own.
std::string mesh_obj_text(const Mesh& mesh, const meltsim::Vec3d& origin, double time,
                          const std::string& name, double cold, double hot,
                          const std::vector<SceneLook>& looks);
/// Liquid and solid of a frame as two nodes, with the attributes _TEMPERATURE, _BODY (from 0, -1 = liquid), _MATERIAL,
/// _LIQUID_FRACTION where it is known and, of contents, one each such as _W_SUGAR: `contents` names their columns.
/// A node has a primitive for each of its materials; those that are coloured by vertex have COLOR_0.
/// Where `up`, a unit vector, is not +y, a node above both turns it there: that is up in glTF.
std::string glb_text(const FrameShapes& shapes, const PartLooks& looks,
                     const std::vector<std::string>& contents = {}, const meltsim::Vec3d& up = {0, 1, 0});

}  // namespace runner
