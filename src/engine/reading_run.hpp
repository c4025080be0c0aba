// SPDX-License-Identifier: Apache-2.0
// Readings of an engine: a few slots, each with its own buffers on device and host, so that the state may advance
// while a reading is copied.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "engine/engine.hpp"
#include "engine/scales.hpp"
#include "engine/scene.hpp"
#include "engine/text.hpp"
#include "frame/reading_frame.hpp"
#include "meltsim/physics/piece_motion.hpp"
#include "meltsim/result.hpp"
#include "pipeline/stage_functions.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

template <class E, class T>
class ReadingRun {
 public:
  /// Values that stay the same until the next upload.
  void describe(const SceneConstants& c, const SceneLattice& l, const Scales& scales) {
    domain_ = c.domain;
    spacing_ = c.spacing;
    set_gravity(c.surroundings.gravity);
    origins_.clear();
    extend(l, scales, 0);
  }

  /// With the bodies whose vertices were added last.
  void extend(const SceneLattice& l, const Scales& scales, std::size_t first_vertex) {
    largest_mass_ = scales.largest_mass;
    size_ = 8 * scales.body_size * scales.spacing;
    sum_bits_ = scales.sum_bits;
    add_body_origins(l, first_vertex, origins_);
    origins_sent_ = false;
    bodies_ = l.bodies.size();
  }

  /// Gravity of readings that are enqueued from now on.
  void set_gravity(Vec3d gravity) {
    gravity_ = gravity;
    grid_ = columns_of(gravity, domain_, spacing_);
  }

  /// Enqueues the requested parts. rolled_back: the World halted and `scene` holds its last
  /// good state. Errors: out_of_memory; nothing is enqueued then.
  Status request(E& ex, const Frame<T>& scene, int slot, const ReadParts& parts, bool rolled_back,
                 bool has_density) {
    Slot& s = slots_[static_cast<std::size_t>(slot)];
    choose_parts(s, scene, parts);
    if (Status fits = fit(ex, s, scene.vertices); !fits) return fits;
    ReadingFrame<T> w = frame_of(s, scene);
    w.rolled_back = rolled_back ? 1u : 0u;
    w.has_density = has_density ? 1u : 0u;
    w.clears = parts.clears ? 1u : 0u;
    w.bodies_taken = s.parts.forces ? static_cast<std::uint32_t>(s.bodies) : 0u;
    w.events_taken = static_cast<std::uint32_t>(s.events);
    ex.set_guard(nullptr);
    reading::status<E, T>(ex, w);
    if (!rolled_back && scene.f.status != nullptr) ex.set_guard(&scene.f.status->halted);
    if (s.parts.sums) reading::sums<E, T>(ex, w);
    if (s.counts) reading::count_pieces<E, T>(ex, w);
    if (s.parts.pieces) reading::pieces<E, T>(ex, w);
    if (s.parts.forces || s.parts.events) reading::records<E, T>(ex, w);
    if (s.parts.particles) reading::pack<E, T>(ex, w);
    if (scene.f.status != nullptr) ex.set_guard(&scene.f.status->halted);
    bring_to_host(ex, s, scene.probes.values);
    s.open = true;
    return {};
  }

  /// Enqueues particles by id, in a buffer of their own, with colours if there is a table of them (256 entries). Waits for memory,
  /// and for a table that is not that of the time before.
  Status pack(E& ex, const Frame<T>& scene, bool rolled_back, bool has_density, const PackColors& colors,
              const std::vector<std::uint32_t>& table, PackedParticles& to) {
    const std::uint64_t plain = padded(scene.capacity * PackedParticles::bytes(scene.species)),
                        colored =
                            padded(256 * sizeof(std::uint32_t)) + scene.capacity * sizeof(std::uint32_t),
                        bytes = plain + (table.empty() ? 0 : colored);
    if (Status fits = fit_packed(ex, bytes); !fits) return fits;
    to = PackedParticles::at(packed_, scene.born, scene.species);
    if (scene.born == 0) return {};
    ReadingFrame<T> w;
    w.s = scene;
    w.rolled_back = rolled_back ? 1u : 0u;
    w.has_density = has_density ? 1u : 0u;
    if (!table.empty()) {
      auto* const entries = reinterpret_cast<std::uint32_t*>(packed_ + plain);
      if (table != table_ || plain != table_at_) {
        ex.synchronize();  // what is enqueued reads the old one
        ex.upload(entries, table.data(), table.size() * sizeof(std::uint32_t));
        table_ = table;
        table_at_ = plain;
      }
      to.color = reinterpret_cast<std::uint32_t*>(packed_ + plain + padded(256 * sizeof(std::uint32_t)));
      w.colors = colors;
      w.colors.table = entries;
    }
    w.p = to;
    ex.set_guard(!rolled_back && scene.f.status != nullptr ? &scene.f.status->halted : nullptr);
    reading::pack<E, T>(ex, w);
    if (scene.f.status != nullptr) ex.set_guard(&scene.f.status->halted);
    return {};
  }

  bool is_open(int slot) const { return slots_[static_cast<std::size_t>(slot)].open; }
  bool ready(E& ex, int slot) const { return ex.reached(slots_[static_cast<std::size_t>(slot)].mark); }
  /// Waits for the reading and returns its head.
  const ReadingHead& wait(E& ex, int slot) {
    Slot& s = slots_[static_cast<std::size_t>(slot)];
    ex.wait_for_mark(s.mark);
    return *reinterpret_cast<const ReadingHead*>(s.host);
  }
  const ReadParts& parts(int slot) const { return slots_[static_cast<std::size_t>(slot)].parts; }
  void keep_status(int slot, const WorldStatus& status) {
    reinterpret_cast<ReadingHead*>(slots_[static_cast<std::size_t>(slot)].host)->status = status;
  }
  /// Marks a reading that cannot be completed; take() returns this error.
  void lose(int slot, const Error& why) { slots_[static_cast<std::size_t>(slot)].lost = why.message; }
  const std::string& lost(int slot) const { return slots_[static_cast<std::size_t>(slot)].lost; }
  void close(int slot) { slots_[static_cast<std::size_t>(slot)].open = false; }

  /// The data of the reading; call after wait().
  void unpack(E& ex, int slot, StateReading& out) {
    Slot& s = slots_[static_cast<std::size_t>(slot)];
    const ReadingHead& head = *reinterpret_cast<const ReadingHead*>(s.host);
    out.status = head.status;
    out.sums = head.sums;
    if (s.species != 0 && s.parts.sums) out.contents = head.contents;
    out.extents = head.extents;
    out.piece_count = s.counts ? head.pieces : 0;
    if (s.parts.pieces) unpack_pieces(ex, s, head, out);
    if (s.parts.forces) {
      const auto* rows = reinterpret_cast<const ForcesRow*>(s.host + layout(s, s.rows_sent).forces);
      out.forces.assign(rows, rows + s.bodies);
    }
    if (s.parts.events) unpack_events(s, out);
    if (s.parts.particles) unpack_particles(s, out.particles);
    const auto* samples = reinterpret_cast<const double*>(s.host + layout(s, s.rows_sent).end);
    out.samples.assign(samples, samples + s.parts.samples);
  }

  void release(E& ex) {
    for (Slot& s : slots_) {
      if (s.marked) ex.wait_for_mark(s.mark);
      if (s.device != nullptr) ex.release(s.device);
      if (s.host != nullptr) ex.release_pinned(s.host);
      if (s.marked) ex.release_mark(s.mark);
      s = Slot{};
    }
    if (scratch_ != nullptr) ex.release(scratch_);
    if (packed_ != nullptr) ex.release(packed_);
    scratch_ = packed_ = nullptr;
    scratch_bytes_ = packed_bytes_ = 0;
    table_.clear();
  }
  /// On the device.
  std::uint64_t bytes() const {
    std::uint64_t n = scratch_bytes_ + packed_bytes_;
    for (const Slot& s : slots_) n += s.device_bytes;
    return n;
  }

 private:
  /// Limit per reading; some 24 MB.
  static constexpr std::uint32_t most_pieces = 65536;
  static constexpr double most_columns = 512;  ///< along an axis

  struct Slot {
    ReadParts parts;
    bool open = false, counts = false, marked = false;
    std::uint32_t born = 0, species = 0, rows = 0, rows_sent = 0;
    std::uint64_t bodies = 0;  ///< that there were
    std::uint64_t events = 0;  ///< rows of the ring
    unsigned char *device = nullptr, *host = nullptr;
    std::uint64_t device_bytes = 0, host_bytes = 0;
    void* mark = nullptr;
    std::string lost;
  };

  /// Where the parts of a slot begin [bytes].
  struct Layout {
    std::uint64_t head = 0, rows = 0, totals = 0, forces = 0, events = 0, particles = 0, end = 0;
  };
  /// Generous, as intervals between readings have some more or fewer samples.
  static std::uint64_t sample_room(std::uint64_t samples) {
    return (samples * sizeof(double) + 65535) / 65536 * 65536;
  }
  static std::uint64_t padded(std::uint64_t bytes) { return (bytes + 255) / 256 * 256; }
  static Layout layout(const Slot& s, std::uint32_t rows) {
    Layout l;
    l.rows = padded(sizeof(ReadingHead));
    l.totals = l.rows + padded(rows * sizeof(PieceRow));
    l.forces = l.totals + padded(rows * sizeof(PieceTotals));
    l.events = l.forces + (s.parts.forces ? padded(s.bodies * sizeof(ForcesRow)) : 0);
    l.particles = l.events + (s.parts.events ? padded(event_bytes(s)) : 0);
    l.end = l.particles + (s.parts.particles ? padded(s.born * PackedParticles::bytes(s.species)) : 0);
    return l;
  }

  static std::uint64_t event_bytes(const Slot& s) { return sizeof(EventHead) + s.events * sizeof(EventRow); }

  /// Working space shared by all slots: the device computes one reading after the other.
  struct Scratch {
    std::uint64_t origins = 0, labels = 0, pieces = 0, columns = 0, levels = 0, end = 0;
  };
  Scratch scratch_layout(std::uint64_t vertices) const {
    Scratch l;
    l.labels = padded(bodies_ * sizeof(std::uint32_t));
    l.pieces = l.labels + padded((vertices / 32 + 1) * sizeof(std::uint32_t));
    l.columns = l.pieces + padded(vertices * sizeof(std::uint32_t));
    std::uint64_t squares = 0;
    for (std::int32_t level = 0; level < grid_.levels; ++level) squares += squares_of(level);
    l.levels = l.columns + padded(squares_of(0) * sizeof(Column));
    l.end = l.levels + padded(squares * sizeof(LevelSums));
    return l;
  }
  std::uint64_t squares_of(std::int32_t level) const {
    return static_cast<std::uint64_t>(((grid_.na - 1) >> level) + 1) *
           static_cast<std::uint64_t>(((grid_.nb - 1) >> level) + 1);
  }

  /// Where an emitter brings particles each reading is larger than the one before, and to allocate makes the device wait: so what
  /// did not suffice once grows by half.
  static std::uint64_t with_growth(std::uint64_t bytes, std::uint64_t before) {
    return std::max(bytes, before + before / 2);
  }
  static bool fit_device(E& ex, Slot& s, std::uint64_t bytes) {
    const std::uint64_t room = with_growth(bytes, s.device_bytes);
    if (s.device != nullptr) ex.release(s.device);
    s.device_bytes = 0;
    if (room <= ex.free_bytes()) bytes = room;
    s.device = bytes <= ex.free_bytes() ? static_cast<unsigned char*>(ex.allocate(bytes)) : nullptr;
    if (s.device == nullptr) return false;
    ex.zero(s.device, bytes);  // gaps are copied along
    s.device_bytes = bytes;
    return true;
  }
  static bool fit_host(E& ex, Slot& s, std::uint64_t bytes) {
    const std::uint64_t room = with_growth(bytes, s.host_bytes);
    if (s.host != nullptr) ex.release_pinned(s.host);
    s.host_bytes = room;
    s.host = static_cast<unsigned char*>(ex.allocate_pinned(room));
    if (s.host == nullptr && room > bytes) {
      s.host_bytes = bytes;
      s.host = static_cast<unsigned char*>(ex.allocate_pinned(bytes));
    }
    if (s.host == nullptr) s.host_bytes = 0;
    return s.host != nullptr;
  }
  Status fit(E& ex, Slot& s, std::uint64_t vertices) {
    const std::uint64_t device = layout(s, s.rows).end,
                        host = layout(s, s.rows_sent).end + sample_room(s.parts.samples);
    const std::uint64_t scratch = s.counts ? scratch_layout(vertices).end : 0;
    const auto too_much = [](std::uint64_t bytes, const char* where) {
      return Error{ErrorCode::out_of_memory,
                   text("request: a reading needs ", double(bytes) / 1e9, " GB of ", where,
                        " memory that is not there; ask for less at a time, or use fewer particles")};
    };
    if (!s.marked) s.mark = ex.make_mark();
    s.marked = true;
    if (device > s.device_bytes && !fit_device(ex, s, device)) return too_much(device, "device");
    if (host > s.host_bytes && !fit_host(ex, s, host)) return too_much(host, "page-locked host");
    if (scratch > scratch_bytes_) {
      if (scratch_ != nullptr) ex.release(scratch_);
      scratch_bytes_ = 0;
      origins_sent_ = false;
      scratch_ = scratch <= ex.free_bytes() ? static_cast<unsigned char*>(ex.allocate(scratch)) : nullptr;
      if (scratch_ == nullptr) return too_much(scratch, "device");
      scratch_bytes_ = scratch;
    }
    if (scratch != 0 && !origins_sent_) {
      ex.upload(scratch_, origins_.data(), origins_.size() * sizeof(std::uint32_t));
      origins_sent_ = true;
    }
    return {};
  }

  ReadingFrame<T> frame_of(const Slot& s, const Frame<T>& scene) const {
    ReadingFrame<T> w;
    w.s = scene;
    w.largest_mass = largest_mass_;
    w.size = size_;
    w.sum_bits = sum_bits_;
    w.piece_room = s.rows;
    w.grid = grid_;
    w.gravity = gravity_;
    const Layout l = layout(s, s.rows);
    w.head = reinterpret_cast<ReadingHead*>(s.device + l.head);
    w.rows = reinterpret_cast<PieceRow*>(s.device + l.rows);
    w.totals = reinterpret_cast<PieceTotals*>(s.device + l.totals);
    w.forces = reinterpret_cast<ForcesRow*>(s.device + l.forces);
    w.event_head = reinterpret_cast<EventHead*>(s.device + l.events);
    w.events = reinterpret_cast<EventRow*>(w.event_head + 1);
    if (s.counts) {
      const Scratch c = scratch_layout(scene.vertices);
      w.body_origin = reinterpret_cast<const std::uint32_t*>(scratch_ + c.origins);
      w.is_label = reinterpret_cast<std::uint32_t*>(scratch_ + c.labels);
      w.piece_of = reinterpret_cast<std::uint32_t*>(scratch_ + c.pieces);
      w.columns = reinterpret_cast<Column*>(scratch_ + c.columns);
      w.levels = reinterpret_cast<LevelSums*>(scratch_ + c.levels);
    }
    if (s.parts.particles) w.p = PackedParticles::at(s.device + l.particles, s.born, s.species);
    return w;
  }

  void unpack_pieces(E& ex, const Slot& s, const ReadingHead& head, StateReading& out) {
    const std::uint32_t n = std::min(head.pieces, s.rows);
    last_pieces_ = head.pieces;
    const Layout host = layout(s, s.rows_sent);
    const auto* rows = reinterpret_cast<const PieceRow*>(s.host + host.rows);
    const auto* totals = reinterpret_cast<const PieceTotals*>(s.host + host.totals);
    std::vector<PieceRow> more_rows;
    std::vector<PieceTotals> more_totals;
    if (n > s.rows_sent) {  // more than were expected: they are still on the device
      const Layout device = layout(s, s.rows);
      more_rows.resize(n);
      more_totals.resize(n);
      ex.download(more_rows.data(), s.device + device.rows, n * sizeof(PieceRow));
      ex.download(more_totals.data(), s.device + device.totals, n * sizeof(PieceTotals));
      rows = more_rows.data();
      totals = more_totals.data();
    }
    for (std::uint32_t k = 0; k < n; ++k) out.pieces.push_back(piece_of(rows[k], totals[k], head.units));
  }

  void unpack_events(const Slot& s, StateReading& out) const {
    const auto* head = reinterpret_cast<const EventHead*>(s.host + layout(s, s.rows_sent).events);
    const auto* rows = reinterpret_cast<const EventRow*>(head + 1);
    out.event_head = *head;
    const std::uint64_t n = std::min(head->written, s.events);
    out.events.reserve(n);
    for (std::uint64_t k = head->written - n; k < head->written; ++k)
      out.events.push_back(rows[k % s.events]);
  }

  static PieceReading piece_of(const PieceRow& row, const PieceTotals& t, const PieceUnits& units) {
    const auto value = [](std::int64_t n, const SumUnit& unit) { return static_cast<double>(n) * unit.size; };
    const auto vector = [&](const std::int64_t(&n)[3], const SumUnit& unit) {
      return Vec3d{value(n[0], unit), value(n[1], unit), value(n[2], unit)};
    };
    const SumUnits& q = units.sums;
    PieceReading p;
    p.label = row.label;
    p.body = row.body;
    p.particles = static_cast<std::uint64_t>(t.count);
    p.mass = value(t.mass, q.mass);
    const double per_mass = 1 / p.mass;
    const Vec3d first = vector(t.first, q.first), momentum = vector(t.momentum, q.momentum);
    const Vec3d center = first * per_mass;
    p.center = row.at + center;
    p.velocity = momentum * per_mass;
    Mat3<double> second, turned;
    for (int k = 0; k < 3; ++k) {
      second.m[k][k] = value(t.second[k], q.second);
      second.m[(k + 1) % 3][(k + 2) % 3] = second.m[(k + 2) % 3][(k + 1) % 3] =
          value(t.second[3 + k], q.second);
      for (int n = 0; n < 3; ++n) turned.m[k][n] = value(t.turned[3 * k + n], q.second);
    }
    p.inertia = physics::inertia_about_center(p.mass, center, second);
    p.angular_velocity = physics::angular_velocity_of(p.inertia, center, momentum, vector(t.spin, q.spin));
    p.orientation = physics::orientation_of(p.mass, turned, first, vector(t.rest, q.first), row.turn);
    const auto low = [&](int axis) { return static_cast<double>(unordered(row.low[axis])); };
    const auto high = [&](int axis) { return -static_cast<double>(unordered(row.high[axis])); };
    p.low = row.at + Vec3d{low(0), low(1), low(2)};
    p.high = row.at + Vec3d{high(0), high(1), high(2)};
    p.temperature_mean = value(t.heat, units.heat) * per_mass;
    p.submerged_fraction = static_cast<double>(t.submerged) / PieceTotals::submerged_units / double(t.count);
    return p;
  }

  static void unpack_particles(const Slot& s, ParticleFrame& out) {
    const PackedParticles p =
        PackedParticles::at(s.host + layout(s, s.rows_sent).particles, s.born, s.species);
    std::uint32_t live = 0;
    for (std::uint32_t i = 0; i < s.born; ++i) live += is_removed(p.tag[i]) ? 0u : 1u;
    out.id.reserve(live);
    for (std::uint32_t i = 0; i < s.born; ++i)
      if (!is_removed(p.tag[i])) out.id.push_back(i);
    const auto take = [&](auto& to, const auto* from) {
      if (live == s.born) return to.assign(from, from + live);
      to.reserve(live);
      for (const std::uint32_t i : out.id) to.push_back(from[i]);
    };
    take(out.position, p.position);
    take(out.velocity, p.velocity);
    take(out.temperature, p.temperature);
    take(out.liquid_fraction, p.fraction);
    take(out.density, p.density);
    take(out.pressure, p.pressure);
    take(out.tag, p.tag);
    take(out.piece, p.piece);
    out.fractions.resize(s.species);
    for (std::uint32_t k = 0; k < s.species; ++k) take(out.fractions[k], p.solute[k]);
  }

  Status fit_packed(E& ex, std::uint64_t bytes) {
    if (bytes <= packed_bytes_) return {};
    ex.synchronize();
    if (packed_ != nullptr) ex.release(packed_);
    packed_bytes_ = 0;
    table_.clear();
    packed_ = bytes <= ex.free_bytes() ? static_cast<unsigned char*>(ex.allocate(bytes)) : nullptr;
    if (packed_ == nullptr)
      return Error{ErrorCode::out_of_memory, text("render_view: ", double(bytes) / 1e9,
                                                  " GB of device memory are not there; use fewer particles")};
    packed_bytes_ = bytes;
    return {};
  }

  /// Parts of a request that this scene has, and the number of rows of pieces.
  void choose_parts(Slot& s, const Frame<T>& scene, const ReadParts& parts) const {
    s.parts = parts;
    s.lost.clear();
    const bool lattice = scene.vertices != 0 && scene.f.vertex_state != nullptr &&
                         scene.f.vertex_piece != nullptr && scene.f.vertex_id != nullptr &&
                         scene.f.vertex_body != nullptr;
    s.counts = lattice && (parts.sums || parts.pieces);
    s.parts.pieces = parts.pieces && lattice && scene.f.vertex_site != nullptr && scene.f.bodies != nullptr;
    s.parts.sums = parts.sums || s.parts.pieces;
    s.parts.forces = parts.forces && scene.f.body_forces != nullptr;
    s.parts.events = parts.events && scene.f.event_head != nullptr;
    s.events = s.parts.events ? scene.event_capacity : 0;
    s.born = scene.born;
    s.species = scene.species;
    s.rows = s.parts.pieces ? std::min<std::uint32_t>(scene.vertices, most_pieces) : 0;
    s.rows_sent = std::min(
        s.rows, std::max<std::uint32_t>({256, static_cast<std::uint32_t>(2 * bodies_), 2 * last_pieces_}));
    s.bodies = bodies_;
  }

  /// Enqueues the copies. A copy costs the host as much as a kernel, so data that follow rows of which all are sent are copied
  /// together with them.
  void bring_to_host(E& ex, Slot& s, const double* samples) {
    const Layout host = layout(s, s.rows_sent), device = layout(s, s.rows);
    ex.begin_copies();
    const auto bring = [&](std::uint64_t to, std::uint64_t from, std::uint64_t bytes) {
      if (bytes != 0) ex.copy_out(s.host + to, s.device + from, bytes);
    };
    if (s.rows == s.rows_sent) {
      bring(0, 0, host.end);
    } else {
      bring(host.head, device.head, sizeof(ReadingHead));
      bring(host.rows, device.rows, s.rows_sent * sizeof(PieceRow));
      bring(host.totals, device.totals, s.rows_sent * sizeof(PieceTotals));
      bring(host.forces, device.forces, host.end - host.forces);
    }
    if (s.parts.samples != 0)
      ex.copy_out(s.host + host.end, samples + s.parts.first_sample, s.parts.samples * sizeof(double));
    ex.end_copies(s.mark);
  }

  /// Least and largest of the coordinates of a box along an axis.
  static void range_along(const DomainDesc& box, Vec3d axis, double& low, double& high) {
    low = infinity;
    high = -infinity;
    for (int k = 0; k < 8; ++k) {
      const Vec3d p{(k & 1) != 0 ? box.max.x : box.min.x, (k & 2) != 0 ? box.max.y : box.min.y,
                    (k & 4) != 0 ? box.max.z : box.min.z};
      low = std::min(low, dot(p, axis));
      high = std::max(high, dot(p, axis));
    }
  }

  static ColumnGrid columns_of(Vec3d gravity, const DomainDesc& domain, double spacing) {
    ColumnGrid g;
    const double weight = length(gravity);
    if (weight > 0) g.up = gravity * (-1 / weight);
    const Vec3d helper = std::fabs(g.up.y) < 0.9 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0};
    g.a = cross(g.up, helper);
    g.a = g.a * (1 / length(g.a));
    g.b = cross(g.up, g.a);
    g.side =
        2 * spacing;  // as spacings: on the lattice of a scene's beginning every column is as full as any
    g.floor = -infinity;
    if (domain.bounded) {
      fit_columns(g, domain);
    } else {
      g.na = g.nb = static_cast<std::int32_t>(most_columns) / 2;
      g.repeats = 1;
    }
    for (std::int32_t widest = std::max(g.na, g.nb) - 1; widest > 0; widest >>= 1) ++g.levels;
    return g;
  }

  /// Columns over all of a domain.
  static void fit_columns(ColumnGrid& g, const DomainDesc& domain) {
    double high_a = 0, high_b = 0, high = 0;
    range_along(domain, g.a, g.low_a, high_a);
    range_along(domain, g.b, g.low_b, high_b);
    range_along(domain, g.up, g.floor, high);
    const double widest = std::max(high_a - g.low_a, high_b - g.low_b);
    while (widest > most_columns * g.side) g.side *= 2;
    const auto along = [&](double extent) {
      return static_cast<std::int32_t>(std::max(1.0, std::ceil(extent / g.side * (1 - 1e-9))));
    };
    g.na = along(high_a - g.low_a);
    g.nb = along(high_b - g.low_b);
    const double aligned = std::max({std::fabs(g.up.x), std::fabs(g.up.y), std::fabs(g.up.z)});
    if (aligned > 1 - 1e-9) {  // else the domain's shadow is no rectangle
      g.extent_a = high_a - g.low_a;
      g.extent_b = high_b - g.low_b;
    }
  }

  /// Site at the low corner of its vertices of every body that has none yet. Bodies follow each other in the lattice.
  static void add_body_origins(const SceneLattice& l, std::size_t first_vertex,
                               std::vector<std::uint32_t>& origins) {
    origins.resize(l.bodies.size(), 0);
    for (std::size_t v = first_vertex; v < l.vertex_site.size();) {
      const std::uint32_t b = l.vertex_body[v];
      Vec3i low = l.vertex_coordinates[v];
      const std::int64_t zero = l.vertex_site[v] - offset_of(low, l.bodies[b]);  // site of (0, 0, 0)
      for (; v < l.vertex_site.size() && l.vertex_body[v] == b; ++v) {
        const Vec3i p = l.vertex_coordinates[v];
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      }
      origins[b] = static_cast<std::uint32_t>(zero + offset_of(low, l.bodies[b]));
    }
  }
  static std::int64_t offset_of(Vec3i p, const BodyRow& b) {
    return p.x + std::int64_t{p.y} * b.stride_y + std::int64_t{p.z} * b.stride_z;
  }

  std::array<Slot, most_readings + 1> slots_;             // the last one for reads that wait
  unsigned char *scratch_ = nullptr, *packed_ = nullptr;  ///< packed_: of pack()
  std::uint64_t scratch_bytes_ = 0, packed_bytes_ = 0;
  std::vector<std::uint32_t> table_;  ///< of colours, as it lies on the device
  std::uint64_t table_at_ = 0;        ///< where
  std::uint32_t last_pieces_ = 0;
  std::uint64_t bodies_ = 0;
  std::vector<std::uint32_t> origins_;
  bool origins_sent_ = false;
  double largest_mass_ = 1, size_ = 1;
  std::int32_t sum_bits_ = 40;
  ColumnGrid grid_;
  Vec3d gravity_;
  DomainDesc domain_;
  double spacing_ = 0;
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
