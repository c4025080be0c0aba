// SPDX-License-Identifier: Apache-2.0
// Stands in for cuda/exec/backend_cuda.cu in a build without CUDA; CMake chooses one of the two.
#include "engine/engine.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

Result<std::shared_ptr<Engine>> make_cuda_engine(const WorldDesc&) {
  return Error{
      ErrorCode::no_device,
      "backend: this build of meltsim has no CUDA backend; configure with -DMELTSIM_CUDA=ON where nvcc is "
      "installed, or use the CPU backend"};
}

CudaInfo cuda_info() {
  CudaInfo info;
  info.reason = "this build has no CUDA backend";
  return info;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
