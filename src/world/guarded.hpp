// SPDX-License-Identifier: Apache-2.0
// Nothing is thrown across the interface: host memory may run out anywhere, and that too is an Error.
#pragma once

#include <exception>
#include <new>
#include <stdexcept>
#include <string>

#include "meltsim/result.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// The exception being caught, as an Error. Call in a handler.
inline Error caught() noexcept {
  const auto error = [](ErrorCode code, const char* text) {
    Error e;
    e.code = code;
    try {
      e.message = text;
    } catch (...) {  // not even memory for that: the code says it
    }
    return e;
  };
  try {
    throw;
  } catch (const std::bad_alloc&) {
    return error(ErrorCode::out_of_memory, "memory: the host ran out of memory; use a larger spacing");
  } catch (const std::length_error&) {
    return error(ErrorCode::out_of_memory, "memory: more than a host can address; use a larger spacing");
  } catch (const std::exception& e) {
    return error(ErrorCode::internal, e.what());
  } catch (...) {
    return error(ErrorCode::internal, "internal: an exception of unknown type");
  }
}

/// function(), or what it threw as an Error.
template <class R, class Function>
R guarded(const Function& function) noexcept {
  try {
    return function();
  } catch (...) {
    return caught();
  }
}

/// The same where the result has a place for the message, beside what else it says.
template <class R, class Function>
R guarded_report(const Function& function) noexcept {
  try {
    return function();
  } catch (...) {
    R r{};
    r.error = std::move(caught().message);
    return r;
  }
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
