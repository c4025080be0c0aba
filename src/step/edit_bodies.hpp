// SPDX-License-Identifier: Apache-2.0
// Kernels between sub-steps that find, append and take out particles.
#pragma once

#include "frame/edit_rows.hpp"
#include "frame/lattice.hpp"
#include "meltsim/particle_tag.hpp"

namespace meltsim {
inline namespace v0 {
namespace step {

using core::Frame;

template <class T>
MELTSIM_HD core::Range slots_of(const Frame<T>& w, const core::FoundBox& b, std::uint64_t k) {
  if (b.by_cells == 0u) {
    const std::uint64_t first = k * core::FoundBox::portion, end = first + core::FoundBox::portion;
    return {static_cast<std::uint32_t>(first),
            end < w.particles ? static_cast<std::uint32_t>(end) : w.particles};
  }
  const std::uint64_t y = static_cast<std::uint64_t>(b.y) + k % static_cast<std::uint64_t>(b.ny),
                      z = static_cast<std::uint64_t>(b.z) + k / static_cast<std::uint64_t>(b.ny);
  const std::uint64_t cell =
      (z * static_cast<std::uint64_t>(w.grid.ny) + y) * static_cast<std::uint64_t>(w.grid.nx) +
      static_cast<std::uint64_t>(b.x);
  return {w.f.cell_begin[cell], w.f.cell_begin[cell + static_cast<std::uint64_t>(b.nx)]};
}

template <class T>
MELTSIM_HD bool is_in(const Frame<T>& w, const core::FoundBox& b, std::uint32_t slot) {
  const Vec3<double> x = cast<double>(xyz(w.f.position[slot]));
  return !is_removed(w.f.tag[slot]) && x.x >= b.low.x && x.y >= b.low.y && x.z >= b.low.z &&
         x.x <= b.high.x && x.y <= b.high.y && x.z <= b.high.z;
}

/// How many particles of a box a range of slots holds.
template <class T>
struct CountInBoxBody {
  Frame<T> w;
  core::FoundBox box;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t k) const {
    const core::Range slots = slots_of(w, box, k);
    std::uint32_t n = 0;
    for (std::uint32_t slot = slots.begin; slot < slots.end; ++slot) n += is_in(w, box, slot) ? 1u : 0u;
    return n;
  }
};

/// Lists them.
template <class T>
struct ListInBoxBody {
  Frame<T> w;
  core::FoundBox box;
  const std::uint32_t* end_of;  ///< of each range, in the list
  core::FoundParticle* list;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    const core::Range slots = slots_of(w, box, k);
    std::uint32_t at = k == 0 ? 0u : end_of[k - 1];
    for (std::uint32_t slot = slots.begin; slot < slots.end; ++slot) {
      if (!is_in(w, box, slot)) continue;
      core::FoundParticle& p = list[at++];
      const Vec4<T> x = w.f.position[slot];
      p.position = cast<double>(xyz(x));
      p.mass = static_cast<double>(w.f.mass[slot]);
      p.volume = static_cast<double>(x.w);
      p.id = w.f.id[slot];
      p.tag = w.f.tag[slot];
      p.slot = slot;
    }
  }
};

/// The next ids get particles: of liquid, as an emitter's do, or of a body, whose vertices begin at `vertex`.
template <class T>
struct AppendBody {
  Frame<T> w;
  core::PreviousViews<T> from;
  std::uint32_t first, vertex;
  std::uint64_t n;  ///< how many there are
  MELTSIM_HD void operator()(std::uint64_t k) const {
    const auto id = first + static_cast<std::uint32_t>(k);
    const std::uint32_t slot = w.f.slot_of_id[id];  // until now it held nothing, as if removed
#define MELTSIM_MOVED(name, type) \
  if (w.f.name != nullptr && from.name != nullptr) w.f.name[slot] = from.name[k];
#include "meltsim/fields.def"
    if (w.f.solute != nullptr && from.solute != nullptr)
      for (std::uint32_t s = 0; s < w.species; ++s) core::solute_at(w, s, slot) = from.solute[s * n + k];
    if (w.f.enthalpy == nullptr) w.f.enthalpy_of_id[id] = from.enthalpy[k];
    if (w.f.vertex_of_id != nullptr)
      w.f.vertex_of_id[id] = vertex == core::none ? core::none : vertex + static_cast<std::uint32_t>(k);
    if (w.f.seen_tag != nullptr) w.f.seen_tag[id] = from.tag[k];
  }
};

template <class T>
MELTSIM_HD void take_out_at(const Frame<T>& w, std::uint32_t slot, std::uint32_t id) {
  w.f.tag[slot] |= tag_removed;
  w.f.slot_of_id[id] = slot;  // is known of what was removed
  if (w.f.seen_tag != nullptr) w.f.seen_tag[id] = w.f.tag[slot];
}

/// Particles that were found are removed.
template <class T>
struct TakeOutBody {
  Frame<T> w;
  const core::FoundParticle* list;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    const std::uint32_t id = list[k].id, slot = list[k].slot;
    take_out_at(w, slot == core::none ? w.f.slot_of_id[id] : slot, id);
  }
};

/// Particles that were found are elsewhere.
template <class T>
struct MoveBody {
  Frame<T> w;
  const core::FoundParticle* list;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    const std::uint32_t slot = list[k].slot == core::none ? w.f.slot_of_id[list[k].id] : list[k].slot;
    w.f.position[slot] = with_w(cast<T>(list[k].position), w.f.position[slot].w);
  }
};

/// All that is solid of a body is removed. One call per vertex of it, from `first` on.
template <class T>
struct TakeBodyBody {
  Frame<T> w;
  std::uint32_t first, body;
  MELTSIM_HD core::TakenSum operator()(std::uint64_t k) const {
    const std::uint32_t v = first + static_cast<std::uint32_t>(k), id = w.f.vertex_id[v];
    core::TakenSum s;
    if (w.f.vertex_state[v] != core::vertex_free && id != core::none) {
      const std::uint32_t slot = w.f.slot_of_id[id], tag = w.f.tag[slot];
      if (is_solid(tag) && body_of(tag) == body + 1u) {
        take_out_at(w, slot, id);
        s.count = 1;
      }
    }
    w.f.vertex_state[v] = core::vertex_free;
    if (w.f.neighbour_mask != nullptr) w.f.neighbour_mask[v] = 0u;
    if (w.f.row_live != nullptr) w.f.row_live[v] = 0u;
    if (w.f.region_members != nullptr) w.f.region_members[v] = 0u;
    if (w.f.region_mask != nullptr)
      for (std::uint32_t n = 0; n < w.region_words; ++n)
        w.f.region_mask[std::uint64_t{v} * w.region_words + n] = 0u;
    return s;
  }
};

/// Lists what is solid of a body; slot none: nothing is, at that vertex. One call per vertex of it, from `first` on.
template <class T>
struct ListBodyBody {
  Frame<T> w;
  std::uint32_t first, body;
  core::FoundParticle* list;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    const std::uint32_t v = first + static_cast<std::uint32_t>(k), id = w.f.vertex_id[v];
    core::FoundParticle p;
    p.slot = core::none;
    if (w.f.vertex_state[v] != core::vertex_free && id != core::none) {
      const std::uint32_t slot = w.f.slot_of_id[id], tag = w.f.tag[slot];
      if (is_solid(tag) && body_of(tag) == body + 1u) {
        p.position = cast<double>(xyz(w.f.position[slot]));
        p.mass = static_cast<double>(w.f.mass[slot]);
        p.id = id;
        p.tag = tag;
        p.slot = slot;
      }
    }
    list[k] = p;
  }
};

/// Particles of a body get their tags and, in place of positions, velocities.
template <class T>
struct HoldBody {
  Frame<T> w;
  const core::FoundParticle* list;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    const core::FoundParticle& p = list[k];
    w.f.tag[p.slot] = p.tag;
    w.f.velocity[p.slot] = with_w(cast<T>(p.position), w.f.velocity[p.slot].w);
    if (w.f.seen_tag != nullptr) w.f.seen_tag[p.id] = p.tag;
  }
};

/// Of rigid bodies that move rotations are kept in double; of others as every channel is.
template <class T>
struct RoundRotationsBody {
  Frame<T> w;
  std::uint32_t first;
  MELTSIM_HD void operator()(std::uint64_t k) const {
    const std::uint64_t v = first + k;
    const Quat<T>& q = w.f.region_rotation[v];
    w.f.rigid_rotation[v] = {static_cast<double>(q.w), static_cast<double>(q.x), static_cast<double>(q.y),
                             static_cast<double>(q.z)};
  }
};

/// Sites of a body that was removed hold no live vertex.
template <class T>
struct EmptySitesBody {
  Frame<T> w;
  std::uint32_t first;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t k, const Add& add) const {
    const std::uint32_t site = w.f.vertex_site[first + k];
    add.clear(core::site_word(w, site), core::site_bit(site));
  }
};

}  // namespace step
}  // namespace v0
}  // namespace meltsim
