// SPDX-License-Identifier: Apache-2.0
#include "show/map_svg.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "show/svg_text.hpp"

namespace runner {

namespace {

constexpr double left = 190, top = 66, row_height = 34, cell_width = 64, gap = 4, margin = 16;

}  // namespace

std::string map_svg(const std::string& title, const std::vector<std::string>& columns,
                    const std::vector<MapKind>& kinds, const std::vector<MapRow>& rows) {
  std::size_t most = 1;
  for (const MapRow& row : rows) most = std::max(most, row.cells.size());
  const double width = std::max(720.0, left + static_cast<double>(most) * cell_width + margin);
  const double height = top + static_cast<double>(rows.size()) * row_height + margin;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" "
      "font-family=\"Helvetica,Arial,sans-serif\" font-size=\"11\" fill=\"#333\">\n"
      "<rect width=\"{0:.0f}\" height=\"{1:.0f}\" fill=\"#fff\"/>\n<text x=\"{2}\" y=\"24\" "
      "font-size=\"15\">{3}</text>\n",
      width, height, margin, svg_escaped(title));
  double x = margin;
  for (const MapKind& kind : kinds) {
    svg += fmt::format(
        "<rect x=\"{0:.0f}\" y=\"36\" width=\"12\" height=\"12\" fill=\"{1}\"/><text x=\"{2:.0f}\" "
        "y=\"46\">{3}</text>\n",
        x, kind.color, x + 17, svg_escaped(kind.name));
    x += 34 + 6.2 * static_cast<double>(kind.name.size());
  }
  std::string order;
  for (const std::string& column : columns) order += (order.empty() ? "fields of a cell: " : " | ") + column;
  svg += fmt::format("<text x=\"{:.0f}\" y=\"46\" fill=\"#777\">{}</text>\n", x + 10, svg_escaped(order));
  double y = top;
  for (const MapRow& row : rows) {
    svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" text-anchor=\"end\">{}</text>\n", left - 10, y + 25,
                       svg_escaped(row.label));
    x = left;
    for (const MapCell& cell : row.cells) {
      const double part = (cell_width - gap) / static_cast<double>(std::max<std::size_t>(1, columns.size()));
      svg += fmt::format(
          "<text x=\"{:.1f}\" y=\"{:.0f}\" text-anchor=\"middle\" font-size=\"{}\">{}</text>\n",
          x + (cell_width - gap) / 2, y + 11, cell.label.size() > 9 ? 8 : 10, svg_escaped(cell.label));
      for (std::size_t k = 0; k < cell.kinds.size(); ++k) {
        const bool known = cell.kinds[k] >= 0 && static_cast<std::size_t>(cell.kinds[k]) < kinds.size();
        svg += fmt::format(
            "<rect x=\"{:.1f}\" y=\"{:.0f}\" width=\"{:.1f}\" height=\"14\" "
            "fill=\"{}\"><title>{}</title></rect>\n",
            x + part * static_cast<double>(k), y + 15, part - 1,
            known ? kinds[static_cast<std::size_t>(cell.kinds[k])].color : "#eee",
            k < cell.titles.size() ? svg_escaped(cell.titles[k]) : "");
      }
      x += cell_width;
    }
    y += row_height;
  }
  return svg + "</svg>\n";
}

}  // namespace runner
