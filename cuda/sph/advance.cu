// SPDX-License-Identifier: Apache-2.0
// Forces and the end of the sub-step in one sweep, for the CUDA executor.
#include "exec/exec_cuda.cuh"
#include "pipeline/stage_functions.hpp"
#include "sph/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

MELTSIM_INSTANTIATE(core::CudaExec, advance)

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
