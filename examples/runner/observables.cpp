// SPDX-License-Identifier: Apache-2.0
#include "observables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "check_heat.hpp"
#include "expect.hpp"
#include "meltsim/particle_tag.hpp"
#include "recorder.hpp"
#include "scene_keys.hpp"
#include "suggest.hpp"

namespace runner {

namespace {

using meltsim::trade::Reduce;

// Share of the liquid that is beyond its front, and above its height: single particles are no front.
constexpr double beyond = 0.01;
// Liquid that begins with less of the length of its room runs along it.
constexpr double has_a_front = 0.95;
// Of one kind, by default: each is another line to read.
constexpr std::size_t most_by_default = 4;
constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

double component(const meltsim::Vec3d& v, std::size_t axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

std::vector<double> coordinates(const meltsim::ParticleFrame& particles, std::size_t axis) {
  std::vector<double> list;
  for (std::size_t i = 0; i < particles.id.size(); ++i) {
    if (meltsim::is_solid(particles.tag[i])) continue;
    const meltsim::Vec3f& p = particles.position[i];
    list.push_back(component({p.x, p.y, p.z}, axis) + component(particles.origin, axis));
  }
  return list;
}

meltsim::ParticleFrame particles_of(meltsim::World& world) {
  meltsim::ReadRequest request;
  request.particles = true;
  return expect(world.take(expect(world.request(request)))).particles;
}

/// Highest less lowest temperature that anything has, or is held at.
double scene_temperatures(const Scene& scene) {
  double least = meltsim::infinity, most = -meltsim::infinity;
  const auto add = [&](double t) {
    least = std::min(least, t);
    most = std::max(most, t);
  };
  const auto add_surface = [&](const meltsim::SurfaceHeatDesc& surface) {
    const Span all = temperatures_of(surface);
    add(all.least);
    add(all.most);
  };
  for (const SceneFluid& fluid : scene.fluids) add(fluid.desc.temperature);
  for (const SceneBody& body : scene.bodies) {
    add(body.desc.temperature);
    if (body.desc.surface.temperature) add_surface(body.desc.surface);
  }
  for (const SceneEmitter& emitter : scene.emitters) add(emitter.desc.temperature);
  for (const SceneHeatRegion& region : scene.heat_regions)
    if (region.desc.temperature) add(*region.desc.temperature);
  for (const meltsim::SurfaceHeatDesc& wall : scene.world.domain.heat) {
    if (wall.temperature || wall.convection > 0 || wall.emissivity > 0) add_surface(wall);
  }
  return most > least ? most - least : 0;
}

bool moves(const SceneBody& body) { return !body.desc.fixed; }
bool is_led(const SceneBody& body) { return body.desc.motion == meltsim::Motion::kinematic; }

const meltsim::MaterialDesc* material(const Scene& scene, const std::string& name) {
  for (const SceneMaterial& m : scene.materials)
    if (m.desc.name == name) return &m.desc;
  return nullptr;
}

std::vector<std::string> body_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneBody& body : scene.bodies) names.push_back(body.desc.name);
  return names;
}

std::vector<std::string> probe_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneProbe& probe : scene.probes) names.push_back(probe.desc.name);
  return names;
}

/// Finds the body, or the only one, of "draught@cork"; `word`: what it is asked for.
std::optional<std::size_t> find_body(const Scene& scene, const std::string& word, const std::string& name,
                                     std::string& problem) {
  const std::vector<std::string> names = body_names(scene);
  if (names.empty()) problem = "the scene has no bodies";
  else if (name.empty() && names.size() > 1)
    problem = fmt::format("of which body? e.g. {}@{}", word, names.front());
  if (!problem.empty()) return std::nullopt;
  if (name.empty()) return 0;
  const auto at = std::find(names.begin(), names.end(), name);
  if (at != names.end()) return static_cast<std::size_t>(at - names.begin());
  problem = fmt::format("no body is named \"{}\"{}", name, suggestion(name, names, "bodies"));
  return std::nullopt;
}

/// Finds the probe of "pressure@low"; `word`: what it is asked for.
std::optional<std::size_t> find_probe(const Scene& scene, const std::string& word, const std::string& name,
                                      std::string& problem) {
  const std::vector<std::string> names = probe_names(scene);
  if (names.empty()) problem = "the scene has no probes";
  else if (name.empty()) problem = fmt::format("at which probe? e.g. {}@{}", word, names.front());
  if (!problem.empty()) return std::nullopt;
  const auto at = std::find(names.begin(), names.end(), name);
  if (at != names.end()) return static_cast<std::size_t>(at - names.begin());
  problem = fmt::format("no probe is named \"{}\"{}", name, suggestion(name, names, "probes"));
  return std::nullopt;
}

/// The column of a field of a probe.
std::optional<std::size_t> find_field(const SceneProbe& probe, const std::string& field,
                                      std::string& problem) {
  if (field == "level") {
    if (probe.desc.kind == meltsim::ProbeKind::level) return 0;
    problem = fmt::format("probe \"{}\" is not of kind level", probe.desc.name);
    return std::nullopt;
  }
  const auto at = std::find(probe.desc.fields.begin(), probe.desc.fields.end(), field);
  if (probe.desc.kind == meltsim::ProbeKind::point && at != probe.desc.fields.end())
    return static_cast<std::size_t>(at - probe.desc.fields.begin());
  problem =
      fmt::format("probe \"{0}\" does not sample the {1}; add {1} to its fields", probe.desc.name, field);
  return std::nullopt;
}

}  // namespace

void describe_bodies(const Scene& scene, Built& built, SceneStart& start) {
  start.latent = 0;
  start.body_height.assign(scene.bodies.size(), 0);
  start.body_size.assign(scene.bodies.size(), 0);
  for (const meltsim::PieceInfo& piece : expect(built.world.pieces())) {
    const meltsim::Vec3d size = piece.bounds.max - piece.bounds.min;
    start.body_height.at(piece.body.index) = component(size, start.up);
    start.body_size.at(piece.body.index) = std::max({size.x, size.y, size.z});
    const auto* m = material(scene, scene.bodies.at(piece.body.index).material);
    if (built.body_melts.at(piece.body.index) && m != nullptr) start.latent += piece.mass * m->latent_heat;
  }
  const meltsim::DomainDesc& domain = scene.world.domain;
  const auto& faces = domain.faces;
  const bool closed = domain.bounded && std::count(faces.begin(), faces.end(), meltsim::Face::open) == 0;
  if (!closed || !scene.emitters.empty() || scene.world.heat.model != meltsim::HeatModel::enthalpy)
    start.latent = 0;
}

namespace {

/// Axes against gravity and of fronts.
void choose_axes(const Scene& scene, SceneStart& start) {
  const meltsim::Vec3d g = scene.world.gravity;
  start.gravity = length(g) > 0;
  const double pull[] = {g.x, g.y, g.z};
  for (std::size_t a = 0; a < 3; ++a)
    if (start.gravity && std::fabs(pull[a]) > std::fabs(pull[start.up])) start.up = a;
  start.up_sign = pull[start.up] > 0 ? -1 : 1;
  start.along = start.up == 0 ? 1 : 0;
  const meltsim::DomainDesc& domain = scene.world.domain;
  for (std::size_t a = 0; a < 3 && domain.bounded; ++a) {
    const meltsim::Vec3d size = domain.max - domain.min;
    if (a != start.up && component(size, a) > component(size, start.along) * (1 + 1e-9)) start.along = a;
  }
}

/// Where an emitter brings its liquid in: at its nozzle, or at a face of the domain up to a level.
double source_of(const Scene& scene, const meltsim::EmitterDesc& emitter, const SceneStart& start,
                 std::size_t axis) {
  if (!emitter.level) return component(emitter.center, axis);
  if (axis == start.up) return start.up_sign * *emitter.level;
  const double inwards = component(emitter.axis, axis);
  const double low = component(scene.world.domain.min, axis), high = component(scene.world.domain.max, axis);
  return inwards > 0 ? low : inwards < 0 ? high : (low + high) / 2;
}

std::vector<double> sources(const Scene& scene, const SceneStart& start, std::size_t axis) {
  std::vector<double> list;
  for (const SceneEmitter& emitter : scene.emitters)
    list.push_back(source_of(scene, emitter.desc, start, axis));
  return list;
}

/// `up` and `along`: places of liquid; `half`: how far it reaches beyond them.
void measure_liquid(const meltsim::DomainDesc& domain, const std::vector<double>& up,
                    const std::vector<double>& along, double half, SceneStart& start) {
  const auto [low, high] = std::minmax_element(up.begin(), up.end());
  const bool upright = start.up_sign > 0;
  const double wall = component(upright ? domain.min : domain.max, start.up);
  start.floor =
      domain.bounded ? start.up_sign * wall : start.up_sign * (upright ? *low - half : *high + half);
  start.top = start.up_sign * (upright ? *high + half : *low - half);
  const auto [first, last] = std::minmax_element(along.begin(), along.end());
  const double center = std::accumulate(along.begin(), along.end(), 0.0) / static_cast<double>(along.size());
  const double from = domain.bounded ? component(domain.min, start.along) : *first - half;
  const double to = domain.bounded ? component(domain.max, start.along) : *last + half;
  start.length = to - from;
  start.liquid_along = half > 0 ? (*last - *first + 2 * half) / start.length : 0;
  start.along_sign = domain.bounded && center > (from + to) / 2 ? -1 : 1;
  start.along_from = start.along_sign > 0 ? from : -to;
}

double largest_liquid_density(const Scene& scene) {
  double most = 0;
  const auto add = [&](const std::string& name) {
    if (const auto* m = material(scene, name)) most = std::max(most, m->density);
  };
  for (const SceneFluid& fluid : scene.fluids) add(fluid.material);
  for (const SceneEmitter& emitter : scene.emitters) add(emitter.material);
  return most;
}

}  // namespace

SceneStart start_of(const Scene& scene, Built& built) {
  SceneStart start;
  choose_axes(scene, start);
  const meltsim::ParticleFrame particles = particles_of(built.world);
  std::vector<double> up = coordinates(particles, start.up), along = coordinates(particles, start.along);
  const double half = up.empty() ? 0 : scene.world.spacing / 2;
  if (up.empty()) {  // liquid is where it comes from
    up = sources(scene, start, start.up);
    along = sources(scene, start, start.along);
  }
  start.liquid = !up.empty();
  if (start.liquid) measure_liquid(scene.world.domain, up, along, half, start);
  describe_bodies(scene, built, start);
  start.temperatures = scene_temperatures(scene);
  start.liquid_density = largest_liquid_density(scene);
  start.body_melts = built.body_melts;
  return start;
}

std::optional<SceneObservable> observable_named(const Scene& scene, const SceneStart& start,
                                                const std::string& name, std::string& problem) {
  problem.clear();
  const std::size_t at = name.find('@');
  const std::string word = name.substr(0, at), of = at == std::string::npos ? "" : name.substr(at + 1);
  SceneObservable o;
  o.desc.name = name;
  const bool melts = std::count(start.body_melts.begin(), start.body_melts.end(), true) > 0;
  if (word == "melted" || word == "melt_time_50" || word == "melt_time_90") {
    if (!melts) problem = "nothing in this scene can melt";
    o.desc.scale = 1;
    o.desc.order = 1;
    if (word != "melted") {
      o.kind = ObservableKind::melt_time;
      o.desc.unit = "s";
      o.desc.scale = 0;
      o.desc.reduce = Reduce::time_to_reach;
      o.desc.level = word == "melt_time_50" ? 0.5 : 0.9;
    }
  } else if (word == "front" || word == "height") {
    o.kind = word == "front" ? ObservableKind::front : ObservableKind::height;
    o.desc.unit = "m";
    o.desc.scale = word == "front" ? start.length : start.top - start.floor;
    if (!start.liquid) problem = "the scene has no liquid";
  } else if (word == "energy") {
    o.kind = ObservableKind::energy;
    o.desc.unit = "J";
  } else if (word == "volume") {
    o.kind = ObservableKind::volume;
    o.desc.scale = 1;
    if (!start.liquid) problem = "the scene has no liquid";
  } else if (word == "draught" || word == "path") {
    const auto body = find_body(scene, word, of, problem);
    if (!body) return std::nullopt;
    o.kind = word == "draught" ? ObservableKind::draught : ObservableKind::path;
    o.index = *body;
    o.desc.unit = "m";
    o.desc.components = word == "path" ? 3 : 1;
    if (word == "draught") o.desc.reduce = Reduce::late_mean;  // it bobs
    o.desc.scale = word == "path" ? start.body_size[*body] : start.body_height[*body];
    if (!moves(scene.bodies[*body]))
      problem = fmt::format("body \"{}\" is fixed", scene.bodies[*body].desc.name);
    else if (is_led(scene.bodies[*body]))
      problem = fmt::format("body \"{}\" is moved as the scene says, with all settings alike",
                            scene.bodies[*body].desc.name);
    else if (word == "draught" && !start.liquid) problem = "the scene has no liquid";
  } else if (word == "pressure" || word == "temperature" || word == "level") {
    const auto probe = find_probe(scene, word, of, problem);
    if (!probe) return std::nullopt;
    const auto column = find_field(scene.probes[*probe], word, problem);
    if (!column) return std::nullopt;
    o.kind = word == "pressure"      ? ObservableKind::pressure
             : word == "temperature" ? ObservableKind::temperature
                                     : ObservableKind::level;
    o.index = *probe;
    o.column = *column;
    o.desc.unit = word == "pressure" ? "Pa" : word == "temperature" ? "K" : "m";
    const double depth = start.top - start.floor;
    o.desc.scale = word == "pressure"      ? start.liquid_density * length(scene.world.gravity) * depth
                   : word == "temperature" ? start.temperatures
                                           : depth;
  } else {
    problem = fmt::format("expected {}{}", either_of(keys::observables), [&] {
      const std::string near = nearest(word, keys::observables);
      return near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near);
    }());
  }
  if (!problem.empty()) return std::nullopt;
  for (const auto& [exact, values] : scene.trade.exact)
    if (exact == name) o.exact = values;
  if (o.kind == ObservableKind::volume && o.exact.empty()) o.exact = {{0, 0}};
  return o;
}

std::vector<std::string> default_observables(const Scene& scene, const SceneStart& start) {
  std::vector<std::string> names;
  const bool melts = std::count(start.body_melts.begin(), start.body_melts.end(), true) > 0;
  if (melts) names.insert(names.end(), {"melted", "melt_time_50"});
  std::size_t afloat = 0;
  for (std::size_t i = 0; i < scene.bodies.size() && !melts && start.gravity && !scene.fluids.empty(); ++i) {
    const SceneBody& body = scene.bodies[i];
    const auto* m = material(scene, body.material);
    const double density = body.density ? *body.density : m != nullptr ? m->density : 0;
    if (!moves(body) || is_led(body) || density >= start.liquid_density || ++afloat > most_by_default)
      continue;
    names.push_back("draught@" + body.desc.name);
  }
  if (scene.bodies.empty() && start.gravity && start.liquid && start.liquid_along < has_a_front)
    names.insert(names.end(), {"front", "height"});
  const bool heat = scene.world.heat.model != meltsim::HeatModel::none && start.temperatures > 0;
  std::size_t probed = 0;
  for (const SceneProbe& probe : scene.probes) {
    if (melts || probed >= most_by_default) break;
    std::string problem;
    for (const char* field : {"temperature", "pressure", "level"}) {
      if (field == std::string("temperature") ? !heat : !start.gravity) continue;
      if (field == std::string("pressure") && !names.empty()) continue;  // a splash's is mostly noise
      if (!find_field(probe, field, problem)) continue;
      names.push_back(fmt::format("{}@{}", field, probe.desc.name));
      ++probed;
    }
  }
  if (names.empty() && start.gravity && start.liquid) names.push_back("energy");
  return names;
}

ObservableReader::ObservableReader(std::vector<SceneObservable> observables, SceneStart start,
                                   std::uint64_t meltable, ProbeGroups probes, double spacing)
    : observables_(std::move(observables)),
      start_(std::move(start)),
      meltable_(meltable),
      probes_(std::move(probes)),
      spacing_(spacing) {}

bool ObservableReader::wants_particles() const {
  return std::any_of(observables_.begin(), observables_.end(), [](const SceneObservable& o) {
    return o.kind == ObservableKind::front || o.kind == ObservableKind::height;
  });
}

bool ObservableReader::wants_probes() const {
  return std::any_of(observables_.begin(), observables_.end(), [](const SceneObservable& o) {
    return o.kind == ObservableKind::pressure || o.kind == ObservableKind::temperature ||
           o.kind == ObservableKind::level;
  });
}

double ObservableReader::reach(const meltsim::ParticleFrame& particles, std::size_t axis, double sign) const {
  std::vector<double> list = coordinates(particles, axis);
  if (list.empty()) return nothing;
  for (double& x : list) x *= sign;
  const auto last = static_cast<std::ptrdiff_t>(
      std::min(static_cast<double>(list.size() - 1), (1 - beyond) * static_cast<double>(list.size())));
  std::nth_element(list.begin(), list.begin() + last, list.end());
  // Liquid reaches half a spacing beyond the centres of its outermost particles.
  return list[static_cast<std::size_t>(last)] + spacing_ / 2;
}

void ObservableReader::body_values(const SceneObservable& observable,
                                   const std::vector<meltsim::PieceInfo>& pieces,
                                   std::vector<double>& values) const {
  double mass = 0, submerged = 0;
  meltsim::Vec3d center{0, 0, 0};
  for (const meltsim::PieceInfo& piece : pieces) {
    if (piece.body.index != observable.index) continue;
    mass += piece.mass;
    submerged += piece.mass * piece.submerged_fraction;
    center = center + piece.center * piece.mass;
  }
  if (observable.kind == ObservableKind::draught) {
    values.push_back(mass > 0 ? submerged / mass * start_.body_height[observable.index] : nothing);
    return;
  }
  for (const double x : {center.x, center.y, center.z}) values.push_back(mass > 0 ? x / mass : nothing);
}

double ObservableReader::probe_value(const SceneObservable& observable,
                                     const std::vector<meltsim::ProbeSeries>& probes) const {
  for (std::size_t g = 0; g < std::min(probes_.size(), probes.size()); ++g) {
    const auto at = std::find(probes_[g].begin(), probes_[g].end(), observable.index);
    if (at == probes_[g].end()) continue;
    const meltsim::ProbeSeries& series = probes[g];
    const std::size_t point = static_cast<std::size_t>(at - probes_[g].begin());
    double sum = 0, n = 0;
    for (std::size_t i = 0; i < series.time.size(); ++i) {
      const double value = series.values[(i * series.points + point) * series.width + observable.column];
      if (!std::isfinite(value)) continue;
      sum += value;
      ++n;
    }
    return n > 0 ? sum / n : nothing;
  }
  return nothing;
}

std::vector<double> ObservableReader::values(const meltsim::Totals& totals,
                                             const std::vector<meltsim::PieceInfo>& pieces,
                                             const meltsim::ParticleFrame& particles,
                                             const std::vector<meltsim::ProbeSeries>& probes) {
  std::vector<double> values;
  if (!first_latent_) first_latent_ = totals.latent;
  const double counted = meltable_ > 0
                             ? std::min(1.0, static_cast<double>(net_melted(totals.melted, totals.frozen)) /
                                                 static_cast<double>(meltable_))
                             : 0;
  all_melted_ = meltable_ > 0 && counted >= 1;
  const double melted =
      start_.latent > 0 ? std::clamp((totals.latent - *first_latent_) / start_.latent, 0.0, 1.0) : counted;
  const double energy = totals.kinetic + totals.potential;
  if (!first_energy_) first_energy_ = energy;
  for (const SceneObservable& o : observables_) {
    switch (o.kind) {
      case ObservableKind::melted:
      case ObservableKind::melt_time:
        values.push_back(melted);
        break;
      case ObservableKind::front:
        values.push_back(reach(particles, start_.along, start_.along_sign) - start_.along_from);
        break;
      case ObservableKind::height:
        values.push_back(reach(particles, start_.up, start_.up_sign) - start_.floor);
        break;
      case ObservableKind::draught:
      case ObservableKind::path:
        body_values(o, pieces, values);
        break;
      case ObservableKind::pressure:
      case ObservableKind::temperature:
      case ObservableKind::level:
        values.push_back(probe_value(o, probes));
        break;
      case ObservableKind::energy:
        values.push_back(energy - *first_energy_);
        break;
      case ObservableKind::volume:
        values.push_back(totals.density_error_mean);
        break;
    }
  }
  return values;
}

}  // namespace runner
