// SPDX-License-Identifier: Apache-2.0
#include <cuda_profiler_api.h>

#include "exec/exec_cuda_scan.cuh"
#include "verb_bench.hpp"

namespace bench {

namespace {
meltsim::core::CudaExec make_exec() { return meltsim::core::CudaExec(0, nullptr); }
}  // namespace

void register_verbs_cuda() {
  if (backends().back() == Backend::cuda) register_verbs("cuda", {60500, 1000000, 10000000}, make_exec);
}

void profile(bool on) { (void)(on ? cudaProfilerStart() : cudaProfilerStop()); }

}  // namespace bench
