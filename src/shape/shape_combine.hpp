// SPDX-License-Identifier: Apache-2.0
// Builders of the inner nodes of a shape. Null stands for the empty shape, as an argument and as a result.
#pragma once

#include <vector>

#include "shape/shape_node.hpp"

namespace meltsim {
inline namespace v0 {

ShapePtr make_union(std::vector<ShapePtr> parts);
ShapePtr make_difference(ShapePtr from, ShapePtr what);
ShapePtr make_intersection(std::vector<ShapePtr> parts);
ShapePtr make_transformed(ShapePtr child, Vec3d offset, Vec3d axis, double angle, double scale);

}  // namespace v0
}  // namespace meltsim
