// SPDX-License-Identifier: Apache-2.0
// Hashes of the state of every built-in scene after a number of sub-steps, per precision, against those of the file
// beside this one. Only builds with MELTSIM_REPRODUCIBLE give them. A hash moves in a commit that says why:
//
//   meltsim_golden tests/golden/hashes.txt [--backend cpu|cuda] [--write]
//
// Exit status: 0 equal, 1 different or missing, 2 usage, 77 skipped (no GPU).
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "build_world.hpp"
#include "builtin.hpp"
#include "failure.hpp"
#include "load_scene.hpp"
#include "meltsim/meltsim.hpp"
#include "resolution.hpp"

namespace {

using namespace meltsim;

// Enough for bodies to hit the liquid and for heat to cross several particles; small enough for a minute on two cores, with
// sanitizers. Scenes of many particles are run coarser, those of few for longer: their nozzles have to bring something first.
constexpr int steps = 120, steps_of_few = 1200;
constexpr double scale = 0.5, scale_of_many = 0.35;
constexpr std::uint64_t many = 4000, few = 400;

runner::Built built_at(double resolution, const std::string& name, Backend backend, Precision precision) {
  runner::Scene scene = runner::load_scene(name, {});
  runner::apply_resolution(scene, resolution, runner::Quality::balanced);
  runner::MachineOptions machine;
  machine.backend = backend;
  machine.precision = precision;
  return runner::build_world(scene, machine);
}

std::uint64_t particles_of(World& world) {
  const Totals t = *world.totals();
  return t.fluid + t.solid;
}

std::string hash_of(const std::string& name, Backend backend, Precision precision) {
  runner::Built built = built_at(scale, name, backend, precision);
  const std::uint64_t particles = particles_of(built.world);
  if (particles > many) built = built_at(scale_of_many, name, backend, precision);
  // A power of two: no rounding of its own in the sum of the steps.
  const double stable = built.world.stable_dt();
  double dt = 1;
  while (dt > 0.75 * stable) dt /= 2;
  for (int k = 0; k < (particles < few ? steps_of_few : steps); ++k) {
    const Status s = built.world.step(dt);
    if (!s) return "error: " + s.error().message;
  }
  const StepResult r = built.world.synchronize();
  if (r.halted) return "halted: " + r.halt_reason;
  const auto hash = built.world.state_hash();
  if (!hash) return "error: " + hash.error().message;
  char text[20];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(*hash));
  return text;
}

std::map<std::string, std::string> read(const char* path) {
  std::map<std::string, std::string> out;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::string scene, precision, hash;
    words >> scene >> precision >> hash;
    out[scene + " " + precision] = hash;
  }
  return out;
}

int compare(const char* path, Backend backend, bool write) {
  const std::map<std::string, std::string> golden = read(path);
  std::map<std::string, std::string> now;
  int different = 0;
  for (const std::string& scene : runner::builtin_names())
    for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
      const std::string key = scene + (precision == Precision::single_precision ? " single" : " double");
      now[key] = hash_of(scene, backend, precision);
      const auto want = golden.find(key);
      const bool same = want != golden.end() && want->second == now[key];
      different += same ? 0 : 1;
      std::printf(
          "%-28s %s%s\n", key.c_str(), now[key].c_str(),
          same ? "" : ("  DIFFERENT, was " + (want == golden.end() ? "not there" : want->second)).c_str());
      std::fflush(stdout);
    }
  if (!write) return different == 0 ? 0 : 1;
  std::ofstream file(path);
  file
      << "# State hashes of the built-in scenes: scene, precision, hash after " << steps << " steps at scale "
      << scale << " (" << scale_of_many << " where that has more than " << many << " particles; "
      << steps_of_few << " steps\n# where it has fewer than " << few
      << ").\n# Written by meltsim_golden --write in a build with MELTSIM_REPRODUCIBLE; a change says why in "
         "its commit.\n";
  for (const auto& [key, hash] : now) file << key << ' ' << hash << '\n';
  return file ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Backend backend = Backend::cpu;
  bool write = false;
  const char* path = nullptr;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--write") == 0) write = true;
    else if (std::strcmp(argv[i], "--backend") == 0 && i + 1 < argc && std::strcmp(argv[i + 1], "cuda") == 0)
      backend = Backend::cuda, ++i;
    else if (std::strcmp(argv[i], "--backend") == 0 && i + 1 < argc && std::strcmp(argv[i + 1], "cpu") == 0)
      ++i;
    else if (argv[i][0] != '-' && path == nullptr) path = argv[i];
    else return std::fprintf(stderr, "usage: %s HASHES [--backend cpu|cuda] [--write]\n", argv[0]), 2;
  }
  if (path == nullptr)
    return std::fprintf(stderr, "usage: %s HASHES [--backend cpu|cuda] [--write]\n", argv[0]), 2;
  if (backend == Backend::cuda && build_info().devices.empty()) {
    std::printf("skipped: %s\n", build_info().cuda_reason.c_str());
    return std::getenv("MELTSIM_REQUIRE_GPU") != nullptr ? 1 : 77;
  }
  try {
    return compare(path, backend, write);
  } catch (const runner::Failure& failure) {
    std::fprintf(stderr, "%s\n", failure.what());
    return 1;
  }
}
