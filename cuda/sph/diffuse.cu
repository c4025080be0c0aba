// SPDX-License-Identifier: Apache-2.0
// Implicit viscosity for the CUDA executor: apart, as it takes long to compile.
#include "exec/exec_cuda.cuh"
#include "pipeline/stage_functions.hpp"
#include "sph/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

MELTSIM_INSTANTIATE(core::CudaExec, diffuse)

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
