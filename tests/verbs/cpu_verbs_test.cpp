// SPDX-License-Identifier: Apache-2.0
#include "exec/exec_cpu.hpp"
#include "verbs/verbs_test.hpp"

namespace verbs_test {

template <>
struct Maker<meltsim::core::CpuExec> {
  static std::string missing() { return {}; }
  static bool required() { return true; }
  static meltsim::core::CpuExec make() { return meltsim::core::CpuExec(3); }
};

INSTANTIATE_TYPED_TEST_SUITE_P(Cpu, Verbs, meltsim::core::CpuExec);

// The promise of exec_cpu.hpp: the number of threads changes no bit.
TEST(CpuVerbs, ReduceDoesNotDependOnThreads) {
  std::vector<std::uint32_t> values(1000003);
  std::mt19937 engine(1);
  for (std::uint32_t& v : values) v = engine() % 1000000u;
  RealSum one;
  meltsim::core::CpuExec(1).reduce(values.size(), InverseOf{values.data()}, &one);
  for (const int threads : {2, 3, 8}) {
    RealSum many;
    meltsim::core::CpuExec(threads).reduce(values.size(), InverseOf{values.data()}, &many);
    EXPECT_EQ(many.x, one.x) << threads << " threads";
  }
}

}  // namespace verbs_test
