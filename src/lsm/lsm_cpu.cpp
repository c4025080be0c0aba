// SPDX-License-Identifier: Apache-2.0
// The lsm stages for the CPU executor.
#include "exec/exec_cpu.hpp"
#include "lsm/stages.hpp"
#include "pipeline/stage_functions.hpp"

namespace meltsim {
inline namespace v0 {
namespace lsm {

MELTSIM_INSTANTIATE(core::CpuExec, gather)
MELTSIM_INSTANTIATE(core::CpuExec, normals)
MELTSIM_INSTANTIATE(core::CpuExec, loads)
MELTSIM_INSTANTIATE(core::CpuExec, contact)
MELTSIM_INSTANTIATE(core::CpuExec, regions)
MELTSIM_INSTANTIATE(core::CpuExec, goals)
MELTSIM_INSTANTIATE(core::CpuExec, balance)
MELTSIM_INSTANTIATE(core::CpuExec, rigid_shape)
MELTSIM_INSTANTIATE(core::CpuExec, rigid)
MELTSIM_INSTANTIATE(core::CpuExec, commit)
MELTSIM_INSTANTIATE(core::CpuExec, rigid_commit)

}  // namespace lsm
}  // namespace v0
}  // namespace meltsim
