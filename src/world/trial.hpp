// SPDX-License-Identifier: Apache-2.0
// Values that are put back unless they are kept.
#pragma once

#include <tuple>
#include <utility>

namespace meltsim {
inline namespace v0 {

/// At its end these are what they were, unless keep() was called: also where something throws.
template <class... T>
class Trial {
 public:
  explicit Trial(T&... values) : values_(values...), were_(values...) {}
  ~Trial() {
    if (!kept_) values_ = std::move(were_);
  }
  Trial(const Trial&) = delete;
  Trial& operator=(const Trial&) = delete;
  void keep() { kept_ = true; }

 private:
  std::tuple<T&...> values_;
  std::tuple<T...> were_;
  bool kept_ = false;
};

}  // namespace v0
}  // namespace meltsim
