// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "shared/super_steps.hpp"
#include "spatial/strategies.hpp"
#include "sph/advance_bodies.hpp"
#include "sph/bodies.hpp"
#include "sph/cohere_bodies.hpp"
#include "sph/diffuse_bodies.hpp"
#include "sph/isotropy_bodies.hpp"
#include "sph/seep_bodies.hpp"
#include "sph/shift_bodies.hpp"
#include "sph/strain_bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace sph {

template <class E, class T>
void density(E& ex, const core::Frame<T>& w) {
  spatial::with_search_of<E>(
      w, [&](auto kind) { spatial::find<kind(), true>(ex, w, DensityBody<T, kind()>{w}); });
}

template <class E, class T>
void viscosity(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, ViscosityBody<T>{w});
}

template <class E, class T>
void strain(E& ex, const core::Frame<T>& w) {
  spatial::with_periods(
      w, [&](auto periodic) { spatial::sweep<periodic()>(ex, w.particles, StrainBody<T, periodic()>{w}); });
}

template <Company company, bool Periodic, class E, class T>
void forces_of(E& ex, const core::Frame<T>& w) {
  using Body = ForcesBody<T, company, Periodic>;
  if (w.f.isotropic_diagonal == nullptr) return spatial::sweep<Periodic>(ex, w.particles, Body{w});
  spatial::sweep<Periodic>(ex, w.particles, WithIsotropy<T, Body, Periodic>{{w}, {w}});
}

/// The frame of a stage that leaves viscosity to sph.diffuse, where the scene has that.
template <class T>
core::Frame<T> without_viscosity(const core::Frame<T>& frame) {
  core::Frame<T> w = frame;
  w.inviscid = w.viscous_stages != 0u;
  if (w.inviscid) w.f.viscosity = nullptr;
  return w;
}

template <class E, class T>
void forces(E& ex, const core::Frame<T>& frame) {
  const core::Frame<T> w = without_viscosity(frame);
  spatial::with_periods(w, [&](auto periodic) {
    switch (company_of(w)) {
      case Company::liquid:
        return forces_of<Company::liquid, periodic()>(ex, w);
      case Company::solids:
        return forces_of<Company::solids, periodic()>(ex, w);
      case Company::any:
        return forces_of<Company::any, periodic()>(ex, w);
    }
  });
}

/// forces and step.integrate in one launch, where a liquid is alone and no stage stands between the two; not a stage.
template <class E, class T>
void advance(E& ex, const core::Frame<T>& w) {
  spatial::with_periods(w, [&](auto periodic) {
    ex.gather_reduce(w.particles, AdvanceBody<T, periodic()>{{w}}, w.f.check, core::JudgeBody<T>{w});
  });
}

template <class E, class T>
void cover(E& ex, const core::Frame<T>& w) {
  ex.for_each((std::uint64_t{w.particles} + 31u) / 32u, KindBitsBody<T>{w, tag_solid, w.f.solid_bits});
  ex.for_each(w.particles, CoverBody<T>{w});
}

template <class E, class T>
void wetted(E& ex, const core::Frame<T>& w) {
  ex.for_each((std::uint64_t{w.particles} + 31u) / 32u, KindBitsBody<T>{w, 0u, w.f.liquid_bits});
  ex.select(w.particles, WettedBody<T>{w}, w.f.wetted);
}

template <class E, class T>
void unstrained(E& ex, const core::Frame<T>& w) {
  spatial::with_periods(
      w, [&](auto periodic) { ex.gather_listed(w.particles, w.f.wetted, UnstrainedBody<T, periodic()>{w}); });
}

template <class E, class T>
void seep(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.vertices, ClearRimsBody<T>{w});
  spatial::with_periods(w, [&](auto periodic) { ex.gather_adding(w.particles, SeepBody<T, periodic()>{w}); });
}

template <class E, class T>
void gaps(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.vertices, ClearGapsBody<T>{w});
  spatial::with_periods(w, [&](auto periodic) { ex.gather_adding(w.particles, GapBody<T, periodic()>{w}); });
  ex.for_each(w.particles, GapPushBody<T>{w});
}

template <class E, class T>
void reaction(E& ex, const core::Frame<T>& frame) {
  const core::Frame<T> w = without_viscosity(frame);
  spatial::with_periods(w, [&](auto periodic) {
    using Body = ReactionBody<T, periodic()>;
    const auto sweep = [&](const auto& body) {
      spatial::sweep_listed<periodic()>(ex, w.particles, w.f.wetted, body);
    };
    if (w.f.isotropic_diagonal == nullptr) return sweep(Body{{w}});
    sweep(WithIsotropy<T, Body, periodic()>{{{w}}, {w}});
  });
}

/// Velocity from the beginning of the sub-step to its end, as an acceleration: viscosity in viscous_supersteps super-steps of
/// viscous_stages stages, and what the stages before gave.
template <class E, class T>
void diffuse(E& ex, const core::Frame<T>& frame) {
  core::Frame<T> w = frame;
  ex.for_each(w.particles, ViscousOperandsBody<T>{w});
  const core::SuperSteps plan{w.viscous_stages, w.viscous_supersteps, w.viscous_dt};
  spatial::with_periods(w, [&](auto periodic) {
    core::super_steps(ex, plan, [&](const physics::StageFactors<double>& stage) {
      const auto sweep = [&](auto first) {
        using Body = ViscousStageBody<T, periodic(), first()>;
        spatial::sweep_adding<periodic()>(ex, w.particles, Body{w, stage.template as<T>()});
      };
      if (stage.first) sweep(std::true_type{});
      else sweep(std::false_type{});
      std::swap(w.f.velocity_increment, w.f.velocity_increment_old);
      std::swap(w.f.viscous_operand, w.f.viscous_operand_next);
    });
  });
}

/// stage(alone, periodic): whether a particle of liquid meets no solid and no other liquid, and whether the domain has periods.
template <class T, class Stage>
void with_company(const core::Frame<T>& w, const Stage& stage) {
  spatial::with_periods(w, [&](auto periodic) {
    if (w.one_liquid && !w.solids) stage(std::true_type{}, periodic);
    else stage(std::false_type{}, periodic);
  });
}

template <class E, class T>
void tension(E& ex, const core::Frame<T>& w) {
  with_company(w, [&](auto alone, auto periodic) {
    spatial::sweep<periodic()>(ex, w.particles, SurfaceStressBody<T, alone(), periodic()>{w});
  });
}

template <class E, class T>
void cohere(E& ex, const core::Frame<T>& w) {
  with_company(w, [&](auto alone, auto periodic) {
    spatial::sweep<periodic()>(ex, w.particles, CohereBody<T, alone(), periodic()>{{w}});
    if constexpr (!alone())
      if (w.f.liquid_bits != nullptr)
        spatial::sweep_listed<periodic()>(ex, w.particles, w.f.wetted, AdhereBody<T, periodic()>{{w}});
  });
}

template <class E, class T>
void arrangement(E& ex, const core::Frame<T>& w) {
  spatial::with_periods(w, [&](auto periodic) {
    spatial::sweep<periodic()>(ex, w.particles, ArrangementBody<T, periodic()>{w});
  });
}

template <class E, class T>
void shift(E& ex, const core::Frame<T>& w) {
  spatial::with_periods(
      w, [&](auto periodic) { spatial::sweep<periodic()>(ex, w.particles, ShiftBody<T, periodic()>{w}); });
}

}  // namespace sph
}  // namespace v0
}  // namespace meltsim
