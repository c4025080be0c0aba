// SPDX-License-Identifier: Apache-2.0
// The state of a World and its functions, which are defined in the rooms of the host's side: scene (adding, removing),
// steering (what a host changes), readout (what a host reads), snapshot, and world itself (stages, constants, steps, plan).
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <unordered_set>
#include <vector>

#include "description/growth_sites.hpp"
#include "description/material_values.hpp"
#include "description/point_grid.hpp"
#include "engine/engine.hpp"
#include "exec/host_loops.hpp"
#include "meltsim/world.hpp"
#include "shape/mesh_chords.hpp"
#include "shape/shape_lattice.hpp"
#include "shape/shape_node.hpp"
#include "world/stored_body.hpp"
#include "world/substep_budget.hpp"

namespace meltsim {
inline namespace v0 {

struct BodyRecord {
  SolidDesc desc;     ///< `fixed`: no force moves it, now
  bool held = false;  ///< a free or rigid one that is fixed for the time being
  bool kinematic() const { return desc.motion == Motion::kinematic; }
  bool proxy() const { return desc.motion == Motion::proxy; }
  bool rigid() const { return desc.motion == Motion::rigid || proxy(); }  ///< moves as a whole
  bool may_deform() const { return desc.motion == Motion::free && (!desc.fixed || held); }
  bool watched = false;     ///< what acts on it is summed
  double density = 0;       ///< of its particles [kg/m^3]; a proxy's is not its material's
  bool gone = false;        ///< the host removed it
  std::uint64_t taken = 0;  ///< particles that went with it
  std::int64_t before =
      0;  ///< particles that melted off bodies which had its row before it, less those that froze on
  std::uint32_t generation = 0;  ///< of its handle
  std::uint64_t since = 0;       ///< sub-steps that were taken before it came
  double reach = 0;              ///< of its farthest particle as built, from its centre or the pivot [m]
  int longest = 0;               ///< sites along its longest axis, as built
  core::SiteBox box;             ///< of its sites
  Vec3d rest_low,
      rest_high;  ///< of a kinematic body: box of its particles as built, relative to the pivot [m]
  std::uint32_t first_vertex = 0, vertices = 0;  ///< of those that it was built of
  std::uint32_t vertices_in_lattice = 0;         ///< with free ones; 0: compact() has left them out
  std::uint64_t sites = 0;                       ///< likewise
  std::uint32_t end_vertex() const { return first_vertex + vertices_in_lattice; }
  Vec3d pivot;  ///< of a kinematic body, as built, in the World [m]
  std::shared_ptr<const core::MeshChords>
      chords;  ///< how its particles follow its mesh; null until that moves
};

/// Motion of a body's particles relative to its pivot, in a step.
struct BodyExtent {
  double speed = 0;  ///< of the fastest particle relative to the pivot, beside rotation [m/s]
  double reach = 0;  ///< of the farthest [m]
  double later = 0;  ///< of the fastest from the end on [m/s]
  Vec3d low, high;   ///< box of them at the end [m]
  double at = 0;     ///< the end [s]
  const physics::MeshPoint* points = nullptr;  ///< of a body that deforms
};

struct EmitterRecord {
  EmitterDesc desc;
  std::array<double, most_species> contents{};  ///< mass fractions, per species
  std::uint32_t first_point = 0, points = 0;
  std::uint64_t first_layer = 0;  ///< that came after it was added; layers are counted from EmitterDesc::from
  std::uint64_t layers = 0;       ///< one past the last
  double layer_distance = 0;      ///< [m]
  std::uint32_t held_layers = 0;  ///< layers that the nozzle holds
  double lead = 0;                ///< how far behind the centre a layer begins [m]
  bool on = true;
  std::uint64_t skipped = 0;  ///< layers that did not come because it was off, or the domain full
  bool blocked = false;       ///< the last one, because the domain was full
  bool brings = false;        ///< liquid, or would have: there was something to come, by now or once
  // With a level: `points` are of a face, there are no layers, and of the description center, up, width and height are the opening's.
  int face = -1;
  std::uint32_t first_id = 0, ids = 0;  ///< in reserve
  std::uint32_t nozzle = 0;             ///< of those that recycle, in order
  bool reservoir() const { return face >= 0; }
  bool recycles() const { return ids != 0 && !reservoir(); }
  /// Its row of core::Inlets.
  std::uint32_t inlet() const {
    return reservoir() ? static_cast<std::uint32_t>(face) : core::first_nozzle + nozzle;
  }
};

/// Liquid that was added before the first step: ids [first, end), and the cells that it was laid out in.
struct LiquidFill {
  std::uint32_t first = 0, end = 0;
  Vec3d cell;  ///< [m]
};

/// State of an emitter in a snapshot.
struct EmitterState {
  std::uint64_t first_layer = 0, skipped = 0, on = 1;
  double from = 0, speed = 0, temperature = 0;
  Vec3d center;
  double level = 0;  ///< where it has one
  std::uint32_t first_id = 0, ids = 0;
};

/// When and how a body that is held is let go.
struct BodyRelease {
  double held_until = 0;  ///< [s]
  Vec3d velocity, angular_velocity;
};

struct ProbeRecord {
  ProbeDesc desc;
  std::uint32_t serial = 0;  ///< of its handle
  std::vector<physics::SampleField> fields;
  std::uint32_t width = 0, values = 0;  ///< values per point, in all
  std::uint32_t points = 0;             ///< that it has values of
  /// Kinds force, heat and flux: stage sampling.loads.
  bool sums() const { return desc.kind != ProbeKind::point && desc.kind != ProbeKind::level; }
};

/// A sample whose values lie on the backend.
struct PendingSample {
  std::uint64_t step = 0;   ///< index of its sub-step
  double time = 0;          ///< [s]
  std::uint64_t due = 0;    ///< bit per probe
  std::uint64_t at = 0;     ///< first of its values
  bool blank = false;       ///< the World was empty: nothing was written
  double origin_level = 0;  ///< height of the origin then, which levels are relative to [m]
};

/// Samples that a reading takes: those that were on the host, and those that lie in a region on the backend.
struct SampleBatch {
  std::vector<ProbeSeries> series;
  std::vector<PendingSample> pending;
  std::uint64_t first = 0, values = 0;  ///< on the backend
  std::uint64_t region = 0, room = 0;   ///< which, of which of the rooms that there have been
};

struct HeatRegionRecord {
  HeatRegionDesc desc;
  std::uint32_t serial = 0;      ///< of its handle
  SiteBits sites;                ///< on the World's lattice; within the domain
  bool acts = false;             ///< in the step that is being taken, or at the time that it is
  bool moves = false;            ///< it has a path, or a host has moved it: its sites go on beyond walls
  bool steered = false;          ///< a host has moved it, and its path is of no use any more
  double since = 0;              ///< [s] when it lay at `displacement`
  Vec3d displacement, velocity;  ///< [m], from where it was built; [m/s]
};

struct ForceFieldRecord {
  ForceFieldDesc desc;
  PlacedPrimitive place;     ///< its shape, where it has one
  std::uint32_t serial = 0;  ///< of its handle
  bool used = false;         ///< there is a field in this row
};

class WorldImpl final : public Scheduler {
 public:
  // scene/build.cpp
  Result<MaterialId> add_material(const MaterialDesc& m);
  Status set_material(MaterialId id, const MaterialDesc& m);
  Result<std::uint64_t> add_fluid(const FluidDesc& f);
  Result<EmitterId> add_emitter(const EmitterDesc& e);
  Status hold(BodyId body, bool on);
  // scene/solid.cpp
  Result<BodyId> add_solid(const SolidDesc& s);
  class NewBody;
  Status come_back(const StoredBody& stored);
  // scene/heat_regions.cpp
  Result<HeatRegionId> add_heat_region(const HeatRegionDesc& r);
  Status remove_heat_region(HeatRegionId id);
  // steering/force_fields.cpp
  Result<ForceFieldId> add_force_field(const ForceFieldDesc& f);
  Status set_force_field(ForceFieldId id, const ForceFieldDesc& f);
  Status remove_force_field(ForceFieldId id);
  Result<ForceFieldDesc> force_field(ForceFieldId id) const;
  // steering/motion.cpp
  Status set_motion(BodyId id, const BodyMotion& m);
  Result<BodyMotion> motion(BodyId id);
  // steering/mesh.cpp
  Status update_mesh(BodyId id, const std::vector<Vec3d>& vertices, const std::vector<Vec3d>& velocities);
  // steering/proxy.cpp
  Status set_proxy(BodyId id, const ProxyState& state);
  Result<ProxyState> proxy(BodyId id);
  Status watch_forces(BodyId id, bool on);
  Result<std::vector<BodyForces>> take_forces();
  std::uint64_t watched_bodies() const;
  // readout/events.cpp
  Status watch_events(const EventWatch& what);
  Status stop_events();
  Result<Events> take_events();
  // steering/settings.cpp
  Status set_gravity(Vec3d gravity);
  Status set_heat_time_scale(double scale);
  Status set_wall_heat(int face, const SurfaceHeatDesc& heat);
  Status set_free_surface_heat(const SurfaceHeatDesc& heat);
  Status set_velocity(BodyId id, Vec3d velocity, Vec3d angular_velocity);
  Status apply_impulse(BodyId id, Vec3d impulse, Vec3d angular_impulse);
  Status set_emitter(EmitterId id, const EmitterSetting& setting);
  Status set_heat_region(HeatRegionId id, const std::optional<double>& temperature, double source);
  Status set_body_heat(BodyId id, const SurfaceHeatDesc& heat, double source);
  bool bodies_heat() const;
  void follow_heat(double at);
  void find_timed_bodies();
  Status move_heat_region(HeatRegionId id, Vec3d displacement, Vec3d velocity);
  // scene/settle.cpp
  Result<Settled> settle(double seconds);
  // scene/remove.cpp
  Status remove_body(BodyId id);
  Result<std::uint64_t> remove_liquid(const Shape& shape);
  void forget_body(std::uint32_t index);
  Result<std::vector<std::uint32_t>> compact();
  bool forgotten(const BodyRecord& body) const { return body.gone && body.vertices_in_lattice == 0; }
  std::uint32_t free_row() const;
  // world/prepare.cpp
  Status prepare();
  /// prepare(), and whether a step may be taken.
  Status ready_to_step() {
    if (Status s = prepare(); !s) return s;
    return refusal_ ? Status{*refusal_} : Status{};
  }
  // world/step.cpp
  Status step(double dt);
  Result<TimedStep> step_within(double dt, double milliseconds);
  Result<TimedStep> step_part(double dt, std::uint64_t substeps);
  void watch() { engine->watch(&interrupted_); }
  void interrupt() noexcept { interrupted_.store(true, std::memory_order_relaxed); }
  StepResult synchronize();
  bool halted() const { return halted_; }
  double stable_dt();
  double stable_dt(double speed) const;
  Resolved resolved();
  // readout/particles.cpp
  Result<Totals> totals();
  Result<Ledger> ledger();
  Result<ParticleData> particles();
  Result<StageContext> device_state();
  Result<RenderView> render_view(const RenderDesc& d);
  Result<std::vector<PieceInfo>> pieces();
  Result<LatticeData> lattice();
  std::vector<BodyInfo> bodies() const;
  // readout/requests.cpp
  Result<ReadTicket> request(const ReadRequest& what);
  Result<bool> ready(ReadTicket ticket);
  Result<Reading> take(ReadTicket ticket);
  // readout/probes.cpp
  Result<ProbeId> add_probe(const ProbeDesc& p);
  Status remove_probe(ProbeId id);
  Result<std::vector<ProbeSeries>> take_samples();
  Result<std::vector<double>> sample(const std::vector<Vec3d>& points,
                                     const std::vector<std::string>& fields);
  // readout/query.cpp
  Result<std::vector<RayHit>> cast_rays(const std::vector<Ray>& rays, std::uint32_t sought);
  Result<Overlap> overlap(const Shape& shape);
  // readout/views.cpp
  Status check_view(const StageContext& view) const;
  Status check_view(const RenderView& view) const;
  Status check_view(const SurfaceView& view) const;
  // readout/surface.cpp
  Result<SurfaceMesh> surface(const SurfaceDesc& d);
  Status check_surface(const SurfaceDesc& d, double cell) const;
  Result<SurfaceView> surface_view(const SurfaceDesc& d,
                                   SurfaceMesh* mesh);  ///< mesh: null if not requested
  // snapshot/saved_states.cpp
  Status save_state(int slot);
  Status load_state(int slot);
  // snapshot/snapshot.cpp
  Result<std::uint64_t> state_hash();
  Result<std::vector<std::uint8_t>> snapshot();
  Status check_storable() const;
  Status restore(const std::uint8_t* data, std::size_t bytes);
  // snapshot/saved_world.cpp
  Result<std::vector<std::uint8_t>> save();
  Status load_saved(const std::uint8_t* data, std::size_t bytes);
  // world/plan.cpp
  Plan plan();
  Status insert_after(const std::string& after, CustomStage stage) override;
  Status remove(const std::string& name) override;
  Status set_interval(const std::string& module, int n) override;
  Status enable(const std::string& module, bool on) override;
  Status enable_timings(bool on, int every) override;
  bool is_disabled(const std::string& module) const;
  std::string reason_to_rest(const core::StageInfo& info) const;
  StageReport stage_report(int s, const core::Arrangement& arrangement) const;
  void report_stages(Plan& p) const;
  StageReport custom_report(std::size_t k, const core::Arrangement& arrangement) const;
  Status place_stage(const std::string& after, const CustomStage& stage);
  Status remove_stage(const std::string& name);
  Status set_interval_of(const std::string& module, int n);
  Status switch_module(const std::string& module, bool on);

  std::atomic<const void*> user{
      nullptr};  ///< thread whose call is under way: an address of the thread's; null: none
  WorldDesc desc;
  std::string backend_reason;
  std::shared_ptr<core::Engine> engine;
  double time = 0;
  std::uint64_t steps = 0;
  std::vector<MaterialDesc> materials;

  bool valid(BodyId id) const {
    return id.index < bodies_.size() && id.generation == bodies_[id.index].generation &&
           !bodies_[id.index].gone;
  }
  /// The handle of body b, as one that is named by what is of sub-step `step`, or of now; null: the body has come since.
  BodyId id_of(std::size_t b) const { return {static_cast<std::uint32_t>(b), bodies_[b].generation}; }
  BodyId id_of(std::size_t b, std::uint64_t step) const {
    return b < bodies_.size() && bodies_[b].since < step ? id_of(b) : BodyId{};
  }
  bool valid(EmitterId id) const { return id.generation == number_ && id.index < emitters_.size(); }
  bool valid(MaterialId id) const {  // generation 1: by its index, in any World
    return (id.generation == number_ || id.generation == 1) && id.index < materials.size();
  }
  /// A description with the ids of this World in place of bare indices.
  MaterialDesc own(MaterialDesc m) const {
    for (MaterialId* id : {&m.melts_into, &m.dissolves_in})
      if (valid(*id)) id->generation = number_;
    return m;
  }
  /// Rows in double, all values derived.
  physics::Melting melting_of(const MaterialDesc& m) const;
  void fill_heat(core::MaterialRow<double>& r, std::size_t i, const MaterialDesc& m) const;
  core::MaterialRow<double> material_row(std::size_t i) const;
  std::vector<core::MaterialRow<double>> material_rows() const;
  std::vector<physics::MaterialProperties<double>> material_properties() const;
  /// Materials that dissolve in another, in the order in which they were added.
  const std::vector<std::uint32_t>& species() const { return species_; }
  std::vector<MaterialId> species_ids() const;
  /// Brings `state` up to date with the engine, and takes note of what the status says.
  void fetch_state();
  Vec3d lattice_origin() const { return desc.domain.bounded ? desc.domain.min : Vec3d{}; }

 private:
  using Contents = std::array<double, most_species>;  ///< mass fractions, per species
  class Limit;
  /// Sub-steps of one length, and how heat is spread over them.
  struct StepPart {
    int substeps = 0, heat_every = 1, heat_rounds = 0;
    double heat_span = 0;  ///< the longest time that one step of heat takes in [s]
    bool heats(int k) const { return (k + 1) * heat_rounds / substeps > k * heat_rounds / substeps; }
  };
  Status plan_part(double rest, core::SubstepArguments& a, StepPart& part) const;
  void begin_motions(core::SubstepArguments& a, bool first, bool first_of_part);
  class OngoingStep;
  /// State that planning a step changes, restored if the step is not taken.
  struct BeforePlan {
    bool heat_level = false, may_melt = false, melted = false;
    double plan_until = 0;
  };
  Error halted_error() const;
  Status check_step(double dt) const;
  Status not_taken(Status s, const BeforePlan& before);
  Status step(double dt, Limit* limit, TimedStep* done);
  Status attempt(double dt, Limit* limit, TimedStep* done);
  Result<TimedStep> limited_step(double dt, double seconds, std::uint64_t substeps);
  static std::uint32_t next_number();
  core::Surroundings surroundings(double at) const;
  bool uneven_conductors() const;
  void surround();
  void see_along(Vec3d gravity);
  /// Bounds of the motion by force fields.
  struct FieldReach {
    double pull = 0;     ///< largest acceleration [m/s^2]
    double squared = 0;  ///< square of the speed that accelerations lead to [m^2/s^2]
    double wind = 0;     ///< largest speed of a wind [m/s]
  };
  const ForceFieldRecord* field_of(ForceFieldId id) const;
  bool any_field() const;
  Status check_field(const char* call, ForceFieldDesc& f, PlacedPrimitive& place,
                     const ForceFieldRecord* own) const;
  Box box_of(const ForceFieldRecord& r) const;
  static Vec3d point_of(const ForceFieldRecord& r);
  FieldReach reach_of(const ForceFieldRecord& r) const;
  FieldReach reach_of_fields() const;
  physics::ForceField<double> field_row(const ForceFieldRecord& r) const;
  std::uint32_t field_rows() const;
  std::vector<physics::ForceField<double>> acting_fields() const;
  double rest_pressure_at(const std::vector<physics::ForceField<double>>& fields, Vec3d x) const;
  void field_changed(std::uint32_t row);
  static Status no_such_field(const char* call, ForceFieldId id);
  HeatRegionRecord* region_of(HeatRegionId id);
  std::uint32_t region_row(const HeatRegionRecord& region) const;
  Result<SiteBits> region_sites(const Shape& shape, const std::string& what, bool moves) const;
  static Status no_such_region(const char* call, HeatRegionId id);
  void see_speed(double speed);
  Status check_body(const char* call, BodyId id) const;
  Status push(const char* call, const core::PushArguments& a);
  Status check_pushed(const char* call, BodyId id) const;
  // steering/teleport.cpp
  class Teleport;
  Status clear_for_teleport(std::uint32_t body, const physics::RigidPlace& place);
  Result<bool> particles_in(Vec3d low, Vec3d high);
  bool fits(Vec3d x) const;
  physics::RigidMotion motion_for(std::uint32_t body, const BodyMotion& m, double dt) const;
  Status plan_motions(double dt);
  void forget_motion(std::size_t body);
  bool on_path(std::size_t body) const;
  physics::RigidMotion path_motion(std::size_t body, double at) const;
  Status check_path(std::uint32_t body, double dt, double& fastest) const;
  void follow_paths(bool first);
  Status check_motion(std::uint32_t body, const physics::RigidMotion& m, const BodyExtent& extent,
                      double from, double dt) const;
  Status inside_walls(std::uint32_t body, const physics::RigidPlace& place, const BodyExtent& extent) const;
  bool deforms(std::uint32_t body) const { return lattice_.rests[body].first_point != core::none; }
  Result<std::shared_ptr<const core::MeshChords>> bind_mesh(std::uint32_t body,
                                                            const std::string& what) const;
  void make_deformable(std::uint32_t body);
  void plan_mesh(std::uint32_t body, double dt);
  const physics::MeshPoint* mesh_points_of(std::uint32_t body) const;
  BodyExtent extent_of(std::uint32_t body, double dt, bool planned) const;
  void place_mesh_points();
  double motion_dt() const;
  Status check_proxy(const SolidDesc& s, const std::string& what) const;
  Status make_proxy(const std::string& what, const std::vector<Vec3i>& points,
                    const std::vector<Vec3d>& positions, Vec3d center, SolidDesc& s) const;
  physics::RigidMotion motion_for(const ProxyState& state, double dt) const;
  std::vector<BodyForces> forces_of(const core::StateReading& s, const std::vector<bool>& watched,
                                    Vec3d origin, double at) const;
  std::vector<bool> watched() const;
  void place_forces();
  static Status check_touching(std::uint32_t kinds, std::size_t bodies, const char* call);
  Events events_of(const core::StateReading& s, Vec3d origin) const;
  core::ReadParts parts_of(const ReadRequest& what);
  struct OpenReading;
  void fill_reading(Reading& r, core::StateReading& s, const OpenReading& open);
  void forget_events();
  void forget_contacts(std::uint32_t body);
  void fit_events();
  void forget_live(std::uint32_t body);
  Vec3d rest_of(std::uint32_t body, std::uint32_t vertex, const BodyExtent& extent) const;
  core::FactSet facts() const;
  bool may_freeze() const;
  bool may_melt(bool freezes) const;
  core::FactSet facts_of_bodies(bool melts) const;
  core::FactSet facts_of_viscosity() const;
  core::FactSet facts_of_liquid() const;
  core::FactSet facts_of_heat() const;
  bool flows_slowly() const;
  bool isotropic() const;
  bool has_walls() const;
  void find_materials();
  void weigh_materials();
  void note_liquid(std::size_t material);
  void take_census();
  void note(const core::WorldStatus& s);
  void recount(const core::WorldStatus& s);
  /// Lowest and highest temperature [degrees Celsius].
  struct LevelRange {
    double low = infinity, high = -infinity;
    void see(double t) {
      low = std::min(low, t);
      high = std::max(high, t);
    }
    /// Equal temperatures that went through mass * c * T and back may differ in the last bits.
    double rounding() const { return 1e-9 * std::max({1.0, std::fabs(low), std::fabs(high)}); }
    bool equal() const { return high - low <= rounding(); }
  };
  bool temperatures_level();
  bool is_level(const LevelRange& range) const;
  // scene/in_place.cpp
  static Error all_taken(std::size_t points);
  bool edits_in_place() const;
  void look_at_scene();
  Status make_particle_room();
  void make_room_for_steps();
  void make_lattice_room();
  void derive_plan();
  void lose_saved_states();
  bool fits_lattice_room(std::uint64_t vertices, std::uint64_t sites, std::uint64_t bodies) const;
  bool stays_level(double temperature, std::uint32_t idle, std::optional<LevelRange>& range);
  bool holds_contents(const Contents& contents) const;
  void mix();
  bool comes_in_place(double temperature, const core::WorldStatus& status);
  bool takes_new_plan() const;
  Result<bool> find_solids(const EmitterDesc& e, double pipe, core::WorldStatus& status);
  void take_up(EmitterRecord& r, const std::vector<Vec3d>& disc, Vec3d origin, bool running,
               const core::WorldStatus& status);
  bool emitter_joins_in_place(const core::WorldStatus& status);
  Result<bool> find(Vec3d low, Vec3d high, core::WorldStatus& status);
  bool same_search(std::uint64_t particles) const;
  void see(Vec3d x, Vec3d up);
  using Derived =
      std::tuple<double, double, double, double, double, double, double, bool, bool, double, bool, bool>;
  Derived derived() const;
  class Change;
  void half_changed() noexcept;
  void edited_in_place();
  void edited_in_place(const Derived& before);
  void body_joined(std::uint32_t index, const core::SceneState& particles, std::uint64_t displaced,
                   core::WorldStatus status, const physics::MaterialRow<double>& row);
  double largest_mass() const;
  Result<bool> find_around(const std::vector<Vec3d>& positions, Vec3d origin, core::WorldStatus& status);
  bool liquid_joined(const core::SceneState& more, std::uint32_t m, const physics::MaterialRow<double>& row);
  std::optional<Result<std::uint64_t>> add_in_place(const FluidDesc& f, const Contents& contents,
                                                    const std::vector<Vec3d>& positions, Vec3d origin,
                                                    Vec3d cell);
  std::optional<Status> remove_in_place(std::uint32_t body);
  std::optional<Result<std::uint64_t>> remove_liquid_in_place(const Shape& shape);
  bool host_heats() const;
  bool emitting() const;
  bool any_liquid() const;
  bool regions_fit() const;
  static bool acts(const HeatRegionRecord& r, double from, double until);
  bool regions_act(double from, double until);
  core::EngineSetup setup_of(core::FactSet facts) const;
  Status adapt(bool back = false);
  Status follow_plan(double dt);
  static std::uint32_t motion_of(const BodyRecord& body, bool held);
  void set_held(std::size_t body, bool on);
  bool set_held_in_place(std::size_t body, bool on);
  void hold_as(std::size_t body, bool on);
  std::vector<char> fixed_in(const core::SceneState& s) const;
  std::vector<std::size_t> let_go_of_bodies(double dt);
  std::vector<BodyRelease> releases() const;
  void set_releases(const std::vector<BodyRelease>& all);
  std::string reason_of_change(const core::StageInfo& info) const;
  double next_region() const;
  double next_switch(double begin, double end) const;
  bool emits(const EmitterRecord& e) const;
  bool used(std::size_t material) const {
    return liquid_used_[material] != 0u || solid_used_[material] != 0u;
  }
  bool may_be_liquid(std::size_t material) const;
  Box reachable(Box box) const;
  Shape with_images(const Shape& shape) const;
  core::FieldSet channels_of(core::FactSet facts) const;
  std::string heat_reason() const;
  bool heat_from_outside() const;
  void fill_properties(core::SceneConstants& c) const;
  void fill_heat_boundary(core::SceneConstants& c) const;
  std::size_t freezes_into(std::size_t material) const;
  // scene/species.cpp
  std::vector<core::SpeciesRow<double>> species_rows() const;
  std::size_t species_of(std::size_t material) const;
  bool leaves_lattice(std::size_t material) const;
  Status check_species(const MaterialDesc& m) const;
  Status check_fractions(const std::string& what, MaterialId liquid,
                         const std::vector<MassFraction>& fractions, Contents& contents) const;
  double mixed_density(double solvent, const Contents& fractions) const;
  double least_density(std::size_t material) const;
  double largest_density(std::size_t material) const;
  double extreme_volume(std::size_t material, double of_solvent, double sign) const;
  bool species_present() const;
  bool contents_level() const;
  bool solution_heats() const;
  bool dissolves() const;
  bool may_precipitate() const;
  void fill_contents();
  void limit_solute(double laplacian_sum);
  void solute_plan(double dt, core::SubstepArguments& a) const;
  Status check_solute_work(double dt, const core::SubstepArguments& a) const;
  Status check_freezing(const MaterialDesc& m);
  Status check_curves() const;
  Status check_expansion(const MaterialDesc& m, double time_scale) const;
  Status check_melting(const MaterialDesc& m) const;
  void push_material(const MaterialDesc& m);
  void pop_material();
  double fall_height() const;
  double weighed_height() const;
  double buoyant_speed2() const;
  static bool always_hydrostatic(const ForceFieldRecord& r);
  double column_height() const;
  double lowest_place() const;
  // world/sound.cpp
  bool follows_sound() const;
  double largest_substep() const;
  double scene_length() const;
  double driven_head(double from, double until) const;
  void look_at_sound();
  int part_length() const;
  void plan_sound(double span);
  bool at_full_sound();
  double sound_now() const;
  double spring_stretch() const;
  void tell_sound();
  void go_on_with_sound(double dt);
  void take_sound_work();
  physics::FlowCurve<double> flow_of(const MaterialDesc& m) const;
  double largest_viscosity(const MaterialDesc& m) const;
  double least_viscosity(const MaterialDesc& m) const;
  void derive_sound_speed();
  Status check_tension_speed() const;
  Status check_sound_speed() const;
  const MaterialDesc* undamped_liquid() const;
  Status check_damping() const;
  bool driven() const;
  void look_for_refusal();
  core::SceneConstants constants() const;
  std::uint64_t planned_emission() const;
  Status check_setting(EmitterId id, const EmitterRecord& r, const EmitterSetting& setting,
                       const std::string& what) const;
  void count_layers_anew(EmitterRecord& r, const EmitterRecord& before) const;
  void move_nozzle(EmitterRecord& r, Vec3d velocity, Vec3d center);
  bool keeps_level(const EmitterRecord& r);
  Status check_emission(const std::string& what, const EmitterRecord& now, const EmitterRecord& before) const;
  void see_particles(Vec3d up);
  void see_driven(std::size_t first);
  void look_at_added();
  void look_at_heat();
  void see_added();
  void pass_over_particles();
  void see_all_anew();
  double thickest(std::size_t i) const;
  void limit_viscosity(double laplacian_sum);
  void derive_limits();
  void limit_motion(double support);
  void limit_tension(double sum);
  void limit_heat(double support, double sum);
  double least_spring(const MaterialDesc& m) const;
  double least_modulus_rate(const MaterialDesc& m) const;
  int most_half_width() const;
  int widest_half_width(const MaterialDesc& m) const;
  double asked_modulus_rate(const MaterialDesc& m) const;
  double modulus_rate_of(const MaterialDesc& m) const;
  double wanted_spring(const MaterialDesc& m) const;
  double stiffness_in_liquid(const MaterialDesc& m) const;
  int half_width_of(const MaterialDesc& m) const;
  int half_width_of(const BodyRecord& body) const;
  template <class Visit>
  void for_each_of(const MaterialDesc& m, const Visit& visit) const;
  double wave_speed2_for(const BodyRecord& body) const;
  double alpha_of(const BodyRecord& body, double dt) const;
  double alpha_of(const MaterialDesc& m, double dt) const;
  Stiffness stiffness_of(const MaterialDesc& m) const;
  void fit_regions();
  void fit_regions_of(const BodyRecord& body, core::BodyRow& row) const;
  void fit_rows(std::vector<core::MaterialRow<double>>& rows) const;
  bool modulus_out_of_reach() const;
  bool stiffened_by_liquid() const;
  void note_halt(const core::WorldStatus& s, const std::string& fault);
  StepResult collect();
  /// State of the host that belongs to a status.
  struct Moment {
    std::uint64_t steps = 0;
    double time = 0;
    std::uint64_t solids_built = 0;
    bool emitter_exhausted = false;
    std::uint64_t reserved_ids = 0;
    Vec3d origin;
    double sound_speed = 0, sound_work = 0;
    std::uint64_t displaced = 0;
    double displaced_work = 0;
    std::uint64_t forgotten = 0;
  };
  Moment now() const;
  static StepResult result_of(const core::WorldStatus& s, const Moment& at);
  static void report_halt(const core::WorldStatus& s, StepResult& r);
  StepResult take_carried();
  static void add_extremes(StepResult& r, const StepResult& more);
  Status ready_to_read();
  Status ready_for_forces();
  Result<core::StateReading> read_now(const core::ReadParts& parts);
  Status lost_device();
  Totals totals_of(const core::StateReading& s, const StepResult& r, const Moment& at) const;
  Ledger ledger_of(const core::StateReading& s, const StepResult& r, const Moment& at) const;
  std::vector<PieceInfo> pieces_of(const core::StateReading& s, Vec3d origin) const;
  double heat_efficiency(double dt) const;
  int most_heat_stages(double reach) const;
  void heat_plan(double dt, int& stages, int& supersteps, double& heat_dt, double& bound) const;
  std::uint64_t stage_bits(std::uint64_t index, bool heat) const;
  int heat_interval(double substep) const;
  core::BurstArguments burst_of(const EmitterRecord& e, double late, bool comes) const;
  core::InletLayer recycled_layer(const EmitterRecord& e, double late) const;
  bool may_come(const EmitterRecord& e) const;
  const std::vector<core::BurstArguments>* due_bursts(double from, double until);
  double substeps_of(double dt) const;
  std::string fast_sound_text() const;
  Status check_substeps(double dt, double most) const;
  void viscous_plan(double dt, core::SubstepArguments& a) const;
  Status check_viscous_work(double dt, int supersteps) const;
  Status check_heat_work(double dt, double supersteps) const;
  double due(const EmitterRecord& e, std::uint64_t layer) const;
  std::uint64_t layers_before(const EmitterRecord& e, double t) const;
  std::uint64_t layers_due(const EmitterRecord& e, double t) const;
  std::vector<Vec3d> places_of(const EmitterRecord& e) const;
  bool room_behind(const EmitterDesc& e, const std::vector<Vec3d>& disc, double distance) const;
  std::uint64_t next_layer(const EmitterRecord& e) const;
  std::uint64_t to_come(const EmitterRecord& e) const;
  void limit_layers(EmitterRecord& e) const;
  bool exhausted(const EmitterRecord& e) const;
  bool has_room_for(std::uint64_t more) const;
  /// For what is large: of particles, of sites.
  core::HostLoops loops() const { return core::HostLoops(desc.threads); }
  Vec3d cube() const { return {desc.spacing, desc.spacing, desc.spacing}; }
  Vec3d cell_of(const Box& bounds) const;
  Vec3d cut_at_walls(Vec3d x, Vec3d cell) const;
  void put_in_cells(Vec3d o, Vec3d cell, std::vector<Vec3i>& points, std::vector<Vec3d>& positions) const;
  void leave_out_taken(std::vector<Vec3d>& positions, Vec3d origin);
  void leave_room(Vec3d cell, std::vector<Vec3i>& points, std::vector<Vec3d>& positions) const;
  Status place(const Shape& shape, const char* what, bool fixed, Vec3d cell, std::vector<Vec3i>& points,
               std::vector<Vec3d>& positions, Vec3d& origin) const;
  Status check_numbers(const std::string& what, const MaterialDesc& m, double density,
                       double specific_enthalpy, Vec3d velocity) const;
  Status check_liquid(const EmitterDesc& e, const std::string& what, Contents& contents) const;
  Status check_state_of(const EmitterDesc& e, const std::string& what, const Contents& contents,
                        Vec3d velocity) const;
  Status check_emitter(const EmitterDesc& e, const std::string& what, Contents& contents) const;
  Status check_layer(const EmitterDesc& e, const std::string& what) const;
  Status plan_layers(EmitterRecord& r, const std::string& what) const;
  // scene/reservoirs.cpp
  Result<EmitterId> add_reservoir(const EmitterDesc& e);
  Status check_reservoir(const EmitterDesc& e, const std::string& what, Contents& contents) const;
  bool moved_by_face(const EmitterRecord& e, Vec3d x) const;
  Status check_faces(const EmitterDesc& e, const std::string& what, const std::vector<Vec3d>& points) const;
  Status check_face(const EmitterRecord& r, const std::string& what, const std::vector<Vec3d>& points) const;
  Status check_layer_of_face(const EmitterDesc& e, const std::string& what) const;
  Status check_reserve(const EmitterRecord& r, std::uint64_t ids, const std::string& what) const;
  Status plan_reserve(EmitterRecord& r, const std::string& what) const;
  void put_in_reserve(EmitterRecord& r, Vec3d at);
  core::Inlet<double> span_of(const EmitterRecord& e) const;
  void fill_inlets(core::SceneConstants& c) const;
  std::uint64_t reserved_ids() const;
  static std::uint64_t left_of(std::uint64_t removed, std::uint64_t entered, std::uint64_t reserve);
  core::Inlet<double> inlet_row(const EmitterRecord& e) const;
  Status set_reservoir(EmitterId id, const EmitterSetting& setting, const std::string& what);
  // scene/build.cpp
  double free_room() const;
  // world/room.cpp
  bool has_memory_for(std::uint64_t particles, core::FactSet facts, bool solutes) const;
  Status check_memory(const EmitterRecord& e, const std::string& what);
  Status check_nozzle(const EmitterDesc& e, const std::string& what, const std::vector<Vec3d>& disc,
                      const EmitterRecord* moved) const;
  Status origin_for(const std::vector<Vec3d>& positions, const char* what, Vec3d& origin) const;
  void settle_at(Vec3d origin);
  void reserve(std::size_t particles, std::size_t vertices, std::size_t sites);
  void extend(core::SceneState& to, std::size_t particles) const;
  void put(core::SceneState& to, std::size_t i, Vec3d position, Vec3d velocity, double density,
           double specific_enthalpy, std::uint32_t tag, std::uint32_t vertex, const Contents& fractions,
           Vec3d cell) const;
  void append(core::SceneState& to, Vec3d position, Vec3d velocity, double density, double specific_enthalpy,
              std::uint32_t tag, std::uint32_t vertex, const Contents& fractions, Vec3d cell) const;
  void extend_vertices(std::size_t vertices);
  void put_vertex(std::size_t v, std::uint32_t id, std::uint32_t state, std::uint32_t piece);
  void drop_fluid(std::uint32_t id);
  void leave_out(const std::vector<std::uint8_t>& drop);
  // scene/settle.cpp
  void make_calm(WorldImpl& calm) const;
  void fix_bodies();
  void hold_liquid(const std::vector<std::uint32_t>& hanging);
  std::array<ForceFieldRecord, physics::most_force_fields> calming_fields(double rate) const;
  double sound_path() const;
  Status run_calm(double seconds, const std::atomic<bool>& interrupted, Settled& done);
  void take_places_of(const WorldImpl& calm, Settled& done);
  // scene/hydrostatic.cpp
  void lay_out();
  void derive_sound_anew();
  void start_at_rest();
  void press_liquid();
  std::vector<std::uint32_t> hanging() const;
  const core::PointGrid& places();
  void update_state();
  void close_up();
  std::vector<std::uint8_t> forgettable() const;
  void leave_out_lattices();
  void leave_out_rows();
  void leave_out_meshes();
  std::uint64_t lattice_hash() const;
  std::uint64_t material_hash(const MaterialDesc& m) const;
  struct StoredState;
  class SnapshotCheck;
  class OtherBodies;
  StoredBody stored_body(std::uint32_t row) const;
  std::vector<std::uint32_t> rows_by_vertex() const;
  Status check_loadable() const;
  Status restore_state(const std::uint8_t* data, std::size_t bytes, const std::vector<StoredBody>* bodies);
  StoredState stored_state() const;
  static Status read_snapshot(const std::uint8_t* data, std::size_t bytes, StoredState& stored,
                              core::SceneState& s);
  Status check_same_setting(const StoredState& stored, const core::SceneState& s) const;
  Status check_same_bodies(const StoredState& stored, const core::SceneState& s) const;
  Status check_stored(const StoredState& stored, const core::SceneState& s) const;
  static Status check_speeds(const StoredState& stored);
  Status check_reservoirs(const StoredState& stored, std::uint64_t particles) const;
  void take_over(const StoredState& stored, core::SceneState&& s, OtherBodies* others);
  std::vector<char> held_in(const StoredState& stored, const core::SceneState& s) const;
  void take_over_sound(const StoredState& stored);
  void fit_sound_to_settings(double stored);
  void take_over_bodies(const StoredState& stored, const std::vector<char>& held);
  Status check_mesh_points(const std::vector<std::uint64_t>& deformed,
                           const std::vector<physics::MeshPoint>& points, double new_time) const;
  static void put_emitter(const EmitterState& s, EmitterRecord& e);
  Status check_emitter(std::size_t k, const EmitterState& s, double new_time) const;
  Status check_origin(Vec3d origin) const;
  std::string halt_text(const core::WorldStatus& s);
  void round_to_precision(double& v) const;
  Status check_points(const std::string& what, const ProbeDesc& p) const;
  Status check(const ProbeDesc& p, ProbeRecord& record) const;
  core::FactSet probe_facts() const;
  Status check_load(const std::string& what, const ProbeDesc& p, ProbeRecord& record) const;
  Vec3d middle_of_wall(std::uint32_t face) const;
  void place_load(const ProbeRecord& record, std::uint32_t number, core::ProbeSetup& s) const;
  std::vector<core::ProbeLine> lines_of(const ProbeDesc& p) const;
  core::ProbeSetup probe_setup() const;
  Status place_probes();
  void begin_sample(core::SubstepArguments& a, double end);
  void end_sample(const core::SubstepArguments& a, double end);
  void collect_samples();
  SampleBatch hand_over_samples();
  void choose_region();
  void add_samples(const SampleBatch& batch, const double* values, std::uint64_t halt_step,
                   std::vector<ProbeSeries>& to) const;
  std::vector<ProbeSeries> empty_series() const;
  std::uint64_t first_of_region() const { return sample_region_ * sample_room_; }
  void drop_samples_from(double time);
  Vec3d up() const;

  std::vector<std::uint32_t> species_;  ///< material indices
  bool species_used_ = false;           ///< something is dissolved or dissolves, or will be emitted so
  bool contents_level_ = false;  ///< contents are the same everywhere and stay so: nothing is exchanged
  double solute_lambda_ = 0;     ///< twice the largest exchange over mass [1/s]
  std::vector<physics::MaterialProperties<double>> properties_;  ///< what rows' tables point to
  std::uint32_t number_ =
      next_number();  ///< of this World in the process: tells its handles from those of others
  std::uint32_t body_number_ = number_;  ///< the same of bodies in new rows: another one after load_saved()
  std::vector<BodyRecord> bodies_;
  std::vector<std::optional<BodyMotion>> motions_;  ///< per body: set since the last step
  /// A mesh that the host set: where its body's particles go. The memory is kept for the next one.
  struct PendingMesh {
    std::vector<physics::MeshPoint> points;
    bool set = false;
  };
  std::vector<PendingMesh> meshes_;                 ///< per body: set since the last step
  std::vector<core::Reshaped> reshaped_;            ///< the same, for the step that is being taken
  std::vector<std::optional<ProxyState>> proxies_;  ///< per body: set since the last step
  std::optional<EventWatch> event_watch_;
  std::vector<core::Steered> steered_;  ///< the same, for the step that is being taken
  double carried_speed_ = 0;            ///< of the fastest kinematic body in that step [m/s]
  std::unordered_set<std::string> body_names_;
  std::vector<EmitterRecord> emitters_;
  std::vector<std::uint32_t>
      timed_bodies_;  ///< whose surface has values in time, of the step that is being taken
  std::vector<HeatRegionRecord> heat_regions_;                             ///< that there are
  std::uint32_t next_region_ = 0;                                          ///< serial of the next one
  std::array<ForceFieldRecord, physics::most_force_fields> force_fields_;  ///< the rows of the backend
  std::uint32_t next_field_ = 0;                                           ///< serial of the next one
  core::SceneState state_;
  std::optional<core::PointGrid> places_;  ///< positions of `state_` by id, while things are added
  std::vector<std::uint32_t> holes_;       ///< ids whose liquid was displaced before the first step
  struct LaidOut {
    std::uint32_t id = 0;
    double at = 0;  ///< coordinate along laid_out_axis_ [m]
  };
  int laid_out_axis_ = 1;
  /// Liquid that was compressed for a hydrostatic start and where it was laid out, by id, until the first step.
  std::vector<LaidOut> laid_out_;
  std::vector<LiquidFill> fills_;
  bool pressed_ = false;  ///< liquid starts compressed, or was restored
  core::SceneLattice lattice_;
  std::uint64_t solids_built_ = 0;  ///< particles that bodies were built of, less what was removed with them
  std::vector<Vec3d> emitter_points_;
  Vec3d origin_;
  bool origin_set_ = false;
  bool dirty_ = true;                     ///< the engine does not hold `state_`
  bool state_stale_ = false;              ///< the engine is ahead of `state_`
  std::atomic<bool> interrupted_{false};  ///< asked for; set from any thread or a signal handler
  static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");
  bool halted_ = false;
  std::uint64_t halt_step_ = 0;
  std::string halt_reason_;
  bool added_ = true;  ///< something was, since the sound speed was derived
  /// What the sound speed was derived from: height and speed of all that was added, as it was added.
  struct Extremes {
    double low = infinity, high = -infinity, speed = 0;
    /// The box of it, for another gravity [m].
    Vec3d min{infinity, infinity, infinity}, max{-infinity, -infinity, -infinity};
    void see(Vec3d x, Vec3d up) {
      low = std::min(low, dot(x, up));
      high = std::max(high, dot(x, up));
      see(Box{x, x});
    }
    void see(const Extremes& more) {
      low = std::min(low, more.low);
      high = std::max(high, more.high);
      speed = std::max(speed, more.speed);
      see(Box{more.min, more.max});
    }
    void see(const Box& b) {
      min = {std::min(min.x, b.min.x), std::min(min.y, b.min.y), std::min(min.z, b.min.z)};
      max = {std::max(max.x, b.max.x), std::max(max.y, b.max.y), std::max(max.z, b.max.z)};
    }
  } seen_;
  std::size_t seen_particles_ = 0, seen_emitters_ = 0, seen_bodies_ = 0;  ///< they are in it
  double sound_speed_ = 0;  ///< of the scene: the derived one, or WorldDesc::sound_speed
  /// Where the sound speed follows what moves (world/sound.cpp); snapshots hold it.
  struct FollowedSound {
    double level = 0;           ///< c that sub-steps are made for [m/s]; 0: the scene's
    double now = 0;             ///< c of the next sub-step [m/s]; 0: nothing was looked at yet
    double head = 0;            ///< found at the last look, above the lowest place [m^2/s^2]
    double told = 0;            ///< that of the last sub-step, which the engine has [m/s]
    double work = 0;            ///< of changes, up to the last look [J]
    std::uint64_t elastic = 0;  ///< SoundLook::elastic
  } sound_;
  double sound_target_ = 0;  ///< where c goes until the next plan [m/s]
  bool look_now_ = true;  ///< something was changed by the host: the next part of a step begins with a look
  double last_max_speed_ = 0;  ///< seen at the last synchronize() [m/s]
  /// Per material: liquid, or solid, of it is or was in the scene, is to be emitted, or can come to be by melting. What only
  /// lies in the table costs nothing.
  std::vector<std::uint8_t> liquid_used_, solid_used_;
  std::vector<std::uint8_t>
      liquid_used_before_;                  ///< for a step that is refused; kept so that no step allocates
  std::vector<std::uint8_t> liquid_there_;  ///< as liquid_used_, but for what can come to be by melting
  /// Something could melt in a sub-step that was taken / or could in the next one. A plan that no sub-step followed
  /// leaves no trace, so that limits do not depend on when the host looks.
  bool could_melt_ = false, may_melt_ = false;
  bool one_liquid_ = false;  ///< no two materials are liquid, now or by melting or emission
  double densest_added_ =
      0;                 ///< of liquid that was added or is emitted, not of what melted [kg/m^3]; 0: none
  double contrast_ = 1;  ///< physics::contrast_factor of what is in the scene
  core::FactSet facts_ = 0;
  /// Census of the scene, from which its stages follow. It may lag behind the device
  /// until the host reads a status: then a stage runs that has nothing to do.
  struct Census {
    bool fluid = false;
    bool supercooled = false;        ///< liquid that freezes without losing heat
    bool molten = false;             ///< solid that melts without gaining heat
    bool apart = false;              ///< a body in several pieces
    bool unsettled = false;          ///< something melted or froze since regions or pieces were updated
    std::vector<std::uint8_t> live;  ///< per body: something of it is solid
    std::uint64_t meltable = 0;      ///< solid particles that can melt
    std::uint64_t removed = 0;       ///< particles that have left
  };
  void count(std::uint32_t tag, const std::vector<physics::MaterialRow<double>>& rows, double h, Census& c,
             std::vector<std::uint8_t>& live) const;
  Census census_;
  std::uint64_t born_ = 0;        ///< ids handed out, by sub-steps that are only enqueued, too
  std::uint64_t noted_step_ = 0;  ///< the sub-step of the status that the census follows
  bool measure_ = true;           ///< something was added: whether temperatures are level is to be asked
  bool plan_changed_ = false;     ///< the census asks for other stages than `facts_`
  bool was_emitting_ = false;
  double plan_until_ = 0;                   ///< end of the step that is being taken [s]
  std::uint32_t capacity_ = 0;              ///< particles that the engine has room for
  core::LatticeRoom room_;                  ///< lattices that the engine has room for; 0: without a reserve
  std::uint64_t searched_ = 0;              ///< those that the search was chosen for: without room in reserve
  std::optional<LevelRange> level_;         ///< temperatures, where they are level and were measured since
  std::uint64_t displaced_ = 0;             ///< liquid that teleports have put elsewhere
  double displaced_work_ = 0;               ///< on it, against gravity [J]
  std::uint64_t forgotten_ = 0;             ///< removed particles that compact() has left out
  std::vector<core::FoundParticle> found_;  ///< by the last find()
  core::SearchChoice search_;
  double spring_dt_ = 0;            ///< what contacts and bodies without a modulus go by [s]
  double spring_share_ = 1;         ///< of the acoustic step
  double static_dt_ = infinity;     ///< largest sub-step [s] whatever moves
  double rest_dt_ = infinity;       ///< what of it does not follow from sound [s]
  double sound_dt_ = infinity;      ///< what of it is inversely as the sound speed [s]
  double substep_ = 0;              ///< the last one [s], 0 before the first
  core::SubstepCost substep_cost_;  ///< by the wall clock, of step_within()
  StepResult carried_;              ///< extremes seen by a synchronize() of the World's own
  bool changes_phase_ = false;      ///< a material in use melts or freezes
  double heat_lambda_ = 0;          ///< bound of the heat operator's spectrum [1/s]
  std::optional<Error>
      refusal_;  ///< what falls outruns the sound speed, or nothing damps liquid: no step is taken
  bool strong_pull_ = false;  ///< a body's damping and stiffness need two super-steps of implicit viscosity
  double viscous_dt_ = infinity;  ///< what explicit viscosity would allow [s]
  double viscous_lambda_ = 0;     ///< bound of the viscous operator's spectrum [1/s]
  bool diffuses_ = false;         ///< viscosity is implicit
  std::vector<core::MaterialRow<double>> rows_;
  std::vector<core::BurstArguments> bursts_;
  std::vector<core::InletLayer> layers_;  ///< of nozzles that recycle, in the next sub-step
  std::vector<ProbeRecord> probes_;       ///< that there are
  std::uint32_t next_probe_ = 0;          ///< serial of the next one
  std::vector<PendingSample> pending_;
  std::vector<ProbeSeries> sampled_;  ///< per probe: on the host already
  /// The backend's room for samples is in as many regions as there may be readings, and one more: sub-steps write to one of
  /// them, open readings hold others.
  std::uint64_t sample_region_ = 0;
  std::uint64_t sample_rooms_ = 0;  ///< how often the engine was given other probes
  std::uint64_t sample_room_ = 0;   ///< values of a region
  std::uint64_t samples_used_ = 0;  ///< those that are in the region that is written to
  bool probes_stale_ = false;       ///< the engine does not have them as they are
  std::vector<core::PlacedStage> custom_;
  core::FactSet disabled_facts_ = 0;
  std::vector<std::string> disabled_modules_;
  int topology_interval_ = 1;
  double heat_owed_ = 0;  ///< [s] of sub-steps without heat in a step that was broken off
  int timings_every_ = 0;
  struct OpenReading {
    ReadTicket ticket;
    ReadRequest what;
    Moment at;
    SampleBatch samples;
    StepResult carried;          ///< extremes that the host had
    std::uint64_t restored = 0;  ///< restored_ then
    bool of_nothing = false;     ///< the World was empty: `carried` is all there is
    std::vector<bool> watched;   ///< bodies whose forces are in it
  };
  std::array<OpenReading, most_readings> readings_;  ///< the engine's slots of the same number
  /// State of the host that belongs to a state saved in the backend's memory.
  struct SavedState {
    std::uint64_t layout = 0;    ///< layout_ then; 0: none
    std::uint64_t restored = 0;  ///< restored_ then
    double time = 0, substep = 0, last_max_speed = 0, plan_until = 0, heat_owed = 0;
    std::uint64_t steps = 0, born = 0, noted_step = 0;
    bool heat_level = false, could_melt = false, was_emitting = false, plan_changed = false, look_now = false;
    FollowedSound sound;
    std::vector<EmitterRecord> emitters;
    std::vector<physics::RigidMotion> motion;
    std::vector<physics::MeshPoint> mesh_points;
    std::vector<BodyRelease> releases;
    Census census;
  };
  /// The views made last: their serial, and the counters that must not have changed since.
  struct Made {
    std::uint64_t serial = 0, layout = 0, uploads = 0, restored = 0, steps = 0;
  };
  std::uint64_t mark_view(Made& made, bool anew);
  Status check_view(const char* call, const Made& made, std::uint64_t serial) const;
  Made state_view_, render_view_, surface_view_;
  std::uint32_t views_ = 0;    ///< serials given out
  std::uint64_t uploads_ = 0;  ///< how often the engine was given the scene anew
  Status check_slot(const char* call, int slot) const;
  Status check_saved(const SavedState& v, int slot) const;
  void forget_what_followed();
  std::array<SavedState, most_saved_states> saved_;
  std::uint64_t layout_ = 0;    ///< of the engine's memory: how often it was made anew or changed
  std::uint64_t restored_ = 0;  ///< how often another state has come in place of this one
};

/// Halts a World that runs if memory ends within a change of what lies on its backend: it would go on half changed.
class WorldImpl::Change {
 public:
  explicit Change(WorldImpl& world) : world_(world) {}
  ~Change() {
    if (std::uncaught_exceptions() > before_) world_.half_changed();
  }
  Change(const Change&) = delete;
  Change& operator=(const Change&) = delete;

 private:
  WorldImpl& world_;
  int before_ = std::uncaught_exceptions();
};

}  // namespace v0
}  // namespace meltsim
