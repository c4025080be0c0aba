// SPDX-License-Identifier: Apache-2.0
// How the triangles of a mesh count towards the inside.
//
// Source: the winding number of a point, the signed number of surfaces between it and the outside, as in Jacobson, Kavan &
// Sorkine-Hornung (2013), ACM Trans. Graph. 32:33, sec. 2. A point is inside where it is not 0: parts that overlap are one, and a
// shell within another is a cavity if it faces the other way. It needs shells that are closed and of one orientation; of others
// only whether the number of surfaces is odd means anything.
#pragma once

#include <cstdint>
#include <vector>

#include "meltsim/shape.hpp"

namespace meltsim {
inline namespace v0 {

/// Per triangle: 1 or -1, by which its orientation counts, or 0 where its shell has edges that are not between as many triangles
/// of one direction as of the other; those count by parity. A shell is what shares edges. One that is inside out and
/// not within the bounds of another is turned.
std::vector<std::int8_t> triangle_turns(const TriangleMesh& mesh);

}  // namespace v0
}  // namespace meltsim
