// SPDX-License-Identifier: Apache-2.0
// Every check of a description, in one place. Messages: field: what is wrong, got value; the fix.
#pragma once

#include "engine/text.hpp"
#include "meltsim/desc.hpp"
#include "meltsim/physics/heat_boundary.hpp"
#include "meltsim/result.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// 0, or within fifteen decades of 1 to either side: what double precision takes to the fourth power, and no material has.
Status measurable(const std::string& field, double v, const char* unit);
/// Numbers small enough that sums over time and particles stay finite in double precision.
Status summable(const std::string& field, double v, const char* unit);

/// Of an enum that a host may have cast from any number: whether it is one of those up to `last`. type: its name; usual: what to use.
template <class E>
Status known(const std::string& field, E value, E last, const char* type, const char* usual) {
  const int number = static_cast<int>(value);
  if (number >= 0 && number <= static_cast<int>(last)) return {};
  return invalid(field, ": is no ", type, ", got ", number, "; ", usual);
}

Status validate(const WorldDesc& desc);
Status validate(const MaterialDesc& desc);
/// Height of the level beyond a face above the floor of the domain [m]; 0 where there is none.
double outlet_head(const WorldDesc& d, std::size_t face);

/// How high above the floor of the domain a height against gravity is [m]; needs gravity along an axis.
double height_above_floor(const WorldDesc& d, double height);
/// The face of the domain that an axis points inwards from; -1: none.
int face_behind(Vec3d axis);
/// Whether an emitter with a level describes a face with liquid beyond; the level alone.
Status validate_reservoir(const EmitterDesc& e, const WorldDesc& d);
Status validate_level(const std::string& p, double level, const WorldDesc& d);

/// Temperature and motion shared by fluids, bodies and emitters; `what` prefixes the field.
Status validate_state(const char* what, double temperature, Vec3d velocity);
Status validate(const EmitterDesc& desc, double spacing);
/// H [m] of a description, automatic resolved.
double support_of(const WorldDesc& desc);

/// `model`: of the World, for conditions that need the enthalpy model. `what` ends in ": " or ".".
Status validate(const SurfaceHeatDesc& s, HeatModel model, const std::string& what);
Status validate(const HeatRegionDesc& r, HeatModel model);
Status validate(const ForceFieldDesc& f);
/// The row of a description.
physics::SurfaceCondition<double> condition_of(const SurfaceHeatDesc& s);
/// How far, and how far in a second, a heat region may be moved: single precision holds it, and its square [m].
inline constexpr double farthest_move = 1e12;
/// Of what it is at a time [s].
physics::SurfaceCondition<double> condition_at(const SurfaceHeatDesc& s, double time);
/// Whether that depends on the time.
bool is_timed(const SurfaceHeatDesc& s);

}  // namespace core
}  // namespace v0
}  // namespace meltsim
