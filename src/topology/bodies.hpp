// SPDX-License-Identifier: Apache-2.0
// Kernels of the phase change and of what it does to the lattice: arrayN, arrayR, SBP, pieces.
// All but MeltBody return at once in a step in which nothing melted.
#pragma once

#include "core/lattice.hpp"
#include "meltsim/physics/phase_change.hpp"

namespace meltsim {
inline namespace v0 {
namespace topology {

using core::BodyRow;
using core::Frame;
using core::none;

inline constexpr std::uint32_t vertex_gone = 0, vertex_live = 1, vertex_died = 2;

/// Number of vertices that melted.
struct Count {
  std::uint32_t n = 0;
  MELTSIM_HD static Count combine(Count a, Count b) { return {a.n + b.n}; }
};

/// A surface particle that is all liquid leaves the lattice. Mass, momentum and enthalpy stay as they are:
/// only the tag changes. Each vertex writes to its own particle and no other.
template <class T>
struct MeltBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    const std::uint32_t state = w.f.vertex_state[v];
    if (state == vertex_gone) return;
    if (state == vertex_died) {  // of the step before
      w.f.vertex_state[v] = vertex_gone;
      return;
    }
    const std::uint32_t slot = w.f.slot_of_id[w.f.vertex_id[v]];
    const std::uint32_t tag = w.f.tag[slot];
    const physics::MaterialRow<T>& m = w.f.materials[material_of(tag)];
    if (!physics::melts(m, (tag & tag_surface) != 0u,
                        w.f.enthalpy[slot] / static_cast<double>(w.f.mass[slot])))
      return;
    w.f.vertex_state[v] = vertex_died;
    w.f.tag[slot] = (tag & ~(tag_material_mask | tag_solid | tag_surface | tag_fixed)) | m.liquid;
  }
};

template <class T>
struct DiedBody {
  Frame<T> w;
  MELTSIM_HD Count operator()(std::uint64_t v) const {
    return {w.f.vertex_state[v] == vertex_died ? 1u : 0u};
  }
};

/// Adds the step's count to the running one.
template <class T>
struct TallyBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t) const {
    w.f.status->melted += w.f.status->died;
    if (w.f.status->died != 0u) w.f.status->pieces_stale = 1u;
  }
};

/// arrayN: drops melted direct neighbours; fewer than 27 makes an SBP. A melted vertex empties its own.
template <class T>
struct NeighboursBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (w.f.status->died == 0u) return;
    if (w.f.vertex_state[v] != vertex_live) {
      w.f.neighbour_mask[v] = 0u;
      return;
    }
    const BodyRow b = w.f.bodies[w.f.vertex_body[v]];
    const std::uint32_t site = w.f.vertex_site[v];
    const std::uint32_t old = w.f.neighbour_mask[v];
    std::uint32_t mask = old, bit = 0;
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx, ++bit)
          if (((old >> bit) & 1u) != 0u &&
              w.f.vertex_state[w.f.site_vertex[core::site_at(site, b, dx, dy, dz)]] != vertex_live)
            mask &= ~(1u << bit);
    if (mask == old) return;
    w.f.neighbour_mask[v] = mask;
    if (popcount(mask) < core::full_neighbours) w.f.tag[w.f.slot_of_id[w.f.vertex_id[v]]] |= tag_surface;
  }
};

/// Iterative fill of arrayR (Shao & Yu 2017, sec. 3.2, Fig. 3): the vertex itself, then w times the direct
/// neighbours of what is already there. A flood fill, not the box: a gap cuts. `Words` bounds the region.
template <class T, int Words>
MELTSIM_HD void fill_region(const Frame<T>& w, std::uint32_t v) {
  const BodyRow b = w.f.bodies[w.f.vertex_body[v]];
  const std::uint32_t site = w.f.vertex_site[v];
  const int h = b.region_half_width;
  std::uint32_t inside[Words], front[Words], next[Words];
  for (int k = 0; k < Words; ++k) inside[k] = front[k] = 0u;
  const std::uint32_t center = core::region_bit(h, 0, 0, 0);
  inside[center >> 5] |= 1u << (center & 31u);
  front[center >> 5] |= 1u << (center & 31u);
  for (int round = 0; round < h; ++round) {
    for (int k = 0; k < Words; ++k) next[k] = 0u;
    std::uint32_t bit = 0;
    for (int dz = -h; dz <= h; ++dz)
      for (int dy = -h; dy <= h; ++dy)
        for (int dx = -h; dx <= h; ++dx, ++bit) {
          if (((front[bit >> 5] >> (bit & 31u)) & 1u) == 0u) continue;
          const std::uint32_t member = w.f.site_vertex[core::site_at(site, b, dx, dy, dz)];
          const std::uint32_t links = w.f.neighbour_mask[member];
          std::uint32_t link = 0;
          for (int ez = -1; ez <= 1; ++ez)
            for (int ey = -1; ey <= 1; ++ey)
              for (int ex = -1; ex <= 1; ++ex, ++link) {
                if (((links >> link) & 1u) == 0u) continue;
                // A path of at most w steps never leaves the box of half-width w.
                const std::uint32_t to = core::region_bit(h, dx + ex, dy + ey, dz + ez);
                if (((inside[to >> 5] >> (to & 31u)) & 1u) == 0u) next[to >> 5] |= 1u << (to & 31u);
              }
        }
    for (int k = 0; k < Words; ++k) {
      inside[k] |= next[k];
      front[k] = next[k];
    }
  }
  std::uint32_t* mask = w.f.region_mask + static_cast<std::uint64_t>(v) * w.region_words;
  for (std::uint32_t k = 0; k < w.region_words; ++k)
    mask[k] = k < static_cast<std::uint32_t>(Words) ? inside[k] : 0u;
}

/// Rebuilds the regions that lost a member, and only those: a vertex outside a region cannot have carried a
/// path inside it.
template <class T, int Words>
struct RegionsBody {
  Frame<T> w;
  bool all;  ///< build every region (when the scene is uploaded)
  MELTSIM_HD void operator()(std::uint64_t i) const {
    if (!all && w.f.status->died == 0u) return;
    const auto v = static_cast<std::uint32_t>(i);
    std::uint32_t* mask = w.f.region_mask + i * w.region_words;
    if (w.f.vertex_state[v] != vertex_live) {
      for (std::uint32_t k = 0; k < w.region_words; ++k) mask[k] = 0u;
      return;
    }
    bool dirty = all;
    if (!all)
      core::for_each_member(
          w, v, [&](std::uint32_t j, int, int, int) { dirty = dirty || w.f.vertex_state[j] == vertex_died; });
    if (dirty) fill_region<T, Words>(w, v);
  }
};

/// Working labels for the search for pieces: every vertex its own index. The search and all that follows is
/// skipped while nothing has melted since the last one ended.
template <class T>
struct LabelsBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (w.f.status->pieces_stale != 0u) w.f.vertex_label[v] = static_cast<std::uint32_t>(v);
  }
};

/// Smallest label among v and its direct neighbours.
template <class T>
MELTSIM_HD std::uint32_t smallest_label(const Frame<T>& w, std::uint32_t v) {
  std::uint32_t label = w.f.vertex_label[v];
  const std::uint32_t mask = w.f.neighbour_mask[v];
  const BodyRow b = w.f.bodies[w.f.vertex_body[v]];
  const std::uint32_t site = w.f.vertex_site[v];
  std::uint32_t bit = 0;
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx, ++bit)
        if (((mask >> bit) & 1u) != 0u)
          label = minimum(label, w.f.vertex_label[w.f.site_vertex[core::site_at(site, b, dx, dy, dz)]]);
  return label;
}

/// One round of connected components (Shiloach & Vishkin 1982; Zhang, Azad & Hu 2020, FastSV): what a vertex
/// sees among its neighbours lowers its own label and its root's, ...
template <class T>
struct CopyLabelBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (w.f.status->pieces_stale != 0u) w.f.vertex_label_next[v] = w.f.vertex_label[v];
  }
};
template <class T>
struct HookBody {
  Frame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t v, const Add& add) const {
    if (w.f.status->pieces_stale == 0u || w.f.vertex_state[v] != vertex_live) return;
    const std::uint32_t label = w.f.vertex_label[v],
                        smallest = smallest_label(w, static_cast<std::uint32_t>(v));
    if (smallest == label) return;
    add.lower(&w.f.vertex_label_next[label], smallest);
    add.lower(&w.f.vertex_label_next[v], smallest);
  }
};
/// ... then every vertex takes its label's label.
template <class T>
struct JumpBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (w.f.status->pieces_stale != 0u) w.f.vertex_label[v] = w.f.vertex_label_next[w.f.vertex_label_next[v]];
  }
};

/// Vertices whose label differs from a neighbour's: 0 when the search has ended.
template <class T>
struct UnsettledBody {
  Frame<T> w;
  MELTSIM_HD Count operator()(std::uint64_t v) const {
    if (w.f.status->pieces_stale == 0u || w.f.vertex_state[v] != vertex_live) return {};
    return {smallest_label(w, static_cast<std::uint32_t>(v)) != w.f.vertex_label[v] ? 1u : 0u};
  }
};

/// Labels take effect only when the search has ended, so a piece never touches itself.
template <class T>
struct AdoptBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (w.f.status->pieces_stale != 0u && w.f.status->labels_unsettled == 0u)
      w.f.vertex_piece[v] = w.f.vertex_label[v];
  }
};

/// The search has ended: nothing to do until something melts.
template <class T>
struct SettledBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t) const {
    if (w.f.status->labels_unsettled == 0u) w.f.status->pieces_stale = 0u;
  }
};

/// arrayN of a lattice as built.
template <class T>
struct BuildNeighboursBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    std::uint32_t mask = 0;
    if (w.f.vertex_state[v] == vertex_live) {
      const BodyRow b = w.f.bodies[w.f.vertex_body[v]];
      const std::uint32_t site = w.f.vertex_site[v];
      std::uint32_t bit = 0;
      for (int dz = -1; dz <= 1; ++dz)
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx, ++bit) {
            const std::uint32_t n = w.f.site_vertex[core::site_at(site, b, dx, dy, dz)];
            if (n != none && w.f.vertex_state[n] == vertex_live) mask |= 1u << bit;
          }
    }
    w.f.neighbour_mask[v] = mask;
  }
};

}  // namespace topology
}  // namespace v0
}  // namespace meltsim
