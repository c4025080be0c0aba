// SPDX-License-Identifier: Apache-2.0
// The other sph stages for the CPU executor.
#include "exec/exec_cpu.hpp"
#include "pipeline/stage_functions.hpp"
#include "sph/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

MELTSIM_INSTANTIATE(core::CpuExec, density)
MELTSIM_INSTANTIATE(core::CpuExec, viscosity)
MELTSIM_INSTANTIATE(core::CpuExec, strain)
MELTSIM_INSTANTIATE(core::CpuExec, cover)
MELTSIM_INSTANTIATE(core::CpuExec, wetted)
MELTSIM_INSTANTIATE(core::CpuExec, unstrained)
MELTSIM_INSTANTIATE(core::CpuExec, seep)
MELTSIM_INSTANTIATE(core::CpuExec, gaps)
MELTSIM_INSTANTIATE(core::CpuExec, tension)
MELTSIM_INSTANTIATE(core::CpuExec, cohere)
MELTSIM_INSTANTIATE(core::CpuExec, arrangement)
MELTSIM_INSTANTIATE(core::CpuExec, shift)

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
