// SPDX-License-Identifier: Apache-2.0
// Readings for the CUDA executor.
#include "exec/exec_cuda.cuh"
#include "exec/exec_cuda_scan.cuh"
#include "pipeline/stage_functions.hpp"
#include "reading/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace reading {

MELTSIM_INSTANTIATE_READING(core::CudaExec)

}  // namespace reading
}  // namespace v0
}  // namespace meltsim
