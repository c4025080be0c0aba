// SPDX-License-Identifier: Apache-2.0
#include "validation.hpp"

namespace validation {

const std::vector<Case>& all_cases() {
  static const std::vector<Case> cases = [] {
    std::vector<Case> all;
    const auto append = [&all](const std::vector<Case>& more) {
      all.insert(all.end(), more.begin(), more.end());
    };
#define VALIDATION_SUBJECT(subject) append(subject##_cases());
#include "subjects.inc"
#undef VALIDATION_SUBJECT
    return all;
  }();
  return cases;
}

}  // namespace validation
