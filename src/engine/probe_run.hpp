// SPDX-License-Identifier: Apache-2.0
// Memory of an engine for probes: tables, room for samples, and the working space of World::sample. None of it is a
// channel: probes come and go without an upload of particles.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "engine/engine_transfer.hpp"
#include "engine/text.hpp"
#include "frame/frame.hpp"
#include "frame/probe_setup.hpp"
#include "meltsim/result.hpp"
#include "pipeline/stage_functions.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

template <class E, class T>
class ProbeRun {
 public:
  /// Enqueued work must not use the old buffers.
  Status set(E& ex, const ProbeSetup& s) {
    tables_.release(ex);
    views_ = {};
    return fill(ex, tables_, s, s.room, views_);
  }

  void link(Frame<T>& w) const { w.probes = views_; }

  void fetch(const E& ex, std::uint64_t first, std::uint64_t n, double* to) const {
    if (n != 0) ex.download(to, views_.values + first, n * sizeof(double));
  }

  /// Waits. derived: density and pressure terms are in the order of the sub-step that halted.
  Status at_once(E& ex, const Frame<T>& scene, const ProbeSetup& what, bool derived,
                 std::vector<double>& values) {
    Frame<T> w = scene;
    values.assign(what.rows.front().values, static_cast<double>(NAN));
    if (w.born == 0) return {};
    ProbeViews<T> v;
    Block tables;
    if (Status s = fill(ex, tables, what, values.size(), v); !s) return s;
    SampleRoom room;
    Status fits = sort_room(ex, w.capacity, derived, room);
    if (fits) {
      v.keys = room.keys_sorted;
      v.slots = room.slots_sorted;
      v.sorted = w.born;
      if (derived) v.terms = w.before.velocity;
      v.derived_slot = room.derived_slot;
      w.probes = v;
      use_cells_of_support(w);
      sampling::at_once<E, T>(ex, w, room);
      ex.download(values.data(), v.values, values.size() * sizeof(double));
    }
    tables.release(ex);
    return fits;
  }

  /// Waits. Where rays end.
  Status follow_rays(E& ex, const Frame<T>& scene, const std::vector<RayQuery>& rays, std::uint32_t sought,
                     std::vector<RayRow>& hits) {
    Frame<T> w = scene;
    Block tables;
    RayRoom r;
    RayQuery* queries = nullptr;
    const auto lay_out = [&](void* base) {
      Arena a{static_cast<unsigned char*>(base)};
      queries = a.template place<RayQuery>(rays.size());
      r.hits = a.template place<RayRow>(rays.size());
      r.bounds = a.template place<ParticleBounds>(1);
      return a.used;
    };
    if (Status s = take(ex, tables, lay_out(nullptr)); !s) return s;
    lay_out(tables.base);
    r.rays = queries;
    r.count = static_cast<std::uint32_t>(rays.size());
    r.sought = sought;
    SampleRoom room;
    Status fits = sort_room(ex, std::max<std::uint64_t>(w.capacity, 1), false, room);
    if (fits) {
      const ParticleBounds nothing;
      put(ex, queries, rays);
      ex.upload(r.bounds, &nothing, sizeof nothing);
      w.probes = {};
      w.probes.keys = room.keys_sorted;
      w.probes.slots = room.slots_sorted;
      w.probes.sorted = w.born;
      use_cells_of_support(w);
      sampling::follow_rays<E, T>(ex, w, room, r);
      hits = core::fetch(ex, r.hits, rays.size());
    }
    tables.release(ex);
    return fits;
  }

  void release(E& ex) {
    tables_.release(ex);
    sorting_.release(ex);
    views_ = {};
  }
  std::uint64_t bytes() const { return tables_.bytes + sorting_.bytes; }

 private:
  struct Block {
    void* base = nullptr;
    std::uint64_t bytes = 0;
    void release(E& ex) {
      if (base != nullptr) ex.release(base);
      base = nullptr;
      bytes = 0;
    }
  };
  struct Arena {
    unsigned char* base;
    std::uint64_t used = 0;
    template <class V>
    V* place(std::uint64_t n) {
      V* const p = reinterpret_cast<V*>(base + used);
      used += (n * sizeof(V) + 255) / 256 * 256;
      return p;
    }
  };

  static Status take(E& ex, Block& block, std::uint64_t needed) {
    if (needed <= block.bytes) return {};
    block.release(ex);
    if (needed <= ex.free_bytes()) block.base = ex.allocate(needed);
    if (block.base == nullptr)
      return Error{ErrorCode::out_of_memory, text("probes: ", double(needed) / 1e6,
                                                  " MB of memory are not there; use fewer points or rays")};
    block.bytes = needed;
    return {};
  }

  static std::vector<ProbePoint<T>> rounded(const std::vector<ProbePoint<double>>& from) {
    std::vector<ProbePoint<T>> to;
    to.reserve(from.size());
    for (const auto& p : from) to.push_back({cast<T>(p.x), p.probe});
    return to;
  }

  /// The count first, then all values.
  static std::vector<std::uint32_t> list_of(std::size_t n) {
    std::vector<std::uint32_t> list(n + 1);
    list[0] = static_cast<std::uint32_t>(n);
    for (std::size_t k = 0; k < n; ++k) list[k + 1] = static_cast<std::uint32_t>(k);
    return list;
  }

  /// The tables of probes as the host has them, rounded.
  struct ProbeTables {
    std::vector<ProbePoint<T>> points, heights;
    std::vector<LoadRow> loads;
    std::vector<std::uint32_t> listed;
  };

  static ProbeTables tables_of(const ProbeSetup& s, ProbeViews<T>& v) {
    ProbeTables t;
    t.points = rounded(s.points);
    t.heights = rounded(s.heights);
    for (std::uint32_t k = 0; k < load_kinds; ++k) {
      t.loads.insert(t.loads.end(), s.loads[k].begin(), s.loads[k].end());
      v.load_begin[k + 1] = static_cast<std::uint32_t>(t.loads.size());
    }
    t.listed = list_of(t.points.size() + t.heights.size());
    return t;
  }

  /// Their buffers on the backend.
  struct ProbePlaces {
    ProbeRow* rows = nullptr;
    ProbePoint<T>*points = nullptr, *heights = nullptr;
    ProbeLine* lines = nullptr;
    LoadRow* loads = nullptr;
    std::uint32_t* listed = nullptr;
  };

  static std::uint64_t lay_out(void* base, const ProbeSetup& s, const ProbeTables& t, std::uint64_t room,
                               ProbePlaces& at, ProbeViews<T>& v) {
    Arena a{static_cast<unsigned char*>(base)};
    at.rows = a.template place<ProbeRow>(s.rows.size());
    at.points = a.template place<ProbePoint<T>>(t.points.size());
    at.heights = a.template place<ProbePoint<T>>(t.heights.size());
    at.lines = a.template place<ProbeLine>(s.lines.size());
    at.listed = a.template place<std::uint32_t>(t.listed.size());
    at.loads = a.template place<LoadRow>(t.loads.size());
    v.load_sums = a.template place<physics::LoadSums>(t.loads.size());
    v.profile = a.template place<T>(t.heights.size());
    v.values = a.template place<double>(room);
    return a.used;
  }

  /// Copies the tables and points `v` at them.
  static Status fill(E& ex, Block& block, const ProbeSetup& s, std::uint64_t room, ProbeViews<T>& v) {
    const ProbeTables t = tables_of(s, v);
    ProbePlaces at;
    if (Status fits = take(ex, block, lay_out(nullptr, s, t, room, at, v)); !fits) {
      v = {};
      return fits;
    }
    lay_out(block.base, s, t, room, at, v);
    put(ex, at.rows, s.rows);
    put(ex, at.points, t.points);
    put(ex, at.heights, t.heights);
    put(ex, at.lines, s.lines);
    put(ex, at.loads, t.loads);
    put(ex, at.listed, t.listed);
    v.listed = at.listed;
    v.rows = at.rows;
    v.points = at.points;
    v.heights = at.heights;
    v.lines = at.lines;
    v.loads = at.loads;
    v.point_count = static_cast<std::uint32_t>(t.points.size());
    v.height_count = static_cast<std::uint32_t>(t.heights.size());
    v.line_count = static_cast<std::uint32_t>(s.lines.size());
    return {};
  }

  /// Kept from call to call.
  Status sort_room(E& ex, std::uint64_t particles, bool derived, SampleRoom& room) {
    const auto lay_out = [&](void* base) {
      Arena a{static_cast<unsigned char*>(base)};
      room.keys = a.template place<std::uint64_t>(particles);
      room.keys_sorted = a.template place<std::uint64_t>(particles);
      room.slots = a.template place<std::uint32_t>(particles);
      room.slots_sorted = a.template place<std::uint32_t>(particles);
      room.derived_slot = a.template place<std::uint32_t>(particles);
      return a.used;
    };
    if (Status fits = take(ex, sorting_, lay_out(nullptr)); !fits) return fits;
    lay_out(sorting_.base);
    if (!derived) room.derived_slot = nullptr;
    return {};
  }

  /// A grid whose cells are no narrower than H along any axis, for particles sorted by cell.
  static void use_cells_of_support(Frame<T>& w) {
    Grid<T>& g = w.grid;
    const std::int32_t nx = maximum(g.nx / g.reach, 1);
    g.inv_cell.x *= static_cast<T>(nx) / static_cast<T>(g.nx);
    g.nx = nx;
    g.reach = 1;
    g.rows = (g.periodic & 1u) != 0u ? 18u : 9u;
    w.cells = 0;
    w.tree.levels = 0;
    w.f.group_ranges = nullptr;
    const double all = double(g.nx) * double(g.ny) * double(g.nz);
    w.key_bits = std::min(64u, static_cast<std::uint32_t>(std::ceil(std::log2(all + 1.0))) + 1u);
  }

  Block tables_, sorting_;
  ProbeViews<T> views_;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
