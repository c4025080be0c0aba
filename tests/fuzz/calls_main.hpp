// SPDX-License-Identifier: Apache-2.0
// What the fuzzers of calls share: their settings, what they report, their command line and their loop.
#pragma once

#include <cstdint>
#include <string>

#include "children.hpp"
#include "meltsim/meltsim.hpp"

namespace fuzz {

struct Settings {
  meltsim::Backend backend = meltsim::Backend::cpu;
  bool trace = false;
};

struct Violation {
  std::string text;
};

/// Runs a Sequence(case, settings, progress) per case. Returns the exit status.
template <class Sequence>
int run_sequences(int argc, char** argv) {
  Options options;
  Settings settings;
  const auto own = [&](const std::string& name, const std::string& value) {
    if (name == "--backend" && value == "cpu") settings.backend = meltsim::Backend::cpu;
    else if (name == "--backend" && value == "cuda") settings.backend = meltsim::Backend::cuda;
    else if (name == "--trace") settings.trace = value != "0";
    else return false;
    return true;
  };
  if (!parse(argc, argv, options, own, "[--backend cpu|cuda] [--trace 0|1]")) return 2;
  return run(options, [&](std::uint64_t item, Progress& progress) {
    return Sequence(item, settings, progress).run();
  });
}

}  // namespace fuzz
