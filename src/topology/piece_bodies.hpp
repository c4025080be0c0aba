// SPDX-License-Identifier: Apache-2.0
// Kernels that find connected pieces. They return at once where nothing melted or froze since the last search.
#pragma once

#include "topology/bodies.hpp"

namespace meltsim {
inline namespace v0 {
namespace topology {

/// visit(u) for the direct neighbours of v.
template <class T, class Visit>
MELTSIM_HD void for_each_direct(const Frame<T>& w, std::uint32_t v, const Visit& visit) {
  const std::uint32_t mask = w.f.neighbour_mask[v];
  const BodyRow b = w.f.bodies[w.f.vertex_body[v]];
  const std::uint32_t site = w.f.vertex_site[v];
  core::each_direct([&](int dx, int dy, int dz) {
    if (((mask >> core::neighbour_bit(dx, dy, dz)) & 1u) != 0u)
      visit(w.f.site_vertex[core::site_beside(site, b, dx, dy, dz)]);
  });
}

/// Whether nothing has melted or frozen since the last search for pieces, so that the next one may return at once.
template <class T>
MELTSIM_HD bool pieces_known(const Frame<T>& w) {
  return w.f.status->pieces_stale == 0u && w.f.status->died == 0;
}

/// The search for pieces: a forest over the vertices (disjoint sets; hooking without locks as in Jaiganesh &
/// Burtscher 2018, HPDC, ECL-CC). vertex_label is a vertex's parent, never larger than itself and only ever
/// lowered, so the root of a piece is its smallest vertex, whatever the order of threads.
/// The first parent of a vertex is its smallest neighbour: in a convex piece that gives one root already.
template <class T>
struct LabelsBody {
  static constexpr bool wide = true;
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t v) const {
    if (pieces_known(w)) return;
    auto label = static_cast<std::uint32_t>(v);
    if (w.f.vertex_state[v] == vertex_live)
      for_each_direct(w, label, [&](std::uint32_t u) { label = minimum(label, u); });
    w.f.vertex_label[v] = label;
  }
};

/// Root of the tree of v. Parents that other threads lower meanwhile remain ancestors; on the way up every vertex gets
/// its grandparent as parent, which halves the path for later calls.
template <class T, class Add>
MELTSIM_HD std::uint32_t root_of(const Frame<T>& w, std::uint32_t v, const Add& add) {
  for (;;) {
    const std::uint32_t up = add.load(&w.f.vertex_label[v]);
    if (up == v) return v;
    const std::uint32_t above = add.load(&w.f.vertex_label[up]);
    if (above == up) return up;
    add.lower(&w.f.vertex_label[v], above);
    v = above;
  }
}

/// Stores roots as labels, so that most neighbours have equal labels at once.
template <class T>
struct ClimbBody {
  static constexpr bool wide = true;
  Frame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t v, const Add& add) const {
    if (pieces_known(w)) return;
    add.lower(&w.f.vertex_label[v], root_of(w, static_cast<std::uint32_t>(v), add));
  }
};

/// Joins the trees of neighbours: the larger root gets the smaller as parent. If it was no root any more, its
/// parent is joined instead.
template <class T>
struct HookBody {
  static constexpr bool wide = true;
  Frame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t v, const Add& add) const {
    if (pieces_known(w) || w.f.vertex_state[v] != vertex_live) return;
    const auto self = static_cast<std::uint32_t>(v);
    for_each_direct(w, self, [&](std::uint32_t u) {
      if (u >= self || add.load(&w.f.vertex_label[u]) == add.load(&w.f.vertex_label[self])) return;
      for (std::uint32_t a = root_of(w, self, add), b = root_of(w, u, add); a != b;) {
        const std::uint32_t larger = maximum(a, b), smaller = minimum(a, b);
        const std::uint32_t was = add.lower(&w.f.vertex_label[larger], smaller);
        if (was == larger) return;
        a = root_of(w, was, add);
        b = root_of(w, smaller, add);
      }
    });
  }
};

/// Stores the label of every vertex: the smallest vertex of its piece.
template <class T>
struct AdoptBody {
  Frame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t v, const Add& add) const {
    if (!pieces_known(w)) w.f.vertex_piece[v] = root_of(w, static_cast<std::uint32_t>(v), add);
  }
};

/// The search has ended: nothing to do until something melts or freezes.
template <class T>
struct SettledBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t) const {
    w.f.status->pieces_stale = 0u;
    w.f.status->died = 0;
  }
};

}  // namespace topology
}  // namespace v0
}  // namespace meltsim
