// SPDX-License-Identifier: Apache-2.0
// The sampling stage for the CUDA executor.
#include "exec/exec_cuda.cuh"
#include "exec/exec_cuda_scan.cuh"
#include "pipeline/stage_functions.hpp"
#include "sampling/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace sampling {

MELTSIM_INSTANTIATE(core::CudaExec, probes)
MELTSIM_INSTANTIATE(core::CudaExec, loads)
MELTSIM_INSTANTIATE(core::CudaExec, forces)
MELTSIM_INSTANTIATE(core::CudaExec, forces_commit)
MELTSIM_INSTANTIATE(core::CudaExec, touches)
MELTSIM_INSTANTIATE(core::CudaExec, events)
template void at_once<core::CudaExec, float>(core::CudaExec&, const core::Frame<float>&,
                                             const core::SampleRoom&);
template void at_once<core::CudaExec, double>(core::CudaExec&, const core::Frame<double>&,
                                              const core::SampleRoom&);
template void follow_rays<core::CudaExec, float>(core::CudaExec&, const core::Frame<float>&,
                                                 const core::SampleRoom&, const core::RayRoom&);
template void follow_rays<core::CudaExec, double>(core::CudaExec&, const core::Frame<double>&,
                                                  const core::SampleRoom&, const core::RayRoom&);

}  // namespace sampling
}  // namespace v0
}  // namespace meltsim
