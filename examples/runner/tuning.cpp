// SPDX-License-Identifier: Apache-2.0
#include "tuning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "build_world.hpp"
#include "expect.hpp"
#include "failure.hpp"
#include "files.hpp"
#include "hash.hpp"
#include "meltsim/physics/isotropic_pressure.hpp"
#include "numbers.hpp"
#include "resolution.hpp"
#include "scene_json.hpp"

namespace runner {

namespace trade = meltsim::trade;
using trade::Knob;
using trade::Knobs;

namespace {

// A body, and the liquid, of fewer particles behaves as no body of the scene does.
constexpr double least_body = 27, least_liquid = 64;
constexpr double largest_courant = 0.6;
// Where a body can move, a film of liquid under it bursts beyond these (docs/trade.md).
constexpr double largest_courant_of_bodies = 0.5, least_sound_of_bodies = 0.5;
constexpr int fewest_samples = 10, most_samples = 60;
// Of gravity: what no observable resolves, and what chaos makes visible.
constexpr double stir = 1e-4;

bool has_level(const Scene& scene) {
  const auto& outlets = scene.world.domain.outlets;
  return std::any_of(outlets.begin(), outlets.end(),
                     [](const meltsim::OutletDesc& o) { return o.level.has_value(); }) ||
         std::any_of(scene.emitters.begin(), scene.emitters.end(),
                     [](const SceneEmitter& e) { return e.desc.level.has_value(); });
}

std::size_t at(Knob knob) { return static_cast<std::size_t>(knob); }

double count_of(const meltsim::StepResult& now) { return static_cast<double>(now.fluid); }

/// Largest thermal diffusivity, sped up as heat is.
double diffusivity(const Scene& scene) {
  double most = 0;
  for (const SceneMaterial& m : scene.materials) {
    double k = m.desc.conductivity, c = m.desc.heat_capacity;
    for (const auto& p : m.desc.conductivity_points) k = std::max(k, p.value);
    for (const auto& p : m.desc.heat_capacity_points) c = std::min(c, p.value);
    most = std::max(most, m.desc.diffusivity ? *m.desc.diffusivity : k / (m.desc.density * c));
  }
  return scene.world.heat.model == meltsim::HeatModel::none ? 0 : most * scene.world.heat.time_scale;
}

/// The exact answer at the samples, linear between its points.
std::vector<double> exact_at(const std::vector<ExactPoint>& points, const std::vector<double>& times) {
  std::vector<double> values;
  for (const double t : times) {
    std::size_t i = 0;
    while (i < points.size() && points[i].time < t) ++i;
    if (i == 0) values.push_back(points.front().value);
    else if (i == points.size()) values.push_back(points.back().value);
    else {
      const ExactPoint &a = points[i - 1], &b = points[i];
      values.push_back(a.value + (b.value - a.value) * (t - a.time) / (b.time - a.time));
    }
  }
  return values;
}

}  // namespace

/// Of the World that is being probed.
struct Tuning::Current {
  std::optional<ObservableReader> reader;
};

Tuning::Tuning(const Scene& scene, const MachineOptions& machine, std::vector<std::string> names,
               const std::string& of)
    : scene_(scene), machine_(machine), current_(std::make_shared<Current>()) {
  Built built = build_world(scene_, machine_);
  const meltsim::Resolved resolved = built.world.resolved();
  spacing_ = scene_.world.spacing;
  sound_speed_ = resolved.sound_speed;
  courant_ = scene_.world.courant;
  support_ = resolved.support_radius / spacing_;
  device_ = std::string(backend_name(resolved.backend)) + ", " + resolved.device_name;
  resolved_ = scene_json(scene_, resolved).dump();
  start_ = start_of(scene_, built);
  choose_observables(std::move(names), of);
  choose_ranges(built);
  measure_bodies();
  make_problem();
}

/// Bodies of many particles fit any spacing. Of liquid where there are no bodies.
void Tuning::measure_bodies() {
  constexpr std::size_t many = 4096;
  constexpr double points = 4e5;
  constexpr int lattices = 13;
  const auto add = [&](const SceneShape& shape, bool liquid) {
    if (shape.mesh) return;
    const std::size_t coarse = shape.shape.lattice_points(scene_.world.domain.min, spacing_).size();
    if (coarse == 0 || coarse > many) return;
    bodies_.push_back({&shape.shape, volume_of(shape.shape, points, lattices), liquid});
  };
  for (const SceneBody& body : scene_.bodies) add(body.shape, false);
  // Beside bodies, which are of fewer particles, a share of liquid more or less matters little.
  if (bodies_.empty())
    for (const SceneFluid& fluid : scene_.fluids) add(fluid.shape, true);
}

/// The spacing near a multiple of the scene's at which bodies and liquid have their volume: what a shape
/// of whole particles is larger or smaller by follows no law.
double Tuning::spacing_for(double multiple) const {
  const auto known = spacings_.find(multiple);
  if (known != spacings_.end()) return known->second;
  constexpr double most_change = 0.12, change_worth = 0.3;
  const double wanted = spacing_ * multiple;
  const auto score = [&](double s) {
    double sum = change_worth * std::fabs(s / wanted - 1);
    for (const Body& body : bodies_)
      sum +=
          std::fabs(volume_of_particles(scene_.world.domain, *body.shape, body.liquid, s) / body.volume - 1);
    return sum;
  };
  std::vector<double> candidates;
  const auto add = [&](double extent) {
    if (!(extent > 0)) return;
    for (double cells = std::max(1.0, std::round(extent / wanted) - 3); cells <= extent / wanted + 3; ++cells)
      if (std::fabs(extent / cells / wanted - 1) <= most_change) candidates.push_back(extent / cells);
  };
  for (const Body& body : bodies_) {
    const meltsim::Box bounds = body.shape->bounds();
    const meltsim::Vec3d size = bounds.max - bounds.min;
    for (const double extent : {size.x, size.y, size.z}) add(extent);
  }
  Scene fitted = scene_;
  apply_resolution(fitted, 1 / multiple, Quality::balanced);
  candidates.push_back(fitted.world.spacing);
  double best = wanted, least = score(best);
  for (const double s : candidates)
    if (const double here = score(s); here < least - 1e-9) {
      least = here;
      best = s;
    }
  return spacings_[multiple] = best;
}

void Tuning::choose_observables(std::vector<std::string> names, const std::string& of) {
  const bool given = !names.empty();
  if (!given) names = scene_.trade.observe;
  const bool written = !given && !names.empty();
  if (names.empty()) names = default_observables(scene_, start_);
  if (names.empty())
    throw Failure(
        ExitCode::scene,
        fmt::format("{}: nothing in this scene melts, flows or floats, and no probe samples it; add a "
                    "probe, or trade: {{observe: [...]}}",
                    scene_.where));
  for (const std::string& name : names) {
    std::string problem;
    const auto observable = observable_named(scene_, start_, name, problem);
    if (!observable && given) throw Failure(ExitCode::usage, fmt::format("{}: {}: {}", of, name, problem));
    if (!observable)
      throw Failure(ExitCode::scene,
                    fmt::format("{}: trade.observe: {}: {}",
                                written ? scene_.trade.observe_where : scene_.where, name, problem));
    const bool known = std::any_of(observables_.begin(), observables_.end(),
                                   [&](const SceneObservable& o) { return o.desc.name == name; });
    if (!known) observables_.push_back(*observable);
  }
}

void Tuning::observe_too(const std::string& name) {
  choose_observables({name}, name);
  make_problem();
}

void Tuning::choose_ranges(Built& built) {
  trade::Ranges& ranges = problem_.ranges;
  const meltsim::StepResult now = built.world.synchronize();
  double coarsest = 4;
  if (count_of(now) > 0) coarsest = std::min(coarsest, std::cbrt(count_of(now) / least_liquid));
  for (const meltsim::PieceInfo& piece : expect(built.world.pieces()))
    coarsest = std::min(coarsest, std::cbrt(static_cast<double>(piece.particles) / least_body));
  for (const SceneEmitter& emitter : scene_.emitters)
    coarsest = std::min(coarsest, least_radius(emitter.desc) / spacing_);
  const meltsim::DomainDesc& domain = scene_.world.domain;
  if (domain.bounded) {
    const meltsim::Vec3d size = domain.max - domain.min;
    const double sizes[] = {size.x, size.y, size.z};
    for (std::size_t a = 0; a < 3; ++a) {
      const meltsim::Face faces[] = {domain.faces[2 * a], domain.faces[2 * a + 1]};
      const double supports = faces[0] == meltsim::Face::periodic                                  ? 3
                              : faces[0] == meltsim::Face::open && faces[1] == meltsim::Face::open ? 0
                                                                                                   : 2;
      // A spacing that is moved to fit may be larger than asked for.
      if (supports > 0) coarsest = std::min(coarsest, sizes[a] / (1.12 * supports * support_ * spacing_));
    }
  }
  ranges[at(Knob::spacing)] = {0.25, std::max(coarsest, 1.0)};
  const double stable = built.world.stable_dt(), frame = 1 / scene_.time.fps;
  heat_only_ = !std::isfinite(stable);
  const double dt = std::min(scene_.time.dt.value_or(frame), frame);
  if (heat_only_) {
    ranges[at(Knob::sound_speed)] = ranges[at(Knob::courant)] = {1, 1};
    step_ = dt;
    ranges[at(Knob::step)] = {1.0 / 8, std::max(1.0, std::min(8.0, frame / dt))};
  } else {
    const bool moving = std::any_of(scene_.bodies.begin(), scene_.bodies.end(),
                                    [](const SceneBody& body) { return !body.desc.fixed; });
    const double most = moving ? largest_courant_of_bodies : largest_courant;
    ranges[at(Knob::courant)] = {std::min(1.0, 0.2 / courant_), std::max(1.0, most / courant_)};
    if (moving) ranges[at(Knob::sound_speed)].least = least_sound_of_bodies;
    // Shorter than what sound asks for: whoever wrote it wants it.
    if (scene_.time.dt && dt < stable) {
      step_ = dt;
      ranges[at(Knob::step)] = {1.0 / 4, std::max(1.0, std::min(4.0, frame / dt))};
    }
  }
}

void Tuning::make_problem() {
  trade::Problem& p = problem_;
  p.end = scene_.time.end;
  if (!(p.end > 0))
    throw Failure(ExitCode::scene,
                  fmt::format("{}: time.end: a run of 0 s has nothing to observe", scene_.where));
  p.samples = static_cast<int>(
      std::clamp(std::round(p.end * scene_.time.fps), double(fewest_samples), double(most_samples)));
  p.longest_step = step_ > 0 ? step_ : meltsim::infinity;
  p.longest_sample_step = 1 / scene_.time.fps;
  p.diffusivity = diffusivity(scene_);
  p.observables.clear();
  for (SceneObservable& o : observables_) {
    const bool probed = o.kind == ObservableKind::pressure || o.kind == ObservableKind::temperature ||
                        o.kind == ObservableKind::level;
    if (!o.exact.empty())
      o.desc.exact = trade::reduce(o.desc, sample_times(),
                                   exact_at(o.exact, probed ? probe_times(o.index) : sample_times()));
    // A probe has no sample before the first step.
    if (probed && o.desc.reduce == trade::Reduce::curve && !o.desc.exact.empty())
      o.desc.exact.front() = std::nan("");
    p.observables.push_back(o.desc);
  }
  p.build = [this](const Knobs& knobs) -> meltsim::Result<meltsim::World> {
    try {
      const Scene scene = with(knobs);
      Built built = build_world(scene, machine_);
      built.probes = add_probes(built.world, built.body_ids, scene);
      current_->reader = reader(built);
      return std::move(built.world);
    } catch (const Failure& failure) {
      return meltsim::Error{meltsim::ErrorCode::invalid_argument, failure.what()};
    }
  };
  p.observe = [this](meltsim::World& world, std::vector<double>& values) -> meltsim::Status {
    meltsim::ReadRequest what;
    what.totals = what.pieces = true;
    what.particles = current_->reader->wants_particles();
    what.probes = current_->reader->wants_probes();
    const auto ticket = world.request(what);
    if (!ticket) return ticket.error();
    const auto reading = world.take(*ticket);
    if (!reading) return reading.error();
    values = current_->reader->values(reading->totals, reading->pieces, reading->particles, reading->probes);
    return {};
  };
  if (scene_.time.until_melted)
    p.finished = [this](const std::vector<double>&) { return current_->reader->all_melted(); };
}

std::vector<double> Tuning::sample_times() const {
  std::vector<double> times;
  for (int i = 0; i <= problem_.samples; ++i) times.push_back(problem_.end * i / problem_.samples);
  return times;
}

std::vector<double> Tuning::probe_times(std::size_t probe) const {
  const double interval = problem_.end / problem_.samples, every = scene_.probes[probe].desc.every;
  // Due at multiples of `every` from `interval` ago until now, now excluded; 0: at every step.
  const double due = every > 0 ? std::max(1.0, std::round(interval / every)) : 1;
  const double ago = every > 0 ? interval - 0.5 * (due - 1) * every : 0.5 * interval;
  std::vector<double> times = sample_times();
  for (double& t : times) t = std::max(0.0, t - ago);
  return times;
}

ObservableReader Tuning::reader(Built& built) const {
  SceneStart start = start_;
  describe_bodies(scene_, built, start);
  return {observables_, std::move(start), built.meltable, built.probes, built.world.desc().spacing};
}

Scene Tuning::with(const Knobs& knobs) const {
  Scene scene = scene_;
  const double x = knobs[Knob::spacing];
  if (x != 1) apply_chosen_spacing(scene, spacing_for(x));
  meltsim::WorldDesc& world = scene.world;
  scene.sound_factor = 1;
  if (!heat_only_ && world.follow_sound_speed) {
    world.density_error = error_at(world.density_error, knobs[Knob::sound_speed]);
  } else if (!heat_only_) {
    world.sound_speed = sound_speed_ * knobs[Knob::sound_speed];
    world.density_error = 0;
  }
  // What artificial viscosity amounts to grows with sound: faster sound would be further from the limit, not nearer.
  // Not below what isotropic pressure needs.
  if (const double faster = knobs[Knob::sound_speed]; !heat_only_ && faster > 1)
    world.artificial_viscosity =
        std::max(world.artificial_viscosity / faster,
                 std::min(world.artificial_viscosity, meltsim::physics::least_artificial_viscosity));
  world.courant = std::min(largest_courant, courant_ * knobs[Knob::courant]);
  if (knobs[Knob::support] != 1) world.support_radius = support_ * knobs[Knob::support] * world.spacing;
  scene.time.adaptive = true;
  scene.time.dt = step_ > 0 ? std::optional<double>(step_ * knobs[Knob::step]) : std::nullopt;
  // A level beyond a face needs gravity along an axis: there it is stronger instead of turned.
  const meltsim::Vec3d g = world.gravity;
  meltsim::Vec3d aside = std::fabs(g.x) < std::fabs(g.y) ? meltsim::Vec3d{1, 0, 0} : meltsim::Vec3d{0, 1, 0};
  if (has_level(scene)) aside = g * (1 / std::max(length(g), 1e-300));
  world.gravity = g + aside * (stir * knobs.stir * length(g));
  return scene;
}

Knobs Tuning::actual(meltsim::World& world, const Knobs& asked) const {
  const meltsim::Resolved resolved = world.resolved();
  Knobs knobs = asked;
  knobs[Knob::spacing] = world.desc().spacing / spacing_;
  if (sound_speed_ > 0 && resolved.sound_speed > 0)
    knobs[Knob::sound_speed] = resolved.sound_speed / sound_speed_;
  knobs[Knob::courant] = world.desc().courant / courant_;
  return knobs;
}

trade::Measurement Tuning::measure(const Knobs& knobs, double wall_limit) {
  meltsim::Result<meltsim::World> world = problem_.build(knobs);
  trade::Measurement failed;
  failed.knobs = knobs;
  failed.complete = false;
  if (!world) {
    failed.problem = world.error().message;
    return failed;
  }
  const Knobs multiples = actual(*world, knobs);
  trade::Problem problem = problem_;
  // It is built already, and trade::measure() would build it once more to refer to.
  std::optional<meltsim::World> ready = std::move(*world);
  problem.build = [&](const Knobs&) -> meltsim::Result<meltsim::World> {
    if (!ready) return problem_.build(knobs);
    meltsim::World taken = std::move(*ready);
    ready.reset();
    return taken;
  };
  meltsim::Result<trade::Measurement> result = trade::measure(problem, knobs, wall_limit);
  if (!result) {
    failed.problem = result.error().message;
    return failed;
  }
  result->actual = multiples;
  return *result;
}

std::string Tuning::settings_text(const Knobs& knobs) const {
  const Scene scene = with(knobs);
  std::string text =
      fmt::format("spacing {:.3g} m (x {:.2f})", scene.world.spacing, scene.world.spacing / spacing_);
  if (!heat_only_)
    text +=
        fmt::format(", sound speed {:.3g} m/s (x {:.2f}), Courant number {:.2g}",
                    sound_speed_ * knobs[Knob::sound_speed], knobs[Knob::sound_speed], scene.world.courant);
  if (step_ > 0)
    text += fmt::format(", steps of {:.3g} s at most (x {:.2f})", *scene.time.dt, knobs[Knob::step]);
  return text;
}

Json Tuning::settings_json(const Knobs& knobs) const {
  const Scene scene = with(knobs);
  Json json;
  for (std::size_t k = 0; k < trade::knob_count; ++k)
    json["multiples"][trade::knob_name(static_cast<Knob>(k))] = knobs.value[k];
  json["spacing"] = scene.world.spacing;
  if (!heat_only_ && scene.world.follow_sound_speed) json["density_error"] = scene.world.density_error;
  else if (!heat_only_) json["sound_speed"] = scene.world.sound_speed;
  json["artificial_viscosity"] = scene.world.artificial_viscosity;
  json["courant"] = scene.world.courant;
  if (step_ > 0) json["dt"] = *scene.time.dt;
  return json;
}

std::string not_reached(const trade::Study& study, std::size_t observable, double end) {
  const trade::Observable& o = study.observables[observable].observable;
  if (o.reduce != trade::Reduce::time_to_reach || study.probes.empty()) return "";
  // The first probe has the scene's settings, or is the nearest to them that there is time for; the scale is its time.
  const std::vector<double>& times = study.probes.front().values.at(observable);
  if (!times.empty() && std::isfinite(times.front())) return "";
  return fmt::format(
      "{}: not reached by t={:g} s, so it has no error; simulate for longer, or name another observable",
      o.name, end);
}

std::string error_text(const trade::Known& known, double error) {
  const std::string share = two_digits(100 * error / known.scale) + " %";
  if (known.observable.unit.empty()) return share;
  return fmt::format("{} ({:.2g} {})", share, error, known.observable.unit);
}

// ---- The cache -------------------------------------------------------------------------------------------

namespace {

constexpr int cache_format = 6;

/// What mesh files held as the scene was read: it names them, and they may be others by the next time.
std::string meshes_text(const Scene& scene) {
  std::string text;
  const auto add = [&text](const SceneShape& shape) {
    if (shape.mesh != 0) text += fmt::format("mesh {:016x}\n", shape.mesh);
  };
  for (const SceneFluid& fluid : scene.fluids) add(fluid.shape);
  for (const SceneBody& body : scene.bodies) add(body.shape);
  for (const SceneHeatRegion& region : scene.heat_regions) add(region.shape);
  return text;
}

/// JSON has neither NaN nor infinity: both become null, and NaN again.
std::vector<double> numbers_from(const Json& list) {
  std::vector<double> values;
  for (const Json& value : list) values.push_back(value.is_null() ? std::nan("") : value.get<double>());
  return values;
}

Json knobs_json(const Knobs& knobs) { return {{"value", knobs.value}, {"stir", knobs.stir}}; }

Knobs knobs_from(const Json& json) {
  Knobs knobs;
  knobs.value = json.at("value").get<std::array<double, trade::knob_count>>();
  knobs.stir = json.at("stir").get<int>();
  return knobs;
}

}  // namespace

Json study_json(const trade::Study& study) {
  Json json;
  json["format"] = cache_format;
  for (const trade::Known& known : study.observables) {
    Json k;
    k["name"] = known.observable.name;
    k["unit"] = known.observable.unit;
    k["scale"] = known.scale;
    k["spread"] = known.spread;
    k["limit"] = known.limit;
    k["rms_share"] = known.rms_share;
    k["support"] = {{"difference", known.support_difference}, {"cost", known.support_cost}};
    for (const trade::Law& law : known.laws)
      k["laws"].push_back({{"knob", trade::knob_name(law.knob)},
                           {"number", static_cast<int>(law.knob)},
                           {"cost_exponent", law.cost_exponent},
                           {"error", law.error},
                           {"error_exponent", law.error_exponent},
                           {"fitted", law.fitted},
                           {"scatters", law.scatters}});
    json["observables"].push_back(k);
  }
  for (const trade::Measurement& m : study.probes)
    json["probes"].push_back({{"knobs", knobs_json(m.knobs)},
                              {"actual", knobs_json(m.actual)},
                              {"values", m.values},
                              {"work", m.work},
                              {"wall_s", m.wall_s},
                              {"substeps", m.substeps},
                              {"particles", m.particles},
                              {"bytes", m.bytes},
                              {"complete", m.complete},
                              {"problem", m.problem}});
  for (const trade::Range& range : study.ranges) json["ranges"].push_back({range.least, range.most});
  json["reference_work"] = study.reference_work;
  json["seconds_per_work"] = study.seconds_per_work;
  json["wall_s"] = study.wall_s;
  json["cut_short"] = study.cut_short;
  json["notes"] = study.notes;
  return json;
}

trade::Study study_from_json(const Json& json, const trade::Problem& problem) {
  trade::Study study;
  if (json.at("format").get<int>() != cache_format) throw Failure(ExitCode::io, "another format");
  const Json& list = json.at("observables");
  if (list.size() != problem.observables.size()) throw Failure(ExitCode::io, "other observables");
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Json& k = list[i];
    trade::Known known;
    known.observable = problem.observables[i];
    if (k.at("name").get<std::string>() != known.observable.name)
      throw Failure(ExitCode::io, "other observables");
    known.scale = k.at("scale").get<double>();
    known.spread = k.at("spread").get<double>();
    known.limit = numbers_from(k.at("limit"));
    known.rms_share = k.at("rms_share").get<double>();
    known.support_difference = k.at("support").at("difference").get<double>();
    known.support_cost = k.at("support").at("cost").get<double>();
    for (const Json& l : k.at("laws")) {
      const int number = l.at("number").get<int>();
      if (number < 0 || number >= static_cast<int>(trade::knob_count))
        throw Failure(ExitCode::io, "an unknown knob");
      known.laws.push_back({static_cast<Knob>(number), l.at("cost_exponent").get<double>(),
                            l.at("error").get<double>(), l.at("error_exponent").get<double>(),
                            l.at("fitted").get<bool>(), l.at("scatters").get<bool>()});
    }
    study.observables.push_back(std::move(known));
  }
  for (const Json& m : json.at("probes")) {
    trade::Measurement probe;
    probe.knobs = knobs_from(m.at("knobs"));
    probe.actual = knobs_from(m.at("actual"));
    for (const Json& values : m.at("values")) probe.values.push_back(numbers_from(values));
    probe.work = m.at("work").get<double>();
    probe.wall_s = m.at("wall_s").get<double>();
    probe.substeps = m.at("substeps").get<std::uint64_t>();
    probe.particles = m.at("particles").get<std::uint64_t>();
    probe.bytes = m.at("bytes").get<std::uint64_t>();
    probe.complete = m.at("complete").get<bool>();
    probe.problem = m.at("problem").get<std::string>();
    study.probes.push_back(std::move(probe));
  }
  for (std::size_t k = 0; k < trade::knob_count; ++k)
    study.ranges[k] = {json.at("ranges").at(k).at(0).get<double>(),
                       json.at("ranges").at(k).at(1).get<double>()};
  study.reference_work = json.at("reference_work").get<double>();
  study.seconds_per_work = json.at("seconds_per_work").get<double>();
  study.wall_s = json.at("wall_s").get<double>();
  study.cut_short = json.at("cut_short").get<bool>();
  study.notes = json.at("notes").get<std::vector<std::string>>();
  return study;
}

/// Empty where there is no place for it.
std::string Tuning::cache_file(const TuneOptions& options) const {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  std::string directory;
  if (cache != nullptr && *cache == '/') directory = cache;  // a relative one counts as none
  else if (home != nullptr && *home == '/') directory = std::string(home) + "/.cache";
  if (directory.empty()) return "";
  std::string key =
      fmt::format("{}\n{}\n{}\n{} {} {} {}\n", meltsim::build_info().version, resolved_, device_,
                  static_cast<int>(machine_.precision), machine_.threads, options.seconds, options.support);
  for (const SceneObservable& o : observables_) key += o.desc.name + "\n";
  key += meshes_text(scene_);
  return fmt::format("{}/meltsim/trade-{:016x}.json", directory, fnv1a(key.data(), key.size()));
}

const trade::Study& Tuning::study(const TuneOptions& options) {
  const std::string file = options.cache ? cache_file(options) : "";
  if (!file.empty() && exists(file)) {
    try {
      study_ = study_from_json(Json::parse(read_file(file)), problem_);
      from_cache_ = true;
      return study_;
    } catch (const std::exception&) {  // written by another version, or half: it is made anew
    }
  }
  trade::Options wanted;
  wanted.seconds = options.seconds;
  wanted.support = options.support;
  int done = 0;
  if (options.progress)
    wanted.progress = [&](const trade::Measurement&, int planned) {
      options.progress(++done, planned);
      return true;
    };
  meltsim::Result<trade::Study> result = trade::study(problem_, wanted);
  if (!result) {
    const meltsim::Error& error = result.error();
    if (error.code == meltsim::ErrorCode::halted) throw Failure(ExitCode::diverged, error.message);
    if (error.message.compare(0, 8, "seconds:") == 0)
      throw Failure(ExitCode::usage, "--time-limit" + error.message.substr(7));
    if (error.code == meltsim::ErrorCode::invalid_argument)
      throw Failure(ExitCode::scene, "a coarser probe of this scene cannot be built: " + error.message);
    throw library_failure(error, {}, "", scene_.where);
  }
  study_ = std::move(*result);
  // Where an observable is shown, not_reached() says it, and by when.
  const auto said_elsewhere = [](const std::string& note) {
    return note.find(": never reaches its level in any probe") != std::string::npos;
  };
  study_.notes.erase(std::remove_if(study_.notes.begin(), study_.notes.end(), said_elsewhere),
                     study_.notes.end());
  from_cache_ = false;
  if (file.empty() || study_.cut_short) return study_;  // what a busy machine cut short is no rule
  try {
    std::filesystem::create_directories(std::filesystem::path(file).parent_path());
    write_file(file, study_json(study_).dump() + "\n");
  } catch (const std::exception&) {  // a cache that cannot be written saves nothing and breaks nothing
  }
  return study_;
}

}  // namespace runner
