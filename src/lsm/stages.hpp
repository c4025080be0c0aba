// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lsm/rigid_bodies.hpp"
#include "lsm/rows.hpp"

namespace meltsim {
inline namespace v0 {
namespace lsm {

template <class E, class T>
void gather(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.vertices, GatherBody<T>{w});
  if (w.f.ragged != nullptr) ex.select(w.vertices, RaggedBody<T>{w}, w.f.ragged);
}

template <class E, class T>
void normals(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, NormalsBody<T>{w});
  ex.select(w.particles, MeetingBody<T>{w}, w.f.meeting);
}

template <class E, class T>
void loads(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.particles, LoadsBody<T>{w});
}

template <class E, class T>
void contact(E& ex, const core::Frame<T>& w) {
  spatial::with_periods(
      w, [&](auto periodic) { ex.gather_listed(w.particles, w.f.meeting, ContactBody<T, periodic()>{w}); });
}

/// Regions by rows and planes, those not made of planes member by member, in kernels of their own: threads side by
/// side would wait for the longer of the two. Where no body is wide enough for rows, there is no room for them.
template <class E, class T>
void regions(E& ex, const core::Frame<T>& w) {
  if (w.f.region_rows == nullptr) return ex.gather(w.vertices, RegionMotionBody<T>{w});
  ex.for_each(w.vertices, RowSumsBody<T>{w});
  ex.for_each(w.vertices, PlaneSumsBody<T>{w});
  ex.for_each(w.vertices, BoxedRegionMotionBody<T>{w});
  ex.gather_listed(w.vertices, w.f.ragged, RegionMotionBody<T>{w});
}

template <class E, class T>
void goals(E& ex, const core::Frame<T>& w) {
  if (w.f.region_rows == nullptr) return ex.gather(w.vertices, GoalsBody<T>{w});
  ex.for_each(w.vertices, RowGoalsBody<T>{w});
  ex.for_each(w.vertices, PlaneGoalsBody<T>{w});
  ex.for_each(w.vertices, BoxedGoalsBody<T>{w});
  ex.gather_listed(w.vertices, w.f.ragged, GoalsBody<T>{w});
}

template <class E, class T>
void balance(E& ex, const core::Frame<T>& w) {
  ex.sum_by_row(w.vertices, PieceSumsBody<T>{w}, w.f.piece_sums);
  ex.for_each(w.vertices, BalanceBody<T>{w});
}

/// Motion of every rigid piece from the forces so far.
template <class E, class T>
void step_rigid(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.vertices, ClearRigidBody<T>{w});
  ex.sum_by_row(w.vertices, RigidSumsBody<T>{w}, w.f.rigid_sums);
  ex.for_each(w.vertices, RigidStepBody<T>{w});
}

template <class E, class T>
void rigid_shape(E& ex, const core::Frame<T>& w) {
  step_rigid(ex, w);
  ex.for_each(w.vertices, RigidShapeBody<T>{w});
}

/// Once all forces are known.
template <class E, class T>
void rigid(E& ex, const core::Frame<T>& w) {
  step_rigid(ex, w);
  ex.for_each(w.vertices, RigidPlaceBody<T>{w});
}

template <class E, class T>
void rigid_commit(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.vertices, RigidCommitBody<T>{w});
}

template <class E, class T>
void commit(E& ex, const core::Frame<T>& w) {
  ex.for_each(w.vertices, CommitBody<T>{w});
}

}  // namespace lsm
}  // namespace v0
}  // namespace meltsim
