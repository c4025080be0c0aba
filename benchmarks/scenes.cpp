// SPDX-License-Identifier: Apache-2.0
// Scenes, at the sizes the targets are stated for.
//   water     a pool at one temperature: neighbour search, liquid, integration
//   liquids   the same, viscous, with a yield stress, surface tension, isotropic pressure and two contents: those stages alone
//   melting   the same with a third of it ice, w = 2: everything, and something melts in most steps
// Structures that find neighbours are compared in water: a pool at rest, one that sloshes, and two droplets
// that stand 1000 H apart where nothing bounds them.
// And what the paper's Table 2 and Fig. 7 time: melting again, at its spacing and step, with as many
// particles of each kind. The arrangement is ours (the ice in the middle of the pool); the paper's is known
// from pictures only.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "bench.hpp"
#include "meltsim/physics/fluid.hpp"
#include "meltsim/physics/integrate.hpp"
#include "meltsim/physics/sph_kernels.hpp"
#include "meltsim/physics/viscous_diffusion.hpp"

namespace bench {

namespace {

constexpr double spacing_of(const Scene& s) { return s.paper ? 0.2 : 0.05; }
constexpr double paper_step = 0.005;

/// A third of the volume, or what the scene says, in the middle; whole spacings.
meltsim::Shape ice_of(const Scene& s) {
  const double share = std::cbrt(1.0 / 3.0), dx = spacing_of(s);
  const auto low = [&](int n, int ice) {
    return (ice > 0 ? (n - ice) / 2 : std::round(0.5 * (1 - share) * n)) * dx;
  };
  const auto high = [&](int n, int ice) {
    return low(n, ice) + (ice > 0 ? double(ice) : std::round(share * n)) * dx;
  };
  return meltsim::Shape::box({low(s.block.x, s.ice.x), low(s.block.y, s.ice.y), low(s.block.z, s.ice.z)},
                             {high(s.block.x, s.ice.x), high(s.block.y, s.ice.y), high(s.block.z, s.ice.z)});
}

/// Time scale at which the sub-steps taken need two stages of heat, the least that super-time-stepping takes
/// (the record 7d7eecb took three, those before it one): tau lambda = 4 of the 2 to 6 that they carry, with
/// the conductor that decides, the ice.
double two_stages(const Scene& s) {
  using namespace meltsim::physics;
  constexpr double g = 9.81, conductivity = 2.2, capacity = 917.0 * 2100.0, courant = 0.4, margin = 1.5;
  const double dx = spacing_of(s), support = s.support * dx;
  const double stable =
      acoustic_dt(courant, support, sound_speed_for(0.0, g, s.block.y * dx, usual_density_error));
  const double dt = s.paper ? paper_step / std::ceil(paper_step / stable) : 0.25 * stable;
  return 4.0 / (dt * 2 * margin * conductivity / capacity * lattice_laplacian_sum(support, dx));
}

/// Viscosity at rest [Pa s] at which the steps taken need six stages, the most of one super-step.
double six_stages(const Scene& s) {
  using namespace meltsim::physics;
  const double dx = spacing_of(s), support = s.support * dx;
  const double stable =
      acoustic_dt(0.4, support, sound_speed_for(0.0, 9.81, s.block.y * dx, usual_density_error));
  return 0.9 * stage_reach(6) /
         (0.25 * stable * viscous_lambda(1.0, 1000.0, lattice_laplacian_sum(support, dx)));
}

/// Exits loudly: a benchmark that measures half a scene would be worse than none.
template <class T>
T value_of(meltsim::Result<T> result) {
  if (result) return *std::move(result);
  std::fprintf(stderr, "benchmark scene: %s\n", result.error().message.c_str());
  std::exit(1);
}

void succeed(const meltsim::Status& status) {
  if (status) return;
  std::fprintf(stderr, "benchmark scene: %s\n", status.error().message.c_str());
  std::exit(1);
}

meltsim::World build(const Scene& s, Backend backend) {
  using namespace meltsim;
  WorldDesc desc;
  const double spacing = spacing_of(s);
  desc.backend = backend;
  desc.threads = s.threads;
  if (s.in_double) desc.precision = Precision::double_precision;
  desc.spacing = spacing;
  desc.support_radius = s.support * spacing;
  desc.domain.bounded = true;
  const Vec3d size{s.block.x * spacing, s.block.y * spacing, s.block.z * spacing};
  desc.domain.max = {size.x, 1.5 * size.y, size.z};
  desc.heat.model = s.heat;
  desc.neighbour_search = s.search;
  const bool droplets = s.layout == "droplets";
  if (droplets) {
    desc.domain = {};
    desc.gravity = {};
    desc.sound_speed = 30;  // the pool's, about
  }
  if (s.extras) desc.domain.heat[2].temperature = 30;
  desc.tension = desc.particle_shifting = s.extras;
  if (s.liquids) desc.viscosity = Viscosity::implicit;
  if (s.liquids) desc.isotropic_pressure = true;
  if (s.solid && s.heat == HeatModel::enthalpy) desc.heat.time_scale = two_stages(s);
  World world = value_of(World::create(desc));
  MaterialDesc water;
  water.viscosity = 0.05;
  if (s.extras) water.viscosity_points = {{0, 0.06}, {100, 0.04}};
  if (s.liquids) {
    water.viscosity = 0.1 * six_stages(s);
    water.regularisation = 10;
    water.yield_stress = 0.9 * six_stages(s) / water.regularisation;
    water.surface_tension = 0.07;
  }
  const MaterialId water_id = value_of(world.add_material(water));
  std::vector<MassFraction> contents;
  if (s.liquids)
    for (const char* name : {"ink", "salt"}) {
      MaterialDesc species;
      species.name = name;
      species.dissolves_in = water_id;
      species.diffusivity_in = 1e-9;
      contents.push_back({value_of(world.add_material(species)), 0.0});
    }
  // Beside the ice the water gets warmer along x, so that the ice melts a little in most steps and not in
  // layers.
  const int slabs = !s.solid && !s.liquids ? 1 : s.large() ? 2 : 4;
  const auto fill = [&] {
    for (int k = 0; k < slabs; ++k) {
      FluidDesc pool;
      pool.shape = Shape::box({std::round(double(s.block.x) * k / slabs) * spacing, 0, 0},
                              {std::round(double(s.block.x) * (k + 1) / slabs) * spacing, size.y, size.z});
      pool.material = water_id;
      pool.temperature = 20 + 80.0 / slabs * k;
      for (MassFraction& content : contents) content.value = 0.1 / slabs * k;
      pool.fractions = contents;
      if (s.layout == "slosh") pool.velocity = {0.5 * std::sqrt(2 * 9.81 * size.y), 0, 0};
      value_of(world.add_fluid(pool));
    }
  };
  if (droplets) {
    const double apart = 1000 * s.support * spacing;
    for (const double x : {0.0, apart}) {
      FluidDesc half;
      half.shape = Shape::box({x, 0, 0}, {x + std::round(0.5 * s.block.x) * spacing, size.y, size.z});
      half.material = water_id;
      value_of(world.add_fluid(half));
    }
    return world;
  }
  if (!s.solid) {
    fill();
    return world;
  }

  MaterialDesc ice;
  ice.name = "ice";
  ice.density = 917;
  ice.conductivity = 2.2;
  ice.heat_capacity = 2100;
  ice.melting_point = 0;
  ice.latent_heat = 0.086 * two_stages(s);  // something melts in most steps, and the ice lasts
  ice.melts_into = water_id;
  ice.freezes = s.extras;
  ice.region_half_width = s.half_width;
  SolidDesc block;
  block.material = value_of(world.add_material(ice));
  block.temperature = 0;
  block.shape = ice_of(s);
  // Every addition looks at all that is there: with ten million particles the fewest first, and in few parts.
  if (!s.large()) fill();
  value_of(world.add_solid(block));
  if (s.large()) fill();
  return world;
}

}  // namespace

const char* name_of(Backend backend) { return backend == Backend::cuda ? "cuda" : "cpu"; }

const std::vector<Backend>& backends() {
  static const std::vector<Backend> all = meltsim::build_info().devices.empty()
                                              ? std::vector<Backend>{Backend::cpu}
                                              : std::vector<Backend>{Backend::cpu, Backend::cuda};
  return all;
}

std::vector<Scene> scenes(Backend backend) {
  std::vector<Scene> all;
  const auto add = [&all](Sites block, double support, bool in_double = false) {
    for (const bool solid : {false, true}) {
      Scene s;
      s.name = solid ? "melting" : "water";
      s.block = block;
      s.support = support;
      s.solid = solid;
      s.in_double = in_double;
      all.push_back(s);
    }
  };
  if (backend == Backend::cpu) add({32, 20, 32}, 2.5);  // 20,480
  for (const double support : {2.5, 2.0}) {
    add({44, 25, 55}, support);  // 60,500: the paper's
    if (backend == Backend::cpu) continue;
    add({100, 100, 100}, support);
    if (std::getenv("MELTSIM_BENCHMARK_LARGE") != nullptr) add({250, 160, 250}, support);  // 10 million
  }
  if (backend == Backend::cuda) add({100, 100, 100}, 2.5, true);
  return all;
}

std::vector<Scene> search_scenes(Backend backend) {
  using meltsim::NeighbourSearch;
  std::vector<Scene> all;
  for (const char* layout : {"pool", "slosh", "droplets"})
    for (const NeighbourSearch search : {NeighbourSearch::grid, NeighbourSearch::tree}) {
      Scene s;
      s.name = "water";
      s.layout = layout;
      s.search = search;
      s.block = {44, 25, 55};
      // Where nothing bounds the domain no grid is kept.
      all.push_back(s);
      if (backend == Backend::cpu) continue;
      s.block = {100, 100, 100};
      all.push_back(s);
    }
  return all;
}

std::vector<Scene> width_scenes(Backend backend) {
  std::vector<Scene> all;
  for (const int half_width : {1, 3, 5, 8}) {
    Scene s;
    s.name = "melting";
    s.solid = true;
    s.half_width = half_width;
    s.block = {44, 25, 55};
    all.push_back(s);
    if (backend == Backend::cpu) continue;
    s.block = {100, 100, 100};
    all.push_back(s);
  }
  return all;
}

std::vector<Scene> probe_scenes(Backend backend) {
  std::vector<Scene> all;
  for (const char* probes : {"gauges", "points", "forces"}) {
    Scene s;
    s.name = "water";
    s.probes = probes;
    s.block = {44, 25, 55};
    all.push_back(s);
    if (backend == Backend::cpu) continue;
    s.block = {100, 100, 100};
    all.push_back(s);
  }
  return all;
}

std::vector<Scene> own_stage_scenes(Backend backend) {
  std::vector<Scene> all;
  if (backend == Backend::cpu) return all;  // which calls it, and that is all
  for (const Scene& scene : scenes(backend))
    for (const char* own : {"own", "own_recorded"}) {
      if (!scene.plain() || scene.block.all() != 60500) continue;
      if (scene.name != "water" && scene.name != "melting") continue;
      all.push_back(scene);
      all.back().own = own;
    }
  return all;
}

std::vector<Scene> paper_scenes(Backend backend) {
  std::vector<Scene> all;
  const auto add = [&all](const char* name, Sites block, Sites ice) {
    Scene s;
    s.name = name;
    s.block = block;
    s.solid = s.paper = true;
    s.ice = ice;
    all.push_back(s);
  };
  add("table2_35k_5k", {40, 25, 40}, {25, 8, 25});
  add("table2_48.5k_12k", {44, 25, 55}, {24, 20, 25});
  add("table2_40.5k_20k", {44, 25, 55}, {25, 20, 40});
  if (backend == Backend::cpu) return all;
  for (const Sites block : {Sites{25, 20, 20}, Sites{40, 20, 25}, Sites{40, 25, 40}, Sites{50, 24, 50},
                            Sites{50, 32, 50}, Sites{50, 40, 50}, Sites{80, 50, 50}})
    add("fig7", block, {});
  return all;
}

namespace {
void add_probes(meltsim::World& world, const Scene& s) {
  meltsim::ProbeDesc d;
  const meltsim::Vec3d size = world.desc().domain.max;
  const bool gauges = s.probes == "gauges";
  if (s.probes == "forces") {  // on every wall, at 1 kHz
    d.kind = meltsim::ProbeKind::force;
    d.fields = {"force", "moment"};
    d.every = 1e-3;
    for (int wall = 0; wall < 6; ++wall) {
      d.wall = wall;
      value_of(world.add_probe(d));
    }
    return;
  }
  const int n = gauges ? 8 : 1000;
  for (int k = 0; k < n; ++k) {
    const double x = (k % 10 + 0.5) / 10, y = (k / 10 % 10 + 0.5) / 10, z = (k / 100 + 0.5) / 10;
    d.points.push_back({x * size.x, y * size.y, z * size.z});
  }
  if (gauges) {
    d.kind = meltsim::ProbeKind::level;
    d.every = 1e-3;
  } else {
    d.fields = {"pressure", "velocity"};
  }
  value_of(world.add_probe(d));
}
}  // namespace

Running* running(const Scene& scene, Backend backend) {
  // Only one World at a time: a million particles and their history would otherwise pile up.
  static std::unique_ptr<Running> current;
  const std::string key = scene.title(backend) + "/" + std::to_string(scene.threads);
  if (current != nullptr && current->key == key) return current.get();
  current.reset();
  meltsim::World world = build(scene, backend);
  // Well below the largest stable step: a layer of ice that melts at once makes waves. Time per step does not
  // care.
  const double dt = scene.paper ? paper_step : 0.25 * world.resolved().stable_dt;
  const meltsim::Totals totals = value_of(world.totals());
  const std::uint64_t particles = totals.fluid + totals.solid;
  if (!scene.probes.empty()) add_probes(world, scene);
  if (!scene.own.empty()) {
    meltsim::CustomStage stage;
    stage.name = "own";
    stage.run = [](const meltsim::StageContext&, void*) {};
    stage.reads = {"position", "velocity", "tag"};
    stage.writes = {"acceleration"};
    stage.recorded = scene.own == "own_recorded";
    succeed(world.scheduler().insert_after("sph.forces", stage));
  }
  // Load kernels, touch memory, and let the surface of the ice warm until some of it melts.
  const int warm_up = scene.threads != 0 || scene.large() ? 8 : backend == Backend::cuda ? 40 : 16;
  for (int k = 0; k < warm_up; ++k) succeed(world.step(dt));
  const meltsim::StepResult r = world.synchronize();
  if (r.halted) {
    std::fprintf(stderr, "benchmark scene %s halted: %s\n", key.c_str(), r.halt_reason.c_str());
    return nullptr;
  }
  current.reset(new Running{key, std::move(world), dt, particles});
  return current.get();
}

}  // namespace bench
