// SPDX-License-Identifier: Apache-2.0
// The lsm stages for the CUDA executor.
#include "exec/exec_cuda.cuh"
#include "lsm/stages.hpp"
#include "pipeline/stage_functions.hpp"

namespace meltsim {
inline namespace v0 {
namespace lsm {

MELTSIM_INSTANTIATE(core::CudaExec, gather)
MELTSIM_INSTANTIATE(core::CudaExec, normals)
MELTSIM_INSTANTIATE(core::CudaExec, loads)
MELTSIM_INSTANTIATE(core::CudaExec, contact)
MELTSIM_INSTANTIATE(core::CudaExec, regions)
MELTSIM_INSTANTIATE(core::CudaExec, goals)
MELTSIM_INSTANTIATE(core::CudaExec, balance)
MELTSIM_INSTANTIATE(core::CudaExec, rigid_shape)
MELTSIM_INSTANTIATE(core::CudaExec, rigid)
MELTSIM_INSTANTIATE(core::CudaExec, commit)
MELTSIM_INSTANTIATE(core::CudaExec, rigid_commit)

}  // namespace lsm
}  // namespace v0
}  // namespace meltsim
