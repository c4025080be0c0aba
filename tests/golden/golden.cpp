// SPDX-License-Identifier: Apache-2.0
// Hashes of the state of every built-in scene after a number of sub-steps, per precision, against those of the file
// beside this one. Only builds with MELTSIM_REPRODUCIBLE give them. A hash moves in a commit that says why:
//
//   meltsim_golden tests/golden/hashes.txt [--backend cpu|cuda] [--precision single|double | --write]
//
// Exit status: 0 equal, 1 different or missing, 2 usage, 77 skipped (no GPU).
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "build_world.hpp"
#include "builtin.hpp"
#include "failure.hpp"
#include "load_scene.hpp"
#include "meltsim/meltsim.hpp"
#include "resolution.hpp"

namespace {

using namespace meltsim;

// Enough for bodies to hit the liquid and for heat to cross several particles; small enough for two minutes on two cores, with
// sanitizers. Scenes of many particles are run coarser, those of few for longer: their nozzles have to bring something first.
constexpr int steps = 60, steps_of_few = 600;
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

int compare(const char* path, Backend backend, const std::vector<Precision>& precisions, bool write) {
  const std::map<std::string, std::string> golden = read(path);
  std::map<std::string, std::string> now;
  int different = 0;
  for (const std::string& scene : runner::builtin_names())
    for (const Precision precision : precisions) {
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

struct Arguments {
  const char* path = nullptr;
  Backend backend = Backend::cpu;
  std::vector<Precision> precisions = {Precision::single_precision, Precision::double_precision};
  bool write = false;
};

bool parsed(int argc, char** argv, Arguments& a) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i], value = i + 1 < argc ? argv[i + 1] : "";
    if (word == "--write") a.write = true;
    else if (word == "--backend" && value == "cuda") a.backend = Backend::cuda, ++i;
    else if (word == "--backend" && value == "cpu") ++i;
    else if (word == "--precision" && value == "single") a.precisions = {Precision::single_precision}, ++i;
    else if (word == "--precision" && value == "double") a.precisions = {Precision::double_precision}, ++i;
    else if (word[0] != '-' && a.path == nullptr) a.path = argv[i];
    else return false;
  }
  return a.path != nullptr && !(a.write && a.precisions.size() == 1);  // a file has both
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  if (!parsed(argc, argv, a))
    return std::fprintf(stderr,
                        "usage: %s HASHES [--backend cpu|cuda] [--precision single|double | --write]\n",
                        argv[0]),
           2;
  if (a.backend == Backend::cuda && build_info().devices.empty()) {
    std::printf("skipped: %s\n", build_info().cuda_reason.c_str());
    return std::getenv("MELTSIM_REQUIRE_GPU") != nullptr ? 1 : 77;
  }
  try {
    return compare(a.path, a.backend, a.precisions, a.write);
  } catch (const runner::Failure& failure) {
    std::fprintf(stderr, "%s\n", failure.what());
    return 1;
  }
}
