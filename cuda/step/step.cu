// SPDX-License-Identifier: Apache-2.0
// The step stages for the CUDA executor.
#include "exec/exec_cuda_bucket.cuh"
#include "exec/exec_cuda_scan.cuh"
#include "pipeline/stage_functions.hpp"
#include "step/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace step {

MELTSIM_INSTANTIATE(core::CudaExec, begin)
MELTSIM_INSTANTIATE(core::CudaExec, begin_cells)
MELTSIM_INSTANTIATE(core::CudaExec, emit)
MELTSIM_INSTANTIATE(core::CudaExec, let_go)
MELTSIM_INSTANTIATE(core::CudaExec, outlets)
MELTSIM_INSTANTIATE(core::CudaExec, inlets)
MELTSIM_INSTANTIATE(core::CudaExec, enter)
MELTSIM_INSTANTIATE(core::CudaExec, carry)
MELTSIM_INSTANTIATE(core::CudaExec, fields)
MELTSIM_INSTANTIATE(core::CudaExec, work)
MELTSIM_INSTANTIATE(core::CudaExec, integrate)
MELTSIM_INSTANTIATE_STEERING(core::CudaExec)
MELTSIM_INSTANTIATE_EDITS(core::CudaExec)
MELTSIM_INSTANTIATE(core::CudaExec, clear)
MELTSIM_INSTANTIATE(core::CudaExec, give_up)
MELTSIM_INSTANTIATE(core::CudaExec, restore)
MELTSIM_INSTANTIATE(core::CudaExec, reindex)
MELTSIM_INSTANTIATE(core::CudaExec, enthalpy_to_slots)
MELTSIM_INSTANTIATE(core::CudaExec, enthalpy_to_ids)

}  // namespace step
}  // namespace v0
}  // namespace meltsim
