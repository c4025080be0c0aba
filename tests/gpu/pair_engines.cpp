// SPDX-License-Identifier: Apache-2.0
// A GPU's ways to add up over pairs: several warps for 32 particles, a thread each, a thread for two; what is few from a list
// in all of them, forces and integration in one sweep where liquid is alone.
#include "exec/gather.hpp"
#include "modules/pairs.hpp"
#include "support/require_gpu.hpp"

namespace modules_test {

std::string no_pair_engines() {
  const std::string none = meltsim_test::why_no_gpu();
  if (!none.empty() && meltsim_test::gpu_required()) ADD_FAILURE() << "MELTSIM_REQUIRE_GPU=1, but " << none;
  return none;
}

std::vector<PairEngine> pair_engines() {
  const auto cuda = [](Precision precision) -> std::shared_ptr<core::Engine> {
    WorldDesc desc;
    desc.backend = Backend::cuda;
    desc.precision = precision;
    auto made = core::make_cuda_engine(desc);
    return made ? *made : nullptr;
  };
  // Two to a thread pays at short supports, in lines of 64 cells and more.
  return {{"three warps", cuda, 0, 2.5, 0},
          {"a thread each", cuda, core::gather_few, 2.5, 0},
          {"a thread for two", cuda, core::gather_few, 2.1, 66}};
}

}  // namespace modules_test
