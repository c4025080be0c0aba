// SPDX-License-Identifier: Apache-2.0
// The surface for the CPU executor.
#include "exec/exec_cpu.hpp"
#include "pipeline/stage_functions.hpp"
#include "surface/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace surface {

template void build<core::CpuExec, float>(core::CpuExec&, const core::SurfaceFrame<float>&, int);
template void build<core::CpuExec, double>(core::CpuExec&, const core::SurfaceFrame<double>&, int);

}  // namespace surface
}  // namespace v0
}  // namespace meltsim
