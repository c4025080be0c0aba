// SPDX-License-Identifier: Apache-2.0
// Tests that need a GPU start with MELTSIM_NEEDS_GPU(): without one they are skipped, and with the
// environment variable MELTSIM_REQUIRE_GPU=1 they fail instead, so that a machine with a GPU never passes by
// skipping.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "meltsim/world.hpp"

namespace meltsim_test {

/// Empty when CUDA is usable.
inline std::string why_no_gpu() {
  const meltsim::BuildInfo info = meltsim::build_info();
  if (!info.devices.empty()) return {};
  return info.cuda_reason.empty() ? "no usable CUDA device" : info.cuda_reason;
}

inline bool gpu_required() {
  const char* value = std::getenv("MELTSIM_REQUIRE_GPU");
  return value != nullptr && std::string(value) == "1";
}

}  // namespace meltsim_test

/// At the start of a test body or of SetUp().
#define MELTSIM_NEEDS_GPU()                                                      \
  do {                                                                           \
    const std::string no_gpu = meltsim_test::why_no_gpu();                       \
    if (!no_gpu.empty() && meltsim_test::gpu_required())                         \
      FAIL() << "MELTSIM_REQUIRE_GPU=1, but there is no usable GPU: " << no_gpu; \
    if (!no_gpu.empty()) GTEST_SKIP() << no_gpu;                                 \
  } while (false)
