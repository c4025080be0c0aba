// SPDX-License-Identifier: Apache-2.0
// Colours that pictures and pages share: those of temperature (blue is cold, yellow between, red hot) and of bodies.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace runner {

using Rgb = std::array<double, 3>;  ///< 0..1, as monitors show it (sRGB)

inline constexpr std::array<Rgb, 6> ramp_stops{{{0.14, 0.25, 0.62},
                                                {0.27, 0.55, 0.85},
                                                {0.68, 0.86, 0.91},
                                                {0.99, 0.90, 0.45},
                                                {0.96, 0.52, 0.22},
                                                {0.75, 0.09, 0.12}}};

/// The transfer function of sRGB (IEC 61966-2-1): what a monitor shows, as linear light.
inline double linear(double shown) {
  return shown <= 0.04045 ? shown / 12.92 : std::pow((shown + 0.055) / 1.055, 2.4);
}
inline Rgb linear(const Rgb& shown) { return {linear(shown[0]), linear(shown[1]), linear(shown[2])}; }

/// Linear light, as a monitor shows it.
inline double monitor(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}
inline Rgb monitor(const Rgb& light) { return {monitor(light[0]), monitor(light[1]), monitor(light[2])}; }

/// Linear light of bodies whose material has no colour, one after another.
inline constexpr std::array<Rgb, 6> body_palette{{{0.66, 0.80, 0.90},
                                                  {0.80, 0.42, 0.09},
                                                  {0.64, 0.15, 0.10},
                                                  {0.22, 0.46, 0.18},
                                                  {0.36, 0.24, 0.55},
                                                  {0.72, 0.32, 0.43}}};

/// Of a body counted from 0.
inline const Rgb& palette_color(std::size_t body) { return body_palette[body % body_palette.size()]; }

/// 0 cold .. 1 hot; beyond both the ends' colours.
inline Rgb ramp(double x) {
  const double at = std::clamp(x, 0.0, 1.0) * static_cast<double>(ramp_stops.size() - 1);
  const std::size_t i = std::min(ramp_stops.size() - 2, static_cast<std::size_t>(at));
  const double part = at - static_cast<double>(i);
  Rgb color{};
  for (std::size_t k = 0; k < 3; ++k)
    color[k] = ramp_stops[i][k] + part * (ramp_stops[i + 1][k] - ramp_stops[i][k]);
  return color;
}

/// The colour of a temperature between two ends.
inline Rgb warmth_of(double temperature, double cold, double hot) {
  return ramp((temperature - cold) / std::max(hot - cold, 1e-9));
}

}  // namespace runner
