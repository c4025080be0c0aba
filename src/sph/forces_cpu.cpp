// SPDX-License-Identifier: Apache-2.0
// Forces on liquid for the CPU executor: apart, as they take the longest to compile.
#include "exec/exec_cpu.hpp"
#include "pipeline/stage_functions.hpp"
#include "sph/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

MELTSIM_INSTANTIATE(core::CpuExec, forces)

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
