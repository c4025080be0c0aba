// SPDX-License-Identifier: Apache-2.0
// The spatial stages for the CUDA executor.
#include "exec/exec_cuda_bucket.cuh"
#include "exec/exec_cuda_scan.cuh"
#include "pipeline/stage_functions.hpp"
#include "spatial/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

MELTSIM_INSTANTIATE(core::CudaExec, cells)
MELTSIM_INSTANTIATE(core::CudaExec, settle)
MELTSIM_INSTANTIATE(core::CudaExec, keys)
MELTSIM_INSTANTIATE(core::CudaExec, sort)
MELTSIM_INSTANTIATE(core::CudaExec, reorder)
MELTSIM_INSTANTIATE(core::CudaExec, groups)
MELTSIM_INSTANTIATE(core::CudaExec, ranges)
MELTSIM_INSTANTIATE(core::CudaExec, codes)
MELTSIM_INSTANTIATE(core::CudaExec, leaves)
MELTSIM_INSTANTIATE(core::CudaExec, boxes)
MELTSIM_INSTANTIATE(core::CudaExec, walk)
MELTSIM_INSTANTIATE(core::CudaExec, neighbours)

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
