// SPDX-License-Identifier: Apache-2.0
// Kernels of probes: averages of fields at points, and the height of liquid along a line. Formulas: meltsim/physics/sampling.hpp.
#pragma once

#include "exec/lane_positions.hpp"
#include "frame/frame.hpp"
#include "meltsim/physics/sampling.hpp"
#include "shared/at_rest.hpp"
#include "shared/solute_state.hpp"
#include "spatial/around.hpp"

namespace meltsim {
inline namespace v0 {
namespace sampling {

using core::Frame;
using core::ProbeRow;

/// Whether a probe is due in this sub-step; World::sample is at once.
template <class T>
MELTSIM_HD bool is_due(const Frame<T>& w, std::uint32_t probe) {
  return w.probes.keys != nullptr || (w.f.clock->sampled >> probe & 1u) != 0u;
}

/// Where its values of this sub-step begin: behind those of the probes before it that are due as well.
template <class T>
MELTSIM_HD double* values_of(const Frame<T>& w, std::uint32_t probe) {
  if (w.probes.keys != nullptr) return w.probes.values;
  std::uint64_t at = w.f.clock->sample_at;
  for (std::uint32_t other = 0; other < probe; ++other)
    if (is_due(w, other)) at += w.probes.rows[other].values;
  return w.probes.values + at;
}

/// Values of a particle that are averaged: only the requested fields, because each costs a load. In a World that
/// went back to an earlier state, density and pressure are in the order of the sub-step that halted.
template <class T>
MELTSIM_HD physics::SampledParticle particle_at(const Frame<T>& w, std::uint32_t slot, std::uint32_t tag,
                                                T volume, std::uint32_t fields) {
  using physics::SampleField;
  const auto asked = [fields](SampleField a, SampleField b, SampleField c) {
    return (fields & (physics::sample_bit(a) | physics::sample_bit(b) | physics::sample_bit(c))) != 0u;
  };
  std::uint32_t derived = slot;
  if (w.probes.derived_slot != nullptr) derived = w.probes.derived_slot[w.f.id[slot]];
  const Vec4<T> v = w.f.velocity[slot];
  const T term = w.probes.terms != nullptr ? w.probes.terms[derived].w : v.w;
  double phi = 0, h = 0, mass = 0;
  if (w.f.density != nullptr && asked(SampleField::density, SampleField::pressure, SampleField::pressure))
    phi = static_cast<double>(w.f.density[derived]);
  if (asked(SampleField::temperature, SampleField::liquid_fraction, SampleField::density)) {
    mass = static_cast<double>(w.f.mass[slot]);
    if (asked(SampleField::temperature, SampleField::liquid_fraction, SampleField::temperature))
      h = core::enthalpy_at(w, slot) / mass;
  }
  physics::SampledParticle p =
      physics::sampled(w.f.materials[material_of(tag)], is_fluid(tag), h, mass, static_cast<double>(volume),
                       phi, static_cast<double>(term), cast<double>(xyz(v)), fields);
  for (std::uint32_t k = 0; k < w.species; ++k)
    if ((fields & physics::sample_bit(physics::solute_field(k))) != 0u)
      p.solute[k] = core::fraction_at(w, k, slot);
  if (is_fluid(tag) && asked(SampleField::pressure, SampleField::pressure, SampleField::pressure))
    p.pressure += static_cast<double>(core::at_rest(w, xyz(w.f.position[slot])).pressure);
  return p;
}

/// Averages at point i: the share k of what is around it.
template <bool Tree, class T>
MELTSIM_HD physics::SampleSums point_part(const Frame<T>& w, std::uint64_t i, std::uint32_t k,
                                          std::uint32_t parts) {
  physics::SampleSums s;
  const core::ProbePoint<T> point = w.probes.points[i];
  if (!is_due(w, point.probe)) return s;
  const std::uint32_t fields = w.probes.rows[point.probe].fields;
  spatial::for_each_around<Tree>(
      w, point.x, k, parts, [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>&, T r2) {
        const std::uint32_t tag = w.f.tag[j];
        if (is_removed(tag)) return;
        const auto weight = static_cast<double>(physics::kernel_shape(w.c.kernel, std::sqrt(r2)));
        s.add(weight, particle_at(w, j, tag, xj.w, fields));
      });
  return s;
}
template <class T>
MELTSIM_HD void finish_point(const Frame<T>& w, std::uint64_t i, const physics::SampleSums& s) {
  const std::uint32_t probe = w.probes.points[i].probe;
  if (!is_due(w, probe)) return;
  const ProbeRow& row = w.probes.rows[probe];
  double* to = values_of(w, probe) + (i - row.first) * row.width;
  for (std::uint32_t f = 0; f < row.listed; ++f)
    for (std::uint32_t c = 0; c < physics::sample_width(row.field[f]); ++c)
      *to++ = physics::sampled_value(s, row.field[f], c);
}

/// Amount of liquid at height i of the gauges, likewise.
template <bool Tree, class T>
MELTSIM_HD physics::FillSums<T> height_part(const Frame<T>& w, std::uint64_t i, std::uint32_t k,
                                            std::uint32_t parts) {
  physics::FillSums<T> s;
  const core::ProbePoint<T> point = w.probes.heights[i];
  if (!is_due(w, point.probe)) return s;
  const auto walls = physics::wall_view(w.c.walls, point.x);
  spatial::for_each_around<Tree>(w, point.x, k, parts,
                                 [&](std::uint32_t j, const Vec4<T>& xj, const Vec3<T>& d, T r2) {
                                   const std::uint32_t tag = w.f.tag[j];
                                   if (is_removed(tag)) return;
                                   s.add(w.c.kernel, walls, is_fluid(tag), xj.w, d, r2);
                                 });
  return s;
}
template <class T>
MELTSIM_HD void finish_height(const Frame<T>& w, std::uint64_t i, const physics::FillSums<T>& s) {
  if (is_due(w, w.probes.heights[i].probe)) w.probes.profile[i] = physics::liquid_excess(w.c.kernel, s);
}

/// Parts of a sum over what is around a point: points are few, so many threads share one. An executor that adds up one
/// after another takes it in one, where its bits need not be those of a GPU. Of
/// more than 14 the sums do not fit into the shared memory of a block (48 KiB).
template <class E>
inline constexpr std::uint32_t sample_parts = core::runs_lanes<E> ? 1u : 14u;

/// Averages at one point.
template <class T, bool Tree, std::uint32_t Parts>
struct PointBody {
  Frame<T> w;
  static constexpr std::uint32_t listed_parts = Parts;
  using Sum = physics::SampleSums;
  MELTSIM_HD bool wanted(std::uint64_t) const { return true; }
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    return point_part<Tree>(w, i, k, parts);
  }
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const { finish_point(w, i, s); }
};

/// What is around a point, or at a height of a gauge: one of the two.
template <class T>
struct AroundSums {
  bool height = false;
  union {
    physics::SampleSums fields;
    physics::FillSums<T> fill;
  };
  MELTSIM_HD AroundSums() : fields{} {}
  MELTSIM_HD explicit AroundSums(const physics::SampleSums& s) : fields(s) {}
  MELTSIM_HD explicit AroundSums(const physics::FillSums<T>& s) : height(true), fill(s) {}
  MELTSIM_HD void add(const AroundSums& o) {
    if (height) fill.add(o.fill);
    else fields.add(o.fields);
  }
};

/// Points, then heights of gauges: in one kernel, as each takes as long as it takes to start.
template <class T, bool Tree, std::uint32_t Parts>
struct AroundBody {
  Frame<T> w;
  static constexpr std::uint32_t listed_parts = Parts;
  using Sum = AroundSums<T>;
  MELTSIM_HD bool wanted(std::uint64_t) const { return true; }
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    const std::uint64_t points = w.probes.point_count;
    return i < points ? Sum(point_part<Tree>(w, i, k, parts))
                      : Sum(height_part<Tree>(w, i - points, k, parts));
  }
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const {
    const std::uint64_t points = w.probes.point_count;
    if (i < points) finish_point(w, i, s.fields);
    else finish_height(w, i - points, s.fill);
  }
};

/// The level that a gauge reads.
template <class T>
struct GaugeLevelBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const core::ProbeLine line = w.probes.lines[i];
    if (!is_due(w, line.probe)) return;
    values_of(w, line.probe)[i - w.probes.rows[line.probe].first] =
        physics::level_of(w.probes.profile + line.first, line.heights, line.lowest, line.step);
  }
};

/// The same, sums included, by one thread per gauge: from the top down, as no value below the level counts.
template <class T, bool Tree, std::uint32_t Parts>
struct LookDownBody {
  Frame<T> w;
  using Sum = physics::FillSums<T>;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const core::ProbeLine line = w.probes.lines[i];
    if (!is_due(w, line.probe)) return;
    bool liquid = false;
    for (std::uint32_t at = line.first + line.heights; at-- > line.first && !liquid;) {
      Sum sum = height_part<Tree>(w, at, 0u, Parts);
      for (std::uint32_t k = 1; k < Parts; ++k) sum.add(height_part<Tree>(w, at, k, Parts));
      finish_height(w, at, sum);
      liquid = w.probes.profile[at] > T(0);
    }
    GaugeLevelBody<T>{w}(i);
  }
};

/// Cell of a particle as it is between sub-steps; one call per id, so that a stable sort leaves ids ascending in a cell.
template <class T>
struct KeyBody {
  Frame<T> w;
  std::uint64_t* keys;
  std::uint32_t* slots;
  MELTSIM_HD void operator()(std::uint64_t id) const {
    const std::uint32_t slot = w.f.slot_of_id[id];
    slots[id] = slot;
    const spatial::CellPlace at = spatial::place_at(w.grid, xyz(w.f.position[slot]));
    keys[id] = is_removed(w.f.tag[slot]) ? core::removed_key
                                         : spatial::cell_key<std::uint64_t>(w.grid, at.x, at.y, at.z);
  }
};

/// Where particles were in the order of the sub-step that halted.
template <class T>
struct DerivedSlotBody {
  Frame<T> w;
  std::uint32_t* to;
  MELTSIM_HD void operator()(std::uint64_t i) const { to[w.before.id[i]] = static_cast<std::uint32_t>(i); }
};

}  // namespace sampling
}  // namespace v0
}  // namespace meltsim
