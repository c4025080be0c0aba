// SPDX-License-Identifier: Apache-2.0
// The public face: creation, choice of backend, and forwarding.
#include "meltsim/world.hpp"

#include "description/validate.hpp"
#include "engine/text.hpp"
#include "exec/threads.hpp"
#include "world/guarded.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::guarded;
using core::guarded_report;
using core::not_entered;
using core::Use;

namespace {
Error moved_from() { return core::invalid("World: it was moved from; use the World that it was moved to"); }
/// function(), unless the World was moved from, another thread is in a call of it, or one of its stages calls.
template <class R, class Function>
R alone(WorldImpl* impl, const Function& function) noexcept {
  if (impl == nullptr) return guarded<R>(moved_from);
  const Use use(impl->user);
  return use.entered() ? guarded<R>(function) : guarded<R>([&] { return not_entered(use); });
}

/// The same for what holds from the next step on and touches nothing that a stage sees.
template <class Function>
Status setting(WorldImpl* impl, const Function& function) noexcept {
  if (impl == nullptr) return guarded<Status>(moved_from);
  const Use use(impl->user);
  return use.entered() || use.within() ? guarded<Status>(function)
                                       : guarded<Status>([&] { return not_entered(use); });
}

/// The same as alone() where the result has a place for the message.
template <class R, class Function>
R reported(WorldImpl* impl, const Function& function) {
  return guarded_report<R>([&]() -> R {
    R r{};
    if (impl == nullptr) return r.error = moved_from().message, r;
    const Use use(impl->user);
    if (!use.entered()) return r.error = not_entered(use).message, r;
    return function();
  });
}
}  // namespace

World::World(std::unique_ptr<WorldImpl> impl) : impl_(std::move(impl)) {}
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;
World::~World() = default;

Result<World> World::create(const WorldDesc& desc, std::uint32_t header_version, std::uint32_t layout) {
  return guarded<Result<World>>([&]() -> Result<World> {
    const std::uint32_t mine = MELTSIM_VERSION_NUMBER;
    // 0.x: minor versions may change the interface, patches may not.
    if (header_version / 100 != mine / 100 || desc.header_version / 100 != mine / 100)
      return Error{ErrorCode::version_mismatch,
                   core::text("header_version: compiled against ",
                              header_version / 100 != mine / 100 ? header_version : desc.header_version,
                              ", the library is ", mine, "; rebuild the host with the library's headers")};
    if (layout != layout_of_headers)
      return Error{
          ErrorCode::version_mismatch,
          core::text(
              "layout: the host was compiled against headers of another state of version ", mine,
              ", or with options that change the sizes of structs; rebuild it with the library's headers")};
    if (Status s = core::validate(desc); !s) return s.error();
    auto impl = std::make_unique<WorldImpl>();
    impl->desc = desc;
    Result<std::shared_ptr<core::Engine>> engine = Error{};
    if (desc.backend != Backend::cpu) {
      engine = core::make_cuda_engine(desc);
      if (!engine && desc.backend == Backend::cuda) return engine.error();
      impl->backend_reason = engine ? "a CUDA device is usable" : engine.error().message;
    } else {
      impl->backend_reason = "asked for";
    }
    if (desc.backend == Backend::cuda) impl->backend_reason = "asked for";
    if (!engine) engine = core::make_cpu_engine(desc);
    if (!engine) return engine.error();
    impl->engine = *engine;
    impl->watch();
    return World(std::move(impl));
  });
}

Result<MaterialId> World::add_material(const MaterialDesc& d) {
  return alone<Result<MaterialId>>(impl_.get(), [&] { return impl_->add_material(impl_->own(d)); });
}
Status World::set_material(MaterialId material, const MaterialDesc& d) {
  return alone<Status>(impl_.get(), [&] { return impl_->set_material(material, impl_->own(d)); });
}
Result<std::uint64_t> World::add_fluid(const FluidDesc& d) {
  return alone<Result<std::uint64_t>>(impl_.get(), [&] { return impl_->add_fluid(d); });
}
Result<BodyId> World::add_solid(const SolidDesc& d) {
  return alone<Result<BodyId>>(impl_.get(), [&] { return impl_->add_solid(d); });
}
Result<Settled> World::settle(double seconds) {
  return alone<Result<Settled>>(impl_.get(), [&] { return impl_->settle(seconds); });
}
Result<HeatRegionId> World::add_heat_region(const HeatRegionDesc& desc) {
  return alone<Result<HeatRegionId>>(impl_.get(), [&] { return impl_->add_heat_region(desc); });
}
Result<ForceFieldId> World::add_force_field(const ForceFieldDesc& desc) {
  return alone<Result<ForceFieldId>>(impl_.get(), [&] { return impl_->add_force_field(desc); });
}
Status World::set_force_field(ForceFieldId field, const ForceFieldDesc& desc) {
  return alone<Status>(impl_.get(), [&] { return impl_->set_force_field(field, desc); });
}
Result<ForceFieldDesc> World::force_field(ForceFieldId field) {
  return alone<Result<ForceFieldDesc>>(impl_.get(), [&] { return impl_->force_field(field); });
}
Status World::remove(ForceFieldId field) {
  return alone<Status>(impl_.get(), [&] { return impl_->remove_force_field(field); });
}
Result<EmitterId> World::add_emitter(const EmitterDesc& d) {
  return alone<Result<EmitterId>>(impl_.get(), [&] { return impl_->add_emitter(d); });
}
Status World::remove(HeatRegionId region) {
  return alone<Status>(impl_.get(), [&] { return impl_->remove_heat_region(region); });
}
Status World::remove(ProbeId probe) {
  return alone<Status>(impl_.get(), [&] { return impl_->remove_probe(probe); });
}
Status World::remove(BodyId body) {
  return alone<Status>(impl_.get(), [&] { return impl_->remove_body(body); });
}
Result<std::vector<std::uint32_t>> World::compact() {
  return alone<Result<std::vector<std::uint32_t>>>(impl_.get(), [&] { return impl_->compact(); });
}
Result<std::uint64_t> World::remove_liquid(const Shape& shape) {
  return alone<Result<std::uint64_t>>(impl_.get(), [&] { return impl_->remove_liquid(shape); });
}
Status World::set_motion(BodyId body, const BodyMotion& motion) {
  return alone<Status>(impl_.get(), [&] { return impl_->set_motion(body, motion); });
}
Status World::update_mesh(BodyId body, const std::vector<Vec3d>& vertices,
                          const std::vector<Vec3d>& velocities) {
  return alone<Status>(impl_.get(), [&] { return impl_->update_mesh(body, vertices, velocities); });
}
Status World::set_proxy(BodyId body, const ProxyState& state) {
  return alone<Status>(impl_.get(), [&] { return impl_->set_proxy(body, state); });
}
Result<ProxyState> World::proxy(BodyId body) {
  return alone<Result<ProxyState>>(impl_.get(), [&] { return impl_->proxy(body); });
}
Status World::watch_forces(BodyId body, bool on) {
  return alone<Status>(impl_.get(), [&] { return impl_->watch_forces(body, on); });
}
Status World::watch_events(const EventWatch& what) {
  return alone<Status>(impl_.get(), [&] { return impl_->watch_events(what); });
}
Status World::stop_events() {
  return alone<Status>(impl_.get(), [&] { return impl_->stop_events(); });
}
Result<Events> World::take_events() {
  return alone<Result<Events>>(impl_.get(), [&] { return impl_->take_events(); });
}
std::uint64_t World::watched_bodies() const { return impl_->watched_bodies(); }
Result<std::vector<RayHit>> World::cast_rays(const std::vector<Ray>& rays, std::uint32_t sought) {
  return alone<Result<std::vector<RayHit>>>(impl_.get(), [&] { return impl_->cast_rays(rays, sought); });
}
Result<Overlap> World::overlap(const Shape& shape) {
  return alone<Result<Overlap>>(impl_.get(), [&] { return impl_->overlap(shape); });
}
Result<RenderView> World::render_view(const RenderDesc& desc) {
  return alone<Result<RenderView>>(impl_.get(), [&] { return impl_->render_view(desc); });
}
Result<std::vector<BodyForces>> World::take_forces() {
  return alone<Result<std::vector<BodyForces>>>(impl_.get(), [&] { return impl_->take_forces(); });
}
Status World::set_gravity(Vec3d gravity) {
  return setting(impl_.get(), [&] { return impl_->set_gravity(gravity); });
}
Status World::set_heat_time_scale(double scale) {
  return setting(impl_.get(), [&] { return impl_->set_heat_time_scale(scale); });
}
Status World::set_wall_heat(int face, const SurfaceHeatDesc& heat) {
  return setting(impl_.get(), [&] { return impl_->set_wall_heat(face, heat); });
}
Status World::set_free_surface_heat(const SurfaceHeatDesc& heat) {
  return setting(impl_.get(), [&] { return impl_->set_free_surface_heat(heat); });
}
Status World::set_velocity(BodyId body, Vec3d velocity, Vec3d angular_velocity) {
  return alone<Status>(impl_.get(), [&] { return impl_->set_velocity(body, velocity, angular_velocity); });
}
Status World::apply_impulse(BodyId body, Vec3d impulse, Vec3d angular_impulse) {
  return alone<Status>(impl_.get(), [&] { return impl_->apply_impulse(body, impulse, angular_impulse); });
}
Status World::hold(BodyId body, bool on) {
  return alone<Status>(impl_.get(), [&] { return impl_->hold(body, on); });
}
Status World::set_emitter(EmitterId emitter, const EmitterSetting& setting) {
  return alone<Status>(impl_.get(), [&] { return impl_->set_emitter(emitter, setting); });
}
Status World::set_heat_region(HeatRegionId region, const std::optional<double>& temperature, double source) {
  return alone<Status>(impl_.get(), [&] { return impl_->set_heat_region(region, temperature, source); });
}
Status World::set_body_heat(BodyId body, const SurfaceHeatDesc& heat, double source) {
  return alone<Status>(impl_.get(), [&] { return impl_->set_body_heat(body, heat, source); });
}
Status World::move_heat_region(HeatRegionId region, Vec3d displacement, Vec3d velocity) {
  return alone<Status>(impl_.get(), [&] { return impl_->move_heat_region(region, displacement, velocity); });
}
Result<BodyMotion> World::motion(BodyId body) {
  return alone<Result<BodyMotion>>(impl_.get(), [&] { return impl_->motion(body); });
}
Status World::prepare() {
  return alone<Status>(impl_.get(), [&] { return impl_->ready_to_step(); });
}
Status World::step(double dt) {
  return alone<Status>(impl_.get(), [&] { return impl_->step(dt); });
}
Result<TimedStep> World::step_within(double dt, double milliseconds) {
  return alone<Result<TimedStep>>(impl_.get(), [&] { return impl_->step_within(dt, milliseconds); });
}
Result<TimedStep> World::step_part(double dt, std::uint64_t substeps) {
  return alone<Result<TimedStep>>(impl_.get(), [&] { return impl_->step_part(dt, substeps); });
}
void World::interrupt() noexcept { impl_->interrupt(); }
StepResult World::synchronize() {
  if (impl_ == nullptr) return reported<StepResult>(nullptr, [] { return StepResult{}; });
  const Use use(impl_->user);
  if (!use.entered())
    return guarded_report<StepResult>([&] {
      StepResult r;
      r.error = not_entered(use).message;
      return r;
    });
  StepResult r = guarded_report<StepResult>([&] { return impl_->synchronize(); });
  r.steps = impl_->steps;
  r.time = impl_->time;
  r.halted = impl_->halted();
  return r;
}
double World::stable_dt() const {
  try {
    return impl_->stable_dt();
  } catch (...) {  // no memory to prepare: the next step says so
    return impl_->stable_dt(0);
  }
}
double World::stable_dt(double speed) const { return impl_->stable_dt(speed); }
Result<ReadTicket> World::request(const ReadRequest& what) {
  return alone<Result<ReadTicket>>(impl_.get(), [&] { return impl_->request(what); });
}
Result<bool> World::ready(ReadTicket ticket) {
  return alone<Result<bool>>(impl_.get(), [&] { return impl_->ready(ticket); });
}
Result<Reading> World::take(ReadTicket ticket) {
  return alone<Result<Reading>>(impl_.get(), [&] { return impl_->take(ticket); });
}
Result<Totals> World::totals() {
  return alone<Result<Totals>>(impl_.get(), [&] { return impl_->totals(); });
}
Result<Ledger> World::ledger() {
  return alone<Result<Ledger>>(impl_.get(), [&] { return impl_->ledger(); });
}
Result<ParticleData> World::particles() {
  return alone<Result<ParticleData>>(impl_.get(), [&] { return impl_->particles(); });
}
Result<std::vector<PieceInfo>> World::pieces() {
  return alone<Result<std::vector<PieceInfo>>>(impl_.get(), [&] { return impl_->pieces(); });
}
Result<LatticeData> World::lattice() {
  return alone<Result<LatticeData>>(impl_.get(), [&] { return impl_->lattice(); });
}
Result<std::uint64_t> World::state_hash() {
  return alone<Result<std::uint64_t>>(impl_.get(), [&] { return impl_->state_hash(); });
}
Status World::save_state(int slot) {
  return alone<Status>(impl_.get(), [&] { return impl_->save_state(slot); });
}
Status World::load_state(int slot) {
  return alone<Status>(impl_.get(), [&] { return impl_->load_state(slot); });
}
Result<std::vector<std::uint8_t>> World::snapshot() {
  return alone<Result<std::vector<std::uint8_t>>>(impl_.get(), [&] { return impl_->snapshot(); });
}
Result<std::vector<std::uint8_t>> World::save() {
  return alone<Result<std::vector<std::uint8_t>>>(impl_.get(), [&] { return impl_->save(); });
}
Status World::load_saved(const void* data, std::size_t bytes) {
  return alone<Status>(impl_.get(),
                       [&] { return impl_->load_saved(static_cast<const std::uint8_t*>(data), bytes); });
}
Result<std::vector<BodyInfo>> World::bodies() const {
  return alone<Result<std::vector<BodyInfo>>>(impl_.get(),
                                              [&] { return Result<std::vector<BodyInfo>>(impl_->bodies()); });
}
Status World::restore(const void* data, std::size_t bytes) {
  return alone<Status>(impl_.get(),
                       [&] { return impl_->restore(static_cast<const std::uint8_t*>(data), bytes); });
}
Result<ProbeId> World::add_probe(const ProbeDesc& d) {
  return alone<Result<ProbeId>>(impl_.get(), [&] { return impl_->add_probe(d); });
}
Result<std::vector<ProbeSeries>> World::take_samples() {
  return alone<Result<std::vector<ProbeSeries>>>(impl_.get(), [&] { return impl_->take_samples(); });
}
Result<std::vector<double>> World::sample(const std::vector<Vec3d>& points, const std::string& field) {
  return sample(points, std::vector<std::string>{field == "velocity" ? "speed" : field});
}
Result<std::vector<double>> World::sample(const std::vector<Vec3d>& points,
                                          const std::vector<std::string>& fields) {
  return alone<Result<std::vector<double>>>(impl_.get(), [&] { return impl_->sample(points, fields); });
}
Result<SurfaceMesh> World::surface(const SurfaceDesc& d) {
  return alone<Result<SurfaceMesh>>(impl_.get(), [&] { return impl_->surface(d); });
}
Result<SurfaceView> World::surface_view(const SurfaceDesc& d) {
  return alone<Result<SurfaceView>>(impl_.get(), [&] { return impl_->surface_view(d, nullptr); });
}
Result<StageContext> World::device_state() {
  return alone<Result<StageContext>>(impl_.get(), [&] { return impl_->device_state(); });
}
Status World::wait_for(void* event) {
  return alone<Status>(impl_.get(), [&] { return impl_->engine->wait_for_event(event); });
}
Status World::signal(void* event) {
  return alone<Status>(impl_.get(), [&] { return impl_->engine->signal_event(event); });
}
Status World::check_view(const StageContext& view) const {
  return alone<Status>(impl_.get(), [&] { return impl_->check_view(view); });
}
Status World::check_view(const RenderView& view) const {
  return alone<Status>(impl_.get(), [&] { return impl_->check_view(view); });
}
Status World::check_view(const SurfaceView& view) const {
  return alone<Status>(impl_.get(), [&] { return impl_->check_view(view); });
}
Plan World::plan() {
  return reported<Plan>(impl_.get(), [&] { return impl_->plan(); });
}
Scheduler& World::scheduler() { return *impl_; }
Resolved World::resolved() {
  return reported<Resolved>(impl_.get(), [&] { return impl_->resolved(); });
}
Backend World::backend() const { return impl_->engine->backend(); }
Precision World::precision() const { return impl_->desc.precision; }
double World::time() const { return impl_->time; }
std::uint64_t World::steps() const { return impl_->steps; }
const WorldDesc& World::desc() const { return impl_->desc; }
MaterialDesc World::material(MaterialId id) const {
  try {
    return impl_->valid(id) ? impl_->materials[id.index] : MaterialDesc{};
  } catch (const std::bad_alloc&) {
    return {};
  }
}

BuildInfo build_info() {
  BuildInfo b;
  b.version = core::text(MELTSIM_VERSION_MAJOR, ".", MELTSIM_VERSION_MINOR, ".", MELTSIM_VERSION_PATCH);
  const core::CudaInfo c = core::cuda_info();
  b.cuda = c.built;
  b.cuda_runtime = c.runtime;
  b.cuda_driver = c.driver;
  b.devices = c.devices;
  b.cuda_reason = c.reason;
  b.architectures = c.architectures;
  b.cpu_threads = core::threads_for(0);
  return b;
}

}  // namespace v0
}  // namespace meltsim
