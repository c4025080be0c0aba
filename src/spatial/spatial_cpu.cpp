// SPDX-License-Identifier: Apache-2.0
// The spatial stages for the CPU executor.
#include "exec/exec_cpu.hpp"
#include "pipeline/stage_functions.hpp"
#include "spatial/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

MELTSIM_INSTANTIATE(core::CpuExec, cells)
MELTSIM_INSTANTIATE(core::CpuExec, settle)
MELTSIM_INSTANTIATE(core::CpuExec, keys)
MELTSIM_INSTANTIATE(core::CpuExec, sort)
MELTSIM_INSTANTIATE(core::CpuExec, reorder)
MELTSIM_INSTANTIATE(core::CpuExec, groups)
MELTSIM_INSTANTIATE(core::CpuExec, ranges)
MELTSIM_INSTANTIATE(core::CpuExec, codes)
MELTSIM_INSTANTIATE(core::CpuExec, leaves)
MELTSIM_INSTANTIATE(core::CpuExec, boxes)
MELTSIM_INSTANTIATE(core::CpuExec, walk)
MELTSIM_INSTANTIATE(core::CpuExec, neighbours)

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
