// SPDX-License-Identifier: Apache-2.0
// Kernels of a reading: sums over the state, sums over pieces, levels of the liquid, particles by id.
#pragma once

#include "frame/lattice.hpp"
#include "frame/reading_frame.hpp"
#include "meltsim/physics/energy.hpp"
#include "meltsim/physics/immersion.hpp"
#include "shared/at_rest.hpp"
#include "spatial/rows.hpp"

namespace meltsim {
inline namespace v0 {
namespace reading {

using core::Column;
using core::LevelSums;
using core::none;
using core::ReadingFrame;

/// Copies the status and, if asked for, resets the extremes. Runs in a halted World, too.
template <class T>
struct StatusBody {
  ReadingFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t) const {
    core::WorldStatus& s = *w.s.f.status;
    w.head->status = s;
    w.head->pieces = 0;
    w.head->complete = s.halted == 0u || w.rolled_back != 0u ? 1u : 0u;
    if (w.events_taken != 0u && w.head->complete != 0u) *w.event_head = *w.s.f.event_head;
    if (w.clears == 0u) return;
    s.max_speed = s.max_density = 0;
    s.courant_exceeded = 0u;
    s.heat_bound_exceeded = 0;
    s.viscous_bound_exceeded = 0;
    s.solute_bound_exceeded = 0;
  }
};

/// Copies the impulses on a body since the last reading and a row of the ring of events, and resets them.
template <class T>
struct TakeRecordsBody {
  ReadingFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    if (k < w.bodies_taken) {
      core::BodyForceTotals& t = w.s.f.body_forces[k];
      core::ForcesRow& to = w.forces[k];
      to.totals = t;
      if (w.s.f.body_motion != nullptr) to.motion = w.s.f.body_motion[k].motion;
      core::BodyForceTotals none;
      none.center = t.center;
      t = none;
    }
    if (k >= w.events_taken) return;
    if (k < w.event_head->written) w.events[k] = w.s.f.events[k];
    if (k == 0) *w.s.f.event_head = core::EventHead{};  // status() has copied it
  }
};

/// Temperature of the particle at slot i [degrees C].
template <class T>
MELTSIM_HD double temperature_at(const core::Frame<T>& w, std::uint64_t i) {
  return physics::temperature_of(w.f.materials[material_of(w.f.tag[i])],
                                 core::enthalpy_at(w, i) / static_cast<double>(w.f.mass[i]));
}

/// Contribution of a particle to the ledger.
template <class T>
struct LedgerBody {
  ReadingFrame<T> w;
  MELTSIM_HD core::LedgerSums operator()(std::uint64_t i) const {
    core::LedgerSums s;
    const std::uint32_t tag = w.s.f.tag[i];
    if (is_removed(tag)) return s;
    const auto mass = static_cast<double>(w.s.f.mass[i]);
    const double enthalpy = core::enthalpy_at(w.s, i);
    const Vec3<double> x = cast<double>(xyz(w.s.f.position[i])), v = cast<double>(xyz(w.s.f.velocity[i]));
    s.mass = mass;
    s.momentum = v * mass;
    s.angular_momentum = cross(x, v) * mass;
    s.kinetic = physics::kinetic_energy(mass, v);
    s.potential = physics::potential_energy(mass, w.gravity, x);
    s.thermal = enthalpy;
    const auto& m = w.s.f.materials[material_of(tag)];
    s.latent = physics::latent_energy(m, mass, enthalpy);
    s.latent_max = physics::latent_energy_of_liquid(m, mass);
    return s;
  }
};

/// Contents of species of a particle.
template <class T>
struct ContentsBody {
  ReadingFrame<T> w;
  MELTSIM_HD core::ContentSums operator()(std::uint64_t i) const {
    core::ContentSums s;
    const std::uint32_t tag = w.s.f.tag[i];
    if (is_removed(tag)) return s;
    const auto mass = static_cast<double>(w.s.f.mass[i]);
    for (std::uint32_t k = 0; k < w.s.species; ++k) {
      const auto& species = w.s.f.species[k];
      const double content = core::solute_at(w.s, k, i);
      const bool of_body = is_solid(tag) && material_of(tag) == species.solute;
      s.solute[k] = content;
      s.dissolved[k] = content - physics::undissolved(species, content, mass, of_body);
      s.solution += species.heat_of_solution * s.dissolved[k];
    }
    return s;
  }
};

template <class T>
struct ExtentsBody {
  ReadingFrame<T> w;
  MELTSIM_HD core::ExtentSums operator()(std::uint64_t i) const {
    core::ExtentSums e;
    const std::uint32_t tag = w.s.f.tag[i];
    if (is_removed(tag)) return e;
    const auto mass = static_cast<double>(w.s.f.mass[i]);
    const double temperature = temperature_at(w.s, i);
    e.coldest = e.hottest = temperature;
    e.heat = mass * temperature;
    e.speed = length(cast<double>(xyz(w.s.f.velocity[i])));
    if (!is_solid(tag)) return e;
    e.solid_mass = mass;
    e.solid_moment = cast<double>(xyz(w.s.f.position[i])) * mass;
    return e;
  }
};

// --- pieces -----------------------------------------------------------------------------------------------

template <class T>
MELTSIM_HD std::uint32_t slot_of_vertex(const core::Frame<T>& w, std::uint64_t v) {
  return w.f.slot_of_id[w.f.vertex_id[v]];
}

/// Whether a vertex holds a solid particle.
template <class T>
MELTSIM_HD bool is_live(const core::Frame<T>& w, std::uint64_t v) {
  return w.f.vertex_state[v] == core::vertex_live && is_solid(w.f.tag[slot_of_vertex(w, v)]);
}

/// Marks the label of every piece that has a live vertex.
template <class T>
struct PresentBody {
  ReadingFrame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t v, const Add& add) const {
    if (!is_live(w.s, v)) return;
    const std::uint32_t label = w.s.f.vertex_piece[v];
    add.set(&w.is_label[label / 32u], 1u << (label % 32u));
  }
};

/// 1: there is a piece with this label.
struct LabelCountBody {
  const std::uint32_t* is_label;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t v) const { return (is_label[v / 32u] >> (v % 32u)) & 1u; }
};

template <class T>
struct PieceCountBody {
  ReadingFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t) const {
    w.head->pieces = w.piece_of[w.s.vertices - 1u];
    const core::ExtentSums& e = w.head->extents;
    const double scale = std::ldexp(w.largest_mass, -w.sum_bits), momentum = scale * e.speed,
                 first = scale * w.size;
    const double hottest = maximum(std::fabs(e.coldest), std::fabs(e.hottest));
    w.head->units.sums = core::sum_units(scale, momentum, momentum * w.size, first, first * w.size);
    w.head->units.heat = core::sum_units(scale * hottest, 0, 0, 0, 0).mass;
  }
};

/// Row of the piece of a live vertex; none if it is not live or the piece has no room.
template <class T>
MELTSIM_HD std::uint32_t row_of(const ReadingFrame<T>& w, std::uint64_t v) {
  if (!is_live(w.s, v)) return none;
  const std::uint32_t row = w.piece_of[w.s.f.vertex_piece[v]] - 1u;
  return row < w.piece_room ? row : none;
}

template <class T>
struct ClearRowBody {
  ReadingFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t row) const {
    if (row >= w.head->pieces) return;
    w.totals[row] = core::PieceTotals{};
    core::PieceRow r;
    r.first = none;
    for (int axis = 0; axis < 3; ++axis) r.low[axis] = r.high[axis] = none;
    w.rows[row] = r;
  }
};

template <class T>
struct FirstVertexBody {
  ReadingFrame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t v, const Add& add) const {
    const std::uint32_t row = row_of(w, v);
    if (row != none) add.lower(&w.rows[row].first, static_cast<std::uint32_t>(v));
  }
};

template <class T>
struct DescribeRowBody {
  ReadingFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t n) const {
    if (n >= w.head->pieces) return;
    core::PieceRow& r = w.rows[n];
    r.label = w.s.f.vertex_piece[r.first];
    r.body = w.s.f.vertex_body[r.first];
    r.at = cast<double>(xyz(w.s.f.position[slot_of_vertex(w.s, r.first)]));
    if (w.s.f.region_rotation == nullptr) return;
    const Quat<T> q = w.s.f.region_rotation[r.first];
    r.turn = {static_cast<double>(q.w), static_cast<double>(q.x), static_cast<double>(q.y),
              static_cast<double>(q.z)};
  }
};

/// Position of the particle at slot i relative to the first of its piece [m]; a piece that is stretched beyond all
/// measure is cut short, so that no sum overflows.
template <class T>
MELTSIM_HD Vec3<double> offset_in_piece(const ReadingFrame<T>& w, std::uint32_t row, std::uint32_t slot) {
  const Vec3<T> at = cast<T>(w.rows[row].at);
  const Vec3<double> d = cast<double>(spatial::separation(w.s.grid, xyz(w.s.f.position[slot]), at));
  const auto turn = [&w](std::uint64_t v) { return core::lattice_turn(w.s, v); };
  const std::uint32_t v = w.s.f.vertex_of_id[w.s.f.id[slot]];
  const Vec3<double> u = core::offset_in_piece(w.s, d, v, w.rows[row].first, turn);
  return {clamp(u.x, -w.size, w.size), clamp(u.y, -w.size, w.size), clamp(u.z, -w.size, w.size)};
}

template <class T>
struct BoundsBody {
  ReadingFrame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t v, const Add& add) const {
    const std::uint32_t row = row_of(w, v);
    if (row == none) return;
    const Vec3<double> u = offset_in_piece(w, row, slot_of_vertex(w.s, v));
    core::PieceRow& r = w.rows[row];
    const double x[3] = {u.x, u.y, u.z};
    for (int axis = 0; axis < 3; ++axis) {
      add.lower(&r.low[axis], core::ordered_below(x[axis]));
      add.lower(&r.high[axis], core::ordered_below(-x[axis]));
    }
  }
};

/// Place of a vertex in the lattice as built, relative to the first of its piece [m].
template <class T>
MELTSIM_HD Vec3<double> rest_offset(const ReadingFrame<T>& w, std::uint64_t v, std::uint32_t first) {
  const std::uint32_t body = w.s.f.vertex_body[v];
  const core::BodyRow b = w.s.f.bodies[body];
  const auto place = [&](std::uint64_t vertex) {
    const std::uint32_t site = w.s.f.vertex_site[vertex] - w.body_origin[body], layer = site % b.stride_z;
    return Vec3<double>{static_cast<double>(layer % b.stride_y), static_cast<double>(layer / b.stride_y),
                        static_cast<double>(site / b.stride_z)};
  };
  return (place(v) - place(first)) * static_cast<double>(w.s.c.spacing);
}

// --- level of the liquid ----------------------------------------------------------------------------------

/// Index of a column along one axis.
MELTSIM_HD std::int32_t column_along(double x, double low, double side, std::int32_t n,
                                     std::uint32_t repeats) {
  const double k = std::floor((x - low) / side);
  if (repeats == 0u) return static_cast<std::int32_t>(clamp(k, 0.0, static_cast<double>(n - 1)));
  return static_cast<std::int32_t>(k - std::floor(k / n) * n);
}

/// Height and column of a particle.
struct Stand {
  double height = 0;
  std::int32_t i = 0, j = 0;
};
template <class T>
MELTSIM_HD Stand stand_of(const ReadingFrame<T>& w, std::uint64_t slot) {
  const core::ColumnGrid& g = w.grid;
  const Vec3<double> x = cast<double>(xyz(w.s.f.position[slot]));
  return {dot(x, g.up), column_along(dot(x, g.a), g.low_a, g.side, g.na, g.repeats),
          column_along(dot(x, g.b), g.low_b, g.side, g.nb, g.repeats)};
}

template <class T>
struct ClearColumnBody {
  ReadingFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t c) const { w.columns[c] = Column{}; }
};

template <class T>
struct ColumnTopBody {
  ReadingFrame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t slot, const Add& add) const {
    const std::uint32_t tag = w.s.f.tag[slot];
    if (is_removed(tag)) return;
    const Stand p = stand_of(w, slot);
    Column& c = w.columns[p.j * w.grid.na + p.i];
    if (is_solid(tag)) add.set(&c.solid, 1u);
    else add.lower(&c.top, core::ordered_below(-p.height));
  }
};

inline constexpr std::uint32_t no_top = 0xffffffffu;
MELTSIM_HD double top_of(const Column& c) { return -static_cast<double>(core::unordered(c.top)); }

template <class T>
struct ColumnVolumeBody {
  ReadingFrame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t slot, const Add& add) const {
    const std::uint32_t tag = w.s.f.tag[slot];
    if (is_removed(tag)) return;
    const Stand p = stand_of(w, slot);
    Column& c = w.columns[p.j * w.grid.na + p.i];
    if (c.top == no_top) return;
    const auto dx = static_cast<double>(w.s.c.spacing);
    const double top = top_of(c), base = physics::column_base(top, w.grid.floor, dx);
    if (is_solid(tag)) {
      // A column below a body ends where that begins, which is no level.
      if (p.height > base - dx && p.height < top + 1.5 * dx) add.set(&c.solid, 2u);
      return;
    }
    const double volume = static_cast<double>(w.s.f.position[slot].w) / (dx * dx * dx);
    add(&c.volume, static_cast<std::int64_t>(
                       std::rint(volume * physics::share_above(p.height, base, dx) * Column::units)));
  }
};

/// Length of a column along an axis: less at the far face of the domain.
MELTSIM_HD double column_length(std::int32_t k, double side, double extent) {
  return extent > 0 ? minimum(side, extent - k * side) : side;
}

/// Level of one column. Liquid keeps more than a spacing from solids, which lowers the level of columns beside them; these
/// get a small weight, so that they count only if there are no others.
template <class T>
struct ColumnLevelBody {
  ReadingFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t n) const {
    const core::ColumnGrid& g = w.grid;
    const auto i = static_cast<std::int32_t>(n % static_cast<std::uint64_t>(g.na)),
               j = static_cast<std::int32_t>(n / static_cast<std::uint64_t>(g.na));
    const Column c = w.columns[n];
    LevelSums s;
    bool beside = false;
    for (std::int32_t k = maximum(j - 1, 0); k <= minimum(j + 1, g.nb - 1); ++k)
      for (std::int32_t l = maximum(i - 1, 0); l <= minimum(i + 1, g.na - 1); ++l)
        beside = beside || (w.columns[k * g.na + l].solid & 2u) != 0u;
    const double weight = beside ? 1.0 / 64 : 1.0;
    if (c.top == no_top) {
      s.dry = c.solid == 0u ? weight : 0.0;
    } else if ((c.solid & 2u) == 0u) {
      const auto dx = static_cast<double>(w.s.c.spacing);
      const double top = top_of(c), base = physics::column_base(top, g.floor, dx);
      const double area = column_length(i, g.side, g.extent_a) * column_length(j, g.side, g.extent_b);
      const double volume = static_cast<double>(c.volume) / Column::units * (dx * dx * dx);
      if (physics::column_fill(top, base, volume, area, dx) >= physics::least_fill) {
        s.wet = weight;
        s.level = weight * physics::column_level(base, volume, area);
      }
    }
    w.levels[n] = s;
  }
};

/// Columns of a level of squares along an axis.
MELTSIM_HD std::int32_t squares(std::int32_t n, std::int32_t level) { return ((n - 1) >> level) + 1; }

/// Four squares in one.
template <class T>
struct CoarserBody {
  ReadingFrame<T> w;
  const LevelSums* from;
  LevelSums* to;
  std::int32_t na, nb;  ///< of `from`
  MELTSIM_HD void operator()(std::uint64_t n) const {
    const std::int32_t wide = squares(na, 1);
    const auto i = 2 * static_cast<std::int32_t>(n % static_cast<std::uint64_t>(wide)),
               j = 2 * static_cast<std::int32_t>(n / static_cast<std::uint64_t>(wide));
    LevelSums s;
    for (std::int32_t k = j; k < minimum(j + 2, nb); ++k)
      for (std::int32_t l = i; l < minimum(i + 2, na); ++l) {
        const LevelSums o = from[k * na + l];
        s.wet += o.wet;
        s.dry += o.dry;
        s.level += o.level;
      }
    to[n] = s;
  }
};

/// Share of a solid particle below the level of the liquid. The level is the mean over the smallest square of columns around
/// the particle whose weights add up to one.
template <class T>
MELTSIM_HD double submerged_share(const ReadingFrame<T>& w, std::uint32_t slot) {
  const core::ColumnGrid& g = w.grid;
  const Stand p = stand_of(w, slot);
  const LevelSums* squares_of = w.levels;
  LevelSums s;
  for (std::int32_t level = 0; level < g.levels; ++level) {
    const std::int32_t na = squares(g.na, level), nb = squares(g.nb, level), i = p.i >> level,
                       j = p.j >> level;
    s = LevelSums{};
    for (std::int32_t k = maximum(j - 1, 0); k <= minimum(j + 1, nb - 1); ++k)
      for (std::int32_t l = maximum(i - 1, 0); l <= minimum(i + 1, na - 1); ++l) {
        const LevelSums o = squares_of[k * na + l];
        s.wet += o.wet;
        s.dry += o.dry;
        s.level += o.level;
      }
    if (s.wet + s.dry >= 1.0) break;
    squares_of += static_cast<std::int64_t>(na) * nb;
  }
  if (!(s.wet > 0.0) || s.wet < s.dry) return 0;
  return physics::share_below(p.height, s.level / s.wet, static_cast<double>(w.s.c.spacing));
}

/// Contribution of a vertex to its piece, in fixed point.
template <class T>
struct PieceTotalsBody {
  ReadingFrame<T> w;
  using Sum = core::PieceTotals;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t v, Sum& s) const {
    const std::uint32_t row = row_of(w, v);
    if (row == none) return none;
    const std::uint32_t slot = slot_of_vertex(w.s, v);
    const auto mass = static_cast<double>(w.s.f.mass[slot]);
    const Vec3<double> u = offset_in_piece(w, row, slot), q = rest_offset(w, v, w.rows[row].first);
    const Vec3<double> p = cast<double>(xyz(w.s.f.velocity[slot])) * mass, spin = cross(u, p);
    const core::SumUnits& unit = w.head->units.sums;
    const auto count = [](double value, const core::SumUnit& of) {
      return static_cast<std::int64_t>(std::rint(value * of.per));
    };
    s.count = 1;
    s.mass = count(mass, unit.mass);
    const double x[3] = {u.x, u.y, u.z}, y[3] = {q.x, q.y, q.z}, m[3] = {p.x, p.y, p.z},
                 l[3] = {spin.x, spin.y, spin.z};
    for (int k = 0; k < 3; ++k) {
      s.momentum[k] = count(m[k], unit.momentum);
      s.spin[k] = count(l[k], unit.spin);
      s.first[k] = count(mass * x[k], unit.first);
      s.rest[k] = count(mass * y[k], unit.first);
      for (int n = 0; n < 3; ++n) s.turned[3 * k + n] = count(mass * x[k] * y[n], unit.second);
      s.second[k] = count(mass * x[k] * x[k], unit.second);
      s.second[3 + k] = count(mass * x[(k + 1) % 3] * x[(k + 2) % 3], unit.second);
    }
    s.heat = count(mass * temperature_at(w.s, slot), w.head->units.heat);
    s.submerged =
        static_cast<std::int64_t>(std::rint(submerged_share(w, slot) * core::PieceTotals::submerged_units));
    return row;
  }
};

// --- particles by id --------------------------------------------------------------------------------------

/// Volume fraction and P/phi^2 of a restored state, in the order of the sub-step that computed them.
template <class T>
struct PackBeforeBody {
  ReadingFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t id = w.s.before.id[i];
    if (id >= w.s.born) return;
    w.p.density[id] = static_cast<float>(w.s.f.density[i]);
    w.p.pressure[id] = static_cast<float>(w.s.before.velocity[i].w);
  }
};

template <class T>
struct PackBody {
  ReadingFrame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t id = w.s.f.id[i];
    if (id >= w.s.born) return;
    const std::uint32_t tag = w.s.f.tag[i];
    w.p.tag[id] = tag;
    const Vec4<T> x = w.s.f.position[i];
    w.p.position[id] = cast<float>(xyz(x));
    w.p.velocity[id] = cast<float>(xyz(w.s.f.velocity[i]));
    for (std::uint32_t k = 0; k < w.s.species && w.s.f.solute != nullptr; ++k)
      w.p.solute[k][id] = static_cast<float>(core::solute_at(w.s, k, i) / static_cast<double>(w.s.f.mass[i]));
    if (is_removed(tag)) {
      if (w.p.color != nullptr) w.p.color[id] = 0u;
      w.p.temperature[id] = w.p.fraction[id] = w.p.density[id] = w.p.pressure[id] = 0.0F;
      w.p.piece[id] = 0u;
      return;
    }
    const auto& m = w.s.f.materials[material_of(tag)];
    const auto mass = static_cast<double>(w.s.f.mass[i]);
    const double h = core::enthalpy_at(w.s, i) / mass;
    w.p.temperature[id] = static_cast<float>(physics::temperature_of(m, h));
    w.p.fraction[id] = m.plateau != 0u ? static_cast<float>(physics::liquid_fraction(m, h))
                       : is_solid(tag) ? 0.0F
                                       : 1.0F;
    const bool before = w.rolled_back != 0u;
    const float phi = w.has_density == 0u ? 0.0F
                      : before            ? w.p.density[id]
                                          : static_cast<float>(w.s.f.density[i]);
    const float term = w.has_density == 0u ? 0.0F
                       : before            ? w.p.pressure[id]
                                           : static_cast<float>(w.s.f.velocity[i].w);
    w.p.density[id] = is_solid(tag)
                          ? static_cast<float>(m.density)
                          : static_cast<float>(static_cast<double>(phi) * mass / static_cast<double>(x.w));
    w.p.pressure[id] = is_solid(tag) || w.has_density == 0u
                           ? 0.0F
                           : term * phi * phi + static_cast<float>(core::at_rest(w.s, xyz(x)).pressure);
    w.p.piece[id] = is_solid(tag) ? piece_of(id) : 0u;
    if (w.p.color != nullptr) w.p.color[id] = color_of(material_of(tag), w.p.temperature[id]);
  }
  /// Vertex that names the piece of a particle of a body, from 1; 0: none.
  MELTSIM_HD std::uint32_t piece_of(std::uint32_t id) const {
    if (w.s.f.vertex_of_id == nullptr || w.s.f.vertex_piece == nullptr) return 0u;
    const std::uint32_t vertex = w.s.f.vertex_of_id[id];
    return vertex == none ? 0u : w.s.f.vertex_piece[vertex] + 1u;
  }
  MELTSIM_HD std::uint32_t color_of(std::uint32_t material, float temperature) const {
    std::uint32_t entry = material;
    if (w.colors.by == static_cast<std::uint32_t>(ColorBy::temperature)) {
      const float place = (temperature - w.colors.coldest) * w.colors.per_degree;
      entry = static_cast<std::uint32_t>(clamp(place, 0.0F, 255.0F));
    }
    return w.colors.table[entry];
  }
};

}  // namespace reading
}  // namespace v0
}  // namespace meltsim
