// SPDX-License-Identifier: Apache-2.0
#include "exec/exec_cpu.hpp"
#include "verb_bench.hpp"

namespace bench {

void register_verbs_cpu() {
  register_verbs("cpu", {60500, 1000000}, [] { return meltsim::core::CpuExec(); });
}

}  // namespace bench
