// SPDX-License-Identifier: Apache-2.0
#include "show/run_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <sstream>

#include "csv.hpp"
#include "failure.hpp"
#include "files.hpp"
#include "load_scene.hpp"
#include "numbers.hpp"
#include "show/ply_reader.hpp"
#include "show/surfaces.hpp"

namespace runner {

Scene run_scene_of(const RunDirectory& directory) {
  const std::string path = directory.file("run.json");
  if (!exists(path)) {
    throw Failure(ExitCode::io, fmt::format("{}: holds no run.json; name the directory of a run, or a scene",
                                            directory.path));
  }
  const Json run = Json::parse(read_file(path), nullptr, false);
  if (!run.is_object() || !run.contains("scene")) {
    throw Failure(ExitCode::io, path + ": is not a whole run.json of this program; run the scene again");
  }
  Json scene = Json::object();
  // What was in it may name mesh files that are elsewhere now, and is not looked at.
  for (const char* key :
       {"meltsim", "title", "domain", "particles", "solver", "time", "materials", "output"}) {
    if (run["scene"].contains(key)) scene[key] = run["scene"][key];
  }
  Scene read = parse_scene(scene.dump(), path, directory.path, {});
  for (const Json& body : run["scene"].value("bodies", Json::array())) {
    const std::string material = body.value("material", "");
    read.output.body_colors.push_back(look_color(read.output, material));
    read.output.body_visible.push_back(body.value("visible", true));
    if (body.contains("density")) add_look(read.output, material, body["density"].get<double>());
  }
  return read;
}

std::vector<std::uint64_t> frames_on_disk(const RunDirectory& directory) {
  std::set<std::uint64_t> numbers;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(directory.file("frames"), error)) {
    const std::string name = entry.path().filename().string();
    const bool ours =
        name.rfind("particles_", 0) == 0 || name.rfind("liquid_", 0) == 0 || name.rfind("solid_", 0) == 0;
    if (!ours || entry.path().extension() != ".ply") continue;
    const auto number = frame_number(name).value_or(-1);
    if (number >= 0) numbers.insert(static_cast<std::uint64_t>(number));
  }
  return {numbers.begin(), numbers.end()};
}

FrameShapes frame_on_disk(const RunDirectory& directory, const Scene& scene, std::uint64_t index) {
  FrameShapes shapes;
  if (scene.world.domain.bounded) shapes.origin = scene.world.domain.min;
  const std::string liquid = directory.frame("liquid", index, "ply"),
                    solid = directory.frame("solid", index, "ply"),
                    particles = directory.frame("particles", index, "ply");
  const bool has_surface = exists(liquid) && exists(solid);
  if (has_surface) {
    shapes.liquid = read_mesh_ply(liquid, shapes.origin, shapes.time);
    shapes.solid = read_mesh_ply(solid, shapes.origin, shapes.time);
    const std::vector<std::uint32_t> species = shown_species(scene);
    double time = 0;
    if (shapes.liquid.contents.size() == species.size()) shapes.liquid.species = species;
    else if (exists(particles))  // surfaces of earlier versions hold no contents
      add_contents(shapes, read_particles_ply(particles, time), species, scene.world.spacing);
  } else if (exists(particles)) {
    add_balls(shapes, read_particles_ply(particles, shapes.time), scene.world.spacing);
  }
  return picture_shapes(std::move(shapes), scene);
}

std::pair<double, double> range_on_disk(const RunDirectory& directory) {
  double cold = 1e300, hot = -1e300;
  if (exists(directory.file("stats.csv"))) {
    std::istringstream table(read_file(directory.file("stats.csv")));
    std::string line;
    std::getline(table, line);
    const std::vector<std::string> header = split_commas(line);
    const auto column = [&](const char* name) {
      return static_cast<std::size_t>(std::find(header.begin(), header.end(), name) - header.begin());
    };
    const std::size_t low = column("T_min"), high = column("T_max"), fluid = column("n_fluid"),
                      solid = column("n_solid");
    while (std::getline(table, line)) {
      const std::vector<std::string> cells = split_commas(line);
      const auto at = [&](std::size_t i) { return i < cells.size() ? parse_number(cells[i]) : std::nullopt; };
      if (at(fluid) == 0.0 && at(solid) == 0.0) continue;  // temperatures of nothing are 0
      if (const auto t = at(low); t && std::isfinite(*t)) cold = std::min(cold, *t);
      if (const auto t = at(high); t && std::isfinite(*t)) hot = std::max(hot, *t);
    }
  }
  if (cold > hot) return {0, 1};
  if (hot - cold < 1e-3) return {cold - 0.5, hot + 0.5};
  return {cold, hot};
}

}  // namespace runner
