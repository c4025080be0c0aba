// SPDX-License-Identifier: Apache-2.0
#include "host_world.hpp"

#include <cmath>
#include <csignal>
#include <set>

#include "csv.hpp"
#include "show/replay_page.hpp"

namespace meltsim_python {

namespace {

std::atomic<std::uint64_t> serials{0};

// SIGINT while the main thread steps: ends the step, then does what Python does.
std::atomic<meltsim::World*> stepping{nullptr};
std::atomic<bool> was_interrupted{false};
struct sigaction python_action;

void on_interrupt(int signal) {
  if (meltsim::World* world = stepping.load()) {
    was_interrupted = true;
    world->interrupt();
  }
  python_action.sa_handler(signal);
}

bool is_main_thread() {
  nb::module_ threading = nb::module_::import_("threading");
  return threading.attr("current_thread")().is(threading.attr("main_thread")());
}

/// Ctrl-C ends the step. Only where Python itself handles the signal, and only in the thread to which it belongs.
class InterruptScope {
 public:
  explicit InterruptScope(meltsim::World& world) {
    was_interrupted = false;
    if (!is_main_thread() || sigaction(SIGINT, nullptr, &python_action) != 0) return;
    if ((python_action.sa_flags & SA_SIGINFO) != 0 || python_action.sa_handler == SIG_DFL ||
        python_action.sa_handler == SIG_IGN)
      return;
    stepping = &world;
    struct sigaction action = python_action;
    action.sa_handler = on_interrupt;
    active_ = sigaction(SIGINT, &action, nullptr) == 0;
  }
  ~InterruptScope() {
    if (active_) sigaction(SIGINT, &python_action, nullptr);
    stepping = nullptr;
  }
  InterruptScope(const InterruptScope&) = delete;

 private:
  bool active_ = false;
};

std::set<HostWorld*> alive;  ///< under the GIL

}  // namespace

HostWorld::HostWorld(meltsim::World world, runner::Scene s)
    : scene(std::move(s)), world_(std::move(world)), serial_(++serials) {
  alive.insert(this);
}

HostWorld::~HostWorld() { alive.erase(this); }

void HostWorld::release_all() {
  std::vector<std::unique_ptr<Stage>> gone;  // what they hold may hold Worlds
  for (HostWorld* host : alive) {
    if (host->closed() || host->busy_.exchange(true)) continue;
    for (auto& stage : host->stages_) {
      static_cast<void>(host->world_->scheduler().remove(stage->name));
      gone.push_back(std::move(stage));
    }
    host->stages_.clear();
    host->busy_ = false;
  }
}

meltsim::World& HostWorld::unguarded() {
  if (closed()) refuse("World: it is closed; make or load another one");
  return *world_;
}

void HostWorld::close() {
  if (closed()) return;
  {
    const Use world(*this, true);
    if (const int views = packed + surfaced; views > 0)
      refuse(
          "World: " + std::to_string(views) +
          " array(s) of render_view() or surface_view() still view its memory; delete them first, or keep a "
          "copy (array.copy())");
    world_.reset();  // under the GIL: another thread may interrupt()
  }
  std::vector<std::unique_ptr<Stage>> gone;  // what they hold may come back here
  gone.swap(stages_);
  requests.clear();
  replay_ = runner::Replay();
}

HostWorld::Use::Use(HostWorld& world, bool changes) : host_(world) {
  world.unguarded();
  if (host_.busy_.exchange(true))
    refuse(
        "World: it is in use: another thread, or the step that runs this stage, has not returned yet; one "
        "World is used "
        "by one thread at a time (interrupt() excepted)");
  if (changes && host_.exported > 0) {
    host_.busy_ = false;
    refuse("World: " + std::to_string(host_.exported) +
           " array(s) of state() or of a stage still view its memory, which this call changes; delete them "
           "first, or keep "
           "a copy (array.copy())");
  }
  if (changes) ++host_.generation;
}

void HostWorld::advance(const std::function<meltsim::Status(meltsim::World&)>& steps) {
  const Use world(*this, true);
  fault_ = nullptr;
  bool late = false;
  meltsim::Status status;
  {
    const InterruptScope scope(*world);
    {
      const nb::gil_scoped_release released;
      status = steps(*world);
    }
    // An interrupt that came after the last sub-step of a step before.
    if (!status && status.error().code == meltsim::ErrorCode::interrupted && stale_interrupt_ &&
        !was_interrupted && !fault_) {
      const nb::gil_scoped_release released;
      status = steps(*world);
    }
    stale_interrupt_ = false;
    late = (was_interrupted || fault_) && status;
  }
  stale_interrupt_ = late;
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
  if (fault_) std::rethrow_exception(std::exchange(fault_, nullptr));
  expect(status);
}

void HostWorld::run_stage(const meltsim::StageContext& context, void* pointer) {
  auto& stage = *static_cast<Stage*>(pointer);
  HostWorld& world = *stage.world;
  if (world.fault_) return;
  const nb::gil_scoped_acquire held;
  try {
    auto* state = new State;
    state->context = context;
    state->owner = nb::find(&world);
    state->world = &world;
    state->stage = true;
    state->writes = stage.writes;
    struct Expiry {  // also where the function raises
      std::shared_ptr<bool> alive;
      ~Expiry() { *alive = false; }
    };
    {
      const Expiry expiry{state->alive};
      nb::object view = nb::cast(state, nb::rv_policy::take_ownership);
      stage.function(view);
    }
    if (world.exported > 0)
      refuse("stage \"" + stage.name +
             "\": it keeps an array of its argument, which holds until the stage returns; keep a copy");
  } catch (...) {
    world.fault_ = std::current_exception();
    world.world_->interrupt();
  }
}

void HostWorld::add_stage(const std::string& name, nb::object function, const std::string& after,
                          std::vector<std::string> reads, std::vector<std::string> writes, bool recorded) {
  if (!PyCallable_Check(function.ptr())) wrong_type("function: expected a function, got " + shown(function));
  const Use world(*this, true);
  auto stage = std::make_unique<Stage>(Stage{this, name, std::move(function), writes});
  meltsim::CustomStage custom;
  custom.name = name;
  custom.run = run_stage;
  custom.user = stage.get();
  custom.reads = std::move(reads);
  custom.writes = std::move(writes);
  custom.recorded = recorded;
  expect(world->scheduler().insert_after(after, custom));
  stages_.push_back(std::move(stage));
}

void HostWorld::remove_stage(const std::string& name) {
  const Use world(*this, true);
  expect(world->scheduler().remove(name));
  for (std::size_t i = 0; i < stages_.size(); ++i)
    if (stages_[i]->name == name)
      return void(stages_.erase(stages_.begin() + static_cast<std::ptrdiff_t>(i)));
}

nb::object HostWorld::state() {
  const Use world(*this);
  auto state = std::make_unique<State>();
  {
    const nb::gil_scoped_release released;
    // Arrays are used on streams that the World has no part in: nothing may still be running.
    world->synchronize();
    auto context = world->device_state();
    if (context) state->context = *context;
    else throw LibraryError(context.error());
  }
  state->owner = nb::find(this);
  state->world = this;
  state->generation = generation;
  return nb::cast(state.release(), nb::rv_policy::take_ownership);
}

void HostWorld::record() {
  const Use world(*this);
  const nb::gil_scoped_release released;
  meltsim::ReadRequest what;
  what.particles = what.totals = true;
  const meltsim::Reading now = expect(world->take(expect(world->request(what))));
  double cold = std::nan(""), hot = cold, mass = 0, heat = 0;
  std::uint64_t meltable = 0;
  const meltsim::ParticleFrame& p = now.particles;
  std::vector<bool> melts;
  for (const Material& m : materials) melts.push_back(static_cast<bool>(world->material(m.id).melts_into));
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    const double t = p.temperature[i];
    cold = std::isnan(cold) ? t : std::min(cold, t);
    hot = std::isnan(hot) ? t : std::max(hot, t);
    mass += 1;
    heat += t;
    const std::uint32_t material = meltsim::material_of(p.tag[i]);
    if (meltsim::is_solid(p.tag[i]) && material < melts.size() && melts[material]) ++meltable;
  }
  meltable_ = std::max(meltable_, meltable);
  if (frame_ == 0)
    stats_ = "time_s,melted_fraction,T_min,T_mean,T_max,kinetic_J,potential_J,n_fluid,n_solid\n";
  const double melted =
      meltable_ == 0 ? 0 : 1 - static_cast<double>(meltable) / static_cast<double>(meltable_);
  const char* gap = "";
  for (const double value :
       {now.time, melted, cold, heat / mass, hot, now.ledger.kinetic, now.ledger.potential,
        static_cast<double>(now.ledger.fluid), static_cast<double>(now.ledger.solid)}) {
    stats_ += gap + runner::csv_number(value);
    gap = ",";
  }
  stats_ += "\n";
  if (replay_.wants(frame_)) replay_.add(frame_, now.time, p);
  ++frame_;
}

void HostWorld::clear_frames() {
  const Use world(*this);
  replay_ = runner::Replay();
  stats_ = std::string();
  frame_ = meltable_ = 0;
}

std::string HostWorld::page(const std::string& title) const {
  runner::Box contents;
  for (const runner::ReplayFrame& frame : replay_.frames())
    for (const runner::ReplayParticle& p : frame.particles)
      contents.add({p.position[0], p.position[1], p.position[2]});
  runner::ReplayPage page;
  page.title = !title.empty() ? title : !scene.title.empty() ? scene.title : "meltsim";
  page.note = "Particles " + runner::csv_number(scene.world.spacing) + " m apart. " + std::to_string(frame_) +
              " frames were recorded,";
  page.spacing = scene.world.spacing;
  page.box = runner::view_box(scene, {});
  page.camera = runner::scene_camera(scene, runner::view_box(scene, contents));
  for (const Body& body : bodies) {  // in the order of their rows, of which some may be free
    page.bodies.resize(std::max<std::size_t>(page.bodies.size(), body.id.index + 1u));
    page.bodies[body.id.index] = body.name;
  }
  page.looks = scene.output.looks;
  page.stats = stats_;
  page.share = replay_.share();
  return runner::replay_page(page, replay_.frames());
}

}  // namespace meltsim_python
