// SPDX-License-Identifier: Apache-2.0
// The topology stages for the CUDA executor.
#include "exec/exec_cuda.cuh"
#include "pipeline/stage_functions.hpp"
#include "topology/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace topology {

MELTSIM_INSTANTIATE(core::CudaExec, freeze)
MELTSIM_INSTANTIATE(core::CudaExec, melt)
MELTSIM_INSTANTIATE(core::CudaExec, neighbours)
MELTSIM_INSTANTIATE(core::CudaExec, regions)
MELTSIM_INSTANTIATE(core::CudaExec, pieces)
MELTSIM_INSTANTIATE(core::CudaExec, build)
MELTSIM_INSTANTIATE_BUILD_BODY(core::CudaExec)

}  // namespace topology
}  // namespace v0
}  // namespace meltsim
