// SPDX-License-Identifier: Apache-2.0
// Stiffness of bodies, and the width of regions for a youngs_modulus. Both follow from the scene's
// largest sub-step, so that a body keeps one law whatever sub-steps are taken.
#include <algorithm>
#include <cmath>

#include "description/validate.hpp"
#include "meltsim/physics/coupling.hpp"
#include "meltsim/physics/integrate.hpp"
#include "meltsim/physics/shape_matching.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

/// Least E dt_s^2/(rho dx^2) of a body in liquid: of lengths alone, so that no sound speed makes it overflow.
double WorldImpl::least_spring(const MaterialDesc& m) const {
  const double share = desc.courant * core::support_of(desc) / desc.spacing * spring_share_;
  return physics::least_modulus_of(m.density, densest_added_) * share * share;
}

/// Least E/(rho dx^2) that liquid leaves a body [1/s^2].
double WorldImpl::least_modulus_rate(const MaterialDesc& m) const {
  return any_liquid() ? least_spring(m) / (spring_dt_ * spring_dt_) : 0;
}

/// How wide regions may be: between any two members the nearest image across periodic faces is the one that is meant, also
/// where the body is strained by a quarter.
int WorldImpl::most_half_width() const {
  double most = physics::most_half_width;
  const Vec3d extent = desc.domain.max - desc.domain.min;
  const double extents[3] = {extent.x, extent.y, extent.z};
  for (std::size_t axis = 0; desc.domain.bounded && axis < 3; ++axis)
    if (desc.domain.faces[2 * axis] == Face::periodic)
      most = std::min(most, 0.4 * extents[axis] / desc.spacing);
  return std::max(1, static_cast<int>(most));
}

/// How wide a body's regions may have to be: sites around it are made for that when it is added.
int WorldImpl::widest_half_width(const MaterialDesc& m) const {
  if (m.youngs_modulus > 0) return most_half_width();
  const double share = desc.courant * core::support_of(desc) / desc.spacing;
  return physics::modulus_half_width(physics::most_least_spring * share * share,
                                     std::max(1, m.region_half_width), most_half_width(), 1.0);
}

double WorldImpl::asked_modulus_rate(const MaterialDesc& m) const {
  if (m.youngs_modulus > 0) return physics::modulus_rate(m.youngs_modulus, m.density, desc.spacing);
  return m.stiffness * physics::region_wave_speed2(m.region_half_width) / (spring_dt_ * spring_dt_);
}

/// The modulus delivered for a youngs_modulus: within the bounds of liquid and of the widest regions at
/// the largest sub-step.
double WorldImpl::modulus_rate_of(const MaterialDesc& m) const {
  const double asked = std::max(asked_modulus_rate(m), least_modulus_rate(m));
  if (!std::isfinite(static_dt_)) return asked;
  return std::min(asked, physics::region_wave_speed2(most_half_width()) / (static_dt_ * static_dt_));
}

/// Likewise of a stiffness: alpha at the step that springs go by.
double WorldImpl::stiffness_in_liquid(const MaterialDesc& m) const {
  if (!any_liquid()) return m.stiffness;
  return std::min(1.0,
                  std::max(m.stiffness, least_spring(m) / physics::region_wave_speed2(half_width_of(m))));
}

int WorldImpl::half_width_of(const MaterialDesc& m) const {
  const int asked = any_liquid() ? std::max(1, m.region_half_width) : m.region_half_width;
  if (!std::isfinite(static_dt_)) return asked;
  if (!(m.youngs_modulus > 0))  // as wide as what liquid asks for needs
    return any_liquid() ? physics::modulus_half_width(least_spring(m), asked, most_half_width(), 1.0) : asked;
  return physics::modulus_half_width(modulus_rate_of(m), asked, most_half_width(), static_dt_);
}

/// alpha at a sub-step of dt.
double WorldImpl::alpha_of(const MaterialDesc& m, double dt) const {
  if (!(m.youngs_modulus > 0)) {
    const double alpha = half_width_of(m) > 0 ? stiffness_in_liquid(m) : m.stiffness;
    return physics::stiffness_of_step(alpha, dt, spring_dt_);
  }
  return std::min(1.0, physics::modulus_stiffness(modulus_rate_of(m), half_width_of(m), dt));
}

Stiffness WorldImpl::stiffness_of(const MaterialDesc& m) const {
  Stiffness s;
  s.region_half_width = half_width_of(m);
  s.stiffness = m.stiffness;
  const double dt = substep_ > 0 ? substep_ : static_dt_;
  if (!std::isfinite(dt)) return s;
  s.stiffness = alpha_of(m, dt);
  s.youngs_modulus = physics::shape_modulus(s.stiffness, s.region_half_width, m.density, desc.spacing, dt);
  return s;
}

/// Whether regions are as wide as fit_regions() would make them.
bool WorldImpl::regions_fit() const {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const MaterialDesc& m = materials[bodies_[b].desc.material.index];
    if (bodies_[b].may_deform() && lattice_.bodies[b].region_half_width != half_width_of(m)) return false;
  }
  return true;
}

/// With room in reserve, also for bodies to come of a material without a modulus.
void WorldImpl::fit_regions() {
  lattice_.max_half_width = 0;
  for (const MaterialDesc& m : materials)
    if (room_.vertices != 0 && !(m.youngs_modulus > 0))
      lattice_.max_half_width = std::max(lattice_.max_half_width, half_width_of(m));
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const MaterialDesc& m = materials[bodies_[b].desc.material.index];
    // Sites around a body are no more than the domain allows (widest_half_width).
    const int w = bodies_[b].rigid()        ? 0
                  : bodies_[b].may_deform() ? half_width_of(m)
                                            : std::min(m.region_half_width, most_half_width());
    lattice_.bodies[b].region_half_width = w;
    lattice_.max_half_width = std::max(lattice_.max_half_width, w);
  }
}

/// Values for kernels: moduli within reach, and at least the damping that sub-steps of varying length need.
void WorldImpl::fit_rows(std::vector<core::MaterialRow<double>>& rows) const {
  if (!std::isfinite(static_dt_)) return;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const MaterialDesc& m = materials[k];
    if (m.youngs_modulus > 0) rows[k].modulus_rate = modulus_rate_of(m);
    else rows[k].shape_stiffness = alpha_of(m, spring_dt_);
    const double least = physics::least_damping(alpha_of(m, static_dt_)) * spring_dt_ / static_dt_;
    rows[k].shape_damping = std::max(rows[k].shape_damping, least);
  }
}

bool WorldImpl::modulus_out_of_reach() const {
  if ((facts_ & core::fact_mobile) == 0) return false;
  for (const BodyRecord& b : bodies_) {
    const MaterialDesc& m = materials[b.desc.material.index];
    if (!b.desc.fixed && !b.rigid() && m.youngs_modulus > 0 &&
        modulus_rate_of(m) < asked_modulus_rate(m) * (1 - 1e-9))
      return true;
  }
  return false;
}

bool WorldImpl::stiffened_by_liquid() const {
  if ((facts_ & core::fact_mobile) == 0) return false;
  for (const BodyRecord& b : bodies_) {
    const MaterialDesc& m = materials[b.desc.material.index];
    if (!b.desc.fixed && !b.rigid() && asked_modulus_rate(m) < least_modulus_rate(m) * (1 - 1e-9))
      return true;
  }
  return false;
}

}  // namespace v0
}  // namespace meltsim
