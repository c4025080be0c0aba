// SPDX-License-Identifier: Apache-2.0
// How many threads and how much memory this process may use.
#pragma once

#include <cstdint>

namespace meltsim {
inline namespace v0 {
namespace core {

/// Processors this process may use: those of its affinity mask, and no more than its control group's share of time.
int processors();

/// Threads of a World that asks for `asked`; 0: one per processor, or fewer where OMP_NUM_THREADS says so. More than
/// there are processors gain nothing; up to 16 are granted anyway, for comparison of results between machines.
int threads_for(int asked);

/// Bytes that a process may still take before the system begins to kill processes: memory available, and what the control
/// groups leave. The largest number if the system reports none.
std::uint64_t available_memory();

}  // namespace core
}  // namespace v0
}  // namespace meltsim
