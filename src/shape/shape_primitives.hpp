// SPDX-License-Identifier: Apache-2.0
// Builders of the leaves of a shape.
#pragma once

#include <vector>

#include "meltsim/shape.hpp"
#include "shape/shape_node.hpp"

namespace meltsim {
inline namespace v0 {

ShapePtr make_box(Vec3d min, Vec3d max);
ShapePtr make_sphere(Vec3d center, double radius);
ShapePtr make_capsule(Vec3d a, Vec3d b, double radius);
ShapePtr make_cylinder(Vec3d a, Vec3d b, double radius);
ShapePtr make_torus(Vec3d center, Vec3d axis, double major_radius, double minor_radius);
ShapePtr make_blend(std::vector<Ellipsoid> parts, double blend);
ShapePtr make_mesh(TriangleMesh mesh);
/// Contains nothing; validate() gives the error.
ShapePtr make_refused(Error error);

}  // namespace v0
}  // namespace meltsim
