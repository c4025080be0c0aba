// SPDX-License-Identifier: Apache-2.0
// meltsim_module_cost [--scene dam_break|ice] [--particles N] [--backend cpu|cuda] [--threads N] [--precision single|double]
// [--warmup N] [--batches N] [--steps N]: what a sub-step costs in a scene of water alone, and in one of ice in warm water. Neither
// needs what modules for particular liquids, fields or faces bring: module_cost.py holds versions of the library without and with
// one of them beside each other. So this uses what the oldest of them has. Prints one line of JSON: the median of the batches.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "meltsim/meltsim.hpp"

namespace {

using namespace meltsim;

constexpr double spacing = 0.05;
constexpr int substeps_of_step = 10;

struct Options {
  std::string scene = "dam_break";
  double particles = 8000;
  Backend backend = Backend::cpu;
  int threads = 1;
  Precision precision = Precision::single_precision;
  int warmup = 6, batches = 5, steps = 4;
};

[[noreturn]] void fail(const std::string& text) {
  std::fprintf(stderr, "meltsim_module_cost: %s\n", text.c_str());
  std::exit(1);
}

template <class T>
T value_of(Result<T> result) {
  if (!result) fail(result.error().message);
  return *std::move(result);
}

void succeed(const Status& status) {
  if (!status) fail(status.error().message);
}

bool read(Options& options, const std::string& option, const std::string& value) {
  const auto number = [&](auto& to) {
    to = static_cast<std::decay_t<decltype(to)>>(std::atof(value.c_str()));
    return to > 0;
  };
  if (option == "--scene") options.scene = value;
  else if (option == "--backend") options.backend = value == "cuda" ? Backend::cuda : Backend::cpu;
  else if (option == "--precision")
    options.precision = value == "double" ? Precision::double_precision : Precision::single_precision;
  else if (option == "--particles") return number(options.particles);
  else if (option == "--threads") return number(options.threads);
  else if (option == "--warmup") return number(options.warmup);
  else if (option == "--batches") return number(options.batches);
  else if (option == "--steps") return number(options.steps);
  else return false;
  return options.scene == "dam_break" || options.scene == "ice";
}

/// A cube of water, n particles wide; in `ice` half as wide a cube of it is ice.
World build(const Options& options, double n) {
  const double width = n * spacing;
  const bool ice = options.scene == "ice";
  WorldDesc desc;
  desc.backend = options.backend;
  desc.threads = options.threads;
  desc.precision = options.precision;
  desc.spacing = spacing;
  desc.domain.bounded = true;
  desc.domain.max = {ice ? width : 2 * width, 1.5 * width, width};
  // What "automatic" comes to may differ from version to version.
  desc.sound_speed = 10 * std::sqrt(2 * 9.81 * width);
  if (ice) desc.heat.time_scale = 100;
  World world = value_of(World::create(desc));
  MaterialDesc water;
  FluidDesc fluid;
  fluid.shape = Shape::box({0, 0, 0}, {width, width, width});
  fluid.material = value_of(world.add_material(water));
  fluid.temperature = 30;
  value_of(world.add_fluid(fluid));
  if (!ice) return world;
  MaterialDesc frozen;
  frozen.name = "ice";
  frozen.density = 917;
  frozen.conductivity = 2.2;
  frozen.heat_capacity = 2100;
  frozen.melting_point = 0;
  frozen.latent_heat = 3.34e5;
  frozen.melts_into = fluid.material;
  SolidDesc block;
  const double low = std::floor(n / 4) * spacing, high = low + std::round(n / 2) * spacing;
  block.shape = Shape::box({low, low, low}, {high, high, high});
  block.material = value_of(world.add_material(frozen));
  block.temperature = -5;
  value_of(world.add_solid(block));
  return world;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return (values[(n - 1) / 2] + values[n / 2]) / 2;
}

int measure(const Options& options) {
  const double n = std::round(std::cbrt(options.particles));
  World world = build(options, n);
  const double support = 2.5 * spacing, sound = world.desc().sound_speed;
  const double dt = substeps_of_step * 0.99 * world.desc().courant * support / sound;
  const auto steps = [&](int count) {
    for (int k = 0; k < count; ++k) succeed(world.step(dt));
    const StepResult now = world.synchronize();
    if (now.halted) fail(now.halt_reason);
    return now;
  };
  const StepResult begun = steps(options.warmup);
  std::vector<double> wall, processor;
  StepResult now = begun;
  for (int batch = 0; batch < options.batches; ++batch) {
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t clock = std::clock();
    const std::uint64_t before = now.steps;
    now = steps(options.steps);
    const double count = static_cast<double>(now.steps - before);
    processor.push_back(1e3 * static_cast<double>(std::clock() - clock) / CLOCKS_PER_SEC / count);
    wall.push_back(1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() /
                   count);
  }
  const Totals totals = value_of(world.totals());
  std::printf(
      "{\"scene\": \"%s\", \"backend\": \"%s\", \"threads\": %d, \"precision\": \"%s\", \"particles\": %llu, "
      "\"solid\": %llu, \"substeps\": %llu, \"ms\": %.6g, \"processor_ms\": %.6g, \"bytes\": %llu, "
      "\"kinetic_J\": %.17g}\n",
      options.scene.c_str(), world.backend() == Backend::cuda ? "cuda" : "cpu", options.threads,
      world.precision() == Precision::double_precision ? "double" : "single",
      static_cast<unsigned long long>(now.fluid + now.solid), static_cast<unsigned long long>(now.solid),
      static_cast<unsigned long long>(now.steps - begun.steps), median(wall), median(processor),
      static_cast<unsigned long long>(world.plan().bytes), totals.kinetic);
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  Options options;
  for (int k = 1; k < count; k += 2)
    if (k + 1 >= count || !read(options, arguments[k], arguments[k + 1]))
      fail(
          "options: --scene dam_break|ice, --backend cpu|cuda, --precision single|double; numbers above 0: "
          "--particles, --threads, "
          "--warmup, --batches, --steps (of 10 sub-steps each)");
  return measure(options);
}
