// SPDX-License-Identifier: Apache-2.0
// Inside of a triangle mesh by parity: an odd number of surfaces crossed on the way to a point means inside.
#pragma once

#include "meltsim/shape.hpp"
#include "shape/shape_lattice.hpp"

namespace meltsim {
inline namespace v0 {

/// Two of three axes have to find the point inside.
bool inside_by_parity(const TriangleMesh& mesh, Vec3d point);

/// The same for all sites of a mask at once. Vertices are moved by -nudge first, which keeps sites that lie
/// on a face of the mesh off it.
void fill_by_parity(const TriangleMesh& mesh, Vec3d nudge, const Lattice& lattice, SiteMask& mask);

}  // namespace v0
}  // namespace meltsim
