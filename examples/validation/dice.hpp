// SPDX-License-Identifier: Apache-2.0
// What cases and cells drawn at random draw their numbers with.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "constants.hpp"
#include "meltsim/types.hpp"

namespace validation {

/// Numbers of one draw. The standard's engine, but not its distributions, which differ from library to library.
class Dice {
 public:
  /// The same for the same `seed` and `number` of the draw, on every machine.
  Dice(std::uint64_t seed, std::uint64_t number) : engine_(seed * 1000003 + number) {}
  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }
  double log(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  int whole(int low, int high) {  ///< both included
    return std::min(high, low + static_cast<int>(uniform(0, high - low + 1)));
  }
  bool coin() { return uniform(0, 1) < 0.5; }
  bool one_in(int n) { return whole(1, n) == 1; }
  meltsim::Vec3d direction() {
    const double z = uniform(-1, 1), phi = uniform(0, 2 * pi), r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
  }
  /// In any direction, so far from the origin.
  meltsim::Vec3d place(double low, double high) {
    const double far = log(low, high);  // first: C++ leaves the order of what is multiplied open
    return direction() * far;
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace validation
