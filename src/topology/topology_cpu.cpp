// SPDX-License-Identifier: Apache-2.0
// The topology stages for the CPU executor.
#include "exec/exec_cpu.hpp"
#include "pipeline/stage_functions.hpp"
#include "topology/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace topology {

MELTSIM_INSTANTIATE(core::CpuExec, freeze)
MELTSIM_INSTANTIATE(core::CpuExec, melt)
MELTSIM_INSTANTIATE(core::CpuExec, neighbours)
MELTSIM_INSTANTIATE(core::CpuExec, regions)
MELTSIM_INSTANTIATE(core::CpuExec, pieces)
MELTSIM_INSTANTIATE(core::CpuExec, build)
MELTSIM_INSTANTIATE_BUILD_BODY(core::CpuExec)

}  // namespace topology
}  // namespace v0
}  // namespace meltsim
