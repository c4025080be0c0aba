// SPDX-License-Identifier: Apache-2.0
// `meltsim trade`: what accuracy costs in a scene, and which setting buys what.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "commands.hpp"
#include "csv.hpp"
#include "expect.hpp"
#include "failure.hpp"
#include "files.hpp"
#include "numbers.hpp"
#include "run_directory.hpp"
#include "show/front_svg.hpp"
#include "trade_watch.hpp"
#include "wall_times.hpp"

namespace runner {

namespace trade = meltsim::trade;
using trade::Knob;

namespace {

/// A point of the front that was run.
struct Tried {
  trade::Measurement run;
  trade::Difference error;
};

class Trade {
 public:
  Trade(const Scene& scene, const TradeOptions& options)
      : scene_(scene), options_(options), tuning_(scene, options.machine, options.observe, "--observe") {}

  int run() {
    probe();
    fmt::print("{}{}\n", scene_.name, scene_.title.empty() ? "" : ": " + scene_.title);
    line("backend", tuning_.device());
    line("probes",
         fmt::format("{} runs in {:.1f} s{}{}", study_.probes.size(), study_.wall_s,
                     tuning_.from_cache() ? " (from the cache)" : "",
                     study_.cut_short ? "; cut short by --time-limit: another time they may differ" : ""));
    for (const std::string& note : study_.notes) line("note", note);
    for (std::size_t k = 0; k < study_.observables.size(); ++k) print_laws(k);
    print_front();
    write();
    if (options_.error) print_choice();
    return 0;
  }

 private:
  static void line(const std::string& what, const std::string& text) { fmt::print("{:<12}{}\n", what, text); }

  void probe() {
    TuneOptions tune;
    tune.seconds = options_.seconds;
    tune.cache = options_.cache;
    tune.support = options_.support;
    study_ = tuning_.study(tune);
    if (const std::string why = not_reached(study_, 0, tuning_.problem().end); !why.empty())
      throw Failure(ExitCode::usage, why);
    fronts_.clear();
    for (std::size_t k = 0; k < study_.observables.size(); ++k) {
      meltsim::Result<std::vector<trade::Choice>> front =
          trade::front(study_, study_.observables[k].observable.name, options_.points);
      // Of those beside the first one a note says that they have no value.
      fronts_.push_back(k == 0 ? expect(std::move(front)) : front ? *front : std::vector<trade::Choice>{});
    }
    // Points of the front that the time left, or else half as much again, allows, from the cheapest on.
    double left = options_.measure ? std::max(options_.seconds - study_.wall_s, options_.seconds / 2) : 0;
    tried_.resize(fronts_[0].size());
    for (std::size_t i = 0; i < fronts_[0].size(); ++i) {
      const double wanted = fronts_[0][i].seconds;
      if (!(wanted < left)) break;
      const Clock::time_point start = Clock::now();
      Tried tried;
      tried.run = tuning_.measure(fronts_[0][i].knobs, 2 * left);
      left -= seconds_since(start);
      if (!tried.run.complete) continue;
      tried.error = trade::delivered(study_, 0, tried.run.actual, tried.run.values[0]);
      tried_[i] = tried;
    }
  }

  static std::string knob_text(Knob knob) {
    return knob == Knob::sound_speed ? "sound speed" : trade::knob_name(knob);
  }

  void print_laws(std::size_t k) {
    const trade::Known& known = study_.observables[k];
    const trade::Observable& o = known.observable;
    if (const std::string why = not_reached(study_, k, tuning_.problem().end); !why.empty()) {
      fmt::print("\n{}\n", why);
      return;
    }
    fmt::print("\n{}: {}; shares are of {:.3g}{}{}\n", o.name,
               o.exact.empty() ? "against the extrapolated limit" : "against the exact answer", known.scale,
               o.unit.empty() ? "" : " ", o.unit);
    for (const trade::Law& law : known.laws) {
      if (!law.measured()) {
        line(knob_text(law.knob), "not measured: it stays as it is, and no error counts what it does");
        continue;
      }
      const trade::Range range = study_.ranges[static_cast<std::size_t>(law.knob)];
      const double cheap = law.cost_exponent < 0 ? range.most : range.least;
      line(knob_text(law.knob),
           fmt::format("cost x^{:.1f}, error {} x^{:.1f}{}; x {:.2g} takes {:.2g} of the time and has {} %",
                       law.cost_exponent, error_text(known, law.error), law.error_exponent,
                       law.scatters ? " (differences scatter; exponent by theory)"
                       : law.fitted ? ""
                                    : " (exponent by theory, or the end of what is believed)",
                       cheap, std::pow(cheap, law.cost_exponent),
                       two_digits(100 * law.at(cheap) / known.scale)));
    }
    if (known.support_cost != 1)
      line("support", fmt::format("x 0.8 takes {:.2g} of the time and changes it by {}", known.support_cost,
                                  error_text(known, known.support_difference)));
    line("chaos", known.spread > 0 ? fmt::format("two starts that are alike come to differ by {}",
                                                 error_text(known, known.spread))
                                   : "two starts that are alike stay alike");
    line("in words", words(known));
  }

  /// Which knob buys what.
  std::string words(const trade::Known& known) const {
    const trade::Law *dearest = nullptr, *cheapest = nullptr;
    for (const trade::Law& law : known.laws) {
      if (dearest == nullptr || law.error > dearest->error) dearest = &law;
      const trade::Range range = study_.ranges[static_cast<std::size_t>(law.knob)];
      const double x = law.cost_exponent < 0 ? range.most : range.least;
      const bool cheap = law.knob != Knob::spacing && std::pow(x, law.cost_exponent) < 0.9;
      if (cheap && (cheapest == nullptr || law.at(x) < cheapest->at(x))) cheapest = &law;
    }
    if (dearest == nullptr || !(dearest->error > 0))
      return "no setting changes it by as much as two starts that are alike differ";
    std::string text =
        fmt::format("most of the error is that of the {}; half of that part costs {:.2g} times as much",
                    knob_text(dearest->knob),
                    std::pow(std::pow(0.5, 1 / dearest->error_exponent), dearest->cost_exponent));
    if (cheapest != nullptr && cheapest != dearest) {
      const trade::Range range = study_.ranges[static_cast<std::size_t>(cheapest->knob)];
      const double x = cheapest->cost_exponent < 0 ? range.most : range.least;
      text += fmt::format("; turn the {} first: x {:.2g} takes {:.2g} of the time for {} % more",
                          knob_text(cheapest->knob), x, std::pow(x, cheapest->cost_exponent),
                          two_digits(std::max(0.0, 100 * (cheapest->at(x) - cheapest->error) / known.scale)));
    }
    return text;
  }

  void print_front() {
    const trade::Known& known = study_.observables[0];
    fmt::print("\nfront of {}\n{:>9} {:>10} | {:>9} {:>10} | settings\n", known.observable.name, "error",
               "time [s]", "measured", "time [s]");
    for (std::size_t i = 0; i < fronts_[0].size(); ++i) {
      const trade::Choice& c = fronts_[0][i];
      const bool run = tried_[i].has_value();
      fmt::print("{:>7} % {:>10.3g} | {:>9} {:>10} | {}\n", two_digits(100 * c.error / known.scale),
                 c.seconds, run ? two_digits(100 * tried_[i]->error.max / known.scale) + " %" : "-",
                 run ? fmt::format("{:.3g}", tried_[i]->run.wall_s) : "-", tuning_.settings_text(c.knobs));
    }
  }

  void print_choice() {
    const TradeRequest request{*options_.error, study_.observables[0].observable.name,
                               fmt::format("--error {:g}%", 100 * *options_.error), true};
    const trade::Choice choice = choose_settings(tuning_, study_, request);
    const trade::Known& known = study_.observables[0];
    fmt::print("\n");
    line("choice", fmt::format("{} within {}: {}", request.of, error_text(known, choice.asked),
                               tuning_.settings_text(choice.knobs)));
    line("expected",
         fmt::format("error {}, {}", error_text(known, choice.error), about_text(choice.seconds)));
    if (!(choice.seconds < options_.seconds)) return;
    const trade::Measurement run = tuning_.measure(choice.knobs, 3 * options_.seconds);
    if (!run.complete) {
      line("tried", run.problem);
      return;
    }
    const double error = trade::delivered(study_, 0, run.actual, run.values[0]).max;
    line("tried", fmt::format("error {}, {:.3g} s", error_text(known, error), run.wall_s));
    if (const std::string broken = broken_promise_text(known, error, choice.asked); !broken.empty())
      line("warning", broken);
  }

  void write() {
    const RunDirectory directory =
        options_.out.empty() ? new_run_directory(scene_.name + "-trade") : named_run_directory(options_.out);
    std::string csv =
        "observable,unit,error,error_share,rms,seconds,spacing,sound_speed,courant,dt,measured_error,"
        "measured_seconds,particles\n";
    std::vector<FrontSeries> series;
    const char* colors[] = {"#2f62c4", "#d1392b", "#2e9e4f", "#8a5bd6", "#e07b00", "#1f8a8a"};
    for (std::size_t k = 0; k < fronts_.size(); ++k) {
      if (!not_reached(study_, k, tuning_.problem().end).empty()) continue;
      const trade::Known& known = study_.observables[k];
      FrontSeries front{known.observable.name, colors[k % 6], true, {}};
      FrontSeries measured{known.observable.name + ", measured", colors[k % 6], false, {}};
      for (std::size_t i = 0; i < fronts_[k].size(); ++i) {
        const trade::Choice& c = fronts_[k][i];
        const Json settings = tuning_.settings_json(c.knobs);
        const bool run = k == 0 && tried_[i].has_value();
        csv += fmt::format("{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{},{},{}\n",
                           known.observable.name, known.observable.unit, c.error, c.error / known.scale,
                           c.rms, c.seconds, settings.value("spacing", 0.0),
                           settings.value("sound_speed", 0.0), settings.value("courant", 0.0),
                           settings.value("dt", 0.0), run ? fmt::format("{:.6g}", tried_[i]->error.max) : "",
                           run ? fmt::format("{:.6g}", tried_[i]->run.wall_s) : "",
                           run ? fmt::format("{}", tried_[i]->run.particles) : "");
        front.points.push_back({c.seconds, 100 * c.error / known.scale});
        if (run) measured.points.push_back({tried_[i]->run.wall_s, 100 * tried_[i]->error.max / known.scale});
      }
      series.push_back(front);
      if (!measured.points.empty()) series.push_back(measured);
    }
    write_file(directory.file("front.csv"), csv);
    write_file(directory.file("front.svg"),
               front_svg(scene_.name + ": error against time, " + tuning_.device(), "time [s]",
                         "largest error [% of the scale]", series));
    Json json = study_json(study_);
    json["scene"] = scene_.name;
    json["device"] = tuning_.device();
    write_file(directory.file("trade.json"), json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
    fmt::print("\nwrote {0}/front.csv, {0}/front.svg and {0}/trade.json\n", directory.path);
  }

  const Scene& scene_;
  const TradeOptions& options_;
  Tuning tuning_;
  trade::Study study_;
  std::vector<std::vector<trade::Choice>> fronts_;
  std::vector<std::optional<Tried>> tried_;
};

}  // namespace

namespace {

/// ensemble.json: what the table holds, and the curves.
void write_ensemble(const Tuning& tuning, const std::vector<trade::Measurement>& runs,
                    const std::vector<trade::Mean>& means, const std::string& out) {
  const RunDirectory directory = named_run_directory(out);
  Json json;
  json["device"] = tuning.device();
  json["times"] = tuning.sample_times();
  for (std::size_t k = 0; k < means.size(); ++k) {
    const trade::Observable& o = tuning.problem().observables[k];
    json["observables"][o.name] = {
        {"unit", o.unit},          {"scale", o.scale},          {"runs", means[k].runs},
        {"mean", means[k].values}, {"spread", means[k].spread}, {"error", means[k].error}};
    if (!o.exact.empty()) json["observables"][o.name]["exact"] = o.exact;
  }
  for (const trade::Measurement& run : runs)
    json["runs"].push_back({{"wall_s", run.wall_s},
                            {"work", run.work},
                            {"substeps", run.substeps},
                            {"particles", run.particles},
                            {"complete", run.complete},
                            {"problem", run.problem},
                            {"values", run.values}});
  write_file(directory.file("ensemble.json"),
             json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
  fmt::print("wrote {}/ensemble.json\n", directory.path);
}

/// Means over starts that are alike, with the scene's own settings.
int print_ensemble(const Scene& scene, const TradeOptions& options) {
  Tuning tuning(scene, options.machine, options.observe, "--observe");
  std::vector<trade::Measurement> runs;
  double seconds = 0;
  for (int n = 0; n < *options.ensemble; ++n) {
    trade::Knobs knobs;
    knobs.stir = n;
    runs.push_back(tuning.measure(knobs, meltsim::infinity));
    seconds += runs.back().wall_s;
  }
  const std::vector<trade::Observable>& observables = tuning.problem().observables;
  const std::vector<trade::Mean> means = expect(trade::average(observables, runs));
  fmt::print("{}: {} starts that differ by 0.0001 of gravity each, {:.3g} s\n{:<20} {:>12} {:>12} {:>14}\n",
             scene.name, *options.ensemble, seconds, "observable", "mean", "one run", "mean known to");
  for (std::size_t k = 0; k < means.size(); ++k) {
    const trade::Observable& o = observables[k];
    const std::string unit = o.unit.empty() ? "" : " " + o.unit;
    fmt::print("{:<20} {:>12} {:>12} {:>14}{}\n", o.name,
               means[k].values.empty() ? "-" : fmt::format("{:.4g}{}", means[k].values.back(), unit),
               fmt::format("+-{:.2g}{}", means[k].spread, unit),
               fmt::format("+-{:.2g}{}", means[k].error, unit),
               means[k].runs < *options.ensemble ? fmt::format(" ({} of them ended)", means[k].runs) : "");
  }
  fmt::print("means of curves are those at the end; spreads are the largest over the run\n");
  if (!options.out.empty()) write_ensemble(tuning, runs, means, options.out);
  return 0;
}

}  // namespace

int cmd_trade(const TradeOptions& options) {
  if (!options.out.empty()) refuse_existing(options.out, "name another directory");
  Scene scene = load_scene(options.scene);
  if (options.time) scene.time.end = *options.time;
  return options.ensemble ? print_ensemble(scene, options) : Trade(scene, options).run();
}

}  // namespace runner
