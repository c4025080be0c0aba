// SPDX-License-Identifier: Apache-2.0
#include "trade/check.hpp"

#include <algorithm>
#include <cmath>

#include "engine/text.hpp"

namespace meltsim {
inline namespace v0 {
namespace trade {

namespace {

std::string number(double value) { return core::to_text(value); }

Error expected(const std::string& field, const std::string& what, const std::string& got) {
  return {ErrorCode::invalid_argument, field + ": expected " + what + ", got " + got};
}
Error expected(const std::string& field, const std::string& what, double got) {
  return expected(field, what, number(got));
}

Status check(const Observable& o) {
  const auto field = [&](const char* name) {
    return "Observable::" + std::string(name) + ": of \"" + o.name + "\"";
  };
  if (!(o.order >= 1) || !std::isfinite(o.order)) return expected(field("order"), "1 or more", o.order);
  if (!(o.scale >= 0) || !std::isfinite(o.scale))
    return expected(field("scale"), "a number above 0, or 0 for the range of the values", o.scale);
  if (o.components < 1) return expected(field("components"), "1 or more", o.components);
  if (o.reduce == Reduce::time_to_reach && o.components != 1)
    return expected(field("components"), "1, as time_to_reach compares numbers with a level", o.components);
  if (o.reduce == Reduce::time_to_reach && !std::isfinite(o.level))
    return expected(field("level"), "a number", o.level);
  if (!o.exact.empty() && !has_value(o.exact))
    return expected(field("exact"), "numbers, or nothing where no exact answer is known",
                    number(o.exact.front()) + " throughout");
  return {};
}

Status check(const Ranges& ranges) {
  for (std::size_t k = 0; k < ranges.size(); ++k) {
    const Range& r = ranges[k];
    if (!(r.least > 0) || !(r.most >= r.least) || !std::isfinite(r.most))
      return expected("Problem::ranges: of " + std::string(knob_name(static_cast<Knob>(k))),
                      "0 < least <= most, multiples of the problem's own setting",
                      number(r.least) + " to " + number(r.most));
  }
  return {};
}

/// What measure() needs to build a World and to step it.
Status check_run(const Problem& p) {
  if (!p.build) return expected("Problem::build", "a function that makes the World", "none");
  if (!p.observe)
    return expected("Problem::observe", "a function that appends the observables' values", "none");
  if (!(p.end > 0) || !std::isfinite(p.end)) return expected("Problem::end", "a time above 0 s", p.end);
  if (p.samples < 1) return expected("Problem::samples", "1 or more", p.samples);
  if (!(p.longest_step > 0))
    return expected("Problem::longest_step", "a time above 0 s, or infinity", p.longest_step);
  if (!(p.longest_sample_step > 0))
    return expected("Problem::longest_sample_step", "a time above 0 s, or infinity", p.longest_sample_step);
  if (!(p.diffusivity >= 0)) return expected("Problem::diffusivity", "0 m^2/s or more", p.diffusivity);
  return {};
}

}  // namespace

bool has_value(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

Status check(const Problem& problem) {
  for (const Observable& o : problem.observables)
    if (Status s = check(o); !s) return s;
  if (Status s = check(problem.ranges); !s) return s;
  if (!(problem.reference_work >= 0) || !std::isfinite(problem.reference_work))
    return expected("Problem::reference_work", "0 or more", problem.reference_work);
  return problem.run ? Status{} : check_run(problem);
}

Status check_names(const std::vector<Observable>& observables) {
  if (observables.empty()) return expected("Problem::observables", "one at least", "none");
  for (std::size_t k = 0; k < observables.size(); ++k)
    for (std::size_t j = 0; j < k; ++j)
      if (observables[j].name == observables[k].name)
        return expected("Observable::name", "names that differ, as choose() goes by them",
                        "\"" + observables[k].name + "\" twice");
  return {};
}

Status check(const Options& options) {
  if (!(options.seconds > 0)) return expected("Options::seconds", "a time above 0 s", options.seconds);
  if (options.probes < 3) return expected("Options::probes", "3 or more", options.probes);
  if (!(options.safety >= 1) || !std::isfinite(options.safety))
    return expected("Options::safety", "1 or more", options.safety);
  if (!(options.finest > 0) || !std::isfinite(options.finest))
    return expected("Options::finest", "a multiple of the spacing above 0", options.finest);
  return {};
}

Status check(const Knobs& knobs) {
  for (std::size_t k = 0; k < knob_count; ++k)
    if (!(knobs.value[k] > 0) || !std::isfinite(knobs.value[k]))
      return expected("Knobs: " + std::string(knob_name(static_cast<Knob>(k))), "a multiple above 0",
                      knobs.value[k]);
  return {};
}

Status check_exact(const Problem& problem, const Measurement& probe) {
  for (std::size_t k = 0; k < std::min(problem.observables.size(), probe.values.size()); ++k) {
    const Observable& o = problem.observables[k];
    if (!o.exact.empty() && o.exact.size() != probe.values[k].size())
      return expected("Observable::exact: of \"" + o.name + "\"",
                      std::to_string(probe.values[k].size()) +
                          " values, as many as are compared (reduce() of the samples and the start)",
                      std::to_string(o.exact.size()));
  }
  return {};
}

}  // namespace trade
}  // namespace v0
}  // namespace meltsim
