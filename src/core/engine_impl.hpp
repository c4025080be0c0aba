// SPDX-License-Identifier: Apache-2.0
// The engine over any executor: buffers, frame, and the walk down the stage table. No physics, no backend.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "core/checked.hpp"
#include "core/empty_sites.hpp"
#include "core/engine.hpp"
#include "core/frame.hpp"
#include "core/lane_positions.hpp"
#include "core/lattice.hpp"
#include "core/repeat_key.hpp"
#include "core/schedule.hpp"
#include "core/stage_functions.hpp"
#include "core/surface_run.hpp"
#include "meltsim/physics/integrate.hpp"
#include "meltsim/physics/phase_change.hpp"
#include "spatial/neighbour_words.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {

template <class E, class T>
class EngineImpl final : public Engine {
 public:
  EngineImpl(E exec, std::string device) : ex_(std::move(exec)), device_(std::move(device)) {}
  ~EngineImpl() override {
    ex_.synchronize();
    release();
  }

  Backend backend() const override { return E::backend; }
  std::string device_name() const override { return device_; }
  std::uint64_t channel_bytes(int field) const override { return bytes_[field] + previous_bytes_[field]; }
  std::uint64_t scratch_bytes() const override { return ex_.reserved_bytes() + surface_.bytes(); }
  std::uint64_t graphs() const override { return ex_.captures(); }
  std::uint64_t free_bytes() const override { return ex_.free_bytes(); }
  void set_custom_stages(const std::vector<PlacedStage>* stages) override { custom_ = stages; }
  void enable_timings(bool on) override { timed_ = on; }
  double median_ms(int stage) override { return ex_.collect().median(stage); }
  std::string fault() override {
    const std::string device = ex_.fault();
    return device.empty() ? broken_ : device;
  }

  std::uint64_t bytes_needed(const SceneConstants& c, const SceneLattice& l,
                             const EngineSetup& s) const override {
    const Sizes n = sizes(c, l, s);
    std::uint64_t total = 0;
    for (int i = 0; i < field_count; ++i)
      if ((s.channels >> i) & 1u) total += field_bytes(i, n) * (double_buffered(i) ? 2u : 1u);
    return total;
  }

  Status upload(const SceneConstants& c, const SceneLattice& l, const SceneState& state,
                const EngineSetup& setup) override {
    ex_.synchronize();
    release();
    w_ = Frame<T>{};
    const Sizes n = sizes(c, l, setup);
    const std::uint64_t needed = bytes_needed(c, l, setup), available = ex_.free_bytes();
    if (needed > available) return out_of_memory(needed, available);
    for (int i = 0; i < field_count; ++i) {
      if (((setup.channels >> i) & 1u) == 0) continue;
      const std::uint64_t bytes = field_bytes(i, n);
      if (bytes == 0) continue;
      buffers_[i] = ex_.allocate(bytes);
      if (buffers_[i] != nullptr) bytes_[i] = bytes;
      if (double_buffered(i)) previous_[i] = ex_.allocate(bytes);
      if (previous_[i] != nullptr) previous_bytes_[i] = bytes;
      if (buffers_[i] == nullptr || (double_buffered(i) && previous_[i] == nullptr)) {
        release();
        return out_of_memory(needed, available);
      }
      ex_.zero(buffers_[i], bytes);
      if (previous_[i] != nullptr) ex_.zero(previous_[i], bytes);
    }
    reserved_ =
        std::max(n.count[static_cast<int>(Owner::particle)], n.count[static_cast<int>(Owner::vertex)]);
    if (!ex_.reserve(reserved_)) return out_of_memory(needed, available);
    spare_position_ = n.spare_position;
    if constexpr (runs_lanes<E>) ex_.template reserve_split<T>(n.count[static_cast<int>(Owner::particle)]);
    link();
    fill_constants(c, l, n);
    fill_state(c, l, state);
    w_.solids = w_.vertices != 0 || std::any_of(state.tag.begin(), state.tag.end(), is_solid);
    // Sorted orders ask by id, liquid that freezes is found by it.
    w_.slots_of_all = (setup.facts & fact_packed) == 0 || (setup.facts & fact_freeze) != 0;
    ex_.set_guard(nullptr);
    step::reindex<E, T>(ex_, w_);
    if (w_.vertices != 0 && w_.f.vertex_site != nullptr && w_.f.site_vertex != nullptr)
      topology::build<E, T>(ex_, w_);
    if (w_.f.status != nullptr) ex_.set_guard(&w_.f.status->halted);
    ex_.synchronize();
    broken_.clear();
    mass_ = 0;
    for (const double m : state.mass) mass_ += m;
    return fault_status();
  }

  void substep(const SubstepArguments& a) override {
    if (rolled_back_) return;  // halted, and already back at the last good state
    if (a.bursts != nullptr)
      for (const BurstArguments& b : *a.bursts) emit(b);
    rebuild_ = rebuild_ || a.bursts != nullptr;
    if (w_.born == 0) return;
    swap_buffers();
    // A host's own stages may do anything, timings and checks look at stages one by one.
    const bool own_stages = custom_ != nullptr && !custom_->empty();
    const bool plain = !timed_ && !checked_build && !own_stages;
    // As long as this one is, so that particles drift as far; and nothing moves them between the two.
    const bool alone = !own_stages && !ex_.host_captures();
    w_.counted = alone && w_.count_ahead && !rebuild_ && counted_dt_ == a.dt;
    w_.count_ahead = alone && can_count_ahead(a.stages);
    w_.cells_begun = w_.counted && plain;
    const bool advances = plain && spare_position_ && liquid_alone(w_) && can_advance(a.stages);
    w_.next.position = advances ? static_cast<Vec4<T>*>(buffers_[field_acceleration]) : nullptr;
    w_.next.velocity = advances ? static_cast<Vec4<T>*>(previous_[field_velocity]) : nullptr;
    // Enthalpies are what they were when the state was put in order.
    w_.heat_at_hand = plain && fuses(ex_) && can_make_operands(a.stages);
    counted_dt_ = a.dt;
    w_.clock.dt = static_cast<T>(a.dt);
    w_.clock.half_dt = static_cast<T>(0.5 * a.dt);
    const double spring_dt = physics::spring_dt(a.dt, spring_reference_);
    w_.clock.spring_dt = static_cast<T>(spring_dt);
    w_.clock.step = a.index;
    w_.clock.time = a.time;
    w_.clock.rebuild = rebuild_ ? 1u : 0u;
    rebuild_ = false;
    w_.heat_dt = static_cast<T>(a.heat_dt);
    w_.heat_stages = static_cast<std::uint32_t>(a.heat_stages);
    w_.heat_supersteps = static_cast<std::uint32_t>(a.heat_supersteps);
    w_.c.heat_bound = a.heat_bound;
    // Exact sums: integers of 2^-bits of a heavy particle, moved by a spacing per step, at the far end of its
    // body. A modulus may be stiffer than springs are.
    const double modulus = std::min(1 / a.dt, 1.5 * largest_modulus_rate_ * a.dt);
    const double speed = spacing_ * std::max(1 / spring_dt, modulus), size = spacing_ * body_size_;
    const double mass = std::ldexp(largest_mass_, -sum_bits_);
    w_.sum_units = core::sum_units(mass, mass * speed, mass * speed * size, mass * size, mass * size * size);
    last_index_ = a.index;
    static_assert(stage_step_begin == 0);
    const auto begin = [&] {
      if (w_.cells_begun) step::begin_cells<E, T>(ex_, w_);
      else run(stage_step_begin, stage_functions<E, T>[stage_step_begin]);
    };
    if (plain) {
      ex_.repeat(repeat_key(a), begin, [&] { run_plain(a); });
    } else {
      begin();
      run_stages(a);
    }
    if (advances) take_next();
  }

  void rebuild() override { rebuild_ = true; }

  WorldStatus synchronize() override {
    WorldStatus s = last_good();
    if (w_.f.status == nullptr) return s;
    unguarded([&] { step::clear<E, T>(ex_, w_); });  // not by a copy: that would wait once more
    return s;
  }

  WorldStatus ledger() override {
    WorldStatus s = last_good();
    if (s.ledger_step == 0) return s;
    unguarded([&] { step::ledger<E, T>(ex_, w_); });
    ex_.download(&s.sums, &w_.f.status->sums, sizeof s.sums);
    return s;
  }

  void download(SceneState& s) override {
    last_good();
    const std::size_t n = w_.born, slots = w_.particles;
    const auto position = fetch(w_.f.position, slots), velocity = fetch(w_.f.velocity, slots);
    const auto enthalpy = fetch(w_.f.enthalpy, slots);
    const auto mass = fetch(w_.f.mass, slots);
    const auto tag = fetch(w_.f.tag, slots), id = fetch(w_.f.id, slots);
    s.position.resize(n);
    s.velocity.resize(n);
    s.enthalpy.resize(n);
    s.mass.resize(n);
    s.volume.resize(n);
    s.tag.resize(n);
    s.vertex_of_id.resize(n, none);
    for (std::size_t i = 0; i < slots; ++i) {
      const std::uint32_t k = id[i];
      if (k >= n) continue;  // to come
      s.position[k] = cast<double>(xyz(position[i]));
      s.velocity[k] = cast<double>(xyz(velocity[i]));
      s.enthalpy[k] = enthalpy[i];
      s.mass[k] = static_cast<double>(mass[i]);
      s.volume[k] = static_cast<double>(position[i].w);
      s.tag[k] = tag[i];
    }
    if (w_.f.vertex_of_id != nullptr) s.vertex_of_id = fetch(w_.f.vertex_of_id, n);
    if (w_.f.vertex_id != nullptr) s.vertex_id = fetch(w_.f.vertex_id, w_.vertices);
    if (w_.f.vertex_state != nullptr) s.vertex_state = fetch(w_.f.vertex_state, w_.vertices);
    if (w_.f.vertex_piece != nullptr) s.vertex_piece = fetch(w_.f.vertex_piece, w_.vertices);
    if (w_.f.region_rotation != nullptr) {
      const auto q = fetch(w_.f.region_rotation, w_.vertices);
      s.region_rotation.resize(q.size());
      for (std::size_t v = 0; v < q.size(); ++v)
        s.region_rotation[v] = {static_cast<double>(q[v].w), static_cast<double>(q[v].x),
                                static_cast<double>(q[v].y), static_cast<double>(q[v].z)};
    }
    if (w_.f.contact_slip != nullptr) {
      const auto slip = fetch(w_.f.contact_slip, w_.vertices);
      s.contact_slip.resize(slip.size());
      for (std::size_t v = 0; v < slip.size(); ++v) s.contact_slip[v] = cast<double>(slip[v]);
    }
    if (w_.f.status != nullptr) {
      WorldStatus status;
      ex_.download(&status, w_.f.status, sizeof status);
      s.melted = static_cast<std::uint64_t>(status.melted);
      s.frozen = status.frozen;
      s.removed = static_cast<std::uint64_t>(status.removed);
      s.heat_in = status.heat_in;
    }
  }

  void download(DerivedState& d) override {
    last_good();
    const std::size_t n = w_.born, slots = w_.particles;
    d.density.assign(n, 0.0);
    d.pressure_term.assign(n, 0.0);
    if (w_.f.density == nullptr || last_index_ == 0) return;
    // Those of a sub-step that halted stand in its order, which the World has gone back from.
    const auto density = fetch(w_.f.density, slots);
    const auto velocity = fetch<Vec4<T>>(rolled_back_ ? w_.before.velocity : w_.f.velocity, slots);
    const auto id = fetch<std::uint32_t>(rolled_back_ ? w_.before.id : w_.f.id, slots);
    for (std::size_t i = 0; i < slots; ++i) {
      if (id[i] >= n) continue;  // to come
      d.density[id[i]] = static_cast<double>(density[i]);
      d.pressure_term[id[i]] = static_cast<double>(velocity[i].w);
    }
  }

  void download(LatticeMasks& m) override {
    // What melted in the last sub-step leaves its regions at the beginning of the next.
    if (w_.f.region_mask != nullptr && w_.f.neighbour_mask != nullptr) topology::regions<E, T>(ex_, w_);
    ex_.synchronize();
    m.region_words = w_.region_words;
    if (w_.f.neighbour_mask != nullptr) m.neighbour_mask = fetch(w_.f.neighbour_mask, w_.vertices);
    if (w_.f.region_mask != nullptr)
      m.region_mask = fetch(w_.f.region_mask, static_cast<std::size_t>(w_.vertices) * w_.region_words);
  }

  Result<bool> surface(const SurfaceRequest& request, SurfaceMesh& mesh) override {
    if (!w_.slots_of_all) index_all();  // it takes particles in order of id
    auto halted = surface_.run(ex_, w_, reserved_, timed_, request, mesh);
    // The flag stays up after the World went back to its last good state.
    return halted && *halted && rolled_back_ ? Result<bool>(false) : halted;
  }

  StageContext context() const override {
    StageContext c;
    c.backend = E::backend;
    c.precision = sizeof(T) == 8 ? Precision::double_precision : Precision::single_precision;
    c.stream = ex_.native_stream();
    c.particles = w_.born;
    c.position = w_.f.position;
    c.velocity = w_.f.velocity;
    c.acceleration = w_.f.acceleration;
    c.enthalpy = w_.f.enthalpy;
    c.id = w_.f.id;
    c.tag = w_.f.tag;
    return c;
  }

 private:
  /// Scenes in which sph.advance never runs.
  static constexpr std::uint32_t not_advancing = fact_solid | fact_melt | fact_shifting | fact_viscosity |
                                                 fact_heat_enthalpy | fact_heat_paper | fact_heat_iwasaki;
  /// What depends on the backend goes as on a GPU: on a CPU, too, where both are to have the same bits.
  static constexpr bool as_gpu = E::lists || !sums_by_lanes;

  struct Sizes {
    std::uint64_t count[static_cast<int>(Owner::world) + 1] = {};
    std::uint64_t groups = 0, rows = 9;
    std::uint64_t cells = 0;      ///< where they are counted one by one
    bool spare_position = false;  ///< accelerations have room for positions
    int reach = 1;
    double skin = 0;  ///< of a kept grid [m]
    std::uint64_t tree_first[Tree<T>::most_levels] = {};
    int tree_levels = 0;
  };

  static bool double_buffered(int field) {
    return field_table[field].owner == Owner::particle && field_table[field].lifetime == Lifetime::State;
  }

  static bool periodic(const SceneConstants& c, int axis) {
    return c.domain.bounded && c.domain.faces[static_cast<std::size_t>(2 * axis)] == Face::periodic;
  }

  Sizes sizes(const SceneConstants& c, const SceneLattice& l, const EngineSetup& s) const {
    Sizes n;
    const auto set = [&n](Owner o, std::uint64_t v) { n.count[static_cast<int>(o)] = v; };
    n.groups = s.particle_capacity;
    if (c.domain.bounded) n.groups = std::min(n.groups, cell_count(c.domain, c.support, 1));
    if ((s.facts & fact_kept) != 0) n.skin = kept_skin * c.support;
    if ((s.facts & fact_packed) != 0) {
      n.reach = std::max(1, packed_reach(c.domain, c.support + n.skin, s.particle_capacity));
      n.cells = n.groups = cell_count(c.domain, c.support + n.skin, n.reach);
    }
    n.rows = periodic(c, 0) ? 18 : 9;
    if ((s.facts & fact_tree) != 0) {
      n.groups = s.particle_capacity;  // a leaf may hold one particle only
      n.rows = tree_rows;
      std::uint64_t nodes = 0;
      for (std::uint64_t level = n.groups; level != 0; level = level == 1 ? 0 : (level + 7) / 8) {
        n.tree_first[n.tree_levels++] = nodes;
        nodes += level;
      }
      set(Owner::tree_node, nodes);
    }
    n.spare_position = fuses(ex_) && (s.facts & fact_fluid) != 0 && (s.facts & not_advancing) == 0;
    set(Owner::particle, s.particle_capacity);
    set(Owner::particle_list, E::lists ? s.particle_capacity + 1 : 0);
    set(Owner::particle_bits, s.particle_capacity / 32 + 2);
    set(Owner::particle_rows, s.particle_capacity * n.rows);
    set(Owner::particle_words, most_words(c, s.particle_capacity, n.rows));
    set(Owner::id, s.particle_capacity);
    set(Owner::cell, n.cells + 2);
    set(Owner::cell_count, n.cells != 0 ? E::count_room(n.cells + 1) : 0);
    set(Owner::group, n.groups + 1);
    set(Owner::group_rows, n.groups * n.rows);
    set(Owner::vertex, l.vertex_site.size());
    set(Owner::vertex_fits, 4 * l.vertex_site.size());
    const bool rows = l.max_half_width >= least_row_width(as_gpu, l.vertex_site.size());
    set(Owner::vertex_rows, rows ? 7 * l.vertex_site.size() : 0);
    set(Owner::vertex_list, rows && E::lists ? l.vertex_site.size() + 1 : 0);
    set(Owner::vertex_words, l.vertex_site.size() * words_for(l.max_half_width));
    set(Owner::site, l.site_vertex.size());
    set(Owner::site_words, l.site_vertex.empty() ? 0 : l.site_vertex.size() / 32 + 2);
    set(Owner::body, l.bodies.size());
    set(Owner::material, c.materials.size());
    set(Owner::property, c.properties.size());
    set(Owner::emitter_point, c.emitter_points.size());
    set(Owner::heat_region, c.heat_regions.size());
    set(Owner::heat_region_word, c.heat_region_cells.size());
    set(Owner::world, 1);
    return n;
  }

  static std::uint64_t field_bytes(int field, const Sizes& n) {
    static constexpr std::uint64_t item[] = {
#define MELTSIM_FIELD(name, type, owner, lifetime, unit, doc) sizeof(type),
#include "meltsim/fields.def"
#undef MELTSIM_FIELD
    };
    const std::uint64_t size =
        field == field_acceleration && n.spare_position ? sizeof(Vec4<T>) : item[field];
    return size * n.count[static_cast<int>(field_table[field].owner)];
  }

  static Status out_of_memory(std::uint64_t needed, std::uint64_t available) {
    const auto gb = [](std::uint64_t b) {
      char text[32];
      std::snprintf(text, sizeof text, "%.1f", double(b) / 1e9);
      return std::string(text);
    };
    const std::string free = available == std::numeric_limits<std::uint64_t>::max()
                                 ? std::string("the system has not that much")
                                 : gb(available) + " GB free";
    return Error{ErrorCode::out_of_memory, "memory: " + gb(needed) + " GB needed, " + free +
                                               "; use fewer particles (larger spacing) or smaller "
                                               "region_half_width"};
  }

  Status fault_status() {
    const std::string f = ex_.fault();
    return f.empty() ? Status{} : Status{Error{ErrorCode::internal, "device: " + f}};
  }

  void release() {
    ex_.forget_repeats();
    surface_.release(ex_);
    for (int i = 0; i < field_count; ++i) {
      if (buffers_[i] != nullptr) ex_.release(buffers_[i]);
      if (previous_[i] != nullptr) ex_.release(previous_[i]);
      buffers_[i] = previous_[i] = nullptr;
      bytes_[i] = previous_bytes_[i] = 0;
    }
  }

  /// Points the frame at the buffers.
  void link() {
#define MELTSIM_FIELD(name, type, owner, lifetime, unit, doc) \
  w_.f.name = static_cast<type*>(buffers_[field_##name]);
#include "meltsim/fields.def"
#undef MELTSIM_FIELD
    w_.before.position = static_cast<Vec4<T>*>(previous_[field_position]);
    w_.before.velocity = static_cast<Vec4<T>*>(previous_[field_velocity]);
    w_.before.enthalpy = static_cast<double*>(previous_[field_enthalpy]);
    w_.before.mass = static_cast<T*>(previous_[field_mass]);
    w_.before.tag = static_cast<std::uint32_t*>(previous_[field_tag]);
    w_.before.id = static_cast<std::uint32_t*>(previous_[field_id]);
  }

  /// Waits. The status, and the World in its last good state, which the buffers may not show yet.
  WorldStatus last_good() {
    WorldStatus s;
    if (timed_ || w_.f.status == nullptr) ex_.synchronize();
    if (w_.f.status == nullptr) return s;
    ex_.download(&s, w_.f.status, sizeof s);
    roll_back(s);
    return s;
  }

  /// slot_of_id of everyone.
  void index_all() {
    if (w_.f.status != nullptr) unguarded([&] { step::reindex<E, T>(ex_, w_); });
  }

  /// Also of a World that halted.
  template <class Enqueue>
  void unguarded(const Enqueue& enqueue) {
    ex_.set_guard(nullptr);
    enqueue();
    ex_.set_guard(&w_.f.status->halted);
  }

  /// Whether no stage moves particles behind step.integrate, and cells are counted in every sub-step.
  static bool can_count_ahead(std::uint64_t stages) {
    return runs(stages, stage_spatial_cells) && runs(stages, stage_step_integrate) &&
           !runs(stages, stage_spatial_moved) && !runs(stages, stage_topology_freeze);
  }

  /// Whether spatial.settle or spatial.reorder may do the work of thermal.operands: no enthalpy changes between.
  static bool can_make_operands(std::uint64_t stages) {
    return (runs(stages, stage_spatial_settle) || runs(stages, stage_spatial_reorder)) &&
           runs(stages, stage_thermal_operands) && !runs(stages, stage_thermal_boundary);
  }

  static bool runs(std::uint64_t stages, int stage) { return ((stages >> stage) & 1u) != 0; }

  /// Whether sph.advance may take the place of sph.forces and step.integrate: nothing runs between them or behind.
  static bool can_advance(std::uint64_t stages) {
    return (stages >> stage_sph_forces) ==
           (std::uint64_t{1} | stage_bit(stage_step_integrate - stage_sph_forces));
  }

  /// sph.advance left the state in the buffer of accelerations, whose place the old positions take, and in that of the
  /// old velocities.
  void take_next() {
    void* const old = previous_[field_position];
    previous_[field_position] = buffers_[field_position];
    buffers_[field_position] = buffers_[field_acceleration];
    buffers_[field_acceleration] = old;
    std::swap(buffers_[field_velocity], previous_[field_velocity]);
    link();
  }

  /// To the last good state, once; the stream has been waited for. Sub-steps after the one that halted have exchanged
  /// buffers, and done nothing else.
  void roll_back(const WorldStatus& s) {
    if (s.halted == 0 || rolled_back_) return;
    const auto is = [](const void* buffer, std::uint64_t address) {
      return reinterpret_cast<std::uintptr_t>(buffer) == address;
    };
    if (spare_position_ && is(buffers_[field_acceleration], s.halt_position))
      std::swap(buffers_[field_acceleration], previous_[field_position]);
    if (!is(buffers_[field_position], s.halt_position))
      std::swap(buffers_[field_position], previous_[field_position]);
    // Velocities that are there in the new order only are the previous ones, whose order the previous ids say.
    if (is(buffers_[field_velocity], s.halt_velocity) != (s.halt_advanced == 0))
      std::swap(buffers_[field_velocity], previous_[field_velocity]);
    if (!is(buffers_[field_id], s.halt_id))
      for (const int i : {field_enthalpy, field_mass, field_tag, field_id})
        std::swap(buffers_[i], previous_[i]);
    link();
    w_.born = s.particles;
    use_slots(slots_for(w_.born));
    rolled_back_ = true;
    index_all();
    if (s.halt_advanced != 0) unguarded([&] { step::restore<E, T>(ex_, w_); });
    ex_.synchronize();
  }

  void swap_buffers() {
    for (int i = 0; i < field_count; ++i)
      if (double_buffered(i)) std::swap(buffers_[i], previous_[i]);
    link();
  }

  void fill_constants(const SceneConstants& c, const SceneLattice& l, const Sizes& n) {
    Constants<T>& k = w_.c;
    k.kernel = physics::make_kernel<T>(c.support, c.spacing);
    k.spacing = static_cast<T>(c.spacing);
    k.sound_speed = static_cast<T>(c.sound_speed);
    k.artificial_viscosity = static_cast<T>(c.artificial_viscosity);
    k.lowest_phi = c.tension ? T(0) : T(1);
    k.gravity = cast<T>(c.gravity);
    k.wall_friction = static_cast<T>(c.domain.friction);
    k.volume_rate = static_cast<T>(c.sound_speed / (physics::volume_relaxation * c.support));
    k.no_slip = c.domain.no_slip ? 1u : 0u;
    k.courant = static_cast<T>(c.courant);
    k.domain_min = k.walls.min = cast<T>(c.domain.min);
    k.domain_max = k.walls.max = cast<T>(c.domain.max);
    k.walls.support = static_cast<T>(c.support);
    k.wall_exchange = physics::make_wall_exchange<T>(c.support, c.spacing);
    k.walls.cover_scale = physics::wall_cover_scale<T>(c.support, c.spacing);
    k.walls.push_scale = physics::floor_push_scale<T>(c.support, c.spacing);
    k.first_layer = physics::wall_area(k.wall_exchange, T(0.5) * k.spacing) * k.spacing;
    k.heat_regions = static_cast<std::uint32_t>(c.heat_regions.size());
    k.leak_distance2 = static_cast<T>(std::pow(physics::leak_distance * c.spacing, 2));
    if (c.domain.bounded)
      for (int f = 0; f < 6; ++f) {
        const Face face = c.domain.faces[static_cast<std::size_t>(f)];
        if (face == Face::wall) k.walls.faces |= 1u << f;
        if (face == Face::open) k.open_faces |= 1u << f;
        k.wall_heat[f] = round_condition(c.wall_heat[static_cast<std::size_t>(f)]);
        if (k.wall_heat[f].kind != physics::SurfaceHeat::insulated) k.heated_walls |= 1u << f;
        k.wall_velocity[f] = cast<T>(c.domain.velocity[static_cast<std::size_t>(f)]);
      }
    fill_grid(c, c.support + n.skin, n.reach);
    w_.kept.reach2 = static_cast<T>(std::pow(c.support + n.skin, 2));
    w_.kept.moved2 = static_cast<T>(std::pow(0.4999 * n.skin, 2));
    if (n.tree_levels != 0) fill_tree(c, n);
    w_.max_groups = static_cast<std::uint32_t>(n.groups);
    w_.cells = static_cast<std::uint32_t>(n.cells);
    w_.vertices = static_cast<std::uint32_t>(l.vertex_site.size());
    w_.bits_stride = n.count[static_cast<int>(Owner::particle)];
    w_.one_liquid = c.one_liquid;
    w_.region_words = words_for(l.max_half_width);
    w_.row_width = least_row_width(as_gpu, w_.vertices);
    largest_mass_ = c.largest_mass > 0 ? c.largest_mass : 1.0;
    spacing_ = c.spacing;
    support_in_spacings_ = c.support / c.spacing;
    spring_reference_ = c.spring_reference;
    largest_modulus_rate_ = 0;
    for (const MaterialRow<double>& m : c.materials)
      largest_modulus_rate_ = std::max(largest_modulus_rate_, m.modulus_rate);
    // 63 bits hold the sum of all vertices, each at most a few units of motion: 6 bits of head room.
    sum_bits_ = 56 - static_cast<int>(std::ceil(std::log2(double(w_.vertices) + 1.0)));
    Vec3i low{}, high{};
    body_size_ = 1;
    for (std::size_t v = 0, body = core::none; v < l.vertex_coordinates.size(); ++v) {
      const Vec3i p = l.vertex_coordinates[v];
      if (l.vertex_body[v] != body) low = high = p;
      body = l.vertex_body[v];
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
      body_size_ = std::max({body_size_, high.x - low.x + 1.0, high.y - low.y + 1.0, high.z - low.z + 1.0});
    }
  }

  void fill_grid(const SceneConstants& c, double support, int reach) {
    Grid<T>& g = w_.grid;
    g.reach = reach;
    if (!c.domain.bounded) {
      // An unbounded lattice of cells around the origin; only occupied ones cost anything.
      g.nx = g.ny = g.nz = 1 << 21;
      const double low = -support * double(1 << 20);
      g.min = cast<T>(Vec3d{low, low, low});
      g.inv_cell = cast<T>(Vec3d{1 / support, 1 / support, 1 / support});
      w_.key_bits = 64;
      return;
    }
    const Vec3d e = c.domain.max - c.domain.min;
    g.min = cast<T>(c.domain.min);
    g.nx = cells_along(e.x, support / reach);
    g.ny = cells_along(e.y, support);
    g.nz = cells_along(e.z, support);
    g.inv_cell = cast<T>(Vec3d{g.nx / e.x, g.ny / e.y, g.nz / e.z});
    for (int axis = 0; axis < 3; ++axis)
      if (periodic(c, axis)) g.periodic |= 1u << axis;
    const auto per = [&](int axis, double extent) { return (g.periodic >> axis) & 1u ? extent : 0.0; };
    const Vec3d p{per(0, e.x), per(1, e.y), per(2, e.z)};
    g.period = cast<T>(p);
    g.inv_period = cast<T>(Vec3d{p.x > 0 ? 1 / p.x : 0, p.y > 0 ? 1 / p.y : 0, p.z > 0 ? 1 / p.z : 0});
    g.rows = (g.periodic & 1u) != 0u ? 18u : 9u;
    // Asked where cells are counted, which are few enough for these numbers.
    for (std::uint32_t line = 0; line < 9; ++line) {
      const std::int64_t y = spatial::line_offset(spatial::lines_y, line);
      const std::int64_t z = spatial::line_offset(spatial::lines_z, line);
      g.line_cells[line] = static_cast<std::int32_t>((z * g.ny + y) * g.nx);
    }
    // One bit more than the cells need: the key of a removed particle, cut to these bits, still sorts last.
    const double all = double(g.nx) * double(g.ny) * double(g.nz);
    w_.key_bits = static_cast<std::uint32_t>(std::ceil(std::log2(all + 1.0))) + 1u;
  }

  void fill_tree(const SceneConstants& c, const Sizes& n) {
    Tree<T>& t = w_.tree;
    const double cell = c.support / tree_resolution;
    t.inv_cell = static_cast<T>(1 / cell);
    t.bits = 21;  // three axes in 63 bits; beyond, only the order suffers
    t.min = w_.grid.min;
    double largest = 0;  // coordinate that distances are rounded at, where axes wrap
    if (c.domain.bounded) {
      const Vec3d e = c.domain.max - c.domain.min;
      const double cells = std::max({e.x, e.y, e.z}) / cell;
      t.bits = static_cast<std::uint32_t>(std::min(21.0, std::ceil(std::log2(std::max(cells, 2.0)))));
      if (w_.grid.periodic != 0u) largest = std::max({e.x, e.y, e.z});
    } else {
      const double low = -cell * double(1 << 20);
      t.min = cast<T>(Vec3d{low, low, low});
    }
    w_.key_bits = 3 * t.bits + 1;
    w_.grid.rows = static_cast<std::uint32_t>(n.rows);
    t.levels = n.tree_levels;
    std::copy(std::begin(n.tree_first), std::end(n.tree_first), t.first);
    t.reach =
        static_cast<T>(c.support * (1 + 1e-5) + 8 * double(std::numeric_limits<T>::epsilon()) * largest);
  }

  void fill_state(const SceneConstants& c, const SceneLattice& l, const SceneState& s) {
    const std::size_t n = s.position.size();
    const std::size_t capacity = w_.bits_stride;
    w_.born = static_cast<std::uint32_t>(n);
    use_slots(slots_for(w_.born));
    rolled_back_ = false;
    rebuild_ = true;
    last_index_ = 0;
    std::vector<MaterialRow<T>> materials;
    for (const MaterialRow<double>& m : c.materials) {
      materials.push_back(round_row(m));
      if (w_.f.properties != nullptr) materials.back().tables = w_.f.properties + (materials.size() - 1);
    }
    put(w_.f.materials, materials);
    std::vector<MaterialProperties<T>> properties;
    for (const MaterialProperties<double>& p : c.properties) properties.push_back(round_properties(p));
    put(w_.f.properties, properties);
    // What emitters will fill lies ready in both halves of the double buffer, as if it had been removed.
    std::vector<Vec4<T>> position(capacity, Vec4<T>{0, 0, 0, 1}), velocity(capacity);
    std::vector<T> mass(capacity, T(1));
    std::vector<double> enthalpy(capacity, 0.0);
    std::vector<std::uint32_t> tag(capacity, tag_removed), id(capacity);
    for (std::size_t i = 0; i < capacity; ++i) id[i] = static_cast<std::uint32_t>(i);
    for (std::size_t i = 0; i < n; ++i) {
      position[i] = with_w(cast<T>(s.position[i]), static_cast<T>(s.volume[i]));
      velocity[i] = with_w(cast<T>(s.velocity[i]), T(0));
      mass[i] = static_cast<T>(s.mass[i]);
      enthalpy[i] = s.enthalpy[i];
      tag[i] = s.tag[i];
    }
    if (spare_position_) put(static_cast<Vec4<T>*>(buffers_[field_acceleration]), position);
    for (int half = 0; half < (capacity > n ? 2 : 1); ++half) {
      if (half == 1) swap_buffers();
      put(w_.f.position, position);
      put(w_.f.velocity, velocity);
      put(w_.f.enthalpy, enthalpy);
      put(w_.f.mass, mass);
      put(w_.f.tag, tag);
      put(w_.f.id, id);
    }
    put(w_.f.slot_of_id, id);
    put(w_.f.vertex_of_id, s.vertex_of_id);
    put(w_.f.vertex_id, s.vertex_id);
    put(w_.f.vertex_site, l.vertex_site);
    put(w_.f.vertex_body, l.vertex_body);
    put(w_.f.vertex_state, s.vertex_state);
    put(w_.f.vertex_piece, s.vertex_piece);
    std::vector<Quat<T>> q;
    for (const Quat<double>& r : s.region_rotation)
      q.push_back({static_cast<T>(r.w), static_cast<T>(r.x), static_cast<T>(r.y), static_cast<T>(r.z)});
    put(w_.f.region_rotation, q);
    std::vector<Vec3<T>> slip;
    for (const Vec3d& x : s.contact_slip) slip.push_back(cast<T>(x));
    put(w_.f.contact_slip, slip);
    put(w_.f.site_vertex, mark_empty_sites(l));
    put(w_.f.bodies, l.bodies);
    std::vector<Vec4<T>> points;
    for (const Vec3d& p : c.emitter_points) points.push_back(with_w(cast<T>(p), T(0)));
    put(w_.f.emitter_points, points);
    std::vector<HeatRegionRow<T>> regions;
    for (const HeatRegionRow<double>& r : c.heat_regions)
      regions.push_back({cast<T>(r.min), static_cast<T>(r.inv_cell), r.nx, r.ny, r.nz, r.first_word, r.held,
                         r.temperature, static_cast<T>(r.source), r.from, r.until});
    put(w_.f.heat_regions, regions);
    put(w_.f.heat_region_cells, c.heat_region_cells);
    std::vector<BodyHeat<T>> body_heat;
    for (const BodyHeat<double>& b : c.body_heat)
      body_heat.push_back({round_condition(b.surface), static_cast<T>(b.source)});
    put(w_.f.body_heat, body_heat);
    WorldStatus status;
    status.melted = static_cast<std::int64_t>(s.melted);
    status.frozen = s.frozen;
    status.removed = static_cast<std::int64_t>(s.removed);
    status.heat_in = s.heat_in;
    status.particles = w_.born;
    if (w_.f.status != nullptr) ex_.upload(w_.f.status, &status, sizeof status);
  }

  static MaterialRow<T> round_row(const MaterialRow<double>& m) {
    MaterialRow<T> r;
    r.density = static_cast<T>(m.density);
    r.tait_stiffness = static_cast<T>(m.tait_stiffness);
    r.viscosity = static_cast<T>(m.viscosity);
    r.conductivity = static_cast<T>(m.conductivity);
    r.diffusivity = static_cast<T>(m.diffusivity);
    r.liquid_conductivity = static_cast<T>(m.liquid_conductivity);
    r.heat_capacity = m.heat_capacity;
    r.liquid_heat_capacity = m.liquid_heat_capacity;
    r.melting_point = m.melting_point;
    r.melting_enthalpy = m.melting_enthalpy;
    r.latent_heat = m.latent_heat;
    r.shape_stiffness = static_cast<T>(m.shape_stiffness);
    r.modulus_rate = static_cast<T>(m.modulus_rate);
    r.shape_damping = static_cast<T>(m.shape_damping);
    r.friction = static_cast<T>(m.friction);
    r.liquid = m.liquid;
    r.solid = m.solid;
    r.melts = m.melts;
    r.freezes = m.freezes;
    r.plateau = m.plateau;
    return r;
  }

  static physics::SurfaceCondition<T> round_condition(const physics::SurfaceCondition<double>& c) {
    return {static_cast<T>(c.temperature), static_cast<T>(c.flux), static_cast<T>(c.convection),
            static_cast<T>(c.emissivity), c.kind};
  }

  static physics::PropertyTable<T> round_table(const physics::PropertyTable<double>& p) {
    physics::PropertyTable<T> r;
    r.points = p.points;
    for (int k = 0; k < physics::property_points; ++k) {
      r.temperature[k] = static_cast<T>(p.temperature[k]);
      r.value[k] = static_cast<T>(p.value[k]);
    }
    return r;
  }

  static MaterialProperties<T> round_properties(const MaterialProperties<double>& p) {
    return {round_table(p.conductivity), round_table(p.liquid_conductivity), round_table(p.viscosity),
            round_table(p.density), p.curve};
  }

  template <class V>
  void put(V* to, const std::vector<V>& from) {
    if (to != nullptr && !from.empty()) ex_.upload(to, from.data(), from.size() * sizeof(V));
  }

  template <class V>
  std::vector<V> fetch(const V* from, std::size_t n) const {
    std::vector<V> v(n);
    if (n != 0) ex_.download(v.data(), from, n * sizeof(V));
    return v;
  }

  void use_slots(std::uint32_t slots) {
    w_.particles = slots;
    w_.words_parts = word_parts(slots);
    w_.words_column = spatial::words_stride(slots) * sizeof(NeighbourWord);
    w_.words_room = spatial::words_room(support_in_spacings_, w_.grid.rows, w_.words_parts);
  }

  /// A CPU finds all neighbours of a particle in one go.
  static std::uint32_t word_parts(std::uint64_t slots) { return runs_lanes<E> ? 1u : shared_parts(slots); }

  /// Entries of neighbour_words for at most so many particles.
  static std::uint64_t most_words(const SceneConstants& c, std::uint64_t capacity, std::uint64_t rows) {
    const auto entries = [&](std::uint64_t n) {
      const std::uint32_t parts = word_parts(n);
      const std::uint32_t room =
          spatial::words_room(c.support / c.spacing, static_cast<std::uint32_t>(rows), parts);
      return std::uint64_t{parts} * (room + 1u) * spatial::words_stride(n);
    };
    return std::max(entries(capacity), entries(std::min(capacity, gather_few - 1u)));
  }

  /// Slots that kernels run over: in steps, so that an emitter does not make every sub-step differ from the
  /// last one.
  std::uint32_t slots_for(std::uint32_t born) const {
    const std::uint64_t capacity = w_.bits_stride, step = std::max<std::uint64_t>(capacity / 8, 1);
    if (born == 0) return 0;
    return static_cast<std::uint32_t>(std::min(capacity, (born + step - 1) / step * step));
  }

  void emit(const BurstArguments& b) {
    w_.burst.first_point = b.first_point;
    w_.burst.points = b.points;
    w_.burst.center = cast<T>(b.center);
    w_.burst.velocity = cast<T>(b.velocity);
    w_.burst.enthalpy = b.enthalpy;
    w_.burst.mass = static_cast<T>(b.mass);
    w_.burst.volume = static_cast<T>(b.volume);
    w_.burst.tag = b.tag;
    w_.burst_first = w_.born;
    step::emit<E, T>(ex_, w_);
    w_.born += b.points;
    use_slots(slots_for(w_.born));
  }

  /// All but step.begin, which the clock makes different every time.
  void run_stages(const SubstepArguments& a) {
    for (int s = 0; s < stage_count; ++s) {
      if (s != stage_step_begin && ((a.stages >> s) & 1u)) run(s, stage_functions<E, T>[s]);
      if (custom_ != nullptr)
        for (std::size_t k = 0; k < custom_->size(); ++k)
          if ((*custom_)[k].after == s) run_custom(static_cast<int>(k), a);
    }
  }

  /// The same with nobody looking on: where the executor can, what needs not wait runs side by side.
  void run_plain(const SubstepArguments& a) {
    if constexpr (!runs_tracks<E>) {
      run_stages(a);
    } else {
      const Schedule plan = make_schedule(a.stages & ~(std::uint64_t{1} << stage_step_begin));
      ex_.begin_tracks();
      for (const int s : EnqueueOrder<E>::of(ex_, plan)) {
        const auto at = static_cast<std::size_t>(s);
        if (plan.track[at] < 0) continue;
        ex_.enter_track(plan.track[at]);
        ex_.hurry(plan.urgency[at]);
        ex_.step_aside(((plan.aside >> s) & 1u) != 0 ? aside_blocks(support_in_spacings_) : 0u);
        for (int t = 0; t < s; ++t)
          if (((plan.waits[at] >> t) & 1u) != 0) ex_.wait_for_stage(t);
        run_unless_done(s);
        if (((plan.awaited >> s) & 1u) != 0) ex_.mark_stage(s);
      }
      ex_.enter_track(0);
      ex_.hurry(0);
      ex_.step_aside(0);
      for (int s = 0; s < stage_count; ++s)
        if (((plan.last >> s) & 1u) != 0) ex_.wait_for_stage(s);
    }
  }

  /// A stage, or what takes its place, or nothing where another has done its work.
  void run_unless_done(int s) {
    if constexpr (can_fuse<E>) {
      if (s == stage_thermal_operands && w_.heat_at_hand) return;
      if (w_.next.position != nullptr) {
        if (s == stage_sph_forces) sph::advance<E, T>(ex_, w_);
        if (s == stage_sph_forces || s == stage_step_integrate) return;
      }
    }
    run(s, stage_functions<E, T>[s]);
  }

  RepeatKey repeat_key(const SubstepArguments& a) const {
    const auto bits = [](double v) {
      std::uint64_t b = 0;
      std::memcpy(&b, &v, sizeof b);
      return b;
    };
    return {a.stages,
            w_.particles,
            reinterpret_cast<std::uintptr_t>(w_.f.position),  // which of the buffers
            reinterpret_cast<std::uintptr_t>(w_.before.position),
            reinterpret_cast<std::uintptr_t>(w_.f.velocity),
            reinterpret_cast<std::uintptr_t>(w_.f.id),
            bits(a.dt),
            bits(a.heat_dt),
            bits(a.heat_bound),
            static_cast<std::uint64_t>(a.heat_stages),
            static_cast<std::uint64_t>(a.heat_supersteps),
            (w_.counted ? 1u : 0u) | (w_.count_ahead ? 2u : 0u) | (w_.next.position != nullptr ? 4u : 0u) |
                (w_.heat_at_hand ? 8u : 0u)};
  }

  void run(int s, StageFunction<E, T> function) {
    if (checked_build) return run_checked(s, function);
    if (timed_) ex_.begin_stage(s, stage_table[static_cast<std::size_t>(s)].name);
    function(ex_, w_);
    if (timed_) ex_.end_stage(s);
  }

  /// Waits before and after; the first broken invariant is a fault, which halts the World.
  void run_checked(int s, StageFunction<E, T> function) {
    ex_.synchronize();
    const auto copy = [this](const auto* from, std::size_t n) { return fetch(from, n); };
    Invariants<T, decltype(copy)> invariants(w_, copy);
    double thermal = 0;
    if (s == stage_thermal_exchange) {
      thermal = invariants.thermal();
      if (w_.f.heat_account != nullptr) invariants.account_before = copy(w_.f.heat_account, 1).front().step;
    }
    function(ex_, w_);
    ex_.synchronize();
    const bool halted = w_.f.status != nullptr && copy(w_.f.status, 1).front().halted != 0;
    if (!halted && broken_.empty()) broken_ = invariants.after(s, mass_, thermal);
  }

  void run_custom(int k, const SubstepArguments& a) {
    const CustomStage& stage = (*custom_)[static_cast<std::size_t>(k)].stage;
    StageContext c = context();
    c.dt = a.dt;
    c.time = a.time;
    if (timed_) ex_.begin_stage(custom_stage + k, stage.name.c_str());
    stage.run(c, stage.user);
    if (timed_) ex_.end_stage(custom_stage + k);
  }

  E ex_;
  std::string device_;
  Frame<T> w_;
  SurfaceRun<E, T> surface_;
  void* buffers_[field_count] = {};
  void* previous_[field_count] = {};
  std::uint64_t bytes_[field_count] = {}, previous_bytes_[field_count] = {};
  const std::vector<PlacedStage>* custom_ = nullptr;
  double largest_mass_ = 1, spacing_ = 1, support_in_spacings_ = 2.5, body_size_ = 1;
  double spring_reference_ = 0, largest_modulus_rate_ = 0;
  int sum_bits_ = 40;
  std::uint64_t last_index_ = 0;
  std::uint64_t reserved_ = 0;  ///< items that verbs may work on
  bool timed_ = false, rolled_back_ = false, rebuild_ = true;
  bool spare_position_ = false;  ///< the buffer of accelerations can hold positions (sph.advance)
  double counted_dt_ = 0;        ///< of the sub-step before
  double mass_ = 0;              ///< checked builds: at the upload [kg]
  std::string broken_;           ///< checked builds: the first broken invariant
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
