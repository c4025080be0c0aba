// SPDX-License-Identifier: Apache-2.0
// Random numbers of the tests: the same on every machine (the standard's distributions are not).
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "meltsim/physics/math.hpp"

namespace test_support {

class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  /// In [low, high).
  double uniform(double low = 0, double high = 1) {
    return low + (high - low) * (static_cast<double>(engine_()) / 4294967296.0);
  }
  meltsim::Vec3<double> vector(double half = 1) {
    const double x = uniform(-half, half), y = uniform(-half, half);
    return {x, y, uniform(-half, half)};
  }
  std::uint32_t below(std::uint32_t n) { return engine_() % n; }
  /// A rotation, all equally likely enough: a random direction in four dimensions.
  meltsim::Quat<double> rotation() {
    for (;;) {
      const double w = uniform(-1, 1), x = uniform(-1, 1), y = uniform(-1, 1), z = uniform(-1, 1);
      const double n2 = w * w + x * x + y * y + z * z;
      if (n2 < 0.01 || n2 > 1) continue;
      const double s = 1 / std::sqrt(n2);
      return {w * s, x * s, y * s, z * s};
    }
  }

 private:
  std::mt19937 engine_;
};

}  // namespace test_support
