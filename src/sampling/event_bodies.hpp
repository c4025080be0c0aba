// SPDX-License-Identifier: Apache-2.0
// Kernels of events: differences from the sub-step before. They compare tags, pieces and contacts with those that
// were stored then, so that an event is a difference that a host would find by comparing, whichever stage made it.
//
// Items are numbered: ids, then vertices, then entries of the table of contacts. An item has one event at most, and events are
// written in the order of their items, so that they depend neither on threads nor on the order of particles.
#pragma once

#include "frame/event_rows.hpp"
#include "frame/lattice.hpp"
#include "shared/pair_forces.hpp"
#include "spatial/neighbours.hpp"

namespace meltsim {
inline namespace v0 {
namespace sampling {

inline constexpr std::uint32_t no_event = event_kinds;

template <class T>
MELTSIM_HD std::uint64_t touch_columns(const Frame<T>& w) {
  return std::uint64_t{w.bodies} + core::wall_columns;
}
template <class T>
MELTSIM_HD std::uint64_t event_items(const Frame<T>& w) {
  return std::uint64_t{w.particles} + w.vertices + w.touch_entries;
}

/// Lowers an entry of the table of contacts to the id of a particle.
template <class T, class Add>
MELTSIM_HD void note_touch(const Frame<T>& w, std::uint32_t row, std::uint64_t column, std::uint32_t id,
                           const Add& add) {
  std::uint32_t* const entry = w.f.touch + (row * touch_columns(w) + column);
  if (id < add.load(entry)) add.lower(entry, id);
}

/// Marks the walls and bodies that a particle touches, by the rules of its contact forces. A particle with a contact
/// has slips of non-zero weight; other particles are skipped.
template <class T, bool Periodic>
struct TouchBody {
  Frame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t i, const Add& add) const {
    const std::uint32_t tag = w.f.tag[i];
    if (w.f.slip_next == nullptr || !is_solid(tag) || (tag & tag_fixed) != 0u) return;
    if (!(w.f.slip_next[i].w > T(0))) return;
    const std::uint32_t body = body_of(tag) - 1u, id = w.f.id[i];
    const Vec3<T> x = xyz(w.f.position[i]), v = xyz(w.f.velocity[i]), slip = core::slip_of(w, i);
    for (int face = 0; face < 6; ++face)
      if (core::wall_contact(w, i, tag, x, v, slip, face).touches)
        note_touch(w, body, static_cast<std::uint64_t>(face), id, add);
    if (w.f.piece == nullptr || (tag & tag_surface) == 0u) return;
    const core::Toucher<T> own = core::toucher(w, i);
    spatial::sweep_part<Periodic>(
        w, i, 0u, 1u, [&](std::uint32_t j, const Vec4<T>&, const Vec3<T>& x_ij, T r2) {
          const std::uint32_t tag_j = w.f.tag[j];
          if (!is_solid(tag_j) || body_of(tag_j) == body + 1u) return;
          if (!(core::pair_contact(w, own, j, x_ij, r2).weight > T(0))) return;
          const std::uint32_t other = body_of(tag_j) - 1u;
          note_touch(w, minimum(body, other), std::uint64_t{core::wall_columns} + maximum(body, other), id,
                     add);
        });
  }
};

/// Data for events of bodies and pieces: whether bodies have solid particles, and, for every label that is no longer
/// one, the smallest label among what it was the label of.
template <class T>
struct NoticeBody {
  Frame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t n, const Add& add) const {
    if (n < w.particles) {
      const std::uint32_t tag = w.f.tag[w.f.slot_of_id[n]];
      if (w.touch_entries == 0u || !is_solid(tag)) return;
      const std::uint32_t body = body_of(tag) - 1u;
      note_touch(w, body, std::uint64_t{core::wall_columns} + body, static_cast<std::uint32_t>(n), add);
      return;
    }
    const auto v = static_cast<std::uint32_t>(n - w.particles);
    if (w.f.vertex_piece == nullptr || w.f.vertex_state == nullptr) return;
    if (w.f.vertex_state[v] != core::vertex_free && w.f.vertex_piece[v] == v)
      add.lower(&w.f.new_piece[w.f.seen_piece[v]], v);
  }
};

template <class T>
MELTSIM_HD std::uint32_t event_of_particle(const Frame<T>& w, std::uint64_t id) {
  const std::uint32_t now = w.f.tag[w.f.slot_of_id[id]], before = w.f.seen_tag[id];
  if (is_removed(before)) return no_event;  // or to come
  if (is_removed(now)) return static_cast<std::uint32_t>(EventKind::left);
  if (is_solid(before) == is_solid(now)) return no_event;
  return static_cast<std::uint32_t>(is_solid(now) ? EventKind::frozen : EventKind::melted);
}

/// The piece that continues the one that had this label: that of the label's own vertex, or, if that has melted, the one with
/// the smallest label.
template <class T>
MELTSIM_HD std::uint32_t heir_of(const Frame<T>& w, std::uint32_t label) {
  return w.f.vertex_state[label] != core::vertex_free ? w.f.vertex_piece[label] : w.f.new_piece[label];
}

/// A label that was none before names a piece that came off another, unless it is that piece's new name.
template <class T>
MELTSIM_HD std::uint32_t event_of_vertex(const Frame<T>& w, std::uint32_t v) {
  if (w.f.vertex_piece == nullptr || w.f.vertex_state == nullptr) return no_event;
  if (w.f.vertex_state[v] == core::vertex_free || w.f.vertex_piece[v] != v) return no_event;
  const std::uint32_t from = w.f.seen_piece[v];
  return from == v || heir_of(w, from) == v ? no_event : static_cast<std::uint32_t>(EventKind::split);
}

template <class T>
MELTSIM_HD std::uint32_t event_of_touch(const Frame<T>& w, std::uint64_t entry) {
  const std::uint64_t row = entry / touch_columns(w), column = entry % touch_columns(w);
  const bool was = w.f.seen_touch[entry] != core::none, is = w.f.touch[entry] != core::none;
  if (was == is) return no_event;
  if (column == row + core::wall_columns) return is ? no_event : static_cast<std::uint32_t>(EventKind::gone);
  return static_cast<std::uint32_t>(is ? EventKind::contact_begun : EventKind::contact_ended);
}

/// The kind of event that an item has, if the host watches it; else no_event.
template <class T>
MELTSIM_HD std::uint32_t event_of(const Frame<T>& w, std::uint64_t n) {
  std::uint32_t kind = no_event;
  if (n < w.particles) kind = event_of_particle(w, n);
  else if (n < std::uint64_t{w.particles} + w.vertices)
    kind = event_of_vertex(w, static_cast<std::uint32_t>(n - w.particles));
  else kind = event_of_touch(w, n - w.particles - w.vertices);
  return ((w.event_kinds >> kind) & 1u) != 0u ? kind : no_event;
}

/// Counts the events of this sub-step.
template <class T>
struct CountEventsBody {
  Frame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t n, const Add& add) const {
    if (event_of(w, n) != no_event) add(&w.f.event_head->pending, 1);
  }
};

/// Lifts the guard of the kernels that follow if there are events.
template <class T>
struct BeginEventsBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t) const {
    w.f.event_head->idle = w.f.event_head->pending == 0 ? 1u : 0u;
  }
};

template <class T>
struct EventRankBody {
  Frame<T> w;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t n) const { return event_of(w, n) != no_event ? 1u : 0u; }
};

/// Writes an event into the ring, which keeps the last ones.
template <class T>
struct WriteEventBody {
  Frame<T> w;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t n, const Add& add) const {
    const std::uint32_t kind = event_of(w, n);
    if (kind == no_event) return;
    core::EventHead& head = *w.f.event_head;
    add(&head.count[kind], 1);
    const std::uint64_t rank = w.f.event_place[n] - 1u;
    if (static_cast<std::uint64_t>(head.pending) - rank > w.event_capacity) return;
    core::EventRow e;
    e.kind = kind;
    e.step = w.f.clock->step;
    e.time = w.f.clock->end;
    if (n < w.particles) describe_particle(e, static_cast<std::uint32_t>(n));
    else if (n < std::uint64_t{w.particles} + w.vertices)
      describe_piece(e, static_cast<std::uint32_t>(n - w.particles));
    else describe_touch(e, n - w.particles - w.vertices);
    e.at = cast<double>(xyz(w.f.position[w.f.slot_of_id[e.particle]]));
    w.f.events[(head.written + rank) % w.event_capacity] = e;
  }

 private:
  MELTSIM_HD void describe_particle(core::EventRow& e, std::uint32_t id) const {
    const std::uint32_t now = w.f.tag[w.f.slot_of_id[id]], before = w.f.seen_tag[id];
    e.particle = id;
    if (is_solid(now) || is_solid(before)) e.body = body_of(is_solid(now) ? now : before) - 1u;
  }
  MELTSIM_HD void describe_piece(core::EventRow& e, std::uint32_t v) const {
    e.particle = w.f.vertex_id[v];
    e.body = w.f.vertex_body[v];
    e.piece = v + 1u;
    e.from = heir_of(w, w.f.seen_piece[v]) + 1u;
  }
  MELTSIM_HD void describe_touch(core::EventRow& e, std::uint64_t entry) const {
    const std::uint64_t row = entry / touch_columns(w), column = entry % touch_columns(w);
    const bool is = w.f.touch[entry] != core::none;
    e.particle = is ? w.f.touch[entry] : w.f.seen_touch[entry];
    e.body = static_cast<std::uint32_t>(row);
    if (column < core::wall_columns) e.wall = static_cast<std::uint32_t>(column);
    else if (column - core::wall_columns != row)
      e.other = static_cast<std::uint32_t>(column - core::wall_columns);
  }
};

/// Ends the events of the sub-step: all have been written.
template <class T>
struct EndEventsBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t) const {
    core::EventHead& head = *w.f.event_head;
    head.written += static_cast<std::uint64_t>(head.pending);
    head.pending = 0;
    head.idle = 1u;
  }
};

/// Stores the state that the next sub-step is compared with.
template <class T>
struct SeenBody {
  Frame<T> w;
  MELTSIM_HD void operator()(std::uint64_t n) const {
    if (n < w.particles) {
      w.f.seen_tag[n] = w.f.tag[w.f.slot_of_id[n]];
    } else if (n < std::uint64_t{w.particles} + w.vertices) {
      const std::uint64_t v = n - w.particles;
      if (w.f.vertex_piece != nullptr) w.f.seen_piece[v] = w.f.vertex_piece[v];
    } else {
      const std::uint64_t entry = n - w.particles - w.vertices;
      w.f.seen_touch[entry] = w.f.touch[entry];
    }
  }
};

}  // namespace sampling
}  // namespace v0
}  // namespace meltsim
