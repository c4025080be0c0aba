// SPDX-License-Identifier: Apache-2.0
// Verbs on an executor itself; one text for both. Time: the executor's own stage timing.
#pragma once

#include <random>

#include "bench.hpp"
#include "frame/frame.hpp"

namespace bench {

struct HeadOf {
  const std::uint64_t* keys;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t i) const {
    return i == 0 || keys[i - 1] != keys[i] ? 1u : 0u;
  }
};

struct SpeedOf {
  const std::uint64_t* keys;
  MELTSIM_HD meltsim::core::CheckResult operator()(std::uint64_t i) const {
    meltsim::core::CheckResult r;
    r.max_speed = static_cast<double>(keys[i]);
    return r;
  }
};

/// Keys as the neighbour search has them: cells of about 15 particles, almost sorted (a step moves few).
struct VerbData {
  std::vector<std::uint64_t> keys;
  std::vector<std::uint32_t> values;
  std::uint32_t bits = 1;
  explicit VerbData(std::uint64_t n) {
    std::mt19937 engine(1);
    const std::uint64_t cells = n / 15 + 1;
    while ((std::uint64_t{1} << bits) <= cells) ++bits;
    ++bits;
    for (std::uint64_t i = 0; i < n; ++i) {
      keys.push_back(engine() % 50 == 0 ? engine() % cells : i / 15);
      values.push_back(static_cast<std::uint32_t>(i));
    }
  }
};

enum class Verb { sort, scan, reduce };

template <class E>
void run_verb(benchmark::State& state, E ex, Verb verb, std::uint64_t n) {
  const VerbData data(n);
  const auto bytes = [n](std::size_t item) { return n * item; };
  auto* k = static_cast<std::uint64_t*>(ex.allocate(bytes(8)));
  auto* ko = static_cast<std::uint64_t*>(ex.allocate(bytes(8)));
  auto* v = static_cast<std::uint32_t*>(ex.allocate(bytes(4)));
  auto* vo = static_cast<std::uint32_t*>(ex.allocate(bytes(4)));
  auto* out = static_cast<meltsim::core::CheckResult*>(ex.allocate(sizeof(meltsim::core::CheckResult)));
  const bool ready = k && ko && v && vo && out && ex.reserve(n);
  int stage = 0;
  const auto once = [&] {
    if (verb == Verb::sort) {  // it may use its input as working space
      ex.upload(k, data.keys.data(), bytes(8));
      ex.upload(v, data.values.data(), bytes(4));
    }
    ex.begin_stage(stage, "benchmark");
    if (verb == Verb::sort) ex.sort(n, data.bits, k, v, ko, vo);
    if (verb == Verb::scan) ex.scan(n, HeadOf{k}, vo);
    if (verb == Verb::reduce) ex.reduce(n, SpeedOf{k}, out);
    ex.end_stage(stage);
    ex.synchronize();
  };
  if (ready) {
    ex.upload(k, data.keys.data(), bytes(8));
    once();
    ++stage;
    // The median over 31 runs is one measurement: single ones are of the size of the timer's steps.
    for (auto _ : state) {
      for (int r = 0; r < 31; ++r) once();
      state.SetIterationTime(ex.collect().median(stage++) * 1e-3);
    }
    state.counters["items/s"] = benchmark::Counter(
        static_cast<double>(n) * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
  } else {
    state.SkipWithError("out of memory");
  }
  for (void* p : {static_cast<void*>(k), static_cast<void*>(ko), static_cast<void*>(v),
                  static_cast<void*>(vo), static_cast<void*>(out)})
    if (p != nullptr) ex.release(p);
  if (const std::string fault = ex.fault(); !fault.empty()) state.SkipWithError(fault.c_str());
}

template <class Make>
void register_verbs(const char* backend, const std::vector<std::uint64_t>& sizes, Make make) {
  for (const auto& [verb, verb_name] :
       {std::pair{Verb::sort, "sort"}, std::pair{Verb::scan, "scan"}, std::pair{Verb::reduce, "reduce"}})
    for (const std::uint64_t n : sizes) {
      const std::string name = std::string("verb/") + verb_name + "/" + backend + "/" + std::to_string(n);
      benchmark::RegisterBenchmark(
          name.c_str(), [make, verb = verb, n](benchmark::State& state) { run_verb(state, make(), verb, n); })
          ->UseManualTime()
          ->Iterations(4)
          ->Unit(benchmark::kMicrosecond);
    }
}

}  // namespace bench
