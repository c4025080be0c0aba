// SPDX-License-Identifier: Apache-2.0
// The end of a sub-step for one particle, once all forces on it are known: kick, second half drift, walls, periodic
// wrap, open faces, and the check of the result. Used by step.integrate, and by sph.advance where liquid
// is alone.
#pragma once

#include "frame/frame.hpp"
#include "meltsim/physics/emission.hpp"
#include "meltsim/physics/integrate.hpp"
#include "meltsim/physics/walls.hpp"
#include "spatial/cells.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Results of a sub-step for a particle.
template <class T>
struct Produced {
  std::uint32_t tag = 0;
  T phi{};
  Vec4<T> position, velocity;  ///< of the middle of the sub-step, of its beginning
  Vec3<T> acceleration, shift;
  double enthalpy = 0;
};

/// State afterwards. moved: false if the particle is of a fixed body, removed, or its results are invalid.
template <class T>
struct EndOfStep {
  Vec4<T> position, velocity;
  bool moved = false;
  ParticleCheck<T> check;
};

/// Whether it is anywhere, and takes up room.
template <class T>
MELTSIM_HD bool is_placed(const Vec4<T>& position) {
  return finite(xyz(position)) && std::isfinite(position.w);
}

/// The first stage whose results make p or its new velocity v invalid.
template <class T>
MELTSIM_HD void blame(const Frame<T>& w, std::uint64_t i, const Produced<T>& p, Vec3<T> v,
                      ParticleCheck<T>& r) {
  Halt why = Halt::speed;
  double value = static_cast<double>(length(v));
  const auto unless = [&](bool good, Halt stage, double found) {
    if (good) return;
    why = stage;
    value = found;
  };
  unless(std::isfinite(p.enthalpy), Halt::heat, p.enthalpy);
  unless(finite(v), Halt::shape, value);
  unless(finite(p.acceleration), Halt::force, static_cast<double>(length(p.acceleration)));
  unless(std::isfinite(r.phi), Halt::density, static_cast<double>(r.phi));
  // Sums need not show it: a GPU takes a distance that is NaN as one beyond H.
  unless(is_placed(p.position), Halt::position, 0.0);
  r.bad = static_cast<std::uint32_t>(why);
  r.bad_id = w.f.id[i];
  r.bad_value = value;
}

/// Checks the results of a sub-step for a particle.
template <class T>
MELTSIM_HD ParticleCheck<T> look(const Frame<T>& w, std::uint64_t i, const Produced<T>& p, Vec3<T> v) {
  ParticleCheck<T> r;
  r.speed = length(v);
  if (is_fluid(p.tag)) r.phi = p.phi;
  // A particle that crosses its whole neighbourhood in one sub-step interacts with nothing on its way. Neither may its
  // speed be NaN.
  const bool good = r.speed * w.f.clock->dt <= w.c.kernel.support && is_placed(p.position) &&
                    finite(p.acceleration) && std::isfinite(r.phi) && std::isfinite(p.enthalpy);
  if (!good) blame(w, i, p, v, r);
  if (r.phi > T(1)) {
    const T most = static_cast<T>(CheckResult::most_excess),
            units = static_cast<T>(CheckResult::excess_units);
    r.excess = static_cast<std::uint32_t>(minimum(r.phi - T(1), most) * units);
    r.counts = ParticleCheck<T>::dense;
  }
  return r;
}

/// The same for one that is removed: nothing moves it, but a stage of the host may have written it, and it is part of the state.
template <class T>
MELTSIM_HD ParticleCheck<T> look_at_removed(const Frame<T>& w, std::uint64_t i, const Produced<T>& p) {
  ParticleCheck<T> r;
  if (is_placed(p.position) && finite(xyz(p.velocity)) && std::isfinite(p.enthalpy)) return r;
  Produced<T> unmoved = p;
  unmoved.acceleration = {};  // that of before it was removed
  blame(w, i, unmoved, xyz(p.velocity), r);
  return r;
}

/// Whether a particle moves with its body: a kinematic or rigid one, or a proxy.
template <class T>
MELTSIM_HD bool is_driven(const Frame<T>& w, std::uint32_t tag) {
  return w.f.carried_position != nullptr && is_solid(tag) &&
         ((tag & tag_kinematic) != 0u || moves_rigidly(w.f.bodies[body_of(tag) - 1u]));
}

/// Velocity v of particle i after a kick by acceleration a; all force stages have finished. That of a rigid body's is what
/// the body as a whole gives it.
/// Channels that the plan does not hold are null.
template <class T>
MELTSIM_HD Vec3<T> kicked(const Frame<T>& w, std::uint64_t i, std::uint32_t tag, Vec3<T> v, Vec3<T> a) {
  if (((tag & tag_fixed) != 0u && is_solid(tag)) || is_held(tag)) return v;
  if (is_driven(w, tag)) return w.f.carried_velocity[w.f.vertex_of_id[w.f.id[i]]];
  if (w.f.acceleration != nullptr) v = physics::kick(v, a, w.f.clock->dt);
  if (w.f.shape_velocity != nullptr && is_solid(tag)) v += w.f.shape_velocity[w.f.vertex_of_id[w.f.id[i]]];
  return v;
}

template <class T>
MELTSIM_HD Vec3<T> acceleration_of(const Frame<T>& w, std::uint64_t i) {
  return w.f.acceleration != nullptr ? w.f.acceleration[i] : Vec3<T>{};
}

/// Whether liquid falls out of the scene: it has just exceeded the speed of strays, and only gravity and force fields act on it.
/// Where liquid diverges, other forces make it that fast.
template <class T>
MELTSIM_HD bool strays(const Frame<T>& w, std::uint64_t i, const Produced<T>& p, Vec3<T> v) {
  const T limit2 = w.c.stray_speed * w.c.stray_speed;  // infinite: nothing does
  if (!(dot(v, v) > limit2) || !is_fluid(p.tag)) return false;
  const Vec3<T> before = xyz(p.velocity), pull = pull_at(w, i), others = p.acceleration - pull;
  constexpr T share2 = T(1e-4);  // a hundredth of the pull
  return dot(before, before) <= limit2 && dot(others, others) <= share2 * dot(pull, pull);
}

/// The second half drift, inside walls.
template <class T>
MELTSIM_HD void drift_inside(const Frame<T>& w, std::uint32_t tag, Vec3<T> shift, Vec3<T>& x, Vec3<T>& v) {
  x = physics::drift(x, v, w.f.clock->half_dt);
  if (is_fluid(tag) && !is_held(tag)) x += shift;
  if (w.c.walls.faces != 0u) physics::hold_inside(w.c.walls, w.c.spacing, x, v);
}

/// Moves x and v to the end of the sub-step; true: p has left through an open face.
template <class T>
MELTSIM_HD bool move(const Frame<T>& w, const Produced<T>& p, Vec3<T>& x, Vec3<T>& v) {
  drift_inside(w, p.tag, p.shift, x, v);
  x = wrapped(w, x);
  const std::uint32_t open = w.c.open_faces;
  if (open == 0u || !is_fluid(p.tag)) return false;
  return ((open & 1u) != 0u && x.x < w.c.domain_min.x) || ((open & 2u) != 0u && x.x > w.c.domain_max.x) ||
         ((open & 4u) != 0u && x.y < w.c.domain_min.y) || ((open & 8u) != 0u && x.y > w.c.domain_max.y) ||
         ((open & 16u) != 0u && x.z < w.c.domain_min.z) || ((open & 32u) != 0u && x.z > w.c.domain_max.z);
}

/// Liquid that has come in through a face is let go at the end of its reach.
template <class T>
MELTSIM_HD void let_in(const Frame<T>& w, std::uint64_t i, Vec3<T> x, Vec3<T> v, std::uint32_t& tag) {
  if (w.c.outlets.inlets == 0u || !is_held(tag)) return;
  for (std::uint32_t f = 0; f < 6u; ++f) {
    if (((w.c.outlets.inlets >> f) & 1u) == 0u) continue;
    const Vec3<T> out = physics::face_outwards<T>(f), along = out * dot(v, out);
    const T past = physics::face_distance(w.c.domain_min, w.c.domain_max, x, f) -
                   T(physics::outlet_reach) * w.c.kernel.support;
    if (past > w.c.spacing || !(dot(v, out) < T(0)) || v.x != along.x || v.y != along.y || v.z != along.z)
      continue;
    tag &= ~tag_held;
    w.f.tag[i] = tag;
  }
}

/// Liquid near a face with an outlet moves at the outlet's speed; so does liquid that a nozzle of the same velocity holds.
template <class T>
MELTSIM_HD void drain(const Frame<T>& w, std::uint64_t i, Vec3<T> x, Vec3<T>& v, std::uint32_t& tag) {
  const std::uint32_t face =
      physics::taken_by(w.c.outlets, w.c.kernel.support, w.c.domain_min, w.c.domain_max, x);
  if (face == 6u) return let_in(w, i, x, v, tag);
  const bool level = (((w.c.outlets.levels | w.c.outlets.inlets) >> face) & 1u) != 0u;
  v = physics::face_outwards<T>(face) * (level ? w.f.outlet_flow->speed[face] : w.c.outlets.speed[face]);
  if (is_held(tag)) return;
  tag |= tag_held;
  w.f.tag[i] = tag;
}

/// A particle that moves with its body is where the body is.
template <class T>
MELTSIM_HD void carry(const Frame<T>& w, std::uint64_t i, std::uint32_t tag, Vec3<T>& x, Vec3<T>& v,
                      T& volume) {
  const std::uint32_t vertex = w.f.vertex_of_id[w.f.id[i]];
  x = w.f.carried_position[vertex];
  v = w.f.carried_velocity[vertex];
  if (w.f.carried_volume != nullptr && (tag & tag_kinematic) != 0u) volume = w.f.carried_volume[vertex];
}

/// Reports the first stage that produced an invalid value for a particle, and does not move the particle. Nothing
/// that is written counts before JudgeBody says so: the state of the sub-step before is still there, in its own order.
/// v: the velocity after the kick. If the next sub-step is as long, also counts which particle will
/// be in which cell.
template <class T, class Add>
MELTSIM_HD EndOfStep<T> end_of_step(const Frame<T>& w, std::uint64_t i, const Produced<T>& p, Vec3<T> v,
                                    const Add& add) {
  EndOfStep<T> end;
  Vec3<T> x = xyz(p.position);
  std::uint32_t tag = p.tag;
  T volume = p.position.w;
  if (is_removed(tag)) {
    v = xyz(p.velocity);
    end.check = look_at_removed(w, i, p);
  } else {
    end.check = look(w, i, p, v);
    const bool held = is_solid(tag) && (tag & tag_fixed) != 0u;
    const bool carried = is_driven(w, tag);
    end.moved = end.check.bad == 0u && (!held || carried);
    if (end.moved && carried) {
      carry(w, i, tag, x, v, volume);
    } else if (end.moved) {
      const bool astray = strays(w, i, p, v), left = move(w, p, x, v);
      if (astray || left) {
        end.check.counts += left ? ParticleCheck<T>::removed : ParticleCheck<T>::strayed;
        if (astray) end.check.speed = T(0);  // no matter to what is left
        tag |= tag_removed;
        w.f.tag[i] = tag;
      } else if (w.c.outlets.taking != 0u && is_fluid(tag)) {
        drain(w, i, x, v, tag);
      }
    }
  }
  end.position =
      with_w(x, is_held(tag) ? physics::entering_volume(p.position.w, w.c.spacing, length(v), w.f.clock->dt)
                             : volume);
  end.velocity = with_w(v, p.velocity.w);
  if (w.count_ahead && end.check.bad == 0u) {  // a particle at NaN is in no cell; the World halts anyway
    const std::uint32_t cell = spatial::counted_cell(w, tag, x, v);
    w.f.cell_of[i] = cell;
    add.count(w.f.cell_count, cell);
  }
  return end;
}

/// The sub-step does not count: from here on the guard holds, and the host goes back to the state at its beginning.
template <class T>
MELTSIM_HD void give_up(const Frame<T>& w, std::uint64_t step, Halt why) {
  WorldStatus& s = *w.f.status;
  const bool advanced = w.next.position != nullptr;
  s.halt_step = step;
  s.halt_position = reinterpret_cast<std::uintptr_t>(w.before.position);
  s.halt_velocity = reinterpret_cast<std::uintptr_t>(advanced ? w.f.velocity : w.before.velocity);
  s.halt_id = reinterpret_cast<std::uintptr_t>(w.before.id);
  s.halt_advanced = advanced ? 1u : 0u;
  s.halted = static_cast<std::uint32_t>(why);
  s.heat_idle |= idle_halted;
}

/// Abandons the sub-step because the host asked to stop; ahead of step.integrate.
template <class T>
struct GiveUpBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t) const { give_up(w, w.f.clock->step, Halt::interrupted); }
};

/// Commits or rejects the sub-step; from here on the guard holds if the World halted. One thread: it reads everything
/// before it writes anything, so that it waits once.
template <class T>
struct JudgeBody {
  Frame<T> w;
  MELTSIM_HD void operator()(const CheckResult& worst) const {
    WorldStatus& s = *w.f.status;
    const Clock<T> clock = *w.f.clock;
    const double fastest = s.max_speed, densest = s.max_density;
    const std::int64_t removed = s.removed, strayed = s.strayed;
    double heat_in = s.heat_in;
    if (w.f.heat_account != nullptr) heat_in += w.f.heat_account->step;
    if (worst.bad != 0u) {
      s.halt_particle = worst.bad_id;
      s.halt_value = worst.bad_value;
      give_up(w, clock.step, static_cast<Halt>(worst.bad));
      return;
    }
    s.heat_in = heat_in;
    if (w.f.heat_account != nullptr) w.f.heat_account->step = 0;  // and stays so in a sub-step without heat
    s.removed = removed + static_cast<std::int64_t>(worst.removed + worst.strayed);
    s.strayed = strayed + static_cast<std::int64_t>(worst.strayed);
    s.max_speed = maximum(fastest, worst.max_speed);
    s.max_density = maximum(densest, worst.max_density);
    s.step_speed = worst.max_speed;
    s.step_density = worst.max_density;
    s.step_excess = worst.dense != 0u ? static_cast<double>(worst.excess) /
                                            (CheckResult::excess_units * static_cast<double>(worst.dense))
                                      : 0.0;
    s.ledger_step = clock.step;
    s.ledger_dt = static_cast<double>(clock.dt);
    if (worst.max_speed * static_cast<double>(clock.dt) >
        static_cast<double>(w.c.courant) * static_cast<double>(w.c.kernel.support))
      s.courant_exceeded = 1u;
  }
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
