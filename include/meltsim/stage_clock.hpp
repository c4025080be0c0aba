// SPDX-License-Identifier: Apache-2.0
// The time of a sub-step, for kernels of a host.
#pragma once

namespace meltsim {
inline namespace v0 {

/// When a sub-step is: in the backend's memory, for kernels of a recorded custom stage; valid in the stage.
struct StageClock {
  double time = 0;    ///< at its start [s]
  double length = 0;  ///< [s]
};

}  // namespace v0
}  // namespace meltsim
