// SPDX-License-Identifier: Apache-2.0
// A map as SVG: rows of labelled cells, each with one coloured field per column.
#pragma once

#include <string>
#include <vector>

namespace runner {

struct MapCell {
  std::string label;
  std::vector<int> kinds;           ///< per column: index of a MapKind; -1: empty
  std::vector<std::string> titles;  ///< per column: said where the mouse is
};

struct MapRow {
  std::string label;
  std::vector<MapCell> cells;
};

struct MapKind {
  std::string name, color;  ///< "#2e9e4f"
};

/// `columns`: what the fields of a cell are, from left to right.
std::string map_svg(const std::string& title, const std::vector<std::string>& columns,
                    const std::vector<MapKind>& kinds, const std::vector<MapRow>& rows);

}  // namespace runner
