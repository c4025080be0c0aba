// SPDX-License-Identifier: Apache-2.0
// What the fuzzers of calls share: their settings, what they report, their command line and their loop.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "children.hpp"
#include "meltsim/meltsim.hpp"

namespace fuzz {

struct Settings {
  meltsim::Backend backend = meltsim::Backend::cpu;
  bool trace = false;
  int threads = 0;              ///< of every World; 0: the case draws them
  std::FILE* states = nullptr;  ///< gets a line of hashes per call
};

struct Violation {
  std::string text;
};

/// Runs a Sequence(case, settings, progress) per case. Returns the exit status. States of two runs with the same cases are equal, line by
/// line, with any number of threads, and on every backend of a reproducible build.
template <class Sequence>
int run_sequences(int argc, char** argv) {
  Options options;
  Settings settings;
  const auto own = [&](const std::string& name, const std::string& value) {
    if (name == "--backend" && value == "cpu") settings.backend = meltsim::Backend::cpu;
    else if (name == "--backend" && value == "cuda") settings.backend = meltsim::Backend::cuda;
    else if (name == "--trace") settings.trace = value != "0";
    else if (name == "--threads") settings.threads = std::atoi(value.c_str());
    else if (name == "--states") settings.states = std::fopen(value.c_str(), "a");
    else return false;
    return name != "--states" || settings.states != nullptr;
  };
  if (!parse(argc, argv, options, own, "[--backend cpu|cuda] [--trace 0|1] [--threads N] [--states FILE]"))
    return 2;
  const int status = run(options, [&](std::uint64_t item, Progress& progress) {
    return Sequence(item, settings, progress).run();
  });
  if (settings.states != nullptr) std::fclose(settings.states);
  return status;
}

}  // namespace fuzz
