// SPDX-License-Identifier: Apache-2.0
// The step stages for the CPU executor.
#include "exec/exec_cpu.hpp"
#include "pipeline/stage_functions.hpp"
#include "step/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace step {

MELTSIM_INSTANTIATE(core::CpuExec, begin)
MELTSIM_INSTANTIATE(core::CpuExec, begin_cells)
MELTSIM_INSTANTIATE(core::CpuExec, emit)
MELTSIM_INSTANTIATE(core::CpuExec, let_go)
MELTSIM_INSTANTIATE(core::CpuExec, outlets)
MELTSIM_INSTANTIATE(core::CpuExec, inlets)
MELTSIM_INSTANTIATE(core::CpuExec, enter)
MELTSIM_INSTANTIATE(core::CpuExec, carry)
MELTSIM_INSTANTIATE(core::CpuExec, fields)
MELTSIM_INSTANTIATE(core::CpuExec, work)
MELTSIM_INSTANTIATE(core::CpuExec, integrate)
MELTSIM_INSTANTIATE_STEERING(core::CpuExec)
MELTSIM_INSTANTIATE_EDITS(core::CpuExec)
MELTSIM_INSTANTIATE(core::CpuExec, clear)
MELTSIM_INSTANTIATE(core::CpuExec, give_up)
MELTSIM_INSTANTIATE(core::CpuExec, restore)
MELTSIM_INSTANTIATE(core::CpuExec, reindex)
MELTSIM_INSTANTIATE(core::CpuExec, enthalpy_to_slots)
MELTSIM_INSTANTIATE(core::CpuExec, enthalpy_to_ids)

}  // namespace step
}  // namespace v0
}  // namespace meltsim
