// SPDX-License-Identifier: Apache-2.0
// stats.csv as plots, by gnuplot.
#pragma once

#include <string>

namespace runner {

/// A gnuplot script that reads `stats` and writes `picture`, PNG or SVG.
/// `only_start`: stats.csv has a single row, of which no step was taken. `empty`: there is no particle in any row.
std::string plot_script(const std::string& stats, const std::string& picture, const std::string& title,
                        bool svg, bool only_start, bool empty);

}  // namespace runner
