// SPDX-License-Identifier: Apache-2.0
// Named ranges in Nsight Systems and Nsight Compute. NVTX is header-only; where a minimal toolkit lacks it,
// the ranges are left out.
#pragma once

#if __has_include(<nvtx3/nvToolsExt.h>)
#include <nvtx3/nvToolsExt.h>

namespace meltsim {
inline namespace v0 {
namespace core {
inline void push_profiler_range(const char* name) { nvtxRangePushA(name); }
inline void pop_profiler_range() { nvtxRangePop(); }
}  // namespace core
}  // namespace v0
}  // namespace meltsim
#else
namespace meltsim {
inline namespace v0 {
namespace core {
inline void push_profiler_range(const char*) {}
inline void pop_profiler_range() {}
}  // namespace core
}  // namespace v0
}  // namespace meltsim
#endif
