// SPDX-License-Identifier: Apache-2.0
// Heat through surfaces that a scene asks for and does not get.
#pragma once

#include <algorithm>
#include <vector>

#include "node.hpp"
#include "scene.hpp"

namespace runner {

/// Least and most.
struct Span {
  double least, most;
};
inline Span span_of(const std::vector<meltsim::TimedValue>& points, double otherwise) {
  if (points.empty()) return {otherwise, otherwise};
  Span span{points.front().value, points.front().value};
  for (const meltsim::TimedValue& p : points)
    span = {std::min(span.least, p.value), std::max(span.most, p.value)};
  return span;
}
/// Of a surface that is held, or of the surroundings of another, whenever.
inline Span temperatures_of(const meltsim::SurfaceHeatDesc& s) {
  return span_of(s.temperature_points, s.temperature.value_or(s.ambient));
}
inline Span fluxes_of(const meltsim::SurfaceHeatDesc& s) { return span_of(s.flux_points, s.flux); }

/// Whether heat goes through a surface at all.
inline bool acts(const meltsim::SurfaceHeatDesc& s) {
  return s.temperature || s.flux != 0 || !s.flux_points.empty() || s.convection != 0 || s.emissivity != 0;
}

/// Notes in `scene.warnings` what can only be an oversight.
void check_heat(const Node& root, Scene& scene);

}  // namespace runner
