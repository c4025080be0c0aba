// SPDX-License-Identifier: Apache-2.0
#include "memory.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <regex>

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

double machine_memory() {
  return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
}

}  // namespace

std::string scale_hint(double needed_bytes, double free_bytes) {
  const double fits = std::floor(100 * std::cbrt(free_bytes / needed_bytes)) / 100;
  return fits > 0 && fits < 1 ? fmt::format("; --scale {:g} fits", fits) : "";
}

void check_particle_budget(const Scene& scene) {
  const double cell = std::pow(scene.world.spacing, 3);
  double largest = 0;
  for (const SceneFluid& fluid : scene.fluids)
    largest = std::max(largest, box_volume(fluid.desc.shape.bounds()));
  for (const SceneBody& body : scene.bodies)
    largest = std::max(largest, box_volume(body.desc.shape.bounds()));
  const double needed = largest / cell * bytes_per_point, memory = machine_memory();
  if (needed <= memory) return;
  throw Failure(ExitCode::device,
                fmt::format("memory: more than {} needed for {:.2g} particles, {} in this machine; raise "
                            "particles.spacing, now {:g} m{}",
                            bytes_text(needed), largest / cell, bytes_text(memory), scene.world.spacing,
                            scale_hint(needed, memory)));
}

Failure memory_failure(const std::string& library_message, const std::string& device) {
  // "memory: 4.2 GB needed, 3.1 GB free; use fewer particles ..."
  static const std::regex form("([0-9.]+) GB needed, ([0-9.]+) GB free");
  std::smatch match;
  if (!std::regex_search(library_message, match, form)) return {ExitCode::device, library_message};
  const double needed = std::stod(match[1].str()), free = std::stod(match[2].str());
  return {ExitCode::device, fmt::format("memory: {} GB needed, {} GB free on {}{}", match[1].str(),
                                        match[2].str(), device, scale_hint(needed, free))};
}

}  // namespace runner
