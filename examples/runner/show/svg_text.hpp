// SPDX-License-Identifier: Apache-2.0
// Text within an SVG.
#pragma once

#include <string>

namespace runner {

/// The text with characters that XML would read as markup written as entities.
inline std::string svg_escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '<'   ? "&lt;"
           : c == '>' ? "&gt;"
           : c == '&' ? "&amp;"
           : c == '"' ? "&quot;"
                      : std::string(1, c);
  return out;
}

}  // namespace runner
