// SPDX-License-Identifier: Apache-2.0
// Mutated files, seeded by the number of the case: scenes (built-in ones and tests/runner/tiny.yaml), meshes and
// checkpoints. A file is taken or refused with a Failure of the right exit code and a message; what is taken steps and
// reads finite. Checksums are made right again in half of the checkpoints, so that what is behind them is reached.
//
//   meltsim_file_fuzz --kind scene|mesh|checkpoint|all --cases 1000 --tiny tests/runner/tiny.yaml
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "build_world.hpp"
#include "builtin.hpp"
#include "checkpoint.hpp"
#include "children.hpp"
#include "failure.hpp"
#include "load_scene.hpp"
#include "meltsim/meltsim.hpp"
#include "support/random.hpp"

namespace {

using namespace meltsim;
using test_support::Random;

struct Settings {
  std::string kind = "all", tiny;
  std::string directory;  ///< of this process, for files that are read by name
  bool keep = false;
};

// --- mutations --------------------------------------------------------------------------------------------------

const char* const absurd[] = {"nan",
                              ".nan",
                              "inf",
                              ".inf",
                              "-1",
                              "0",
                              "1e300",
                              "-1e300",
                              "1e-300",
                              "1e999",
                              "4294967296",
                              "~",
                              "null",
                              "true",
                              "\"\"",
                              "[]",
                              "{}",
                              "[[[]]]",
                              "&a",
                              "*a",
                              "!!binary AA==",
                              "'%FRAMES%'",
                              "\"</script>\"",
                              "0x10",
                              "1e9",
                              "-273.16",
                              "1e-9"};

/// One token: what stands between separators of YAML and meshes.
struct Span {
  std::size_t at, length;
};
std::vector<Span> tokens_of(const std::string& text) {
  std::vector<Span> out;
  std::size_t start = std::string::npos;
  for (std::size_t i = 0; i <= text.size(); ++i) {
    const bool word = i < text.size() && std::strchr(" \t\r\n,:[]{}#\"'/", text[i]) == nullptr;
    if (word && start == std::string::npos) start = i;
    if (!word && start != std::string::npos) {
      out.push_back({start, i - start});
      start = std::string::npos;
    }
  }
  return out;
}

void mutate_text(std::string& text, Random& random) {
  for (int k = 1 + static_cast<int>(random.below(4)); k > 0; --k) {
    const auto size = static_cast<std::uint32_t>(text.size());
    if (size == 0) return;
    const std::vector<Span> tokens = tokens_of(text);
    const auto token = [&] { return tokens[random.below(static_cast<std::uint32_t>(tokens.size()))]; };
    switch (random.below(8)) {
      case 0:
        text[random.below(size)] = static_cast<char>(random.below(256));
        break;
      case 1:
        text.erase(random.below(size), 1 + random.below(40));
        break;
      case 2:
        text.insert(random.below(size), text.substr(random.below(size), 1 + random.below(60)));
        break;
      case 3:
        text.resize(random.below(size));
        break;
      case 4:
      case 5: {
        if (tokens.empty()) break;
        const Span s = token();
        text.replace(s.at, s.length, absurd[random.below(sizeof absurd / sizeof *absurd)]);
        break;
      }
      case 6: {
        if (tokens.empty()) break;
        const Span s = token(), from = token();
        const std::string word = text.substr(from.at, from.length);
        text.replace(s.at, s.length, word);
        break;
      }
      default: {  // a number, by a factor
        if (tokens.empty()) break;
        const Span s = token();
        const std::string word = text.substr(s.at, s.length);
        char* end = nullptr;
        const double value = std::strtod(word.c_str(), &end);
        if (*end != '\0') break;
        char number[40];
        std::snprintf(number, sizeof number, "%g", value * std::pow(10.0, random.uniform(-4, 4)));
        text.replace(s.at, s.length, number);
      }
    }
  }
}

void mutate_bytes(std::string& bytes, Random& random) {
  for (int k = 1 + static_cast<int>(random.below(6)); k > 0 && !bytes.empty(); --k) {
    const auto size = static_cast<std::uint32_t>(bytes.size());
    const std::uint32_t at = random.below(size);
    switch (random.below(5)) {
      case 0:
        bytes[at] = static_cast<char>(random.below(256));
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.below(8)));
        break;
      case 2:
        bytes.resize(at);
        break;
      case 3:
        bytes.insert(at, std::string(1 + random.below(16), static_cast<char>(random.below(256))));
        break;
      default: {  // eight bytes that read as a special number
        const double special[] = {NAN, INFINITY, -INFINITY, 0.0, -1.0, 1e300, 4e9};
        const double v = special[random.below(7)];
        if (at + sizeof v <= size) std::memcpy(&bytes[at], &v, sizeof v);
      }
    }
  }
}

// --- cases ------------------------------------------------------------------------------------------------------

std::string scene_text(Random& random, const std::string& tiny) {
  const auto& scenes = runner::builtin_scenes();
  const std::uint32_t which = random.below(static_cast<std::uint32_t>(scenes.size()) + 3);
  return which < scenes.size() ? scenes[which].text : tiny;
}

/// Whether building it takes a moment only: points that its boxes would hold.
bool small(const runner::Scene& scene) {
  const double dx = scene.world.spacing;
  if (!(dx > 0)) return true;
  double points = 0;
  const auto add = [&](const Shape& shape) {
    const Box b = shape.bounds();
    points += std::fabs((b.max.x - b.min.x) * (b.max.y - b.min.y) * (b.max.z - b.min.z)) / (dx * dx * dx);
  };
  for (const auto& f : scene.fluids) add(f.desc.shape);
  for (const auto& b : scene.bodies) add(b.desc.shape);
  for (const auto& r : scene.heat_regions) add(r.shape.shape);
  return points < 20000;
}

std::string finite_world(World& world) {
  const auto t = world.totals();
  if (!t) return {};
  for (const double v :
       {t->mass, t->kinetic, t->thermal, t->temperature_min, t->temperature_max, t->max_speed})
    if (!std::isfinite(v)) return "a total is not finite";
  if ((t->fluid + t->solid > 0) && t->temperature_min < absolute_zero * (1 + 1e-5)) return "colder than 0 K";
  return {};
}

std::string step_world(World& world) {
  const double stable = world.stable_dt();
  if (std::isfinite(stable) && stable > 0)
    for (int k = 0; k < 2; ++k) (void)world.step(stable);
  const StepResult r = world.synchronize();
  if (r.halted && r.halt_reason.empty()) return "halted without a reason";
  return finite_world(world);
}

/// The one message a user sees must say something.
std::string refused(const runner::Failure& failure) {
  if (std::strlen(failure.what()) == 0) return "refused without a message";
  if (failure.code() == runner::ExitCode::ok) return "refused with exit code 0";
  if (std::strstr(failure.what(), "unexpected error") != nullptr) return failure.what();
  return {};
}

std::string one_scene(Random& random, const Settings& settings) {
  std::string text = scene_text(random, settings.tiny);
  mutate_text(text, random);
  if (settings.keep) std::ofstream(settings.directory + "/scene.yaml") << text;
  try {
    const runner::Scene scene = runner::parse_scene(text, "fuzz.yaml", settings.directory, {});
    if (!small(scene)) return {};
    runner::MachineOptions machine;
    machine.backend = Backend::cpu;
    machine.threads = 1;
    runner::Built built = runner::build_world(scene, machine);
    return step_world(built.world);
  } catch (const runner::Failure& failure) {
    return refused(failure);
  }
}

std::string some_mesh(Random& random, bool& binary) {
  binary = false;
  switch (random.below(4)) {
    case 0:
      return "# a tetrahedron\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3/1/1 1//2 "
             "4/2\n";
    case 1:
      return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
             "element face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 "
             "1\n"
             "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
    case 2:
      return "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
             "0\nendloop\nendfacet\n"
             "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nvertex 0 1 "
             "0\nendloop\nendfacet\nendsolid t\n";
    default: {
      binary = true;
      std::string stl(80, ' ');
      const std::uint32_t n = 4;
      stl.append(reinterpret_cast<const char*>(&n), 4);
      for (std::uint32_t t = 0; t < n; ++t) {
        float v[12];
        for (float& x : v) x = static_cast<float>(random.uniform(0, 1));
        stl.append(reinterpret_cast<const char*>(v), sizeof v);
        stl.append(2, '\0');
      }
      return stl;
    }
  }
}

std::string one_mesh(Random& random, const Settings& settings) {
  bool binary = false;
  std::string bytes = some_mesh(random, binary);
  if (binary || random.below(4) == 0) mutate_bytes(bytes, random);
  else mutate_text(bytes, random);
  const std::string path = settings.directory + "/mesh";
  std::ofstream(path, std::ios::binary) << bytes;
  const auto mesh = read_mesh(path);
  if (!mesh) return mesh.error().message.empty() ? "refused without a message" : "";
  const Shape shape = Shape::mesh(*mesh);
  if (!shape.validate()) return {};
  const Box b = shape.bounds();
  const double side = std::max({b.max.x - b.min.x, b.max.y - b.min.y, b.max.z - b.min.z});
  for (const Vec3i& p : shape.lattice_points({}, side / 8))
    if (std::abs(p.x) > (1 << 30)) return "a lattice point is out of range";
  return {};
}

std::uint64_t fnv1a(const std::string& data) {
  std::uint64_t hash = 14695981039346656037ull;
  for (const char c : data) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  return hash;
}
void append_checksum(std::string& data) {
  const std::uint64_t sum = fnv1a(data);
  data.append(reinterpret_cast<const char*>(&sum), sizeof sum);
}

std::string one_checkpoint(Random& random, const Settings& settings) {
  const std::string path = settings.directory + "/checkpoint.bin";
  const runner::Scene scene = runner::parse_scene(settings.tiny, "tiny.yaml", settings.directory, {});
  runner::MachineOptions machine;
  machine.backend = Backend::cpu;
  machine.threads = 1;
  runner::Built built = runner::build_world(scene, machine);
  for (int k = 0; k < 2; ++k) (void)built.world.step(0.005);
  const auto snapshot = built.world.snapshot();
  if (!snapshot) return "no snapshot: " + snapshot.error().message;
  const auto hash = built.world.state_hash();
  std::string inner(snapshot->begin(), snapshot->end());
  if (random.below(2) == 0) {  // the World's own part, its checksum made right
    inner.resize(inner.size() - 8);
    mutate_bytes(inner, random);
    append_checksum(inner);
    const Status restored = built.world.restore(inner.data(), inner.size());
    if (!restored) {
      const auto same = built.world.state_hash();
      if (!same || *same != *hash) return "a refused snapshot changed the state: " + restored.error().message;
      return restored.error().message.empty() ? "refused without a message" : "";
    }
    return step_world(built.world);
  }
  runner::Checkpoint checkpoint;
  checkpoint.scene = {{"time", {{"fps", 25.0}}}};
  checkpoint.snapshot = *snapshot;
  runner::write_checkpoint(path, checkpoint);
  std::ifstream file(path, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  file.close();
  if (random.below(2) == 0) {
    bytes.resize(bytes.size() - 8);
    std::string head = bytes.substr(0, std::min<std::size_t>(bytes.size(), 400));
    mutate_bytes(head, random);
    bytes.replace(0, std::min<std::size_t>(bytes.size(), 400), head);
    append_checksum(bytes);
  } else {
    mutate_bytes(bytes, random);
  }
  std::ofstream(path, std::ios::binary) << bytes;
  try {
    const runner::Checkpoint back = runner::read_checkpoint(path);
    (void)built.world.restore(back.snapshot.data(), back.snapshot.size());
    return step_world(built.world);
  } catch (const runner::Failure& failure) {
    return failure.code() == runner::ExitCode::io ? refused(failure)
                                                  : "a damaged checkpoint needs exit code 5";
  }
}

std::string one(std::uint64_t item, const Settings& settings, fuzz::Progress& progress) {
  Random random(static_cast<std::uint32_t>(item * 2654435761u + 99u));
  progress.calls = progress.calls + 1;
  const std::string kinds[] = {"scene", "mesh", "checkpoint"};
  // A scene takes a hundred times as long as a mesh: equal shares of cases still give most of the time to scenes.
  const std::string kind = settings.kind == "all" ? kinds[item % 3] : settings.kind;
  std::snprintf(progress.what, sizeof progress.what, "a mutated %s", kind.c_str());
  try {
    const std::string violation = kind == "scene"  ? one_scene(random, settings)
                                  : kind == "mesh" ? one_mesh(random, settings)
                                                   : one_checkpoint(random, settings);
    return violation.empty() ? violation : kind + ": " + violation;
  } catch (const std::exception& e) {
    return kind + ": an exception got out: " + e.what();
  }
}

}  // namespace

int main(int argc, char** argv) {
  fuzz::Options options;
  options.per_child = 200;
  Settings settings;
  const auto own = [&](const std::string& name, const std::string& value) {
    if (name == "--kind" && (value == "scene" || value == "mesh" || value == "checkpoint" || value == "all"))
      settings.kind = value;
    else if (name == "--keep") settings.keep = value != "0";
    else if (name == "--tiny") {
      std::ifstream file(value);
      settings.tiny.assign(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    } else return false;
    return true;
  };
  if (!fuzz::parse(argc, argv, options, own,
                   "--tiny tests/runner/tiny.yaml [--kind scene|mesh|checkpoint|all] [--keep 0|1]"))
    return 2;
  if (settings.tiny.empty()) {
    std::fprintf(stderr, "%s: --tiny: names no scene; pass tests/runner/tiny.yaml\n", argv[0]);
    return 2;
  }
  char directory[] = "/tmp/meltsim-fuzz-XXXXXX";
  if (mkdtemp(directory) == nullptr) {
    std::perror("mkdtemp");
    return 1;
  }
  settings.directory = directory;
  const int code = fuzz::run(
      options, [&](std::uint64_t item, fuzz::Progress& progress) { return one(item, settings, progress); });
  if (settings.keep) std::printf("files are in %s\n", directory);
  else std::filesystem::remove_all(directory);
  return code;
}
