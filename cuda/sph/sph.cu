// SPDX-License-Identifier: Apache-2.0
// The sph stages for the CUDA executor.
#include "exec/exec_cuda.cuh"
#include "pipeline/stage_functions.hpp"
#include "sph/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

MELTSIM_INSTANTIATE(core::CudaExec, density)
MELTSIM_INSTANTIATE(core::CudaExec, viscosity)
MELTSIM_INSTANTIATE(core::CudaExec, strain)
MELTSIM_INSTANTIATE(core::CudaExec, forces)
MELTSIM_INSTANTIATE(core::CudaExec, cover)
MELTSIM_INSTANTIATE(core::CudaExec, wetted)
MELTSIM_INSTANTIATE(core::CudaExec, unstrained)
MELTSIM_INSTANTIATE(core::CudaExec, seep)
MELTSIM_INSTANTIATE(core::CudaExec, gaps)
MELTSIM_INSTANTIATE(core::CudaExec, reaction)
MELTSIM_INSTANTIATE(core::CudaExec, tension)
MELTSIM_INSTANTIATE(core::CudaExec, cohere)
MELTSIM_INSTANTIATE(core::CudaExec, arrangement)
MELTSIM_INSTANTIATE(core::CudaExec, shift)

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
