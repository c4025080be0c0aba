// SPDX-License-Identifier: Apache-2.0
// Errors are values. A message names the field, the value it had, and the fix.
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace meltsim {
inline namespace v0 {

enum class ErrorCode {
  invalid_argument,  ///< a description that cannot be simulated; the message names the field
  version_mismatch,  ///< header and library differ
  no_device,         ///< the backend asked for is not built in or has no usable device
  out_of_memory,     ///< the message names the bytes needed and free
  capacity,          ///< a fixed capacity would be exceeded; the message names the setting to raise
  step_too_large,    ///< more sub-steps than allowed; the message names the step that fits
  halted,            ///< the simulation diverged earlier and keeps its last good state
  corrupt_data,      ///< a snapshot that does not verify
  interrupted,       ///< World::interrupt() ended a step between two sub-steps; what came before them counts
  internal           ///< a fault of the library or of the device
};

struct Error {
  ErrorCode code = ErrorCode::internal;
  std::string message;
};

/// A value or an Error. Dereferencing a Result that holds an Error is undefined: test it first.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}
  Result(Error error) : state_(std::move(error)) {}
  explicit operator bool() const { return state_.index() == 0; }
  bool ok() const { return state_.index() == 0; }
  T& operator*() & { return *std::get_if<0>(&state_); }
  const T& operator*() const& { return *std::get_if<0>(&state_); }
  T&& operator*() && { return std::move(*std::get_if<0>(&state_)); }
  T* operator->() { return std::get_if<0>(&state_); }
  const T* operator->() const { return std::get_if<0>(&state_); }
  const Error& error() const { return *std::get_if<1>(&state_); }

 private:
  std::variant<T, Error> state_;
};

/// Success or an Error.
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(Error error) : error_(std::move(error)), ok_(false) {}
  explicit operator bool() const { return ok_; }
  bool ok() const { return ok_; }
  const Error& error() const { return error_; }

 private:
  Error error_;
  bool ok_ = true;
};

}  // namespace v0
}  // namespace meltsim
