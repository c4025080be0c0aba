// SPDX-License-Identifier: Apache-2.0
// Unwraps a Result of a call that fails only when memory runs out or the device is at fault.
#pragma once

#include <utility>

#include "library_error.hpp"

namespace runner {

template <class T>
T expect(meltsim::Result<T> result) {
  if (!result) throw library_failure(result.error(), {}, "", "the library");
  return std::move(*result);
}

inline void expect(const meltsim::Status& status) {
  if (!status) throw library_failure(status.error(), {}, "", "the library");
}

}  // namespace runner
