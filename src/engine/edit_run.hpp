// SPDX-License-Identifier: Apache-2.0
// Particles that are found, appended and taken out where they are, without the scene being uploaded anew.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "engine/engine_transfer.hpp"
#include "frame/edit_rows.hpp"
#include "pipeline/stage_functions.hpp"
#include "spatial/cells.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

/// Working space of edits between sub-steps. Its functions wait and return false where there is not the memory; nothing has changed then.
template <class E, class T>
class EditRun {
 public:
  void release(E& ex) {
    for (Room* room : {&counts_, &list_, &staged_}) {
      if (room->memory != nullptr) ex.release(room->memory);
      *room = {};
    }
    fresh_.clear();
  }
  std::uint64_t bytes() const { return counts_.bytes + list_.bytes + staged_.bytes; }

  /// A sub-step has sorted all particles by cell, if cells: counted ones.
  void sorted(bool cells) {
    cells_ = cells;
    fresh_.clear();
  }
  /// Particles may lie elsewhere than in the cells of the last sub-step.
  void moved() { cells_ = false; }

  /// Particles in a box, by id.
  bool find(E& ex, const Frame<T>& w, std::uint64_t most_ranges, const Vec3d& low, const Vec3d& high,
            std::vector<FoundParticle>& found) {
    found.clear();
    if (w.particles == 0 || !(low.x <= high.x && low.y <= high.y && low.z <= high.z)) return true;
    FoundBox box;
    box.low = low;
    box.high = high;
    const bool by_cells = cells_ && w.f.cell_begin != nullptr && w.cells != 0 && place(w, box) &&
                          std::uint64_t(box.ny) * std::uint64_t(box.nz) <= most_ranges;
    box.by_cells = by_cells ? 1u : 0u;
    const std::uint64_t ranges = by_cells ? std::uint64_t(box.ny) * std::uint64_t(box.nz)
                                          : (w.particles + FoundBox::portion - 1) / FoundBox::portion;
    auto* const counts = fit<std::uint32_t>(ex, counts_, ranges);
    if (counts == nullptr) return false;
    step::count_in_box<E, T>(ex, w, box, ranges, counts);
    std::uint32_t n = 0;
    ex.download(&n, counts + (ranges - 1), sizeof n);
    if (n != 0) {
      auto* const list = fit<FoundParticle>(ex, list_, n);
      if (list == nullptr) return false;
      step::list_in_box<E, T>(ex, w, box, ranges, counts, list);
      found = fetch(ex, static_cast<const FoundParticle*>(list), n);
    }
    // What was appended since then is in no cell.
    const auto inside = [&](const Vec3d& x) {
      return x.x >= low.x && x.y >= low.y && x.z >= low.z && x.x <= high.x && x.y <= high.y && x.z <= high.z;
    };
    for (const FoundParticle& p : fresh_)
      if (by_cells && inside(p.position)) found.push_back(p);
    std::sort(found.begin(), found.end(),
              [](const FoundParticle& a, const FoundParticle& b) { return a.id < b.id; });
    return true;
  }

  /// So that take_out() and append() of so many do not fail.
  bool make_room(E& ex, std::uint64_t taken, std::uint64_t appended) {
    std::uint64_t item = 0, channels = 0;
#define MELTSIM_MOVED(name, type) item += sizeof(type), ++channels;
#include "meltsim/fields.def"
    return fit<FoundParticle>(ex, list_, taken) != nullptr &&
           fit<unsigned char>(ex, staged_,
                              (item + most_species * sizeof(double)) * appended + 256 * channels) != nullptr;
  }

  /// Particles get the ids from `first` on; vertex: of the first, or none.
  bool append(E& ex, const Frame<T>& w, const SceneState& more, std::uint32_t first, std::uint32_t vertex) {
    const std::size_t n = more.position.size();
    ParticleArrays<T> arrays(more, n, w.f.solute != nullptr ? w.species : 0, HostLoops(1));
    for (std::uint32_t& id : arrays.id) id += first;
    std::vector<unsigned char> bytes;
    const auto pack = [&bytes](const auto& array) {
      const std::size_t at = (bytes.size() + 255) / 256 * 256, size = array.size() * sizeof(array[0]);
      bytes.resize(at + size);
      if (size != 0) std::memcpy(bytes.data() + at, array.data(), size);
      return at;
    };
#define MELTSIM_MOVED(name, type) const std::size_t at_##name = pack(arrays.name);
#include "meltsim/fields.def"
    auto* const staged = fit<unsigned char>(ex, staged_, bytes.size());
    if (staged == nullptr) return false;
    std::vector<FoundParticle> fresh = fresh_;
    for (std::size_t k = 0; k < n; ++k)
      fresh.push_back({cast<double>(xyz(arrays.position[k])), static_cast<double>(arrays.mass[k]),
                       static_cast<double>(arrays.position[k].w), arrays.id[k], arrays.tag[k], none, 0});
    ex.upload(staged, bytes.data(), bytes.size());
    PreviousViews<T> from;
#define MELTSIM_MOVED(name, type) \
  if (!arrays.name.empty()) from.name = reinterpret_cast<const type*>(staged + at_##name);
#include "meltsim/fields.def"
    step::append<E, T>(ex, w, from, first, vertex, n);
    ex.synchronize();
    fresh_.swap(fresh);
    return true;
  }

  /// Particles that find() has found.
  bool take_out(E& ex, const Frame<T>& w, const std::vector<FoundParticle>& what) {
    auto* const list = fit<FoundParticle>(ex, list_, what.size());
    if (list == nullptr) return false;
    ex.upload(list, what.data(), what.size() * sizeof(FoundParticle));
    step::take_out<E, T>(ex, w, list, what.size());
    const auto taken = [&what](const FoundParticle& p) {
      return std::any_of(what.begin(), what.end(), [&p](const FoundParticle& q) { return q.id == p.id; });
    };
    if (!fresh_.empty()) fresh_.erase(std::remove_if(fresh_.begin(), fresh_.end(), taken), fresh_.end());
    return true;
  }

  /// Particles that find() has found go to their new positions.
  bool move(E& ex, const Frame<T>& w, const std::vector<FoundParticle>& what) {
    auto* const list = fit<FoundParticle>(ex, list_, what.size());
    if (list == nullptr) return false;
    ex.upload(list, what.data(), what.size() * sizeof(FoundParticle));
    step::move<E, T>(ex, w, list, what.size());
    moved();
    return true;
  }

  /// What is solid of a body, by id.
  bool find_body(E& ex, const Frame<T>& w, std::uint32_t body, std::uint32_t first, std::uint32_t count,
                 std::vector<FoundParticle>& found) {
    auto* const list = fit<FoundParticle>(ex, list_, count);
    if (list == nullptr) return false;
    step::list_body<E, T>(ex, w, body, first, count, list);
    found = fetch(ex, static_cast<const FoundParticle*>(list), count);
    found.erase(
        std::remove_if(found.begin(), found.end(), [](const FoundParticle& p) { return p.slot == none; }),
        found.end());
    std::sort(found.begin(), found.end(),
              [](const FoundParticle& a, const FoundParticle& b) { return a.id < b.id; });
    return true;
  }

  /// Holds them, or lets them go at the velocities that stand in place of positions.
  bool hold(E& ex, const Frame<T>& w, const std::vector<FoundParticle>& what, bool on, std::uint32_t first,
            std::uint32_t count) {
    auto* const list = fit<FoundParticle>(ex, list_, what.size());
    if (list == nullptr) return false;
    ex.upload(list, what.data(), what.size() * sizeof(FoundParticle));
    step::hold<E, T>(ex, w, list, what.size(), on, first, count);
    for (FoundParticle& p : fresh_)
      for (const FoundParticle& q : what)
        if (p.id == q.id) p.tag = q.tag;
    return true;
  }

  /// How much of a body was solid; false: out of memory.
  bool take_body(E& ex, const Frame<T>& w, std::uint32_t body, std::uint32_t first, std::uint32_t count,
                 std::uint64_t& taken) {
    auto* const sum = fit<TakenSum>(ex, counts_, 1);
    if (sum == nullptr) return false;
    step::take_body<E, T>(ex, w, body, first, count, sum);
    TakenSum s;
    ex.download(&s, sum, sizeof s);
    taken = s.count;
    return true;
  }

 private:
  struct Room {
    void* memory = nullptr;
    std::uint64_t bytes = 0;
  };
  /// Room for n items; null where there is none.
  template <class Item>
  static Item* fit(E& ex, Room& room, std::uint64_t n) {
    const std::uint64_t bytes = std::max<std::uint64_t>(n * sizeof(Item), 256);
    if (room.bytes < bytes) {
      if (room.memory != nullptr) ex.release(room.memory);
      room = {};
      room.memory = ex.allocate(std::max(bytes, 2 * room.bytes));
      if (room.memory == nullptr) return nullptr;
      room.bytes = std::max(bytes, 2 * room.bytes);
    }
    return static_cast<Item*>(room.memory);
  }

  /// The cells of a box and those around it: since it was sorted, a particle has gone half a sub-step on, in which no particle
  /// that counts crosses H/2, and one that froze has gone to its site. False: there are none.
  static bool place(const Frame<T>& w, FoundBox& box) {
    const Grid<T>& g = w.grid;
    const double margin = static_cast<double>(w.c.kernel.support);
    const Vec3d least = cast<double>(w.c.domain_min), most = cast<double>(w.c.domain_max);
    const auto along = [margin](double low, double high, double begin, double end, T min, T inv_cell,
                                std::int32_t n, bool periodic, std::int32_t& first, std::int32_t& count) {
      low -= margin;
      high += margin;
      first = 0;
      count = n;
      if (periodic && (low < begin || high > end)) return;  // it may have gone across
      const auto cell = [&](double x) {
        return spatial::cell_coordinate(static_cast<T>(std::min(std::max(x, begin), end)), min, inv_cell, n,
                                        false);
      };
      first = cell(low);
      count = cell(high) - first + 1;
    };
    along(box.low.x, box.high.x, least.x, most.x, g.min.x, g.inv_cell.x, g.nx, (g.periodic & 1u) != 0, box.x,
          box.nx);
    along(box.low.y, box.high.y, least.y, most.y, g.min.y, g.inv_cell.y, g.ny, (g.periodic & 2u) != 0, box.y,
          box.ny);
    along(box.low.z, box.high.z, least.z, most.z, g.min.z, g.inv_cell.z, g.nz, (g.periodic & 4u) != 0, box.z,
          box.nz);
    return box.nx > 0 && box.ny > 0 && box.nz > 0;
  }

  Room counts_, list_, staged_;
  bool cells_ = false;                ///< slots are in the order of cell_begin
  std::vector<FoundParticle> fresh_;  ///< appended since the last sub-step
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
