// SPDX-License-Identifier: Apache-2.0
// Stiffness of bodies, and the width of regions for a youngs_modulus. Both follow from the scene's
// largest sub-step, so that a body keeps one law whatever sub-steps are taken.
#include <algorithm>
#include <array>
#include <cmath>

#include "description/validate.hpp"
#include "meltsim/physics/coupling.hpp"
#include "meltsim/physics/integrate.hpp"
#include "meltsim/physics/shape_matching.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

namespace {

/// physics::bar_wave_speed2, each found once.
double wave_speed2_of(int half_width, int sites) {
  using Row = std::array<double, physics::most_short_sites + 1>;
  static const auto all = [] {
    std::array<Row, physics::most_half_width + 1> t{};
    for (int w = 0; w <= physics::most_half_width; ++w)
      for (int n = 0; n <= physics::most_short_sites; ++n)
        t[static_cast<std::size_t>(w)][static_cast<std::size_t>(n)] = physics::bar_wave_speed2(w, n);
    return t;
  }();
  const int n = sites <= physics::most_short_sites ? sites : 0;
  return all[static_cast<std::size_t>(half_width)][static_cast<std::size_t>(n)];
}

}  // namespace

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
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (core::is_periodic(desc.domain, axis)) most = std::min(most, 0.4 * extents[axis] / desc.spacing);
  return std::max(1, static_cast<int>(most));
}

/// How wide a body's regions may have to be: sites around it are made for that when it is added.
int WorldImpl::widest_half_width(const MaterialDesc& m) const {
  if (m.youngs_modulus > 0) return most_half_width();
  const double share = desc.courant * core::support_of(desc) / desc.spacing;
  return physics::modulus_half_width(physics::most_least_spring * share * share,
                                     std::max(1, m.region_half_width), most_half_width(), 1.0,
                                     physics::region_wave_speed2);
}

double WorldImpl::asked_modulus_rate(const MaterialDesc& m) const {
  if (m.youngs_modulus > 0) return physics::modulus_rate(m.youngs_modulus, m.density, desc.spacing);
  return m.stiffness * physics::region_wave_speed2(m.region_half_width) / (spring_dt_ * spring_dt_);
}

/// The modulus delivered for a youngs_modulus: within the bounds of liquid and of the widest regions at
/// the largest sub-step.
double WorldImpl::modulus_rate_of(const MaterialDesc& m) const {
  if (!std::isfinite(static_dt_)) return std::max(asked_modulus_rate(m), least_modulus_rate(m));
  return wanted_spring(m) / (static_dt_ * static_dt_);
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
    return any_liquid() ? physics::modulus_half_width(least_spring(m), asked, most_half_width(), 1.0,
                                                      physics::region_wave_speed2)
                        : asked;
  return physics::modulus_half_width(modulus_rate_of(m), asked, most_half_width(), static_dt_,
                                     physics::region_wave_speed2);
}

/// Of one that can deform. With a youngs_modulus as wide as a body of its length needs, and no wider than holds all of it: that
/// pulls no harder.
int WorldImpl::half_width_of(const BodyRecord& body) const {
  const MaterialDesc& m = materials[body.desc.material.index];
  if (!(m.youngs_modulus > 0) || !std::isfinite(static_dt_)) return half_width_of(m);
  const int asked = any_liquid() ? std::max(1, m.region_half_width) : m.region_half_width;
  const int most = std::min(most_half_width(), std::max({1, asked, body.longest - 1}));
  return physics::modulus_half_width(modulus_rate_of(m), asked, most, static_dt_,
                                     [&](int w) { return wave_speed2_of(w, body.longest); });
}

/// modulus_rate_of() at the largest sub-step, squared. What liquid asks for and what the widest regions give is to the bit the same whatever
/// that sub-step is: bodies stay as they are while it changes, as in a World that is loaded.
double WorldImpl::wanted_spring(const MaterialDesc& m) const {
  const double share = static_dt_ / spring_dt_, of_liquid = any_liquid() ? least_spring(m) : 0;
  return std::min(std::max(asked_modulus_rate(m) * static_dt_ * static_dt_, of_liquid * share * share),
                  physics::region_wave_speed2(most_half_width()));
}

/// What alpha of a body with a youngs_modulus goes by: where its regions cannot give all of that, what makes alpha 1 at the largest
/// sub-step, so that it keeps one law at shorter ones.
double WorldImpl::wave_speed2_for(const BodyRecord& body) const {
  const MaterialDesc& m = materials[body.desc.material.index];
  const double speed2 = wave_speed2_of(half_width_of(body), body.longest);
  if (!(m.youngs_modulus > 0) || !std::isfinite(static_dt_)) return speed2;
  return std::max(speed2, wanted_spring(m));
}

/// alpha at a sub-step of dt, of a body with a youngs_modulus.
double WorldImpl::alpha_of(const BodyRecord& body, double dt) const {
  return std::min(1.0, physics::modulus_stiffness(modulus_rate_of(materials[body.desc.material.index]),
                                                  wave_speed2_for(body), dt));
}

/// visit(body) of those of a material that can deform, also of those that were removed, so that a removal changes no table.
template <class Visit>
void WorldImpl::for_each_of(const MaterialDesc& m, const Visit& visit) const {
  for (const BodyRecord& b : bodies_)
    if (&materials[b.desc.material.index] == &m && b.may_deform()) visit(b);
}

/// alpha at a sub-step of dt; with a youngs_modulus the largest of its bodies.
double WorldImpl::alpha_of(const MaterialDesc& m, double dt) const {
  if (!(m.youngs_modulus > 0)) {
    const double alpha = half_width_of(m) > 0 ? stiffness_in_liquid(m) : m.stiffness;
    return physics::stiffness_of_step(alpha, dt, spring_dt_);
  }
  double most = 0;
  for_each_of(m, [&](const BodyRecord& b) { most = std::max(most, alpha_of(b, dt)); });
  return most;
}

/// Of the body that has least of a modulus.
Stiffness WorldImpl::stiffness_of(const MaterialDesc& m) const {
  Stiffness s;
  s.region_half_width = half_width_of(m);
  s.stiffness = m.stiffness;
  const double dt = substep_ > 0 ? substep_ : static_dt_;
  if (!std::isfinite(dt)) return s;
  const auto has = [&](double alpha, int w, double speed2) {
    const double modulus = physics::shape_modulus(alpha, speed2, m.density, desc.spacing, dt);
    if (s.youngs_modulus == 0 || modulus < s.youngs_modulus) s = {w, alpha, modulus};
  };
  for_each_of(m, [&](const BodyRecord& b) {
    const int w = half_width_of(b);
    has(m.youngs_modulus > 0 ? alpha_of(b, dt) : alpha_of(m, dt), w, wave_speed2_of(w, b.longest));
  });
  if (s.youngs_modulus == 0) {
    const double speed2 = physics::region_wave_speed2(s.region_half_width);
    has(m.youngs_modulus > 0 ? std::min(1.0, physics::modulus_stiffness(modulus_rate_of(m), speed2, dt))
                             : alpha_of(m, dt),
        s.region_half_width, speed2);
  }
  return s;
}

/// Whether regions, and what their alpha goes by, are as fit_regions() would make them.
bool WorldImpl::regions_fit() const {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!bodies_[b].may_deform()) continue;
    const core::BodyRow& row = lattice_.bodies[b];
    if (row.region_half_width != half_width_of(bodies_[b])) return false;
    if (row.wave_speed2 != wave_speed2_for(bodies_[b])) return false;
  }
  return true;
}

/// Regions lie within the sites around a body (widest_half_width). Springs of one that is held, which counts for no step, may ask for more.
void WorldImpl::fit_regions_of(const BodyRecord& body, core::BodyRow& row) const {
  const int asked = materials[body.desc.material.index].region_half_width;
  row.region_half_width =
      body.rigid() ? 0
                   : std::min(body.may_deform() ? half_width_of(body) : std::min(asked, most_half_width()),
                              static_cast<int>(row.pad));
  row.wave_speed2 =
      body.may_deform() ? wave_speed2_for(body) : wave_speed2_of(row.region_half_width, body.longest);
}

/// With room in reserve, also for bodies to come of a material without a modulus.
void WorldImpl::fit_regions() {
  lattice_.max_half_width = 0;
  for (const MaterialDesc& m : materials)
    if (room_.vertices != 0 && !(m.youngs_modulus > 0))
      lattice_.max_half_width = std::max(lattice_.max_half_width, half_width_of(m));
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    core::BodyRow& row = lattice_.bodies[b];
    fit_regions_of(bodies_[b], row);
    lattice_.max_half_width = std::max(lattice_.max_half_width, row.region_half_width);
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
    if (b.desc.fixed || b.rigid() || !(m.youngs_modulus > 0)) continue;
    const double most = wave_speed2_of(half_width_of(b), b.longest) / (static_dt_ * static_dt_);
    if (most < asked_modulus_rate(m) * (1 - 1e-9)) return true;
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
