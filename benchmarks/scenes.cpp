// SPDX-License-Identifier: Apache-2.0
// Two scenes, at the sizes the targets are stated for.
//   water     a pool at one temperature: neighbour search, liquid, integration
//   melting   the same with a third of it ice, w = 2: everything, and something melts in most steps
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "bench.hpp"

namespace bench {

namespace {

constexpr double spacing = 0.05;

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
  desc.backend = backend;
  desc.spacing = spacing;
  desc.support_radius = s.support * spacing;
  desc.domain.bounded = true;
  const Vec3d size{s.nx * spacing, s.ny * spacing, s.nz * spacing};
  desc.domain.max = {size.x, 1.5 * size.y, size.z};
  desc.heat.model = s.heat;
  if (s.extras) desc.domain.heat[2].temperature = 30;
  desc.tension = desc.particle_shifting = s.extras;
  // Three heat stages, the least that super-time-stepping takes; the latent heat below goes with it.
  desc.heat.time_scale = s.solid && s.heat == HeatModel::enthalpy ? 7e5 : 1;
  World world = value_of(World::create(desc));
  MaterialDesc water;
  water.viscosity = 0.05;
  if (s.extras) water.viscosity_points = {{0, 0.06}, {100, 0.04}};
  const MaterialId water_id = value_of(world.add_material(water));
  // Beside the ice the water gets warmer along x, so that the ice melts a little in most steps and not in
  // layers.
  const int slabs = s.solid ? 4 : 1;
  for (int k = 0; k < slabs; ++k) {
    FluidDesc pool;
    pool.shape = Shape::box({std::round(double(s.nx) * k / slabs) * spacing, 0, 0},
                            {std::round(double(s.nx) * (k + 1) / slabs) * spacing, size.y, size.z});
    pool.material = water_id;
    pool.temperature = s.solid ? 20 + 20 * k : 20;
    value_of(world.add_fluid(pool));
  }
  if (!s.solid) return world;

  MaterialDesc ice;
  ice.name = "ice";
  ice.density = 917;
  ice.conductivity = 2.2;
  ice.heat_capacity = 2100;
  ice.melting_point = 0;
  ice.latent_heat = 6e4;
  ice.melts_into = water_id;
  ice.freezes = s.extras;
  ice.region_half_width = 2;
  SolidDesc block;
  block.material = value_of(world.add_material(ice));
  block.temperature = 0;
  // A third of the volume, in the middle; whole spacings.
  const double share = std::cbrt(1.0 / 3.0);
  const auto low = [share](int n) { return std::round(0.5 * (1 - share) * n) * spacing; };
  const auto high = [share](int n) {
    return (std::round(0.5 * (1 - share) * n) + std::round(share * n)) * spacing;
  };
  block.shape = Shape::box({low(s.nx), low(s.ny), low(s.nz)}, {high(s.nx), high(s.ny), high(s.nz)});
  value_of(world.add_solid(block));
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
  const auto add = [&all](const char* suffix, int nx, int ny, int nz, double support) {
    all.push_back({std::string("water") + suffix, nx, ny, nz, support, false});
    all.push_back({std::string("melting") + suffix, nx, ny, nz, support, true});
  };
  if (backend == Backend::cpu) add("", 32, 20, 32, 2.5);  // 20,480
  add("", 44, 25, 55, 2.5);                               // 60,500: the paper's
  if (backend == Backend::cuda) {
    add("", 100, 100, 100, 2.5);
    add("_2d", 100, 100, 100, 2.0);
    if (std::getenv("MELTSIM_BENCHMARK_LARGE") != nullptr) add("", 250, 160, 250, 2.5);  // 10 million
  }
  return all;
}

Running* running(const Scene& scene, Backend backend) {
  // Only one World at a time: a million particles and their history would otherwise pile up.
  static std::unique_ptr<Running> current;
  const std::string key = scene.name + "/" + name_of(backend) + "/" + std::to_string(scene.nx);
  if (current != nullptr && current->key == key) return current.get();
  current.reset();
  meltsim::World world = build(scene, backend);
  // Well below the largest stable step: a layer of ice that melts at once makes waves. Time per step does not
  // care.
  const double dt = 0.25 * world.resolved().stable_dt;
  const std::uint64_t particles = value_of(world.totals()).fluid + value_of(world.totals()).solid;
  // Load kernels, touch memory, and let the surface of the ice warm until some of it melts.
  const int warm_up = backend == Backend::cuda ? 40 : 16;
  for (int k = 0; k < warm_up; ++k) succeed(world.step(dt));
  const meltsim::StepResult r = world.synchronize();
  if (r.halted) {
    std::fprintf(stderr, "benchmark scene %s halted: %s\n", scene.name.c_str(), r.halt_reason.c_str());
    return nullptr;
  }
  current.reset(new Running{key, std::move(world), dt, particles});
  return current.get();
}

}  // namespace bench
