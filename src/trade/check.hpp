// SPDX-License-Identifier: Apache-2.0
// What a host may get wrong in a problem, said before a probe is run.
#pragma once

#include <string>
#include <vector>

#include "meltsim/trade.hpp"

namespace meltsim {
inline namespace v0 {
namespace trade {

/// Errors: invalid_argument (names the field, the value and what is expected).
Status check(const Problem& problem);
Status check_names(const std::vector<Observable>& observables);
Status check(const Options& options);
Status check(const Knobs& knobs);
/// Whether the exact answers have as many values as are compared. Errors: invalid_argument.
Status check_exact(const Problem& problem, const Measurement& probe);

/// Whether any of them is a number.
bool has_value(const std::vector<double>& values);

}  // namespace trade
}  // namespace v0
}  // namespace meltsim
