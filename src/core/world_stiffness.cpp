// SPDX-License-Identifier: Apache-2.0
// How stiff bodies come out, and how wide regions have to be for a youngs_modulus.
#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "core/world_impl.hpp"
#include "meltsim/physics/integrate.hpp"
#include "meltsim/physics/shape_matching.hpp"

namespace meltsim {
inline namespace v0 {

/// What a material's modulus comes to at sub-steps of dt, infinite while none is known. A function of dt
/// alone, not of history, so that a restored World goes on with the same bits.
Stiffness WorldImpl::stiffness_of(const MaterialDesc& m, double dt) const {
  Stiffness s;
  s.region_half_width = m.region_half_width;
  s.stiffness = m.stiffness;
  if (!(dt > 0 && std::isfinite(dt))) return s;
  const double rate = m.youngs_modulus / (m.density * desc.spacing * desc.spacing);
  if (rate > 0) {
    s.region_half_width =
        physics::modulus_half_width(rate, m.region_half_width, physics::most_half_width, dt);
    s.stiffness = std::min(1.0, physics::modulus_stiffness(rate, s.region_half_width, dt));
  } else s.stiffness = physics::stiffness_of_step(s.stiffness, dt, physics::spring_dt(dt, spring_reference_));
  s.youngs_modulus = physics::shape_modulus(s.stiffness, s.region_half_width, m.density, desc.spacing, dt);
  return s;
}

int WorldImpl::half_width_for(const BodyRecord& b, double dt) const {
  const MaterialDesc& m = materials[b.desc.material.index];
  return b.desc.fixed ? m.region_half_width : stiffness_of(m, dt).region_half_width;
}

/// Whether the regions are as wide as moduli ask for at sub-steps of dt.
bool WorldImpl::regions_fit(double dt) const {
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (lattice_.bodies[b].region_half_width != half_width_for(bodies_[b], dt)) return false;
  return true;
}

void WorldImpl::fit_regions(double dt) {
  lattice_.max_half_width = 0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const int w = half_width_for(bodies_[b], dt);
    lattice_.bodies[b].region_half_width = w;
    lattice_.max_half_width = std::max(lattice_.max_half_width, w);
  }
}

bool WorldImpl::modulus_out_of_reach(double dt) const {
  if ((facts_ & core::fact_mobile) == 0 || !(dt > 0)) return false;
  for (const BodyRecord& b : bodies_) {
    const MaterialDesc& m = materials[b.desc.material.index];
    if (!b.desc.fixed && stiffness_of(m, dt).youngs_modulus < m.youngs_modulus * (1 - 1e-9)) return true;
  }
  return false;
}

/// Before sub-steps of dt: makes the regions as wide as moduli ask for at that length.
Status WorldImpl::follow_modulus(double dt) {
  if (dt == substep_) return {};
  const bool fits = (facts_ & core::fact_mobile) == 0 || regions_fit(dt);
  if (!fits && steps > 0) {  // what was enqueued must have gone well before it is sent anew
    fetch_state();
    if (halted_)
      return Error{ErrorCode::halted,
                   "step: the World halted: " + halt_reason_ + "; restore a snapshot to go on"};
  }
  substep_ = dt;
  dirty_ = dirty_ || !fits;
  modulus_unreachable_ = modulus_unreachable_ || modulus_out_of_reach(dt);
  return prepare();
}

}  // namespace v0
}  // namespace meltsim
