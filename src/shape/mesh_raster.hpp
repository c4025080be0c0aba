// SPDX-License-Identifier: Apache-2.0
// Inside of a triangle mesh by the surfaces crossed on the way to a point along an axis: their signed sum is not 0, or, of shells
// that are open or of no orientation, their number is odd (mesh_shells.hpp). Two of three axes have to find the point inside.
#pragma once

#include "meltsim/shape.hpp"
#include "shape/shape_lattice.hpp"

namespace meltsim {
inline namespace v0 {

/// turns: triangle_turns() of the mesh.
bool inside_of(const TriangleMesh& mesh, const std::vector<std::int8_t>& turns, Vec3d point);

/// The same for all sites of a mask at once. Vertices are moved by -nudge first, which keeps sites that lie
/// on a face of the mesh off it.
void fill_inside(const TriangleMesh& mesh, const std::vector<std::int8_t>& turns, Vec3d nudge,
                 const Lattice& lattice, SiteMask& mask);

}  // namespace v0
}  // namespace meltsim
