// SPDX-License-Identifier: Apache-2.0
// Kernels of melting, and of the changes of arrayN and of surface flags by melting and freezing. Those after the phase
// change return at once in a step in which nothing melted or froze.
#pragma once

#include "frame/lattice.hpp"
#include "meltsim/physics/phase_change.hpp"
#include "shared/solute_state.hpp"
#include "spatial/neighbours.hpp"

namespace meltsim {
inline namespace v0 {
namespace topology {

using core::BodyRow;
using core::Frame;
using core::none;
using core::row_changed;

using core::vertex_free;
using core::vertex_live;
using core::vertex_melted;

/// Whether liquid froze onto a vertex in this step.
template <class T>
MELTSIM_HD bool was_born(const Frame<T>& w, std::uint32_t v) {
  return w.f.vertex_pick != nullptr && w.f.vertex_pick[v] != none;
}

/// A surface particle of liquid fraction 1, or of a species whose content is down to saturation, leaves the lattice. Mass,
/// momentum, enthalpy and contents do not change, only the tag and, where it is crushed, the rest volume.
template <class T>
struct MeltBody {
  Frame<T> w;
  MELTSIM_HD bool dissolved(std::uint32_t material, std::uint32_t slot) const {
    for (std::uint32_t k = 0; k < w.species; ++k)
      if (w.f.species[k].solute == material)
        return physics::is_dissolved(core::solute_at(w, k, slot), static_cast<double>(w.f.mass[slot]),
                                     core::saturation_at(w, k, slot));
    return false;
  }
  struct Item {
    std::uint32_t state = 0, id = 0;
  };
  MELTSIM_HD Item read(std::uint64_t v) const { return {w.f.vertex_state[v], w.f.vertex_id[v]}; }
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t v, const Add& add) const {
    (*this)(v, read(v), add);
  }
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t v, const Item& item, const Add& add) const {
    if (item.state == vertex_free) return;
    if (item.state == vertex_melted) {  // of the step before
      w.f.vertex_state[v] = vertex_free;
      return;
    }
    const std::uint32_t slot = w.f.slot_of_id[item.id];
    const std::uint32_t tag = w.f.tag[slot];
    const physics::MaterialRow<T>& m = w.f.materials[material_of(tag)];
    const bool surface = (tag & tag_surface) != 0u;
    if (!physics::melts(m, surface, w.f.enthalpy[slot] / static_cast<double>(w.f.mass[slot])) &&
        !(surface && w.species != 0u && dissolved(material_of(tag), slot)))
      return;
    w.f.vertex_state[v] = vertex_melted;
    const T share = physics::born_share(-w.f.velocity[slot].w);
    if (share < T(1)) w.f.position[slot].w *= share;
    w.f.tag[slot] =
        (tag & ~(tag_material_mask | tag_solid | tag_surface | tag_fixed | tag_kinematic)) | m.liquid;
    const std::uint32_t site = w.f.vertex_site[v];
    add.clear(core::site_word(w, site), core::site_bit(site));
    add(&w.f.status->died, 1);
    add(&w.f.status->melted, 1);
  }
};

/// Mask of the live direct neighbours of the live vertex at a site, itself included.
template <class T>
MELTSIM_HD std::uint32_t direct_neighbours(const Frame<T>& w, std::uint32_t site, const BodyRow& b) {
  std::uint32_t mask = 0, bit = 0;
  if ((b.around[0] | b.around[1] | b.around[2]) != 0u) {
    core::each_direct([&](int dx, int dy, int dz) {
      mask |= core::live_sites(w, core::site_beside(site, b, dx, dy, dz), 1) << bit++;
    });
    return mask;
  }
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy, bit += 3)
      mask |= core::live_sites(w, core::site_at(site, b, -1, dy, dz), 3) << bit;
  return mask;
}

/// Live vertices within w of a site along x: bit k of 2w+1 is the one at k - w.
template <class T>
MELTSIM_HD std::uint32_t live_along_x(const Frame<T>& w, std::uint32_t site, int h) {
  return core::live_sites(w, site - static_cast<std::uint32_t>(h), static_cast<std::uint32_t>(2 * h + 1));
}

/// Every live vertex sets its bit; runs when the scene is uploaded, on words that are 0.
template <class T>
struct SiteLiveBody {
  Frame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t v, const Add& add) const {
    const std::uint32_t site = w.f.vertex_site[v];
    if (w.f.vertex_state[v] == vertex_live) add.set(core::site_word(w, site), core::site_bit(site));
  }
};

/// Whether anything melted or froze in this sub-step, or in the one before if this one has not yet reached that stage.
template <class T>
MELTSIM_HD std::uint32_t has_changed(const Frame<T>& w) {
  return w.f.status->died != 0 || w.f.status->born != 0u ? 1u : 0u;
}

/// arrayN: drops melted direct neighbours and takes in frozen ones; fewer than 27 makes an SBP, 27 an IBP. A
/// melted vertex empties its own. Each vertex writes to its own particle and no other.
/// It also stores the live sites in the row about a vertex, melted or not, and whether they changed, for topology.regions.
template <class T>
struct NeighbourMasksBody {
  Frame<T> w;
  struct Item {
    std::uint32_t state = 0, id = 0, site = 0, body = 0, mask = 0, row = 0;
    std::uint32_t changed = 0;
  };
  MELTSIM_HD Item read(std::uint64_t v) const {
    return {w.f.vertex_state[v], w.f.vertex_id[v],      w.f.vertex_site[v],
            w.f.vertex_body[v],  w.f.neighbour_mask[v], w.f.row_live != nullptr ? w.f.row_live[v] : 0u,
            has_changed(w)};
  }
  MELTSIM_HD void operator()(std::uint64_t v) const { (*this)(v, read(v)); }
  MELTSIM_HD void operator()(std::uint64_t v, const Item& item) const {
    if (item.changed == 0u) return;
    const BodyRow b = w.f.bodies[item.body];
    const std::uint32_t mask = item.state == vertex_live ? direct_neighbours(w, item.site, b) : 0u;
    if (w.f.row_live != nullptr) {
      const std::uint32_t live = live_along_x(w, item.site, b.region_half_width);
      w.f.row_live[v] = live | (live != (item.row & ~row_changed) ? row_changed : 0u);
    }
    if (mask == item.mask) return;
    w.f.neighbour_mask[v] = mask;
    if (mask == 0u) return;
    std::uint32_t& tag = w.f.tag[w.f.slot_of_id[item.id]];
    tag = popcount(mask) < core::full_neighbours ? tag | tag_surface : tag & ~tag_surface;
  }
};

/// arrayN of a lattice as built.
template <class T>
struct BuildNeighbourMasksBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    w.f.neighbour_mask[v] = w.f.vertex_state[v] == vertex_live
                                ? direct_neighbours(w, w.f.vertex_site[v], w.f.bodies[w.f.vertex_body[v]])
                                : 0u;
  }
};

}  // namespace topology
}  // namespace v0
}  // namespace meltsim
