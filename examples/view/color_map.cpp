// SPDX-License-Identifier: Apache-2.0
#include "color_map.hpp"

#include <algorithm>
#include <cmath>

#include "meltsim/particle_tag.hpp"
#include "show/ramp.hpp"

namespace view {

namespace {

struct Stop {
  double at, r, g, b;
};

constexpr Stop speed_stops[] = {
    {0.00, 0.12, 0.20, 0.44}, {0.30, 0.13, 0.47, 0.67}, {0.65, 0.45, 0.80, 0.72}, {1.00, 1.00, 0.98, 0.82}};

std::uint8_t byte(double share) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

template <std::size_t N>
Rgb between(const Stop (&stops)[N], double x) {
  std::size_t k = 0;
  while (k + 2 < N && x > stops[k + 1].at) ++k;
  const Stop &a = stops[k], &b = stops[k + 1];
  const double t = std::clamp((x - a.at) / (b.at - a.at), 0.0, 1.0);
  return {byte(a.r + t * (b.r - a.r)), byte(a.g + t * (b.g - a.g)), byte(a.b + t * (b.b - a.b))};
}

/// Hues a golden angle apart: neighbours in the list are far apart in colour.
Rgb hue(int k) {
  const double at = std::fmod(0.08 + 0.61803398875 * k, 1.0) * 6;
  const auto channel = [at](double shift) {
    const double x = std::fmod(at + shift, 6.0);
    const double ramp = std::clamp(std::min(x, 4 - x), 0.0, 1.0);
    return byte(0.92 * (1 - 0.62 * (1 - ramp)));
  };
  return {channel(2), channel(0), channel(4)};
}

ColorTable make_table() {
  ColorTable table{};
  for (int i = 0; i < table_width; ++i) {
    const double x = i / (table_width - 1.0);
    const auto k = static_cast<std::size_t>(i);
    const runner::Rgb warmth = runner::ramp(x);
    table[0][k] = {byte(warmth[0]), byte(warmth[1]), byte(warmth[2])};
    table[1][k] = Rgb{58, 132, 205};
    table[2][k] = hue(i);
    table[3][k] = between(speed_stops, x);
    table[4][k] = i < solid_materials ? Rgb{58, 132, 205} : Rgb{226, 234, 240};
  }
  table[1][static_cast<std::size_t>(Phase::solid)] = Rgb{226, 234, 240};
  table[1][static_cast<std::size_t>(Phase::melted)] = Rgb{120, 205, 190};
  table[2][0] = Rgb{58, 132, 205};
  return table;
}

}  // namespace

const std::vector<std::string>& color_names() {
  static const std::vector<std::string> names{"temperature", "phase", "body", "speed", "material"};
  return names;
}

const ColorTable& color_table() {
  static const ColorTable table = make_table();
  return table;
}

ColorTable color_table(const Colors& bodies, const Colors& materials) {
  ColorTable table = color_table();
  const auto bytes = [](const std::array<double, 3>& c) { return Rgb{byte(c[0]), byte(c[1]), byte(c[2])}; };
  for (std::size_t i = 0; i < bodies.size() && i + 1 < table[2].size(); ++i)
    if (bodies[i]) table[2][i + 1] = bytes(*bodies[i]);
  for (std::size_t i = 0; i < materials.size() && i < solid_materials; ++i)
    if (materials[i]) table[4][i] = table[4][i + solid_materials] = bytes(*materials[i]);
  return table;
}

int ramp_index(double value, const Range& range) {
  const double width = range.high - range.low;
  const double x = width > 0 ? (value - range.low) / width : 0.5;
  return static_cast<int>(std::lround(std::clamp(x, 0.0, 1.0) * (table_width - 1)));
}

Phase phase_of(std::uint32_t tag) {
  if (meltsim::is_solid(tag)) return Phase::solid;
  return meltsim::body_of(tag) != 0 ? Phase::melted : Phase::liquid;
}

int body_index(std::uint32_t body) {
  return body == 0 ? 0 : 1 + static_cast<int>((body - 1) % (table_width - 1));
}

int material_index(std::uint32_t tag) {
  const int material = static_cast<int>(meltsim::material_of(tag)) % solid_materials;
  return material + (meltsim::is_solid(tag) ? solid_materials : 0);
}

Rgb color_of(ColorBy by, double temperature, double speed, std::uint32_t tag, const Range& range) {
  int at = 0;
  if (by == ColorBy::temperature) at = ramp_index(temperature, range);
  if (by == ColorBy::phase) at = static_cast<int>(phase_of(tag));
  if (by == ColorBy::body) at = body_index(meltsim::body_of(tag));
  if (by == ColorBy::speed) at = ramp_index(speed, range);
  if (by == ColorBy::material) at = material_index(tag);
  return color_table()[static_cast<std::size_t>(by)][static_cast<std::size_t>(at)];
}

std::vector<double> ticks(const Range& range, int most) {
  const double width = range.high - range.low;
  if (!(width > 0) || !std::isfinite(width)) return {range.low};
  double step = std::pow(10, std::floor(std::log10(width / most)));
  for (const double factor : {2.0, 2.5, 2.0}) {
    if (width / step < most) break;
    step *= factor;
  }
  std::vector<double> at;
  const double slack = 1e-9 * width;
  for (double k = std::ceil((range.low - slack) / step); k * step <= range.high + slack; ++k)
    at.push_back(k * step + 0.0);  // no -0
  return at;
}

}  // namespace view
