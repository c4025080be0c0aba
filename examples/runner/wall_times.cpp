// SPDX-License-Identifier: Apache-2.0
#include "wall_times.hpp"

namespace runner {

namespace {
const Clock::time_point started = Clock::now();
}  // namespace

Clock::time_point program_start() { return started; }

}  // namespace runner
