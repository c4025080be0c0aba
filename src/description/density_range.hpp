// SPDX-License-Identifier: Apache-2.0
// The rest densities that a material may have.
#pragma once

#include <algorithm>

#include "meltsim/material.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Least and largest rest density [kg/m^3], over the temperatures of the table if there is one.
inline double least_density(const MaterialDesc& m) {
  double rho = m.density;
  for (const PropertyPoint& p : m.density_points) rho = std::min(rho, p.value);
  return rho;
}

inline double largest_density(const MaterialDesc& m) {
  double rho = m.density;
  for (const PropertyPoint& p : m.density_points) rho = std::max(rho, p.value);
  return rho;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
