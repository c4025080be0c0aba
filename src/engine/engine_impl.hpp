// SPDX-License-Identifier: Apache-2.0
// The engine over any executor: buffers, frame, and the walk down the stage table. No physics, no backend.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <exception>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "engine/checked.hpp"
#include "engine/custom_stages.hpp"
#include "engine/edit_run.hpp"
#include "engine/engine.hpp"
#include "engine/engine_buffers.hpp"
#include "engine/engine_sizes.hpp"
#include "engine/engine_transfer.hpp"
#include "engine/frame_constants.hpp"
#include "engine/mesh_staging.hpp"
#include "engine/probe_run.hpp"
#include "engine/reading_run.hpp"
#include "engine/scales.hpp"
#include "engine/surface_run.hpp"
#include "exec/lane_positions.hpp"
#include "exec/repeat_key.hpp"
#include "exec/timings.hpp"
#include "frame/frame.hpp"
#include "meltsim/physics/integrate.hpp"
#include "pipeline/fusions.hpp"
#include "pipeline/schedule.hpp"
#include "pipeline/stage_functions.hpp"
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
    probes_.release(ex_);
    release();
    drop_saved();
    readings_.release(ex_);
    mesh_staging_.release(ex_);
    edits_.release(ex_);
    for (void* const mark : marks_) ex_.release_mark(mark);
    if (sound_ != nullptr) ex_.release(sound_);
  }

  Backend backend() const override { return E::backend; }
  std::string device_name() const override { return device_; }
  std::uint64_t channel_bytes(int field) const override { return buffers_.bytes(field); }
  std::uint64_t scratch_bytes() const override {
    std::uint64_t saved = 0;
    for (const Saved& s : saved_) saved += s.bytes;
    return ex_.reserved_bytes() + surface_.bytes() + probes_.bytes() + readings_.bytes() + edits_.bytes() +
           saved;
  }
  std::uint64_t graphs() const override { return ex_.captures(); }
  std::uint64_t free_bytes() const override { return ex_.free_bytes(); }
  void set_custom_stages(const std::vector<PlacedStage>* stages) override { custom_.set(stages); }
  void enable_timings(int every) override {
    if (every != sampling_.every) sampling_ = {every};
  }
  double median_ms(int stage) override { return ex_.collect().median(stage); }
  std::string fault() override {
    const std::string device = ex_.fault();
    return device.empty() ? broken_ : device;
  }

  std::uint64_t bytes_needed(const SceneConstants& c, const SceneLattice& l,
                             const EngineSetup& s) const override {
    const Sizes n = sizes_of<E>(c, l, s, fuses(ex_));
    std::uint64_t total = 0;
    for (int i = 0; i < field_count; ++i)
      if (s.channels.has(i)) total += field_bytes<T>(i, n) * (double_buffered(i) ? 2u : 1u);
    return total;
  }

  Status upload(const SceneConstants& c, const SceneLattice& l, const SceneState& state,
                const EngineSetup& setup) override {
    settle_readings();
    ex_.synchronize();
    release();
    w_ = Frame<T>{};
    const Sizes n = sizes_of<E>(c, l, setup, fuses(ex_));
    sizes_ = n;
    room_ = setup.room;
    vertices_ = l.vertex_site.size();
    if (Status s = allocate(setup.channels, n, bytes_needed(c, l, setup)); !s) return s;
    buffers_.link(w_);
    scales_ = scales_of(c, l);
    readings_.describe(c, l, scales_);
    fill_constants<E>(w_, c, l, n);
    probes_.link(w_);
    w_.born = static_cast<std::uint32_t>(state.position.size());
    use_slots(slots_for(w_.born));
    put_state(c, l, state, HostLoops(setup.threads));
    edits_.sorted(false);
    rolled_back_ = abandoned_ = sized_ = false;
    materials_ = static_cast<std::uint32_t>(c.materials.size());
    count_anew_ = true;
    last_index_ = 0;
    w_.solids = w_.vertices != 0 || std::any_of(state.tag.begin(), state.tag.end(), is_solid);
    w_.slots_of_all = asks_by_id(setup.facts);
    ex_.set_guard(nullptr);
    step::reindex<E, T>(ex_, w_);
    if (w_.vertices != 0 && w_.f.vertex_site != nullptr) topology::build<E, T>(ex_, w_);
    if (w_.f.status != nullptr) ex_.set_guard(&w_.f.status->halted);
    ex_.synchronize();
    broken_.clear();
    mass_ = 0;
    for (const double m : state.mass) mass_ += m;
    return fault_status();
  }

  Status adapt(const SceneConstants& c, const SceneLattice& l, const SceneState& state,
               const EngineSetup& setup) override {
    last_good();
    if (rolled_back_) return {};
    settle_regions();  // the new plan may lack the stage
    const Sizes& n = sizes_ = sizes_of<E>(c, l, setup, fuses(ex_));
    const std::uint64_t needed = buffers_.missing(setup.channels, n), available = ex_.free_bytes();
    if (needed > available) return out_of_memory(needed, available);
    FieldSet grown = 0;
    if (!buffers_.grow(ex_, setup.channels, n, grown)) return out_of_memory(needed, available);
    const std::string had(reinterpret_cast<const char*>(&w_), sizeof w_);  // what recorded sub-steps hold
    buffers_.link(w_);
    scales_ = scales_of(c, l);
    fill_constants<E>(w_, c, l, n);
    materials_ = static_cast<std::uint32_t>(c.materials.size());
    sized_ = false;
    edits_.moved();
    w_.slots_of_all = asks_by_id(setup.facts);
    put_tables(ex_, with(setup.channels), c);
    put_lattice(ex_, w_, l, state, room_, grown, HostLoops(setup.threads));
    const auto has = [grown](int field) { return grown.has(field); };
    unguarded([&] {
      if (has(field_enthalpy)) step::enthalpy_to_slots<E, T>(ex_, w_);
      if (has(field_enthalpy_of_id)) step::enthalpy_to_ids<E, T>(ex_, w_);
      if (has(field_acceleration) && buffers_.has_spare_position())
        ex_.copy(w_.capacity, w_.f.position, buffers_.spare().position);
      if (has(field_neighbour_mask) || has(field_region_mask) || has(field_site_live))
        topology::build<E, T>(ex_, w_);
      step::reindex<E, T>(ex_, w_);
    });
    if (setup.heat_flows_again || setup.heat_rests_again) {
      const std::uint32_t idle = setup.heat_rests_again ? idle_level : 0u;
      ex_.upload(&w_.f.status->heat_idle, &idle, sizeof idle);
    }
    ex_.synchronize();
    buffers_.shrink(ex_, setup.channels, n);
    buffers_.link(w_);
    if (std::memcmp(had.data(), &w_, sizeof w_) != 0) ex_.forget_repeats();
    return fault_status();
  }

  Result<WorldStatus> find(const Vec3d& low, const Vec3d& high, std::vector<FoundParticle>& found) override {
    const WorldStatus s = last_good();
    bool there = true;
    if (w_.f.status != nullptr && !rolled_back_)
      unguarded([&] { there = edits_.find(ex_, w_, reserved_, low, high, found); });
    if (!there) return out_of_memory(w_.particles * sizeof(FoundParticle), ex_.free_bytes()).error();
    return s;
  }

  Status make_edit_room(std::uint64_t taken, std::uint64_t appended) override {
    if (edits_.make_room(ex_, taken, appended)) return {};
    return out_of_memory(taken * sizeof(FoundParticle) + appended * 256, ex_.free_bytes());
  }

  Status append(const SceneState& more, bool heat_level, std::uint32_t vertex) override {
    const auto n = static_cast<std::uint32_t>(more.position.size());
    bool there = true;
    unguarded([&] { there = edits_.append(ex_, w_, more, w_.born, vertex); });
    if (!there) return out_of_memory(std::uint64_t{n} * 256, ex_.free_bytes());
    w_.born += n;
    use_slots(slots_for(w_.born));
    for (const double m : more.mass) mass_ += m;
    edited(0, heat_level ? idle_level : 0u);
    return fault_status();
  }

  Status add_body(const SceneLattice& l, const SceneState& s, const AddedBody& a) override {
    const std::uint64_t end = l.vertex_site.size();
    const Scales had = scales_;
    const bool first = !w_.solids;
    extend(scales_, l, a);
    readings_.extend(l, scales_, a.first_vertex);
    w_.solids = true;
    vertices_ = end;
    if (w_.f.vertex_site != nullptr) {
      unguarded([&] {
        put_body(ex_, w_, l, s, a);
        use_vertices<E>(w_, end, sizes_);
        topology::build_body<E, T>(ex_, w_, a.first_vertex, static_cast<std::uint32_t>(end) - a.first_vertex);
      });
    }
    ex_.synchronize();
    if (first || !(had == scales_)) ex_.forget_repeats();  // recorded sub-steps hold them
    return fault_status();
  }

  Status take_out(const std::vector<FoundParticle>& what) override {
    bool there = true;
    unguarded([&] { there = edits_.take_out(ex_, w_, what); });
    if (!there) return out_of_memory(what.size() * sizeof(FoundParticle), ex_.free_bytes());
    edited(what.size(), idle_level);
    return fault_status();
  }

  Status move(const std::vector<FoundParticle>& what) override {
    bool there = true;
    unguarded([&] { there = edits_.move(ex_, w_, what); });
    if (!there) return out_of_memory(what.size() * sizeof(FoundParticle), ex_.free_bytes());
    edited(0, idle_level);
    return fault_status();
  }

  Result<std::uint64_t> take_body(std::uint32_t body, std::uint32_t first, std::uint32_t count) override {
    std::uint64_t taken = 0;
    bool there = true;
    if (w_.f.vertex_state != nullptr && w_.f.vertex_id != nullptr)
      unguarded([&] { there = edits_.take_body(ex_, w_, body, first, count, taken); });
    if (!there) return out_of_memory(256, ex_.free_bytes()).error();
    if (w_.f.bodies != nullptr) {
      BodyRow row = fetch(ex_, static_cast<const BodyRow*>(w_.f.bodies) + body, 1).front();
      row.watched = 0;
      ex_.upload(w_.f.bodies + body, &row, sizeof row);
    }
    if (w_.f.seen_touch != nullptr && body < w_.bodies) {  // it does not melt away
      const std::uint64_t columns = w_.bodies + wall_columns, at = body * columns + wall_columns + body;
      if (at < w_.touch_entries) ex_.upload(w_.f.seen_touch + at, &none, sizeof none);
    }
    edited(taken, idle_level);
    if (Status s = fault_status(); !s) return s.error();
    return taken;
  }

  Result<WorldStatus> find_body(std::uint32_t body, std::uint32_t first, std::uint32_t count,
                                std::vector<FoundParticle>& found) override {
    const WorldStatus s = last_good();
    found.clear();
    bool there = true;
    if (w_.f.vertex_state != nullptr && w_.f.vertex_id != nullptr && !rolled_back_)
      unguarded([&] { there = edits_.find_body(ex_, w_, body, first, count, found); });
    if (!there) return out_of_memory(count * sizeof(FoundParticle), ex_.free_bytes()).error();
    return s;
  }

  Status hold(const std::vector<FoundParticle>& what, bool on, std::uint32_t first,
              std::uint32_t count) override {
    bool there = true;
    unguarded([&] { there = edits_.hold(ex_, w_, what, on, first, count); });
    if (!there) return out_of_memory(what.size() * sizeof(FoundParticle), ex_.free_bytes());
    edited(0, idle_level);
    return fault_status();
  }

  Status set_body(std::uint32_t body, const BodyRow& row) override {
    if (w_.f.bodies != nullptr) ex_.upload(w_.f.bodies + body, &row, sizeof row);
    return fault_status();
  }

  Status set_forces(std::uint32_t body, std::uint32_t vertex, BodyForceTotals& forces) override {
    if (w_.f.vertex_id == nullptr) return {};
    if (!w_.slots_of_all) index_all();
    const std::uint32_t id =
        fetch(ex_, static_cast<const std::uint32_t*>(w_.f.vertex_id) + vertex, 1).front();
    const std::uint32_t slot = fetch(ex_, static_cast<const std::uint32_t*>(w_.f.slot_of_id) + id, 1).front();
    forces.center =
        cast<double>(xyz(fetch(ex_, static_cast<const Vec4<T>*>(w_.f.position) + slot, 1).front()));
    if (w_.f.body_forces != nullptr) ex_.upload(w_.f.body_forces + body, &forces, sizeof forces);
    return fault_status();
  }

  void surround(const Surroundings& s) override {
    fill_surroundings(w_, s);
    readings_.set_gravity(s.gravity);
  }

  void push(const PushArguments& a) override {
    if (rolled_back_ || w_.f.push == nullptr || w_.f.vertex_id == nullptr) return;  // it has melted
    step::push<E, T>(ex_, w_, a);
    count_anew_ = true;
  }

  void respeed(Vec3d from, Vec3d to) override {
    if (rolled_back_ || w_.born == 0) return;
    step::respeed<E, T>(ex_, w_, from, to);
    count_anew_ = true;
  }

  void shift(Vec3d velocity, Vec3d begin, double length, double reach, Vec3d by) override {
    if (rolled_back_ || w_.born == 0) return;
    step::shift<E, T>(ex_, w_, velocity, begin, length, reach, by);
    count_anew_ = true;
    edits_.moved();
  }

  void set_heat_region(std::uint32_t row, bool held, double temperature, double source) override {
    if (w_.f.heat_regions == nullptr || row >= w_.c.heat_regions) return;  // the next plan has it
    step::set_heat_region<E, T>(ex_, w_, row, held, temperature, source);
  }
  void set_body_heat(std::uint32_t body, const BodyHeat<double>& heat) override {
    if (w_.f.body_heat == nullptr) return;  // the next plan has it
    const BodyHeat<T> now{round_condition<T>(heat.surface), static_cast<T>(heat.source)};
    unguarded([&] { step::set_body_heat<E, T>(ex_, w_, body, now); });
  }
  void move_heat_region(std::uint32_t row, double since, Vec3d displacement, Vec3d velocity) override {
    if (w_.f.heat_regions == nullptr || row >= w_.c.heat_regions) return;  // the next plan has it
    step::move_heat_region<E, T>(ex_, w_, row, since, displacement, velocity);
  }

  void set_force_field(std::uint32_t row, const physics::ForceField<double>& field,
                       std::uint32_t count) override {
    if (w_.f.force_fields == nullptr) return;  // the next plan has it
    unguarded([&] { step::set_force_field<E, T>(ex_, w_, row, round_field<T>(field), count); });
  }

  void set_inlet(std::uint32_t row, const Inlet<double>& now) override {
    mass_ = 0;                           // checked builds: what comes in again may be lighter
    if (w_.f.inlets == nullptr) return;  // the next plan has it
    unguarded([&] { step::set_inlet<E, T>(ex_, w_, row, round_inlet<T>(now)); });
  }

  SoundLook look() override {
    SoundLook seen;
    last_good();
    if (w_.f.status == nullptr || w_.born == 0 || rolled_back_ || !has_sound_room()) return seen;
    step::look<E, T>(ex_, w_, sized_ && w_.f.density != nullptr, &sound_->look);
    ex_.download(&seen, &sound_->look, sizeof seen);
    return seen;
  }

  void set_sound_speed(double speed, double change) override {
    if (rolled_back_ || w_.f.materials == nullptr || !has_sound_room()) return;
    const bool counts = sized_ && w_.f.density != nullptr && w_.born != 0;
    step::set_sound_speed<E, T>(ex_, w_, materials_, speed, counts ? change : 0.0, &sound_->sum,
                                &sound_->account);
  }

  double take_sound_work() override {
    if (sound_ == nullptr) return 0;
    SoundWork work;
    ex_.download(&work, &sound_->account, sizeof work);
    const SoundWork none;
    ex_.upload(&sound_->account, &none, sizeof none);
    return work.done;
  }

  void substep(const SubstepArguments& a) override {
    if (rolled_back_) return;  // halted, and already back at the last good state
    if (a.bursts != nullptr)
      for (const BurstArguments& b : *a.bursts) emit(b);
    if (a.layers != nullptr)
      for (const InletLayer& layer : *a.layers) set_inlet(layer.row, layer.now);
    if (a.steered != nullptr || a.reshaped != nullptr) steer(a);
    count_anew_ = count_anew_ || a.bursts != nullptr || a.steered != nullptr || a.reshaped != nullptr;
    if (w_.born == 0) return;
    buffers_.turn(w_);
    const Sample sample = sampling_.next();
    timed_ = sample == Sample::stages;
    // A host's stages that are not recorded may do anything, timings take stages one by one.
    const bool plain = !timed_ && custom_.all_recorded();
    count_ahead(a, plain);
    const bool advances = plain && may_advance(a.stages);
    w_.next = advances ? buffers_.spare() : NextViews<T>{};
    set_clock(a);
    set_super_steps(a);
    set_sum_units(a.dt);
    last_index_ = a.index;
    if (plain) run_at_once(a, sample == Sample::whole);
    else {
      begin_substep();
      run_stages(a);
    }
    if (!thrown_.empty()) ex_.forget_repeats();  // what was recorded lacks the rest of the stage
    if (advances) buffers_.take_spare(w_);
    if (advances && checked_build) look_at(stage_step_integrate, 0);
    sized_ = true;
    edits_.sorted(w_.cells != 0 && !custom_.move_particles());
    ex_.pace();
  }

  bool runs_ahead() const override { return !E::in_host_memory; }
  void mark(int number) override {
    void*& mark = marks_[number];
    if (mark == nullptr) mark = ex_.make_mark();
    ex_.begin_copies();
    ex_.end_copies(mark);
  }
  void wait_for(int number) override { ex_.wait_for_mark(marks_[number]); }
  bool host_captures() const override { return ex_.host_captures(); }
  Status wait_for_event(void* event) override { return event_status("wait_for", ex_.wait_for_event(event)); }
  Status signal_event(void* event) override { return event_status("signal", ex_.signal_event(event)); }

  void watch(const std::atomic<bool>* asked) override { ex_.watch(asked); }
  bool abandoned() const override { return abandoned_; }
  std::string take_thrown() override { return std::exchange(thrown_, std::string{}); }

  WorldStatus synchronize() override {
    WorldStatus s = last_good();
    if (w_.f.status == nullptr) return s;
    unguarded([&] { step::clear<E, T>(ex_, w_); });  // not by a copy: that would wait once more
    return s;
  }

  Status request(int slot, const ReadParts& parts) override {
    if (ex_.host_captures()) return captured("request");
    return enqueue_reading(slot, parts);
  }

  Result<bool> ready(int slot) override {
    if (ex_.host_captures()) return captured("ready");
    return readings_.ready(ex_, slot);
  }

  Status take(int slot, StateReading& reading) override {
    if (ex_.host_captures()) return captured("take");
    const Status settled = settle_reading(slot);
    if (settled) readings_.unpack(ex_, slot, reading);
    readings_.close(slot);
    return settled;
  }

  Status pack(const PackColors& colors, const std::vector<std::uint32_t>& table,
              PackedParticles& to) override {
    return readings_.pack(ex_, w_, rolled_back_, w_.f.density != nullptr && last_index_ != 0, colors, table,
                          to);
  }

  Status save(int slot) override {
    Saved& s = saved_[static_cast<std::size_t>(slot)];
    const std::uint64_t bytes = Saved::head + buffers_.saved_bytes();
    if (bytes != s.bytes) {
      if (s.memory != nullptr) ex_.release(s.memory);
      s = {};
      if (bytes <= ex_.free_bytes()) s.memory = static_cast<unsigned char*>(ex_.allocate(bytes));
      if (s.memory == nullptr)
        return Error{ErrorCode::out_of_memory, text("save_state: ", double(bytes) / 1e9,
                                                    " GB of memory are not there; save fewer states")};
      s.bytes = bytes;
    }
    s.born = w_.born;
    s.last_index = last_index_;
    if (w_.f.status == nullptr) return {};
    unguarded([&] { ex_.fill(1, 1u, s.missing()); });
    buffers_.save(ex_, s.memory + Saved::head);
    ex_.fill(1, 0u, s.missing());
    return fault_status();
  }

  void load(int slot) override {
    const Saved& s = saved_[static_cast<std::size_t>(slot)];
    settle_readings();
    w_.born = s.born;
    use_slots(slots_for(w_.born));
    last_index_ = s.last_index;
    rolled_back_ = abandoned_ = sized_ = false;
    count_anew_ = true;
    edits_.sorted(false);
    if (w_.f.status == nullptr) return;
    ex_.set_guard(s.missing());
    buffers_.load(ex_, s.memory + Saved::head);
    unguarded([&] { step::loaded<E, T>(ex_, w_, s.missing(), s.last_index + 1); });
  }

  void forget_saved() override {
    ex_.synchronize();
    drop_saved();
  }

  void drop(int slot) override {
    readings_.wait(ex_, slot);
    readings_.close(slot);
  }

  WorldStatus download(SceneState& s) override {
    const WorldStatus status = last_good();
    download_state(ex_, w_, s);
    return status;
  }

  void download_lattice(SceneState& s) override {
    last_good();
    core::download_lattice(ex_, w_, s);
  }

  void download(DerivedState& d) override {
    last_good();
    d.density.assign(w_.born, 0.0);
    d.pressure_term.assign(w_.born, 0.0);
    if (w_.f.density != nullptr && last_index_ != 0) download_derived(ex_, w_, rolled_back_, d);
  }

  void download(LatticeMasks& m) override {
    settle_regions();
    ex_.synchronize();
    m.region_words = w_.region_words;
    if (w_.f.neighbour_mask != nullptr) m.neighbour_mask = fetch(ex_, w_.f.neighbour_mask, vertices_);
    if (w_.f.region_mask != nullptr)
      m.region_mask = fetch(ex_, w_.f.region_mask, static_cast<std::size_t>(vertices_) * w_.region_words);
  }

  Result<bool> surface(const SurfaceRequest& request, SurfaceView& view, SurfaceMesh* mesh) override {
    if (!w_.slots_of_all) index_all();  // it takes particles in order of id
    auto halted = surface_.run(ex_, w_, reserved_, sampling_.every != 0, request, view, mesh);
    // The flag stays up after the World went back to its last good state.
    return halted && *halted && rolled_back_ ? Result<bool>(false) : halted;
  }

  Status set_probes(const ProbeSetup& setup) override {
    settle_readings();
    ex_.synchronize();
    ex_.forget_repeats();
    if (Status s = probes_.set(ex_, setup); !s) return s;
    probes_.link(w_);
    return {};
  }

  std::uint64_t samples(std::uint64_t first, std::uint64_t n, double* to) override {
    const WorldStatus s = last_good();
    probes_.fetch(ex_, first, n, to);
    return s.halted != 0 ? s.halt_step : 0;
  }

  Status sample(const ProbeSetup& what, std::vector<double>& values) override {
    last_good();
    if (!w_.slots_of_all) index_all();
    const bool derived = w_.f.density != nullptr && rolled_back_;
    ex_.set_guard(nullptr);
    Status s = probes_.at_once(ex_, w_, what, derived, values);
    if (w_.f.status != nullptr) ex_.set_guard(&w_.f.status->halted);
    return s ? fault_status() : s;
  }

  Status follow_rays(const std::vector<RayQuery>& rays, std::uint32_t sought,
                     std::vector<RayRow>& hits) override {
    last_good();
    if (!w_.slots_of_all) index_all();
    ex_.set_guard(nullptr);
    Status s = probes_.follow_rays(ex_, w_, rays, sought, hits);
    if (w_.f.status != nullptr) ex_.set_guard(&w_.f.status->halted);
    return s ? fault_status() : s;
  }

  Arrangement arrangement(std::uint64_t stages) const override {
    Arrangement a;
    const bool own = !custom_.all_recorded();
    a.track.fill(-1);
    a.fused[fusion_advance] = !own && may_advance(stages);
    a.fused[fusion_count_ahead] =
        !own && !custom_.move_particles() && can_fuse_stages(fusion_count_ahead, stages);
    a.custom_track.assign(custom_.count(), -1);
    if constexpr (runs_tracks<E>)
      if (!own) {
        a.track = schedule(stages, a.fused[fusion_advance]).track;
        for (std::size_t k = 0; k < custom_.count(); ++k) {
          const int at = custom_.seat(k, stages);
          a.custom_track[k] = at == before_tracks ? std::int8_t{0} : a.track[static_cast<std::size_t>(at)];
        }
      }
    return a;
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
    c.enthalpy_of_id = w_.f.enthalpy == nullptr ? w_.f.enthalpy_of_id : nullptr;
    c.id = w_.f.id;
    c.tag = w_.f.tag;
    return c;
  }

 private:
  /// The frame with these channels alone: others are about to be given back, and have the size that they had.
  Frame<T> with(FieldSet channels) const {
    Frame<T> kept = w_;
    buffers_.link(kept, channels);
    return kept;
  }

  /// A copy of the buffers, behind a word that is 0 once it has been made.
  struct Saved {
    static constexpr std::uint64_t head = 256;
    std::uint32_t* missing() const { return reinterpret_cast<std::uint32_t*>(memory); }
    unsigned char* memory = nullptr;
    std::uint64_t bytes = 0, last_index = 0;
    std::uint32_t born = 0;
  };
  /// Device memory for the quantities that the sound speed follows from, and for the work of its changes.
  struct SoundRoom {
    SoundLook look;
    SoundWork sum, account;
  };
  bool has_sound_room() {
    if (sound_ != nullptr) return true;
    sound_ = static_cast<SoundRoom*>(ex_.allocate(sizeof *sound_));
    const SoundRoom empty;
    if (sound_ != nullptr) ex_.upload(sound_, &empty, sizeof empty);
    return sound_ != nullptr;
  }
  void drop_saved() {
    for (Saved& s : saved_) {
      if (s.memory != nullptr) ex_.release(s.memory);
      s = {};
    }
  }

  /// Vertices that melted in the last sub-step leave their regions at the beginning of the next, if its plan has the stage.
  void settle_regions() {
    if (w_.f.plane_changed != nullptr && w_.f.region_mask != nullptr && w_.f.neighbour_mask != nullptr)
      topology::regions<E, T>(ex_, w_);
  }

  static Status out_of_memory(std::uint64_t needed, std::uint64_t available) {
    const auto gb = [](std::uint64_t b) {
      return core::number_text(double(b) / 1e9, std::chars_format::fixed, 1);
    };
    const std::string free = needed <= available  // it was refused all the same
                                 ? std::string("the system has not that much")
                                 : gb(available) + " GB free";
    return Error{ErrorCode::out_of_memory, "memory: " + gb(needed) + " GB needed, " + free +
                                               "; use fewer particles (larger spacing) or smaller "
                                               "region_half_width"};
  }

  /// Sorting, freezing and events look particles up by id.
  static bool asks_by_id(FactSet facts) {
    return (facts & fact_packed) == 0 || (facts & (fact_freeze | fact_events)) != 0;
  }

  static Error captured(const char* call) {
    return Error{ErrorCode::invalid_argument,
                 std::string(call) +
                     ": the World's stream is being captured into a graph, which cannot "
                     "hold a reading; end the capture first"};
  }

  Status enqueue_reading(int slot, const ReadParts& parts) {
    const bool has_density = w_.f.density != nullptr && last_index_ != 0;
    return readings_.request(ex_, w_, slot, parts, rolled_back_, has_density);
  }

  /// Waits. If the World had halted before a reading, so that only the status was read, the last good state is read
  /// now.
  Status settle_reading(int slot) {
    if (!readings_.lost(slot).empty()) return Error{ErrorCode::out_of_memory, readings_.lost(slot)};
    const ReadingHead& head = readings_.wait(ex_, slot);
    if (head.complete != 0u) return {};
    const WorldStatus then = head.status;  // with the extremes of its interval
    last_good();
    ReadParts parts = readings_.parts(slot);
    parts.clears = false;
    if (Status s = enqueue_reading(slot, parts); !s) return s;
    readings_.wait(ex_, slot);
    readings_.keep_status(slot, then);
    return {};
  }

  /// Before another scene: results that refer to this one are read first.
  void settle_readings() {
    if (w_.f.status == nullptr) return;
    for (int slot = 0; slot < reading_slots; ++slot)
      if (readings_.is_open(slot))
        if (const Status s = settle_reading(slot); !s) readings_.lose(slot, s.error());
  }

  static Status event_status(const char* call, const std::string& why_not) {
    if (why_not.empty()) return {};
    return Error{ErrorCode::invalid_argument, text(call, ": event: ", why_not)};
  }

  Status fault_status() {
    const std::string f = ex_.fault();
    return f.empty() ? Status{} : Status{Error{ErrorCode::internal, "device: " + f}};
  }

  void release() {
    ex_.forget_repeats();
    surface_.release(ex_);
    buffers_.release(ex_);
  }

  /// Waits. The status, and the World in its last good state, which the buffers may not show yet.
  WorldStatus last_good() {
    WorldStatus s;
    if (w_.f.status == nullptr) {
      ex_.synchronize();
      return s;
    }
    ex_.download(&s, w_.f.status, sizeof s);
    roll_back(s);
    return s;
  }

  /// slot_of_id of every particle.
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

  /// Behind an edit: `taken` particles were removed; of what keeps heat from flowing `idle` may stay.
  void edited(std::uint64_t taken, std::uint32_t idle) {
    WorldStatus s;
    ex_.download(&s, w_.f.status, sizeof s);
    s.particles = w_.born;
    s.removed += static_cast<std::int64_t>(taken);
    s.heat_idle &= idle;
    ex_.upload(w_.f.status, &s, sizeof s);
    sized_ = false;
    last_index_ = 0;
    count_anew_ = true;
  }

  /// Goes back to the last good state, once, after the stream has been waited for.
  void roll_back(const WorldStatus& s) {
    if (s.halted == 0 || rolled_back_) return;
    buffers_.go_back(w_, s);
    edits_.sorted(false);
    w_.born = s.particles;
    use_slots(slots_for(w_.born));
    rolled_back_ = true;
    index_all();
    if (s.halt_advanced != 0) unguarded([&] { step::restore<E, T>(ex_, w_); });
    ex_.synchronize();
  }

  /// Slots of particles to come are prepared in every buffer that may hold the state.
  void put_state(const SceneConstants& c, const SceneLattice& l, const SceneState& s,
                 const HostLoops& loops) {
    const std::size_t capacity = w_.capacity;
    const ParticleArrays<T> particles(s, capacity, c.species.size(), loops);
    put_particles(ex_, w_, particles);
    if (capacity > s.position.size()) {
      buffers_.turn(w_);
      put_particles(ex_, w_, particles);
    }
    if (buffers_.has_spare_position()) put(ex_, buffers_.spare().position, particles.position);
    put(ex_, w_.f.slot_of_id, particles.id);
    put_tables(ex_, w_, c);
    put_lattice(ex_, w_, l, s, room_, ~FieldSet{0}, loops);
    put_events(ex_, w_, particles.tag, s, room_);
    put_status(ex_, w_, s);
  }

  void use_slots(std::uint32_t slots) {
    w_.particles = slots;
    w_.words_parts = word_parts<E>(slots);
    w_.words_column = spatial::words_stride(slots) * sizeof(NeighbourWord);
    w_.words_room = spatial::words_room(scales_.support_in_spacings, w_.grid.rows, w_.words_parts);
  }

  std::uint32_t slots_for(std::uint32_t born) const { return stepped(born, w_.capacity); }

  void emit(const BurstArguments& b) {
    w_.burst.first_point = b.first_point;
    w_.burst.points = b.points;
    w_.burst.center = cast<T>(b.center);
    w_.burst.velocity = cast<T>(b.velocity);
    w_.burst.axis = cast<T>(b.velocity * (1 / length(b.velocity)));
    w_.burst.radius = static_cast<T>(b.radius);
    w_.burst.across = cast<T>(b.across);
    w_.burst.upright = cast<T>(b.upright);
    w_.burst.width = static_cast<T>(b.width);
    w_.burst.height = static_cast<T>(b.height);
    w_.burst.held = static_cast<T>(b.held);
    w_.burst.enthalpy = b.enthalpy;
    w_.burst.mass = static_cast<T>(b.mass);
    w_.burst.volume = static_cast<T>(b.volume);
    std::copy(b.solute.begin(), b.solute.end(), w_.burst.solute);
    w_.burst.tag = b.tag;
    w_.burst_first = w_.born;
    if (w_.particles != 0) step::let_go<E, T>(ex_, w_);
    if (b.points == 0) return;
    step::emit<E, T>(ex_, w_);
    w_.born += b.points;
    use_slots(slots_for(w_.born));
  }

  void steer(const SubstepArguments& a) {
    if (w_.f.body_motion == nullptr) return;  // they have melted
    const auto n = static_cast<std::uint32_t>(a.steered != nullptr ? a.steered->size() : 0);
    bool jumps = false;
    for (std::uint32_t k = 0; k < n; k += most_steered)
      step::steer<E, T>(ex_, w_, a.steered->data() + k, std::min(most_steered, n - k));
    for (std::uint32_t k = 0; k < n; ++k) jumps = jumps || (*a.steered)[k].jumps;
    if (a.reshaped != nullptr && w_.f.mesh_points != nullptr)
      mesh_staging_.put(ex_, *a.reshaped, w_.f.mesh_points);
    step::set_off<E, T>(ex_, w_, a.time, jumps);
  }

  /// The memory of a World.
  Status allocate(FieldSet channels, const Sizes& n, std::uint64_t needed) {
    const auto items = [&n](Owner owner) { return n.count[static_cast<int>(owner)]; };
    const std::uint64_t available = ex_.free_bytes();
    if (needed > available) return out_of_memory(needed, available);
    if (!buffers_.allocate(ex_, channels, n)) return out_of_memory(needed, available);
    reserved_ = std::max({items(Owner::particle), items(Owner::vertex), items(Owner::event_item)});
    if (!ex_.reserve(reserved_)) return out_of_memory(needed, available);
    if (!mesh_staging_.reserve(ex_, items(Owner::mesh_point))) return out_of_memory(needed, available);
    if constexpr (runs_lanes<E>) ex_.template reserve_split<T>(items(Owner::particle));
    return {};
  }

  /// Whether the sub-step before counted the cells of this one, and whether this one counts those of the next: that has to
  /// be as long, so that particles drift as far, and nothing may move them between the two.
  void count_ahead(const SubstepArguments& a, bool plain) {
    const bool alone = custom_.all_recorded() && !custom_.move_particles() && !ex_.host_captures();
    w_.counted = alone && w_.count_ahead && !count_anew_ && counted_dt_ == a.dt;
    w_.count_ahead = alone && can_fuse_stages(fusion_count_ahead, a.stages);
    w_.cells_begun = w_.counted && plain;
    counted_dt_ = a.dt;
    count_anew_ = false;
  }

  void set_clock(const SubstepArguments& a) {
    w_.clock.dt = static_cast<T>(a.dt);
    w_.clock.half_dt = static_cast<T>(0.5 * a.dt);
    w_.clock.spring_dt = static_cast<T>(scales_.spring_dt * a.spring_stretch);
    w_.clock.step = a.index;
    w_.clock.time = a.time;
    w_.clock.length = a.dt;
    w_.clock.end = a.end;
    w_.clock.sampled = a.sampled;
    w_.clock.sample_at = a.sample_at;
  }

  /// Super-steps of the diffusing quantities: heat, velocity, species.
  void set_super_steps(const SubstepArguments& a) {
    w_.heat_dt = static_cast<T>(a.heat_dt);
    w_.heat_stages = static_cast<std::uint32_t>(a.heat_stages);
    w_.heat_supersteps = static_cast<std::uint32_t>(a.heat_supersteps);
    w_.c.heat_bound = a.heat_bound;
    w_.viscous_dt = a.viscous_dt;
    w_.viscous_stages = static_cast<std::uint32_t>(a.viscous_stages);
    w_.viscous_supersteps = static_cast<std::uint32_t>(a.viscous_supersteps);
    w_.viscous_bound = a.viscous_bound;
    w_.solute_dt = a.solute_dt;
    w_.solute_supersteps = static_cast<std::uint32_t>(a.solute_supersteps);
    w_.solute_bound = a.solute_bound;
    w_.solute_share = a.solute_share;
  }

  /// Units of exact sums: integers of 2^-bits of a heavy particle, moved by a spacing per step, at the far end of its body. A
  /// modulus may be stiffer than springs are.
  void set_sum_units(double dt) {
    const double modulus = std::min(1 / dt, 1.5 * scales_.largest_modulus_rate * dt);
    const double speed = scales_.spacing * std::max(1 / scales_.spring_dt, modulus),
                 size = scales_.spacing * scales_.body_size;
    const double mass = std::ldexp(scales_.largest_mass, -scales_.sum_bits);
    w_.sum_units = core::sum_units(mass, mass * speed, mass * speed * size, mass * size, mass * size * size);
  }

  void begin_substep() {
    static_assert(stage_step_begin == 0);
    if (w_.cells_begun) step::begin_cells<E, T>(ex_, w_);
    else run(stage_step_begin, stage_functions<E, T>[stage_step_begin]);
  }

  /// All stages as one piece of work, which the executor may record and repeat.
  void run_at_once(const SubstepArguments& a, bool timed) {
    if (timed) ex_.begin_stage(whole_substep, "sub-step");
    if constexpr (checked_build) {  // looks between the stages: nothing that could be repeated
      begin_substep();
      run_plain(a);
    } else {
      ex_.repeat(
          repeat_key(a), [&] { begin_substep(); }, [&] { run_plain(a); });
    }
    if (timed) ex_.end_stage(whole_substep);
  }

  bool may_advance(std::uint64_t stages) const {
    return buffers_.has_spare_position() && liquid_alone(w_) && can_fuse_stages(fusion_advance, stages) &&
           custom_.allow_advance(stages);
  }

  /// The schedule of a sub-step, on executors that have tracks.
  Schedule schedule(std::uint64_t stages, bool advances) const {
    const bool stays = w_.c.open_faces == 0u && !std::isfinite(w_.c.stray_speed);
    const std::uint64_t barriers = !advances ? usual_barriers : stays ? probing_barriers : advancing_barriers;
    const Joined joined = custom_.joined(stages);
    return make_schedule(stages & ~stage_bit(stage_step_begin), barriers, &joined);
  }

  /// All but step.begin, which the clock makes different every time.
  void run_stages(const SubstepArguments& a) {
    for (int s = 0; s < stage_count; ++s) {
      if (s <= stage_step_integrate && !abandoned_ && ex_.asked_to_stop()) {
        step::give_up<E, T>(ex_, w_);
        abandoned_ = true;
      }
      if (s != stage_step_begin && ((a.stages >> s) & 1u)) run(s, stage_functions<E, T>[s]);
      for (std::size_t k = 0; k < custom_.count() && !abandoned_; ++k)
        if (custom_[k].after == s) run_custom(k, a);
    }
  }

  /// Runs the sub-step without timings or checks; independent stages run concurrently if the executor can, the host's with
  /// those that they join.
  void run_plain(const SubstepArguments& a) {
    if constexpr (!runs_tracks<E>) {
      run_stages(a);
    } else {
      const Schedule plan = schedule(a.stages, w_.next.position != nullptr);
      run_customs_at(before_tracks, a);
      ex_.begin_tracks();
      for (const int s : EnqueueOrder<E>::of(ex_, plan)) {
        const auto at = static_cast<std::size_t>(s);
        if (plan.track[at] < 0) continue;
        ex_.enter_track(plan.track[at]);
        ex_.hurry(plan.urgency[at]);
        ex_.step_aside(((plan.aside >> s) & 1u) != 0 ? aside_blocks(scales_.support_in_spacings) : 0u);
        for (int t = 0; t < s; ++t)
          if (((plan.waits[at] >> t) & 1u) != 0) ex_.wait_for_stage(t);
        run_unless_done(s);
        run_customs_at(s, a);
        if (((plan.awaited >> s) & 1u) != 0) ex_.mark_stage(s);
      }
      ex_.enter_track(0);
      ex_.hurry(0);
      ex_.step_aside(0);
      for (int s = 0; s < stage_count; ++s)
        if (((plan.last >> s) & 1u) != 0) ex_.wait_for_stage(s);
    }
  }

  /// Runs a stage, the fused stage that replaces it, or nothing if another stage has done its work.
  void run_unless_done(int s) {
    if constexpr (can_fuse<E>) {
      if (w_.next.position != nullptr) {
        if (s == stage_sph_forces) run(s, sph::advance<E, T>);
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
            w_.particles | std::uint64_t{w_.vertices} << 32,
            reinterpret_cast<std::uintptr_t>(w_.f.position),  // which of the buffers
            reinterpret_cast<std::uintptr_t>(w_.before.position),
            reinterpret_cast<std::uintptr_t>(w_.f.velocity),
            reinterpret_cast<std::uintptr_t>(w_.f.id),
            bits(a.dt),
            bits(a.heat_dt),
            bits(a.heat_bound),
            static_cast<std::uint64_t>(a.heat_stages),
            static_cast<std::uint64_t>(a.heat_supersteps),
            bits(a.viscous_dt),
            static_cast<std::uint64_t>(a.viscous_stages),
            bits(a.solute_dt),
            bits(a.solute_share),
            static_cast<std::uint64_t>(a.solute_supersteps),
            (w_.counted ? 1u : 0u) | (w_.count_ahead ? 2u : 0u) | (w_.next.position != nullptr ? 4u : 0u),
            custom_.generation(),
            custom_.any_recorded() ? w_.born : 0};  // which they are told
  }

  void run(int s, StageFunction<E, T> function) {
    // Level temperatures do not change, whether or not the plan has heat stages.
    const bool heat = w_.f.status != nullptr && s != stage_thermal_level &&
                      std::strcmp(stage_table[static_cast<std::size_t>(s)].module, "thermal") == 0;
    if (heat) ex_.set_guard(&w_.f.status->heat_idle);
    if (checked_build) {
      run_checked(s, function);
    } else {
      if (timed_) ex_.begin_stage(s, stage_table[static_cast<std::size_t>(s)].name);
      function(ex_, w_);
      if (timed_) ex_.end_stage(s);
    }
    if (heat) ex_.set_guard(&w_.f.status->halted);
  }

  /// Waits; the first broken invariant after a stage is a fault, which halts the World.
  void look_at(int s, double thermal, double account = 0) {
    ex_.synchronize();
    const auto copy = [this](const auto* from, std::size_t n) { return fetch(ex_, from, n); };
    Invariants<T, decltype(copy)> invariants(w_, copy);
    invariants.account_before = account;
    const bool halted = w_.f.status != nullptr && copy(w_.f.status, 1).front().halted != 0;
    if (!halted && broken_.empty()) broken_ = invariants.after(s, mass_, thermal);
  }

  /// Waits before and after.
  void run_checked(int s, StageFunction<E, T> function) {
    ex_.synchronize();
    const auto copy = [this](const auto* from, std::size_t n) { return fetch(ex_, from, n); };
    double thermal = 0, account = 0;
    if (s == stage_thermal_exchange) {
      thermal = Invariants<T, decltype(copy)>(w_, copy).thermal();
      if (w_.f.heat_account != nullptr) account = copy(w_.f.heat_account, 1).front().step;
    }
    function(ex_, w_);
    look_at(s, thermal, account);
  }

  void run_customs_at(int seat, const SubstepArguments& a) {
    for (std::size_t k = 0; k < custom_.count(); ++k)
      if (custom_.seat(k, a.stages) == seat) run_custom(k, a);
  }

  void run_custom(std::size_t k, const SubstepArguments& a) {
    const CustomStage& stage = custom_[k].stage;
    const int number = custom_stage + static_cast<int>(k);
    StageContext c = context();
    c.dt = a.dt;
    c.time = a.time;
    c.clock = w_.f.clock;
    if (timed_) ex_.begin_stage(number, stage.name.c_str());
    try {
      stage.run(c, stage.user);
    } catch (const std::exception& e) {
      note_thrown(custom_[k], e.what());
    } catch (...) {
      note_thrown(custom_[k], "an exception of unknown type");
    }
    if (timed_) ex_.end_stage(number);
    if (stage.recorded) ex_.ended_recorded(stage.name);
  }

  /// The sub-step is given up while the state that it began with is there; in a graph that is being recorded there is no giving up.
  void note_thrown(const PlacedStage& placed, const char* what) {
    thrown_ = text("custom stage \"", placed.stage.name, "\" threw: ", what);
    if (placed.after >= stage_step_integrate || (placed.stage.recorded && !E::in_host_memory)) return;
    step::give_up<E, T>(ex_, w_);
    abandoned_ = true;
  }

  E ex_;
  std::string device_;
  Frame<T> w_;
  SurfaceRun<E, T> surface_;
  ProbeRun<E, T> probes_;
  ReadingRun<E, T> readings_;
  EngineBuffers<E, T> buffers_;
  MeshStaging<E> mesh_staging_;
  EditRun<E, T> edits_;
  CustomStages custom_;
  Scales scales_;
  Sizes sizes_;
  LatticeRoom room_;
  std::uint64_t vertices_ = 0;  ///< of the lattices that are there
  std::uint64_t last_index_ = 0;
  SoundRoom* sound_ = nullptr;   ///< null until it is asked for
  std::uint32_t materials_ = 0;  ///< rows of the table
  bool sized_ = false;           ///< densities are those of a sub-step since the upload
  std::uint64_t reserved_ = 0;   ///< items that verbs may work on
  std::array<Saved, most_saved_states> saved_;
  void* marks_[2] = {nullptr, nullptr};
  Sampling sampling_;
  bool timed_ = false;  ///< this sub-step
  bool rolled_back_ = false, count_anew_ = true;
  bool abandoned_ = false;  ///< a sub-step since the upload
  std::string thrown_;      ///< by a stage of the host
  double counted_dt_ = 0;   ///< of the sub-step before
  double mass_ = 0;         ///< checked builds: at the upload [kg]
  std::string broken_;      ///< checked builds: the first broken invariant
};

}  // namespace core
}  // namespace v0
}  // namespace meltsim
