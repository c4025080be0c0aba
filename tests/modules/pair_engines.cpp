// SPDX-License-Identifier: Apache-2.0
// The CPU's ways to add up over pairs: its own, by threads, and in any order, with and without forces and integration in
// one sweep.
#include "modules/pairs.hpp"

namespace modules_test {

std::string no_pair_engines() { return {}; }

std::vector<PairEngine> pair_engines() {
  const auto permuting = [](Order order, bool fuses) {
    return [order, fuses](Precision precision) -> std::shared_ptr<core::Engine> {
      if (precision == Precision::double_precision)
        return make_engine<double>(PermutingExec<double>(order, fuses));
      return make_engine<float>(PermutingExec<float>(order, fuses));
    };
  };
  const auto threads = [](Precision precision) -> std::shared_ptr<core::Engine> {
    WorldDesc desc;
    desc.precision = precision;
    desc.threads = 3;
    auto made = core::make_cpu_engine(desc);
    return made ? *made : nullptr;
  };
  return {{"three threads", threads, 3000, 2.5, 0},
          {"shuffled", permuting(Order::shuffled, false), 0, 2.5, 0},
          {"fused", permuting(Order::reversed, true), 0, 2.1, 66}};
}

}  // namespace modules_test
