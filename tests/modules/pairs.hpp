// SPDX-License-Identifier: Apache-2.0
// Scenes for sums over pairs, and what an engine makes of them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "modules/pair_sums.hpp"

namespace modules_test {

/// A way to make the sums. CPU: pair_engines.cpp; CUDA: tests/gpu/pair_engines.cpp.
struct PairEngine {
  std::string name;
  std::function<std::shared_ptr<core::Engine>(Precision)> make;
  /// Removed particles beside those of a scene: how many there are decides how a GPU shares its sums out.
  std::size_t removed = 0;
  double support = 2.5;  ///< spacings
  /// Scenes whose domain ends in walls along x are this many supports long: in long lines of cells a thread may take two.
  double length = 0;
};
std::vector<PairEngine> pair_engines();
/// Why they cannot run here; empty: they can.
std::string no_pair_engines();

struct NamedScene {
  std::string name;
  PairScene scene;
};
/// dx 0.2, lattices of 0.9 dx: compressed, so that liquid has a pressure and comes within the reach of leak_force.
/// `length`: PairEngine::length.
std::vector<NamedScene> pair_scenes(double support, double length = 0);

/// All that the engine adds up over pairs.
template <class T>
PairSums sums_of(const PairEngine& how, const PairScene& scene);

}  // namespace modules_test
