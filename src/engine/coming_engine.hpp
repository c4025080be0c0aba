// SPDX-License-Identifier: Apache-2.0
// The engine of a World, which may still be on its way: a CUDA device takes a quarter of a second to begin, while a host adds liquid
// and bodies.
#pragma once

#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <system_error>
#include <utility>

#include "engine/engine.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

class ComingEngine {
 public:
  using Made = Result<std::shared_ptr<Engine>>;
  using Make = std::function<Made()>;

  /// An engine that is there.
  void set(std::shared_ptr<Engine> engine) { engine_ = std::move(engine); }

  /// Makes one in a thread of its own, at once where the system has none left. Where that fails, `instead` is the engine, and error() says
  /// why. Neither throws.
  void begin(Make make, Made instead) {
    instead_ = std::move(instead);
    try {
      coming_ = std::async(std::launch::async, make);
    } catch (const std::system_error&) {
      arrived(make());
    }
  }

  /// Waits. Why the engine is not the one that was begun; empty if it is.
  const std::string& error() const {
    wait();
    return error_.message;
  }
  /// Likewise.
  Status status() const { return error().empty() ? Status{} : Status{error_}; }

  Engine& operator*() const {
    wait();
    return *engine_;
  }
  Engine* operator->() const { return &**this; }

 private:
  void wait() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (coming_.valid()) arrived(coming_.get());
  }
  void arrived(Made made) const {
    if (!made) error_ = made.error();
    engine_ = made ? *made : *instead_;
  }

  mutable std::mutex mutex_;  ///< World::backend() may be called from any thread
  mutable std::future<Made> coming_;
  mutable std::shared_ptr<Engine> engine_;
  mutable Error error_;
  Made instead_ = Error{};
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
