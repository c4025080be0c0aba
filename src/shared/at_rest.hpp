// SPDX-License-Identifier: Apache-2.0
// What hydrostatic force fields take out of liquid (physics/force_field.hpp).
#pragma once

#include "frame/frame.hpp"
#include "meltsim/physics/force_field.hpp"
#include "spatial/rows.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// The liquid at rest at a place whose pressure hydrostatic fields count from: 0 where there is none.
template <class T>
struct AtRest {
  T density{};   ///< [kg/m^3]
  T pressure{};  ///< [Pa]
};
template <class T>
MELTSIM_HD AtRest<T> at_rest(const Frame<T>& w, Vec3<T> x) {
  AtRest<T> rest;
  if (w.f.force_fields == nullptr) return rest;
  const Clock<T>& clock = *w.f.clock;
  for (std::uint32_t k = 0; k < w.f.force_fields->count; ++k) {
    const physics::ForceField<T>& field = w.f.force_fields->row[k];
    if (field.on == 0u || field.kind != physics::ForceKind::hydrostatic) continue;
    if (!clock.within(field.from, field.until)) continue;
    if (!physics::in_force_region(field, spatial::separation(w.grid, x, field.center))) continue;
    const T depth = physics::depth_below(spatial::separation(w.grid, x, field.about), clock.gravity);
    rest.density += field.density * physics::hydrostatic_share(field, depth);
    rest.pressure += physics::rest_pressure(field, depth, clock.gravity);
  }
  return rest;
}

/// Force of that liquid on particle i of a body, by Archimedes: step.fields gives it to what can move.
template <class T>
MELTSIM_HD Vec3<T> rest_force_on(const Frame<T>& w, std::uint64_t i) {
  const Vec4<T> x = w.f.position[i];
  const T density = at_rest(w, xyz(x)).density;
  return density == T(0) ? Vec3<T>{} : w.f.clock->gravity * (-density * x.w);
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
