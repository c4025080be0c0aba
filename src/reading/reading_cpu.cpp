// SPDX-License-Identifier: Apache-2.0
// Readings for the CPU executor.
#include "exec/exec_cpu.hpp"
#include "pipeline/stage_functions.hpp"
#include "reading/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace reading {

MELTSIM_INSTANTIATE_READING(core::CpuExec)

}  // namespace reading
}  // namespace v0
}  // namespace meltsim
