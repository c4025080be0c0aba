// SPDX-License-Identifier: Apache-2.0
// The surface for the CUDA executor.
#include "exec/exec_cuda.cuh"
#include "exec/exec_cuda_scan.cuh"
#include "pipeline/stage_functions.hpp"
#include "surface/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace surface {

template void build<core::CudaExec, float>(core::CudaExec&, const core::SurfaceFrame<float>&, int);
template void build<core::CudaExec, double>(core::CudaExec&, const core::SurfaceFrame<double>&, int);

}  // namespace surface
}  // namespace v0
}  // namespace meltsim
