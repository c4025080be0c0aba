// SPDX-License-Identifier: Apache-2.0
// Errors are values. A message names the field, the value it had, and the fix.
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace meltsim {
inline namespace v0 {
/// What kind of error a call returns.
enum class ErrorCode {
  invalid_argument,  ///< a description that cannot be simulated; the message names the field
  version_mismatch,  ///< the host was compiled against other headers than the library
  no_device,         ///< the backend asked for is not built in or has no usable device
  out_of_memory,     ///< the message names the bytes needed and free
  capacity,          ///< a fixed capacity would be exceeded; the message names the setting to raise
  step_too_large,    ///< more sub-steps than allowed; the message names the step that fits
  halted,            ///< the simulation diverged earlier; the World keeps its last good state
  corrupt_data,      ///< a snapshot whose checksum or structure is wrong
  interrupted,       ///< World::interrupt() ended a step; the sub-steps completed before it count
  internal           ///< a fault of the library or of the device
};
/// An error as a value.
struct Error {
  ErrorCode code = ErrorCode::internal;  ///< for programs
  std::string message;                   ///< for people: field, value, fix
};

/// A value or an Error. Dereferencing a Result that holds an Error is undefined: test it first.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}                       ///< holds a value
  Result(Error error) : state_(std::move(error)) {}                   ///< holds an error
  explicit operator bool() const { return state_.index() == 0; }      ///< whether it holds a value
  bool ok() const { return state_.index() == 0; }                     ///< whether it holds a value
  T& operator*() & { return *std::get_if<0>(&state_); }               ///< the value
  const T& operator*() const& { return *std::get_if<0>(&state_); }    ///< the value
  T&& operator*() && { return std::move(*std::get_if<0>(&state_)); }  ///< the value, moved out
  T* operator->() { return std::get_if<0>(&state_); }              ///< the value; null if it holds an error
  const T* operator->() const { return std::get_if<0>(&state_); }  ///< the value; null if it holds an error
  const Error& error() const { return *std::get_if<1>(&state_); }  ///< the error; undefined for a value

 private:
  std::variant<T, Error> state_;
};

#ifdef Status
#error "Status is a macro: Xlib.h defines it. Include meltsim before Xlib.h, or #undef Status between them"
#endif
/// Success or an Error.
class [[nodiscard]] Status {
 public:
  Status() = default;                                            ///< success
  Status(Error error) : error_(std::move(error)), ok_(false) {}  ///< an error
  explicit operator bool() const { return ok_; }                 ///< whether it is success
  bool ok() const { return ok_; }                                ///< whether it is success
  const Error& error() const { return error_; }                  ///< the error; without meaning on success

 private:
  Error error_;
  bool ok_ = true;
};

}  // namespace v0
}  // namespace meltsim
