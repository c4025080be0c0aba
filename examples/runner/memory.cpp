// SPDX-License-Identifier: Apache-2.0
#include "memory.hpp"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <regex>

#include "check_units.hpp"
#include "numbers.hpp"

namespace runner {

namespace {

// Positions alone take this much while a shape is sampled; a World takes more. Only hopeless scenes are
// refused here: the library knows the real need.
constexpr double bytes_per_point = 12;

double box_volume(const meltsim::Box& box) {
  const meltsim::Vec3d size = box.max - box.min;
  return size.x > 0 && size.y > 0 && size.z > 0 ? size.x * size.y * size.z : 0;
}

/// A number in a file, infinite where there is none: "max", or no such file.
double number_in(const char* path) {
  std::ifstream file(path);
  double value = 0;
  return file >> value ? value : meltsim::infinity;
}

/// What this process may have: the machine's memory, less where the system limits the process or its container.
double usable_memory() {
  double memory = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    memory = std::min(memory, static_cast<double>(limit.rlim_cur));
  for (const char* path : {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"})
    memory = std::min(memory, number_in(path));
  return memory;
}

double extent(const meltsim::Box& box) {
  const meltsim::Vec3d size = box.max - box.min;
  return std::max({size.x, size.y, size.z});
}

}  // namespace

std::string scale_hint(double needed_bytes, double free_bytes) {
  const double fits = std::floor(100 * std::cbrt(free_bytes / needed_bytes)) / 100;
  return fits > 0 && fits < 1 ? fmt::format("; --scale {:g} fits", fits) : "";
}

void keep_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the largest it takes
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
}

void check_particle_budget(const Scene& scene) {
  const double cell = std::pow(scene.world.spacing, 3);
  const SceneShape* largest = nullptr;
  const Source* source = nullptr;
  double volume = 0;
  const auto see = [&](const auto& item) {
    const double of_this = box_volume(item.shape.shape.bounds());
    if (!(of_this > volume)) return;
    volume = of_this;
    largest = &item.shape;
    source = &item.source;
  };
  for (const SceneFluid& fluid : scene.fluids) see(fluid);
  for (const SceneBody& body : scene.bodies) see(body);
  const double needed = volume / cell * bytes_per_point, memory = usable_memory();
  if (needed <= memory || largest == nullptr) return;
  const meltsim::Box box = largest->shape.bounds();
  const meltsim::Vec3d size = box.max - box.min;
  throw Failure(
      ExitCode::device,
      fmt::format(
          "memory: more than {} needed for {:.2g} particles of {}, {:.3g} x {:.3g} x {:.3g} m, and {} "
          "can be had here; raise particles.spacing, now {:g} m{}{}",
          bytes_text(needed), volume / cell, source->path, size.x, size.y, size.z, bytes_text(memory),
          scene.world.spacing, scale_hint(needed, memory),
          millimetre_hint(*largest, extent(box), extent(box), scene.world.spacing)));
}

Failure memory_failure(const std::string& library_message, const std::string& device) {
  // "memory: 4.2 GB needed, 3.1 GB free; use fewer particles ..."
  static const std::regex form("([0-9.]+) GB needed, ([0-9.]+) GB free");
  std::smatch match;
  if (!std::regex_search(library_message, match, form)) return {ExitCode::device, library_message};
  const double needed = parse_number(match[1]).value_or(0), free = parse_number(match[2]).value_or(0);
  return {ExitCode::device, fmt::format("memory: {} GB needed, {} GB free on {}{}", match[1].str(),
                                        match[2].str(), device, scale_hint(needed, free))};
}

}  // namespace runner
