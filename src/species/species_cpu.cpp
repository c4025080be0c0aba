// SPDX-License-Identifier: Apache-2.0
// The stage of species for the CPU executor.
#include "exec/exec_cpu.hpp"
#include "pipeline/stage_functions.hpp"
#include "species/stages.hpp"

namespace meltsim {
inline namespace v0 {
namespace species {

MELTSIM_INSTANTIATE(core::CpuExec, exchange)

}  // namespace species
}  // namespace v0
}  // namespace meltsim
