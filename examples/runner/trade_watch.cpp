// SPDX-License-Identifier: Apache-2.0
#include "trade_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "expect.hpp"
#include "failure.hpp"

namespace runner {

namespace trade = meltsim::trade;

namespace {

const double safety = trade::Options{}.safety;

const trade::Known& known_of(const trade::Study& study, const std::string& name) {
  for (const trade::Known& known : study.observables)
    if (known.observable.name == name) return known;
  return study.observables.front();
}

/// Two significant digits, rounded up: what can be asked for.
double round_up(double value) {
  const double digit = std::pow(10, std::floor(std::log10(value)) - 1);
  return std::ceil(value / digit - 1e-9) * digit;
}

}  // namespace

std::string about_text(double seconds) {
  if (seconds < 1) return "less than a second";
  if (seconds < 100) return fmt::format("{:.2g} s", seconds);
  if (seconds < 6000) return fmt::format("{:.2g} min", seconds / 60);
  if (seconds < 72 * 3600) return fmt::format("{:.2g} hours", seconds / 3600);
  return fmt::format("{:.2g} days", seconds / 86400);
}

std::string broken_promise_text(const trade::Known& known, double error, double asked) {
  if (!(error > asked)) return "";
  return fmt::format(
      "{}: the estimated error, {}, is more than was asked for, {}: between the probes and these settings it "
      "does not follow the "
      "law that they gave; give the probes more time (--time-limit), or ask for less than you need",
      known.observable.name, error_text(known, error), error_text(known, asked));
}

trade::Choice choose_settings(const Tuning& tuning, const trade::Study& study, const TradeRequest& request) {
  for (std::size_t k = 0; k < study.observables.size(); ++k) {
    if (study.observables[k].observable.name != request.of) continue;
    if (const std::string why = not_reached(study, k, tuning.problem().end); !why.empty())
      throw Failure(request.by_option ? ExitCode::usage : ExitCode::scene, request.asked_by + ": " + why);
  }
  const trade::Choice choice = expect(trade::choose(study, request.of, request.max_error));
  if (choice.attainable) return choice;
  const trade::Known& known = known_of(study, request.of);
  const double ask = round_up(100 * safety * choice.error / known.scale);
  const ExitCode code = request.by_option ? ExitCode::usage : ExitCode::scene;
  if (choice.chaotic)
    throw Failure(code, fmt::format("{}: {}: the course of this scene is chaotic: two starts that differ by "
                                    "0.0001 of gravity come to differ "
                                    "by {}, whatever the settings; ask for {:g} % or more, for another "
                                    "observable, or for a shorter run",
                                    request.asked_by, request.of, error_text(known, known.spread), ask));
  throw Failure(
      code,
      fmt::format(
          "{}: {}: the smallest error that this scene can be expected to have is {}, with {}, in about {} "
          "here; ask for {:g} % or more",
          request.asked_by, request.of, error_text(known, choice.error), tuning.settings_text(choice.knobs),
          about_text(choice.seconds), ask));
}

TradeWatch::TradeWatch(std::shared_ptr<const Tuning> tuning, trade::Study study, trade::Choice choice,
                       TradeRequest request, Built& built)
    : tuning_(std::move(tuning)),
      study_(std::move(study)),
      choice_(choice),
      request_(std::move(request)),
      reader_(tuning_->reader(built)),
      actual_(tuning_->actual(built.world, choice.knobs)) {}

void TradeWatch::frame(double time, const meltsim::Totals& totals,
                       const std::vector<meltsim::PieceInfo>& pieces) {
  open_.push_back({time, totals, pieces});
  if (!wants_particles() && !wants_probes()) rest({}, {});
}

void TradeWatch::rest(const meltsim::ParticleFrame& particles,
                      const std::vector<meltsim::ProbeSeries>& probes) {
  if (open_.empty()) return;
  const Open open = std::move(open_.front());
  open_.pop_front();
  times_.push_back(open.time);
  rows_.push_back(reader_.values(open.totals, open.pieces, particles, probes));
}

std::vector<double> TradeWatch::compared(std::size_t k) const {
  std::size_t first = 0;
  for (std::size_t i = 0; i < k; ++i)
    first += static_cast<std::size_t>(study_.observables[i].observable.components);
  const trade::Observable& observable = study_.observables[k].observable;
  const auto width = static_cast<std::size_t>(observable.components);
  const std::vector<double> times = tuning_->sample_times();
  std::vector<double> values;
  for (const double t : times) {
    // Linear between frames; what ended early stays as it ended.
    std::size_t next = 0;
    while (next + 1 < times_.size() && times_[next] < t) ++next;
    const std::size_t before = next > 0 && times_[next] > t ? next - 1 : next;
    const double part = next > before ? (t - times_[before]) / (times_[next] - times_[before]) : 0;
    for (std::size_t c = first; c < first + width; ++c) {
      const double a = rows_[before][c], b = rows_[next][c];
      values.push_back(part > 0 && std::isfinite(a) ? a + part * (b - a) : b);
    }
  }
  return trade::reduce(observable, times, values);
}

std::vector<trade::Difference> TradeWatch::delivered() const {
  std::vector<trade::Difference> list;
  for (std::size_t k = 0; k < study_.observables.size() && !rows_.empty(); ++k)
    list.push_back(trade::delivered(study_, k, actual_, compared(k)));
  return list;
}

/// Why nothing can be said of the error of a time to reach something; empty: it can.
std::string TradeWatch::missed(std::size_t k) const {
  const double end = tuning_->problem().end;
  if (std::string why = not_reached(study_, k, end); !why.empty()) return why;
  const trade::Observable& o = study_.observables[k].observable;
  if (o.reduce != trade::Reduce::time_to_reach || std::isfinite(compared(k).front())) return "";
  return fmt::format("{}: not reached by t={:g} s in this run", o.name, end);
}

std::vector<std::string> TradeWatch::report() const {
  std::vector<std::string> lines;
  const std::vector<trade::Difference> errors = delivered();
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const trade::Known& known = study_.observables[k];
    if (const std::string why = missed(k); !why.empty()) {
      lines.push_back(why);
      continue;
    }
    std::string line =
        fmt::format("{}: estimated error of this run {}, root mean square {}", known.observable.name,
                    error_text(known, errors[k].max), error_text(known, errors[k].rms));
    if (known.observable.name == request_.of)
      line += fmt::format("; asked for {}", error_text(known, choice_.asked));
    lines.push_back(line);
  }
  return lines;
}

std::string TradeWatch::broken_promise() const {
  const std::vector<trade::Difference> errors = delivered();
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const trade::Known& known = study_.observables[k];
    if (known.observable.name != request_.of || !missed(k).empty()) continue;
    return broken_promise_text(known, errors[k].max, choice_.asked);
  }
  return "";
}

Json TradeWatch::json(bool ended) const {
  Json json;
  json["of"] = request_.of;
  json["max_error"] = request_.max_error;
  json["settings"] = tuning_->settings_json(choice_.knobs);
  json["probes"] = study_.probes.size();
  json["probing_s"] = study_.wall_s;
  json["from_cache"] = tuning_->from_cache();
  json["cut_short"] = study_.cut_short;
  json["notes"] = study_.notes;
  const trade::Known& of = known_of(study_, request_.of);
  json["expected"] = {{"error", choice_.error},
                      {"share", choice_.error / of.scale},
                      {"rms", choice_.rms},
                      {"seconds", choice_.seconds}};
  if (!ended) return json;
  const std::vector<trade::Difference> errors = delivered();
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const trade::Known& known = study_.observables[k];
    if (!missed(k).empty()) {
      json["delivered"][known.observable.name] = {{"reached", false}};
      continue;
    }
    json["delivered"][known.observable.name] = {{"error", errors[k].max},
                                                {"rms", errors[k].rms},
                                                {"share", errors[k].max / known.scale},
                                                {"unit", known.observable.unit},
                                                {"values", compared(k)}};
  }
  return json;
}

}  // namespace runner
