// SPDX-License-Identifier: Apache-2.0
// The stage of species for the CUDA executor.
#include "exec/exec_cuda.cuh"
#include "pipeline/stage_functions.hpp"
#include "species/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace species {

MELTSIM_INSTANTIATE(core::CudaExec, exchange)

}  // namespace species
}  // namespace v0
}  // namespace meltsim
