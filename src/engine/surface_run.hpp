// SPDX-License-Identifier: Apache-2.0
// The surface of an engine: its buffers, kept between calls, its grid, and the host's side of a
// call.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "engine/engine.hpp"
#include "engine/scene.hpp"
#include "engine/surface_request.hpp"
#include "engine/text.hpp"
#include "exec/repeat_key.hpp"
#include "frame/surface_frame.hpp"
#include "meltsim/result.hpp"
#include "pipeline/stage_functions.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

template <class E, class T>
class SurfaceRun {
 public:
  /// Waits, or not where the request says so and the kind of surface is known. True: the World has halted; the mesh is that of the
  /// state as it lies there.
  /// reserved: items that the engine's own verbs work on. timed: what is enqueued is, as surface_stage.
  /// mesh: null if only the view is requested.
  Result<bool> run(E& ex, const Frame<T>& scene, std::uint64_t reserved, bool timed, const SurfaceRequest& q,
                   SurfaceView& view, SurfaceMesh* mesh) {
    view = {};
    view.backend = E::backend;
    view.stream = ex.native_stream();
    if (scene.born == 0) return false;
    describe(scene, q);
    Room& room = rooms_[static_cast<std::size_t>(q.of)][q.anisotropic ? 1 : 0];
    look_back(ex);
    if (room.groups == 0) room = first_guess();
    const bool waits = q.waits || room.guessed || E::in_host_memory || !fit_counts(ex);
    for (;;) {
      if (Status s = build(ex, room, scene, reserved, timed, q); !s) return s.error();
      SurfaceCounts c;
      if (waits) ex.download(&c, w_.counts, sizeof c);
      else c = follow(ex, room);
      if (scene.f.status != nullptr) ex.set_guard(&scene.f.status->halted);
      if (const std::string fault = ex.fault(); !fault.empty())
        return Error{ErrorCode::internal, "device: " + fault};
      if (!waits || !grow(room, c)) {
        if (waits) shrink(room, c);
        describe(view, c);
        if (mesh != nullptr) fetch(ex, view, *mesh);
        const std::string lost = ex.fault();
        if (!lost.empty()) return Error{ErrorCode::internal, "device: " + lost};
        return c.halted != 0;
      }
    }
  }

  void release(E& ex) {
    if (arena_ != nullptr) ex.release(arena_);
    arena_ = nullptr;
    arena_bytes_ = 0;
    forget_ = true;
    if (host_ != nullptr) ex.release_pinned(host_);
    host_ = nullptr;
    host_bytes_ = 0;
    if (mark_ != nullptr) ex.release_mark(mark_);
    mark_ = nullptr;
    if (followed_ != nullptr) ex.wait_for_mark(counts_mark_);
    followed_ = nullptr;
    if (counts_ != nullptr) ex.release_pinned(counts_);
    counts_ = nullptr;
    if (counts_mark_ != nullptr) ex.release_mark(counts_mark_);
    counts_mark_ = nullptr;
  }
  std::uint64_t bytes() const { return arena_bytes_; }

 private:
  struct Room;

  Status build(E& ex, const Room& room, const Frame<T>& scene, std::uint64_t reserved, bool timed,
               const SurfaceRequest& q) {
    w_.max_groups = room.groups;
    w_.max_blocks = room.blocks;
    w_.max_vertices = room.vertices;
    w_.max_triangles = room.triangles;
    if (Status s = fit(ex, reserved); !s) return s;
    ex.set_guard(nullptr);
    if (timed) ex.begin_stage(surface_stage, "surface.build");
    enqueue(ex, q, scene);
    if (timed) ex.end_stage(surface_stage);
    return {};
  }

  /// Page-locked memory for counts that are fetched without waiting; false if there is none.
  bool fit_counts(E& ex) {
    if (counts_mark_ == nullptr) counts_mark_ = ex.make_mark();
    if (counts_ == nullptr) counts_ = static_cast<SurfaceCounts*>(ex.allocate_pinned(sizeof(SurfaceCounts)));
    return counts_mark_ != nullptr && counts_ != nullptr;
  }

  /// Enqueues the copy of this surface's counts to the host, for a later call to read; one copy at a time. Until then its size is
  /// that of its buffers.
  SurfaceCounts follow(E& ex, Room& room) {
    if (followed_ == nullptr) {
      ex.begin_copies();
      ex.copy_out(counts_, w_.counts, sizeof *counts_);
      ex.end_copies(counts_mark_);
      followed_ = &room;
    }
    SurfaceCounts c;
    c.vertices = room.vertices;
    c.triangles = room.triangles;
    return c;
  }

  /// Reads counts that have arrived. Room grows before it is used up, because a surface that exceeds it is not drawn.
  void look_back(E& ex) {
    if (followed_ == nullptr || !ex.reached(counts_mark_)) return;
    Room& room = *std::exchange(followed_, nullptr);
    const auto soon = [](std::uint32_t n) { return n + n / 8; };
    const SurfaceCounts& c = *counts_;
    if (!grow(room, {soon(c.groups), soon(c.blocks), soon(c.vertices), soon(c.triangles), 0}))
      shrink(room, c);
  }

  void describe(const Frame<T>& scene, const SurfaceRequest& q) {
    w_.position = scene.f.position;
    w_.enthalpy = scene.f.enthalpy;
    w_.enthalpy_of_id = scene.f.enthalpy_of_id;
    w_.mass = scene.f.mass;
    w_.tag = scene.f.tag;
    w_.id = scene.f.id;
    w_.slot_of_id = scene.f.slot_of_id;
    w_.materials = scene.f.materials;
    w_.status = scene.f.status;
    w_.particles = scene.born;
    capacity_ = scene.capacity;
    w_.only_solids = q.of == SurfaceOf::liquid ? 0u : 1u;
    w_.only_body = q.of == SurfaceOf::body ? q.body : 0u;
    w_.two_fields = q.of == SurfaceOf::liquid && q.solids;
    // A third of a cell hides what smoothing moves; a quarter of a spacing stays inside the thinnest solid.
    const double overlap = std::min(1.0 / 3, 0.25 * q.spacing / q.cell);
    w_.overlap = w_.two_fields && !q.closed ? static_cast<T>(overlap) : T(0);
    w_.anisotropic = q.anisotropic;
    w_.coarse_first = q.cell < 0.4 * q.spacing;  // at half a spacing it costs a GPU more than it saves
    if (spacing_ != q.spacing) {
      spacing_ = q.spacing;
      for (const bool anisotropic : {false, true})
        fields_[anisotropic ? 1 : 0] = physics::make_surface_field<T>(q.spacing, anisotropic);
    }
    w_.field = fields_[q.anisotropic ? 1 : 0];
    const double support = physics::surface_support(q.anisotropic) * q.spacing;
    w_.walls = scene.c.walls;
    w_.walls.support = w_.field.kernel.support;
    w_.walls.cover_scale = T(1);
    describe_grid(q, support);
  }

  static constexpr double most_blocks_along = 1 << 20;  ///< half of them, of a domain without bounds

  /// Blocks of the grid along each axis, and the corner that they begin at.
  struct GridExtent {
    double n[3] = {2 * most_blocks_along, 2 * most_blocks_along, 2 * most_blocks_along};
    Vec3d base;
  };

  /// Faces of the domain lie in the middle between two nodes, so that they cross edges where those are
  /// longest.
  void describe_grid(const SurfaceRequest& q, double support) {
    SurfaceGrid<T>& g = w_.grid;
    const auto side = static_cast<std::int32_t>(std::ceil(support / q.cell * (1 - 1e-9)));
    g.side = side;
    g.volume = static_cast<std::uint32_t>(side * side * side);
    const double edge = side * q.cell, half = 0.5 * q.cell;
    g.cell = static_cast<T>(q.cell);
    g.edge = static_cast<T>(edge);
    g.inv_edge = static_cast<T>(1 / edge);
    g.offset = 1 << 20;
    GridExtent extent;
    extent.base = {-half, -half, -half};
    if (q.domain.bounded) fit_grid(q, edge, half, extent);
    clip_at_faces(q.domain);
    shift_positions(q);
    const double* const n = extent.n;
    g.base = cast<T>(extent.base);
    g.nx = static_cast<std::int32_t>(n[0]);
    g.ny = static_cast<std::int32_t>(n[1]);
    g.nz = static_cast<std::int32_t>(n[2]);
    // The key of particles that take no part, cut to these bits, still sorts last.
    g.key_bits =
        std::min(64u, static_cast<std::uint32_t>(std::ceil(std::log2(n[0] * n[1] * n[2] + 1.0))) + 1u);
  }

  void fit_grid(const SurfaceRequest& q, double edge, double half, GridExtent& extent) {
    const Vec3d e = q.domain.max - q.domain.min;
    const double along[3] = {e.x, e.y, e.z};
    extent.base = extent.base + q.domain.min;
    const double cells = std::ceil((std::max({e.x, e.y, e.z}) + half) / edge) + 2;
    if (cells >= 2 * most_blocks_along) return;
    for (std::size_t a = 0; a < 3; ++a)  // a block beyond the domain on each side
      extent.n[a] = std::ceil((along[a] + half) / edge) + 2;
    w_.grid.offset = 1;
  }

  /// The surface ends at faces that are not open; across periodic ones it goes on.
  void clip_at_faces(const DomainDesc& d) {
    const double far = 0.25 * static_cast<double>(std::numeric_limits<T>::max());
    double low[3] = {-far, -far, -far}, high[3] = {far, far, far};
    w_.period = {};
    if (d.bounded) {
      const double from[3] = {d.min.x, d.min.y, d.min.z}, to[3] = {d.max.x, d.max.y, d.max.z};
      T* const period[3] = {&w_.period.x, &w_.period.y, &w_.period.z};
      for (std::size_t a = 0; a < 3; ++a) {
        if (d.faces[2 * a] != Face::open) low[a] = from[a];
        if (d.faces[2 * a + 1] != Face::open) high[a] = to[a];
        if (d.faces[2 * a] == Face::periodic) *period[a] = static_cast<T>(to[a] - from[a]);
      }
    }
    w_.clip_min = cast<T>(Vec3d{low[0], low[1], low[2]});
    w_.clip_max = cast<T>(Vec3d{high[0], high[1], high[2]});
  }

  /// Positions are handed out in single precision: far from the origin, relative to the middle of the domain.
  void shift_positions(const SurfaceRequest& q) {
    w_.shift = {};
    if (!q.domain.bounded) return;
    const Vec3d &low = q.domain.min, &high = q.domain.max;
    const double reach = std::max({std::fabs(low.x), std::fabs(low.y), std::fabs(low.z), std::fabs(high.x),
                                   std::fabs(high.y), std::fabs(high.z)});
    if (!(reach * 6e-8 > 1e-3 * q.spacing)) return;
    const Vec3d middle = (low + high) * 0.5;
    w_.shift = cast<T>(Vec3d{std::floor(middle.x), std::floor(middle.y), std::floor(middle.z)});
  }

  /// Capacities of the buffers of results.
  struct Room {
    std::uint32_t groups = 0, blocks = 0, vertices = 0, triangles = 0;
    bool guessed = true;  ///< nothing has been found yet
  };

  /// Capacities that suffice for a compact body of liquid.
  Room first_guess() const {
    Room r;
    r.groups = static_cast<std::uint32_t>(capacity_ / 12 + 64);
    r.blocks = std::min(r.groups, static_cast<std::uint32_t>(20 * std::pow(r.groups, 2.0 / 3)) + 64);
    r.vertices = 12 * r.blocks + 1024;
    r.triangles = 2 * r.vertices;
    return r;
  }

  static std::uint32_t enough_for(std::uint32_t count) {
    return static_cast<std::uint32_t>(
        std::min<std::uint64_t>(count + std::uint64_t{count} / 4 + 64, none - 1));
  }

  /// Enlarges capacities that were exceeded; false if none was. A count is valid only if the counts before it
  /// fitted.
  bool grow(Room& r, const SurfaceCounts& c) {
    const auto more = [](std::uint32_t& room, std::uint32_t needed) {
      if (needed <= room) return false;
      room = enough_for(needed);
      return true;
    };
    bool grown = more(r.groups, c.groups);
    if (!grown) grown = more(r.blocks, c.blocks);
    if (!grown) {
      grown = more(r.vertices, c.vertices);
      grown = more(r.triangles, c.triangles) || grown;
    }
    forget_ = forget_ || grown;
    return grown;
  }

  /// Kernels run over all of the room, so that too much of it costs time; to change it costs what was
  /// recorded.
  void shrink(Room& r, const SurfaceCounts& c) {
    const std::uint32_t most = r.guessed ? 1 : 2;
    r.guessed = false;
    const auto less = [this, most](std::uint32_t& room, std::uint32_t needed) {
      if (room / most <= enough_for(needed)) return;
      room = enough_for(needed);
      forget_ = true;
    };
    less(r.groups, c.groups);
    less(r.blocks, c.blocks);
    less(r.vertices, c.vertices);
    less(r.triangles, c.triangles);
  }

  struct Arena {
    unsigned char* base;
    std::uint64_t used = 0;
    template <class V>
    void place(V*& p, std::uint64_t n) {
      p = reinterpret_cast<V*>(base + used);
      used += (n * sizeof(V) + 255) / 256 * 256;
    }
  };

  std::uint64_t lay_out(void* base) {
    Arena a{static_cast<unsigned char*>(base)};
    CubeCase* cases = nullptr;
    a.place(cases, 256);
    w_.cases = cases;
    a.place(w_.counts, 1);
    a.place(w_.draw, 1);
    lay_out_particles(a, capacity_);
    lay_out_groups(a, w_.max_groups);
    lay_out_blocks(a, w_.max_blocks);
    lay_out_mesh(a, w_.max_vertices);
    return a.used;
  }

  void lay_out_particles(Arena& a, std::uint64_t n) {
    a.place(w_.key, n);
    a.place(w_.key_out, n);
    a.place(w_.slot, n);
    a.place(w_.slot_out, n);
    a.place(w_.group_of, n);
    a.place(w_.point, n);
    a.place(w_.share, n);
    a.place(w_.shape, w_.anisotropic ? n : 0);
    a.place(w_.solid_share, n);
    a.place(w_.mark, n);
    a.place(w_.at_surface, n);
    a.place(w_.heat, n);
  }

  void lay_out_groups(Arena& a, std::uint64_t g) {
    a.place(w_.group_key, g);
    a.place(w_.group_begin, g + 1);
    a.place(w_.group_rows, 9 * g);
    a.place(w_.group_near, 9 * g);
    a.place(w_.group_mark, g);
    a.place(w_.group_deep, g);
    a.place(w_.owns, 27 * g);
  }

  void lay_out_blocks(Arena& a, std::uint64_t b) {
    const std::uint64_t nodes = b * w_.grid.volume;
    a.place(w_.block_key, b);
    a.place(w_.block_rows, 9 * b);
    a.place(w_.block_link, 27 * b);
    a.place(w_.value, nodes);
    a.place(w_.solid_value, nodes);
    a.place(w_.inside, nodes);
    a.place(w_.code, nodes);
    a.place(w_.ends, nodes);
  }

  void lay_out_mesh(Arena& a, std::uint64_t v) {
    a.place(w_.vertex_edge, v);
    a.place(w_.vertex, v);
    a.place(w_.vertex_next, v);
    a.place(w_.ring, v);
    a.place(w_.out_position, v);
    a.place(w_.out_normal, v);
    a.place(w_.out_temperature, v);
    a.place(w_.out_fraction, v);
    a.place(w_.out_body, v);
    a.place(w_.out_material, v);
    a.place(w_.out_triangles, std::uint64_t{3} * w_.max_triangles);
  }

  /// Allocates the capacities. Recorded graphs of steps are discarded if their working space moves.
  Status fit(E& ex, std::uint64_t reserved) {
    const std::uint64_t nodes = std::uint64_t{w_.max_blocks} * w_.grid.volume;
    const auto too_much = [](std::uint64_t bytes) {
      return Error{ErrorCode::out_of_memory, text("surface: cell: so fine a mesh needs ", double(bytes) / 1e9,
                                                  " GB of working space; use larger cells")};
    };
    const std::uint64_t needed = lay_out(nullptr);
    if (nodes >= (std::uint64_t{1} << 30) || std::uint64_t{w_.max_triangles} * 3 >= none)
      return too_much(needed);
    if (needed > arena_bytes_) {
      release(ex);
      if (needed > ex.free_bytes()) return too_much(needed);
      arena_ = ex.allocate(needed);
      if (arena_ == nullptr) return too_much(needed);
      arena_bytes_ = needed;
      lay_out(arena_);
      static const std::array<CubeCase, 256> cases = make_cube_table();
      ex.upload(const_cast<CubeCase*>(w_.cases), cases.data(),
                sizeof cases);  // the first thing in any layout
    }
    lay_out(arena_);
    if (forget_) ex.forget_repeats();
    forget_ = false;
    const std::uint64_t before = ex.reserved_bytes();
    if (!ex.reserve(std::max({reserved, std::uint64_t{27} * w_.max_groups, nodes, capacity_})))
      return too_much(needed);
    if (ex.reserved_bytes() != before) ex.forget_repeats();
    return {};
  }

  RepeatKey key(const SurfaceRequest& q, const Frame<T>& scene) const {
    std::uint64_t cell;
    std::memcpy(&cell, &q.cell, sizeof cell);
    return {~std::uint64_t{0},  // no sub-step has all stages
            static_cast<std::uint64_t>(q.of) | (q.anisotropic ? 8u : 0u) | (q.solids ? 16u : 0u) |
                (q.closed ? 32u : 0u) | static_cast<std::uint64_t>(q.smoothing) << 8,
            q.body,
            cell,
            reinterpret_cast<std::uintptr_t>(scene.f.position),
            scene.born,
            0,
            0};
  }

  /// Recorded when the same call repeats: recording costs more than one replay saves.
  void enqueue(E& ex, const SurfaceRequest& q, const Frame<T>& scene) {
    const auto all = [&] { surface::build<E, T>(ex, w_, q.smoothing); };
    const RepeatKey now = key(q, scene);
    const bool again = std::find(recent_.begin(), recent_.end(), now) != recent_.end();
    if (again) return ex.repeat(now, all);
    recent_[next_recent_++ % recent_.size()] = now;
    all();
  }

  void describe(SurfaceView& view, const SurfaceCounts& c) const {
    view.origin = cast<double>(w_.shift);
    view.vertices = c.vertices;
    view.triangles = c.triangles;
    if (c.vertices == 0) return;
    view.position = w_.out_position;
    view.normal = w_.out_normal;
    view.temperature = w_.out_temperature;
    view.liquid_fraction = w_.out_fraction;
    view.body = w_.out_body;
    view.material = w_.out_material;
    view.triangle = w_.out_triangles;
    view.draw = w_.draw;
  }

  /// f(a vector of the mesh, the same in the view, entries) for each.
  template <class F>
  static void for_arrays(const SurfaceView& view, SurfaceMesh& mesh, const F& f) {
    f(mesh.position, view.position, view.vertices);
    f(mesh.normal, view.normal, view.vertices);
    f(mesh.temperature, view.temperature, view.vertices);
    f(mesh.liquid_fraction, view.liquid_fraction, view.vertices);
    f(mesh.body, view.body, view.vertices);
    f(mesh.material, view.material, view.vertices);
    f(mesh.triangles, view.triangle, 3 * view.triangles);
  }

  /// By way of page-locked memory, which a device writes several times as fast as any other, in copies that wait for
  /// one another at the end only.
  void fetch(E& ex, const SurfaceView& view, SurfaceMesh& mesh) {
    mesh.origin = view.origin;
    if (view.vertices == 0) return;
    std::uint64_t bytes = 0;
    for_arrays(view, mesh, [&](auto&, const auto* from, std::uint64_t n) { bytes += n * sizeof *from; });
    if (E::in_host_memory || !fit_host(ex, bytes)) {
      for_arrays(view, mesh, [&](auto& to, const auto* from, std::uint64_t n) {
        to.resize(static_cast<std::size_t>(n));
        ex.download(to.data(), from, n * sizeof *from);
      });
      return;
    }
    const auto in_turn = [&](const auto& f) {
      const unsigned char* at = host_;
      for_arrays(view, mesh, [&](auto& to, const auto* from, std::uint64_t n) {
        f(to, from, at, n);
        at += n * sizeof *from;  // all are of four bytes or three times four
      });
    };
    ex.begin_copies();
    in_turn([&](auto&, const auto* from, const unsigned char* at, std::uint64_t n) {
      ex.copy_out(const_cast<unsigned char*>(at), from, n * sizeof *from);
    });
    ex.end_copies(mark_);
    ex.wait_for_mark(mark_);
    in_turn([](auto& to, const auto* from, const unsigned char* at, std::uint64_t n) {
      const auto* first = reinterpret_cast<decltype(from)>(at);
      to.assign(first, first + n);
    });
  }

  /// Room in page-locked memory; false where there is none.
  bool fit_host(E& ex, std::uint64_t bytes) {
    if (mark_ == nullptr) mark_ = ex.make_mark();
    if (mark_ == nullptr) return false;
    if (bytes <= host_bytes_) return true;
    if (host_ != nullptr) ex.release_pinned(host_);
    host_bytes_ = bytes + bytes / 4;  // the next surface may be a little larger
    host_ = static_cast<unsigned char*>(ex.allocate_pinned(host_bytes_));
    if (host_ == nullptr) host_bytes_ = 0;
    return host_ != nullptr;
  }

  SurfaceFrame<T> w_;
  void* arena_ = nullptr;
  std::uint64_t arena_bytes_ = 0;
  unsigned char* host_ = nullptr;  ///< page-locked, for what fetch() brings
  std::uint64_t host_bytes_ = 0;
  void* mark_ = nullptr;
  SurfaceCounts* counts_ = nullptr;  ///< page-locked, counts of a surface that was not waited for
  void* counts_mark_ = nullptr;
  Room* followed_ = nullptr;           ///< whose counts are on their way
  Room rooms_[3][2];                   ///< per SurfaceOf and kernel
  bool forget_ = false;                ///< what was recorded points elsewhere
  std::uint64_t capacity_ = 0;         ///< particles
  std::array<RepeatKey, 6> recent_{};  ///< both halves of the double buffer, of a few kinds of surface
  std::size_t next_recent_ = 0;
  double spacing_ = 0;
  physics::SurfaceField<T> fields_[2];  ///< isotropic, anisotropic
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
