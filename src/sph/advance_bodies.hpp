// SPDX-License-Identifier: Apache-2.0
// Forces and the end of the sub-step in one sweep, where liquid is alone.
#pragma once

#include "shared/advance.hpp"
#include "sph/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

/// ForcesBody and what step.integrate does. Others may still read the state of the middle of the sub-step, so the
/// new one goes elsewhere (Frame::next). Enthalpies are not looked at: nothing changes them here.
template <class T, bool Periodic>
struct AdvanceBody : ForcesBody<T, Company::liquid, Periodic> {
  using Forces = ForcesBody<T, Company::liquid, Periodic>;
  using Forces::w;
  using typename Forces::Sum;
  /// Operands of finish, loaded together.
  struct Item {
    core::Produced<T> p;
    T mass{};
  };
  MELTSIM_HD Item read(std::uint64_t i) const {
    Item item;
    item.p.tag = w.f.tag[i];
    item.p.phi = w.f.density[i];
    item.p.position = w.f.position[i];
    item.p.velocity = w.f.velocity[i];
    item.mass = w.f.mass[i];
    return item;
  }
  template <class Add>
  MELTSIM_HD core::ParticleCheck<T> finish(std::uint64_t i, const Sum& s, Item item, const Add& add) const {
    core::Produced<T>& p = item.p;
    const Vec3<T> v = xyz(p.velocity);
    if (is_fluid(p.tag)) p.acceleration = Forces::acceleration(i, p.tag, p.position, v, item.mass, s);
    const Vec3<T> kicked = is_held(p.tag) ? v : physics::kick(v, p.acceleration, w.f.clock->dt);
    const auto end = core::end_of_step(w, i, p, kicked, add);
    w.next.position[i] = end.position;
    w.next.velocity[i] = end.velocity;
    return end.check;
  }
};

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
