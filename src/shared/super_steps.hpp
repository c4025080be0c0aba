// SPDX-License-Identifier: Apache-2.0
// The driver of Runge-Kutta-Legendre super-steps, for any quantity that diffuses (physics/diffusion.hpp). A quantity brings
// a body that sums what a particle's neighbours give and ends in physics::next_increment.
#pragma once

#include <cstdint>

#include "meltsim/physics/diffusion.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// The super-steps of a quantity in one sub-step.
struct SuperSteps {
  std::uint32_t stages = 0;  ///< of each
  std::uint32_t count = 0;
  double tau = 0;  ///< of each [s]
};

/// stage(factors) enqueues one stage and exchanges the buffers of increments and potentials: what it wrote is the d_{j-1} and
/// the potential of the next.
template <class E, class Stage>
void super_steps(E& ex, const SuperSteps& plan, const Stage& stage) {
  const int stages = static_cast<int>(plan.stages);
  for (std::uint32_t super = 0; super < plan.count; ++super)
    for (int j = 1; j <= stages; ++j) {
      if (ex.asked_to_stop()) return;  // the sub-step will not count
      stage(physics::stage_factors(j, stages, plan.tau, super == 0u, super + 1u == plan.count));
    }
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
