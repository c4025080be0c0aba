// SPDX-License-Identifier: Apache-2.0
// Forces of liquid on solids, for the CPU executor: a unit of its own, as it takes long to compile.
#include "exec/exec_cpu.hpp"
#include "pipeline/stage_functions.hpp"
#include "sph/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

MELTSIM_INSTANTIATE(core::CpuExec, reaction)

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
