// SPDX-License-Identifier: Apache-2.0
// Values of command-line options: text to type, with errors that name the option and what it takes.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "options.hpp"

namespace runner {

double option_positive(const std::string& option, const std::string& value);
double option_not_negative(const std::string& option, const std::string& value);
double option_share(const std::string& option, const std::string& value);  ///< "0.03" or "3%"
double option_milliseconds(const std::string& option,
                           const std::string& value);  ///< "16ms", "0.016s" or "16"
std::uint64_t option_count(const std::string& option, const std::string& value);
std::string option_choice(const std::string& option, const std::string& value,
                          const std::vector<std::string>& names);
/// Names with commas between them, without the blanks around them.
std::vector<std::string> option_list(const std::string& option, const std::string& value);
std::vector<std::string> option_formats(const std::string& value);

/// `'a b'` where a shell would take it apart.
/// A whole number from `least` to `most`.
int option_between(const std::string& option, const std::string& value, int least, int most);
/// "960x540"
std::pair<int, int> option_size(const std::string& option, const std::string& value);
std::string shell_quoted(const std::string& word);

}  // namespace runner
