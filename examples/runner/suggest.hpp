// SPDX-License-Identifier: Apache-2.0
// "Did you mean": the nearest known name, when it is near enough to be a typo.
#pragma once

#include <string>
#include <vector>

namespace runner {

/// Insertions, deletions, substitutions and swaps of neighbours that turn `a` into `b`.
std::size_t edit_distance(const std::string& a, const std::string& b);

/// The nearest of `names`, or empty when none is near.
std::string nearest(const std::string& word, const std::vector<std::string>& names);

/// `; did you mean "x"?`, or `; known <what>: a, b, c` when nothing is near.
std::string suggestion(const std::string& word, const std::vector<std::string>& names,
                       const std::string& what);

/// "a, b or c"
std::string either_of(const std::vector<std::string>& names);

}  // namespace runner
