// SPDX-License-Identifier: Apache-2.0
// The thermal stages for the CUDA executor.
#include "exec/exec_cuda.cuh"
#include "pipeline/stage_functions.hpp"
#include "thermal/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace thermal {

MELTSIM_INSTANTIATE(core::CudaExec, operands)
MELTSIM_INSTANTIATE(core::CudaExec, exchange)
MELTSIM_INSTANTIATE(core::CudaExec, paper)
MELTSIM_INSTANTIATE(core::CudaExec, boundary)
MELTSIM_INSTANTIATE(core::CudaExec, iwasaki)
MELTSIM_INSTANTIATE(core::CudaExec, level)

}  // namespace thermal
}  // namespace v0
}  // namespace meltsim
