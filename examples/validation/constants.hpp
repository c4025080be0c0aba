// SPDX-License-Identifier: Apache-2.0
// What references and draws have in common.
#pragma once

namespace validation {

inline constexpr double pi = 3.14159265358979323846;

}  // namespace validation
