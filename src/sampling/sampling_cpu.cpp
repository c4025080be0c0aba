// SPDX-License-Identifier: Apache-2.0
// The sampling stage for the CPU executor.
#include "exec/exec_cpu.hpp"
#include "pipeline/stage_functions.hpp"
#include "sampling/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace sampling {

MELTSIM_INSTANTIATE(core::CpuExec, probes)
MELTSIM_INSTANTIATE(core::CpuExec, loads)
MELTSIM_INSTANTIATE(core::CpuExec, forces)
MELTSIM_INSTANTIATE(core::CpuExec, forces_commit)
MELTSIM_INSTANTIATE(core::CpuExec, touches)
MELTSIM_INSTANTIATE(core::CpuExec, events)
template void at_once<core::CpuExec, float>(core::CpuExec&, const core::Frame<float>&,
                                            const core::SampleRoom&);
template void at_once<core::CpuExec, double>(core::CpuExec&, const core::Frame<double>&,
                                             const core::SampleRoom&);
template void follow_rays<core::CpuExec, float>(core::CpuExec&, const core::Frame<float>&,
                                                const core::SampleRoom&, const core::RayRoom&);
template void follow_rays<core::CpuExec, double>(core::CpuExec&, const core::Frame<double>&,
                                                 const core::SampleRoom&, const core::RayRoom&);

}  // namespace sampling
}  // namespace v0
}  // namespace meltsim
