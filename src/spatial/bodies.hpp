// SPDX-License-Identifier: Apache-2.0
// Kernels of the neighbour search: a uniform grid whose occupied cells are the groups. Nothing is sized by
// the number of cells, so the domain may be unbounded or mostly empty.
#pragma once

#include "frame/frame.hpp"
#include "meltsim/physics/integrate.hpp"
#include "meltsim/physics/liquid_properties.hpp"
#include "meltsim/physics/phase_change.hpp"
#include "spatial/neighbours.hpp"

namespace meltsim {
inline namespace v0 {
namespace spatial {

using core::Frame;
using core::Grid;
using core::none;
using core::Range;
using core::removed_key;

/// One call per former slot. Removed particles come last.
template <class T>
struct CellBody {
  Frame<T> w;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t slot) const {
    return counted_cell(w, w.before.tag[slot], xyz(w.before.position[slot]), xyz(w.before.velocity[slot]));
  }
};

/// The same for cells too many to be counted one by one; one call per id, so that ids ascend within a cell whatever
/// the history was.
template <class T>
struct KeysBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t id) const {
    const std::uint32_t slot = w.f.slot_of_id[id];
    w.f.sort_key[id] =
        cell_of(w, w.before.tag[slot], xyz(w.before.position[slot]), xyz(w.before.velocity[slot]));
    w.f.sort_slot[id] = slot;
  }
};

/// Copies the contents of a particle from its old slot. Returns its volume at rest, from that of as much solvent [m^3].
template <class T>
MELTSIM_HD T carry_contents(const Frame<T>& w, std::uint64_t i, std::uint32_t from, T mass,
                            T solvent_volume) {
  double dissolved = 0, volume = 0;
  for (std::uint32_t k = 0; k < w.species; ++k) {
    const double content = w.before.solute[k * w.capacity + from];
    core::solute_at(w, k, i) = content;
    dissolved += content;
    volume += physics::dissolved_volume(w.f.species[k], content);
  }
  const double share = 1.0 - dissolved / static_cast<double>(mass);
  return static_cast<T>(static_cast<double>(solvent_volume) * share + volume);
}

/// State of slot i from where it was, drifted half a step.
template <class T>
MELTSIM_HD void reorder(const Frame<T>& w, std::uint64_t i, std::uint32_t from, std::uint32_t id) {
  const std::uint32_t tag = w.before.tag[from];
  const Vec4<T> x = w.before.position[from];
  const Vec4<T> v = w.before.velocity[from];
  const T mass = w.before.mass[from];
  const core::MaterialRow<T>& m = w.f.materials[material_of(tag)];
  const bool has_enthalpy = w.f.enthalpy != nullptr;
  double enthalpy = 0;
  if (has_enthalpy) enthalpy = w.before.enthalpy[from];
  else if (m.tables != nullptr) enthalpy = w.f.enthalpy_of_id[id];
  const Vec3<T> moved = is_removed(tag) ? xyz(x) : physics::drift(xyz(x), xyz(v), w.f.clock->half_dt);
  T at_rest = T(0);
  if (!is_solid(tag)) at_rest = mass / physics::rest_density(m, enthalpy / static_cast<double>(mass));
  if (w.f.solute != nullptr) at_rest = carry_contents(w, i, from, mass, at_rest);
  // The volume of a melted particle relaxes to that of its liquid within some acoustic times.
  const T volume =
      is_solid(tag) ? x.w : physics::relaxed_volume(x.w, at_rest, w.f.clock->dt * w.c.volume_rate);
  w.f.position[i] = with_w(moved, volume);
  w.f.velocity[i] = v;
  if (has_enthalpy) w.f.enthalpy[i] = enthalpy;
  w.f.mass[i] = mass;
  w.f.tag[i] = tag;
  w.f.id[i] = id;
#define MELTSIM_COPIED(name) \
  if (w.f.name != nullptr) w.f.name[i] = w.before.name[from];
#include "meltsim/fields.def"
  // A permutation: no two i share an id. Written all over memory, hence only for particles that are looked up later.
  if (core::slot_is_known(w, tag)) w.f.slot_of_id[id] = static_cast<std::uint32_t>(i);
}

/// Takes a particle to its new slot: within a cell ids ascend, whatever the history was, so that sums have one order.
/// Cells hold a few particles; those that were removed stay in any order. Writes where no other call does: ranks within
/// a cell are a permutation.
template <class T>
struct SettleBody {
  static constexpr bool wide = true;
  Frame<T> w;
  using Item = std::uint32_t;
  MELTSIM_HD Item read(std::uint64_t k) const { return w.f.cell_order[k]; }
  MELTSIM_HD void operator()(std::uint64_t k) const { (*this)(k, read(k)); }
  MELTSIM_HD void operator()(std::uint64_t k, Item from) const {
    const std::uint32_t cell = w.f.cell_of[from], id = w.before.id[from];
    auto to = static_cast<std::uint32_t>(k);
    if (cell != w.cells) {
      const std::uint32_t begin = w.f.cell_begin[cell], end = w.f.cell_begin[cell + 1u];
      to = begin;
      for (std::uint32_t other = begin; other < end; ++other)
        to += w.before.id[w.f.cell_order[other]] < id ? 1u : 0u;
    }
    reorder(w, to, from, id);
    w.f.group_of[to] = cell == w.cells ? none : cell;
  }
};

template <class T>
struct ReorderBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint32_t from = w.f.sort_slot_alt[i];
    reorder(w, i, from, w.before.id[from]);
  }
};

/// 1 where a new cell begins.
template <class T>
struct HeadBody {
  Frame<T> w;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t i) const {
    const std::uint64_t key = w.f.sort_key_alt[i];
    return key != removed_key && (i == 0 || w.f.sort_key_alt[i - 1] != key) ? 1u : 0u;
  }
};

/// Turns the running count of heads into group numbers and lists the groups.
template <class T>
struct GroupsBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t i) const {
    const std::uint64_t key = w.f.sort_key_alt[i];
    const bool live = key != removed_key;
    const std::uint32_t count = w.f.group_of[i];  // heads up to and including i
    const bool head = live && (i == 0 || w.f.sort_key_alt[i - 1] != key);
    const bool last = live && (i + 1 == w.particles || w.f.sort_key_alt[i + 1] == removed_key);
    if (head) {
      w.f.group_key[count - 1] = key;
      w.f.group_begin[count - 1] = static_cast<std::uint32_t>(i);
    }
    if (last) {
      w.f.group_begin[count] = static_cast<std::uint32_t>(i) + 1u;
      w.f.status->groups = count;
    }
    if (i == 0 && !live) {
      w.f.group_begin[0] = 0u;
      w.f.status->groups = 0u;
    }
    if (live) w.f.group_of[i] = count - 1u;
    else w.f.group_of[i] = none;
  }
};

/// First of n ascending keys that is not below `key`.
MELTSIM_HD std::uint32_t first_not_below(const std::uint64_t* keys, std::uint32_t n, std::uint64_t key) {
  std::uint32_t lo = 0, hi = n;
  while (lo < hi) {
    const std::uint32_t mid = lo + (hi - lo) / 2u;
    if (keys[mid] < key) lo = mid + 1u;
    else hi = mid;
  }
  return lo;
}

/// The rows of an occupied cell where those are sorted.
template <class T>
struct RangesBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t g) const {
    const std::uint32_t groups = w.f.status->groups;
    if (g >= groups) return;
    const CellPlace place = place_of(w.grid, w.f.group_key[g]);
    for (std::uint32_t r = 0; r < w.grid.rows; ++r) {
      const auto row = cell_row<std::uint64_t>(w.grid, place, r);
      Range slots;
      if (row.cells != 0u) {
        const std::uint32_t a = first_not_below(w.f.group_key, groups, row.first);
        std::uint32_t b = a;
        while (b < groups && w.f.group_key[b] < row.first + row.cells) ++b;  // a few
        slots = Range{w.f.group_begin[a], w.f.group_begin[b]};
      }
      w.f.group_ranges[g * w.grid.rows + r] = slots;
    }
  }
};

/// Which candidates of each row lie within H: every later sweep visits set bits only, 65 instead of some 400.
/// Where there is liquid, sph.density does this in passing.
template <class T, SearchKind kind>
struct NeighboursBody {
  Frame<T> w;
  static constexpr bool shared = true;
  static constexpr bool mirrors = false;
  struct Sum {
    MELTSIM_HD void add(const Sum&) {}
    struct Lanes {
      Sum at(std::size_t) const { return {}; }
      void put(std::size_t, const Sum&) {}
      Sum total() const { return {}; }
    };
  };
  MELTSIM_HD void found(Sum&, T, T) const {}
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    if (w.f.group_of[i] != none)  // not removed
      find_part<kind>(w, i, k, parts, [](const Vec4<T>&, T) {});
    return {};
  }
  MELTSIM_HD void join(std::uint64_t i) const {
    if (w.f.group_of[i] != none) join_words(w, i);
  }
  MELTSIM_HD void more(std::uint64_t, std::uint32_t, std::uint32_t, Sum&) const {}
  MELTSIM_HD void finish(std::uint64_t, const Sum&) const {}
};

}  // namespace spatial
}  // namespace v0
}  // namespace meltsim
