// SPDX-License-Identifier: Apache-2.0
// The map x -> linear x + offset, where linear is a rotation times a uniform scale.
#pragma once

#include "meltsim/types.hpp"

namespace meltsim {
inline namespace v0 {

struct Affine {
  Mat3<double> linear = identity3<double>();
  Vec3d offset;

  Vec3d operator()(Vec3d p) const { return linear * p + offset; }
  Vec3d direction(Vec3d d) const { return linear * d; }
  /// Every column has the same length.
  double scale() const { return length(Vec3d{linear.m[0][0], linear.m[1][0], linear.m[2][0]}); }
};

/// x -> outer(inner(x))
inline Affine compose(const Affine& outer, const Affine& inner) {
  return {outer.linear * inner.linear, outer(inner.offset)};
}

}  // namespace v0
}  // namespace meltsim
