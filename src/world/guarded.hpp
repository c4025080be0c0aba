// SPDX-License-Identifier: Apache-2.0
// Nothing is thrown across the interface: host memory may run out anywhere, and that too is an Error. Nor does anything happen
// to a World that is in use.
#pragma once

#include <atomic>
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

/// Marks a World as in use by this thread: one thread at a time.
class Use {
 public:
  explicit Use(std::atomic<const void*>& user) : user_(user) {
    static thread_local char here;
    const void* nobody = nullptr;
    entered_ = user_.compare_exchange_strong(nobody, &here, std::memory_order_acquire);
    within_ = !entered_ && nobody == &here;
  }
  ~Use() {
    if (entered_) user_.store(nullptr, std::memory_order_release);
  }
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;
  bool entered() const { return entered_; }
  bool within() const { return within_; }  ///< a stage of the host calls the World that runs it

 private:
  std::atomic<const void*>& user_;
  bool entered_ = false, within_ = false;
};

/// Why a call that has not entered is refused.
inline Error not_entered(const Use& use) {
  return {ErrorCode::invalid_argument,
          use.within()
              ? "World: it runs the stage that calls it; call it between steps (in a stage: interrupt(), "
                "time(), gravity, "
                "heat of walls and surfaces)"
              : "World: another thread is in a call of it; let one thread at a time call it (any may call "
                "interrupt())"};
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
