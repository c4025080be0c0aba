// SPDX-License-Identifier: Apache-2.0
// The thermal stages for the CPU executor.
#include "exec/exec_cpu.hpp"
#include "pipeline/stage_functions.hpp"
#include "thermal/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace thermal {

MELTSIM_INSTANTIATE(core::CpuExec, operands)
MELTSIM_INSTANTIATE(core::CpuExec, exchange)
MELTSIM_INSTANTIATE(core::CpuExec, paper)
MELTSIM_INSTANTIATE(core::CpuExec, boundary)
MELTSIM_INSTANTIATE(core::CpuExec, iwasaki)
MELTSIM_INSTANTIATE(core::CpuExec, level)

}  // namespace thermal
}  // namespace v0
}  // namespace meltsim
