// SPDX-License-Identifier: Apache-2.0
#include "show/front_svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "show/svg_text.hpp"

namespace runner {

namespace {

constexpr double width = 640, height = 420, left = 80, right = 20, top = 44, bottom = 56;

/// Decades of one axis.
struct Axis {
  double low = 1e300, high = 0;  ///< of the values, then powers of ten around them
  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void close() {
    if (!(high > 0)) low = 0.1, high = 1;
    low = std::floor(std::log10(low) * 2) / 2;
    high = std::ceil(std::log10(high) * 2) / 2;
    if (high - low < 1) high = low + 1;
  }
  double part(double value) const { return (std::log10(value) - low) / (high - low); }
};

}  // namespace

std::string front_svg(const std::string& title, const std::string& cost, const std::string& error,
                      const std::vector<FrontSeries>& series) {
  Axis across, up;
  const auto shown = [](const FrontPoint& p) {
    return p.cost > 0 && p.error > 0 && std::isfinite(p.cost) && std::isfinite(p.error);
  };
  for (const FrontSeries& s : series)
    for (const FrontPoint& p : s.points)
      if (shown(p)) across.add(p.cost), up.add(p.error);
  across.close();
  up.close();
  const auto x = [&](double v) { return left + across.part(v) * (width - left - right); };
  const auto y = [&](double v) { return height - bottom - up.part(v) * (height - top - bottom); };
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "font-family=\"Helvetica,Arial,sans-serif\" font-size=\"12\" fill=\"#333\">\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n<text x=\"{2}\" y=\"24\" "
      "font-size=\"15\">{3}</text>\n",
      width, height, left, svg_escaped(title));
  const auto ticks = [&](const Axis& axis, bool horizontal) {
    for (double decade = std::floor(axis.low); decade <= axis.high; ++decade)
      for (const double digit : {1.0, 2.0, 5.0}) {
        const double value = digit * std::pow(10, decade), part = axis.part(value);
        if (part < -1e-9 || part > 1 + 1e-9) continue;
        if (horizontal)
          svg += fmt::format(
              "<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\" stroke=\"#e3e3e3\"/><text "
              "x=\"{0:.1f}\" "
              "y=\"{3}\" text-anchor=\"middle\">{4:g}</text>\n",
              x(value), top, height - bottom, height - bottom + 18, value);
        else
          svg += fmt::format(
              "<line x1=\"{1}\" x2=\"{2}\" y1=\"{0:.1f}\" y2=\"{0:.1f}\" stroke=\"#e3e3e3\"/><text x=\"{3}\" "
              "y=\"{4:.1f}\" text-anchor=\"end\">{5:g}</text>\n",
              y(value), left, width - right, left - 8, y(value) + 4, value);
      }
  };
  ticks(across, true);
  ticks(up, false);
  svg += fmt::format("<text x=\"{:.0f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                     (left + width - right) / 2, height - 14, svg_escaped(cost));
  svg +=
      fmt::format("<text transform=\"translate(18 {:.0f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                  (top + height - bottom) / 2, svg_escaped(error));
  double legend = top + 14;
  for (const FrontSeries& s : series) {
    std::string path;
    for (const FrontPoint& p : s.points) {
      if (!shown(p)) continue;
      path += fmt::format("{:.1f},{:.1f} ", x(p.cost), y(p.error));
      if (!s.line)
        svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\"/>\n", x(p.cost),
                           y(p.error), s.color);
    }
    if (s.line)
      svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>\n", path,
                         s.color);
    svg += fmt::format(
        "<rect x=\"{0}\" y=\"{1:.0f}\" width=\"10\" height=\"10\" fill=\"{2}\"/><text x=\"{3}\" "
        "y=\"{4:.0f}\">{5}</text>\n",
        width - right - 200, legend - 9, s.color, width - right - 184, legend, svg_escaped(s.title));
    legend += 18;
  }
  return svg + "</svg>\n";
}

}  // namespace runner
