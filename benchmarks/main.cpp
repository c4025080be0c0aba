// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "bench.hpp"

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  const meltsim::BuildInfo info = meltsim::build_info();
  benchmark::AddCustomContext("meltsim", info.version);
  benchmark::AddCustomContext("cpu_threads", std::to_string(info.cpu_threads));
  benchmark::AddCustomContext("cuda_device", info.devices.empty() ? info.cuda_reason : info.devices.front());
  bench::register_verbs_cpu();
  bench::register_verbs_cuda();
  bench::register_scenes();
  bench::register_searches();
  bench::register_widths();
  bench::register_probes();
  bench::register_own_stages();
  bench::register_paper();
  bench::register_threads();
  bench::register_surfaces();
  bench::register_profile();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
