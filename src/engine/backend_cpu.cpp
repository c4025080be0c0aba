// SPDX-License-Identifier: Apache-2.0
#include "engine/engine_impl.hpp"
#include "exec/exec_cpu.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

Result<std::shared_ptr<Engine>> make_cpu_engine(const WorldDesc& desc) {
  CpuExec exec(desc.threads);
  const std::string device = "CPU, " + std::to_string(exec.threads()) + " threads";
  if (desc.precision == Precision::double_precision)
    return std::shared_ptr<Engine>(std::make_shared<EngineImpl<CpuExec, double>>(exec, device));
  return std::shared_ptr<Engine>(std::make_shared<EngineImpl<CpuExec, float>>(exec, device));
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
