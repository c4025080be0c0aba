// SPDX-License-Identifier: Apache-2.0
// What follows from the description of a material alone.
#pragma once

#include <vector>

#include "meltsim/material.hpp"
#include "meltsim/physics/property_table.hpp"

namespace meltsim {
inline namespace v0 {

physics::PropertyTable<double> table(const std::vector<PropertyPoint>& points);
/// The least and the largest value of a table; without points `otherwise`.
double least_value(const std::vector<PropertyPoint>& points, double otherwise);
double largest_value(const std::vector<PropertyPoint>& points, double otherwise);
/// Whether a liquid's viscosity depends on the shear rate.
bool shears(const MaterialDesc& m);
/// tau_y at any temperature [Pa].
double largest_yield_stress(const MaterialDesc& m);
/// w_s at any temperature [-].
double largest_solubility(const MaterialDesc& m);
double least_solubility(const MaterialDesc& m);
/// Largest mass fraction that liquid may hold: where the species precipitates, liquid beside a body may be crystals.
double largest_content(const MaterialDesc& m);

}  // namespace v0
}  // namespace meltsim
