// SPDX-License-Identifier: Apache-2.0
#include "frame_budget.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "expect.hpp"
#include "failure.hpp"
#include "files.hpp"
#include "trade_watch.hpp"

namespace runner {

namespace trade = meltsim::trade;

namespace {

// Settings are chosen for this share of the budget: costs differ between frames, and a frame that is late is worse than one
// that is quick.
constexpr double share_to_plan = 0.8;
// A frame counts as within its budget up to here.
constexpr double tolerance = 1.05;
// Sub-steps of the scene are timed for so long.
constexpr double timing_ms = 200;
// Settings that are timed before a run.
constexpr int most_tries = 5;

/// What a frame of the scene, and a sub-step of it, take on this machine as it begins.
FrameCost frame_cost(const Scene& scene, const MachineOptions& machine) {
  Built built = build_world(scene, machine);
  const double frame = 1 / scene.time.fps;
  expect(built.world.step_part(frame, 1));  // allocates and records
  const meltsim::TimedStep timed = expect(built.world.step_within(frame, timing_ms));
  if (timed.substeps == 0) return {};
  const double steps = scene.time.dt ? std::max(1.0, std::ceil(frame / *scene.time.dt - 1e-6)) : 1;
  const double planned = std::max(static_cast<double>(timed.planned), steps);
  const double each = timed.wall_ms / static_cast<double>(timed.substeps);
  return {each * planned, each};
}

}  // namespace

const trade::Known& first_that_changes(const trade::Study& study) {
  for (const trade::Known& known : study.observables)
    for (const trade::Law& law : known.laws)
      if (law.error > 0 && std::isfinite(law.error)) return known;
  return study.observables.front();
}

FitToBudget most_exact_within(double milliseconds, double frames, const std::vector<trade::Choice>& front,
                              const std::function<FrameCost(const trade::Knobs&)>& time) {
  const double wanted = share_to_plan * milliseconds;
  const auto dearest_within = [&](double seconds) {
    trade::Choice best = front.front();
    for (const trade::Choice& c : front)
      if (c.seconds <= seconds) best = c;
    return best;
  };
  FitToBudget fit;
  fit.choice = dearest_within(frames * wanted / 1000);
  for (int tries = 0;;) {
    fit.cost = time(fit.choice.knobs);
    const trade::Choice cheaper =
        dearest_within(fit.choice.seconds * std::min(0.95, wanted / fit.cost.frame_ms));
    const bool cheapest = cheaper.knobs.value == fit.choice.knobs.value;
    if (fit.cost.frame_ms <= milliseconds || cheapest || ++tries == most_tries) return fit;
    fit.choice = cheaper;
  }
}

FrameBudget FrameBudget::repeating(const std::string& directory) {
  const std::string file = directory + "/run.json";
  const auto fail = [&](const std::string& why) {
    return Failure(ExitCode::usage, fmt::format("--repeat {}: {}", directory, why));
  };
  if (!std::filesystem::exists(file))
    throw fail("no run.json is there; name the directory of a run under --budget");
  const Json json = Json::parse(read_file(file), nullptr, false);
  if (!json.is_object() || !json.contains("budget"))
    throw fail("its run.json is not of a run under --budget; name the directory of one");
  try {
    const Json& budget = json.at("budget");
    FrameBudget again(budget.at("milliseconds").get<double>());
    again.repeats_ = true;
    again.substeps_ = budget.at("substeps").get<std::vector<std::uint64_t>>();
    again.settings_ = budget.value("settings", Json());
    const Json& time = json.at("scene").at("time");
    again.fps_ = time.at("fps").get<double>();
    again.end_ = time.at("end").get<double>();
    return again;
  } catch (const Json::exception& error) {
    throw fail(fmt::format("its run.json is damaged: {}", error.what()));
  }
}

void FrameBudget::set_times(SceneTime& time, const RunOptions& options) const {
  time.fps = fps_;
  time.end = end_;
  if (options.time) time.end = std::min(end_, *options.time);
  if (options.frames) time.end = std::min(end_, static_cast<double>(*options.frames) / fps_);
}

void FrameBudget::choose(Scene& scene, const RunOptions& options, Log& log) {
  FrameCost cost = frame_cost(scene, options.machine);
  expected_ms_ = cost.frame_ms;
  const auto say = [&](const std::string& what, const char* when) {
    log.info("chosen for the budget: " + what);
    // Sub-steps are whole, and a frame has one at least, however long that takes.
    if (cost.substep_ms > 0) {
      const double planned = std::max(1.0, std::round(expected_ms_ / cost.substep_ms));
      const double fit = std::max(1.0, std::floor(milliseconds_ / cost.substep_ms));
      expected_share_ = std::min(planned, fit) / planned;
    }
    const std::string lost =
        expected_share_ < 1
            ? fmt::format("{:.2g} s of every second will not be simulated", 1 - expected_share_)
            : "";
    if (cost.substep_ms > milliseconds_)
      log.warn(
          fmt::format("expected: one sub-step takes {:.3g} ms, more than the budget of {:g} ms; every frame "
                      "will have one and be late{}{}; ask for a longer budget or coarser settings (--scale)",
                      cost.substep_ms, milliseconds_, lost.empty() ? "" : ", and ", lost));
    else if (expected_share_ < 1)
      log.warn(fmt::format("expected: {:.3g} ms of computing a frame{}, more than the budget of {:g} ms; {}",
                           expected_ms_, when, milliseconds_, lost));
    else
      log.info(fmt::format("expected: {:.3g} ms of computing a frame{}, of {:g} ms", expected_ms_, when,
                           milliseconds_));
  };
  const double wanted = share_to_plan * milliseconds_;
  const char* at_start = " as the scene begins";
  if (expected_ms_ <= wanted) return say("the scene's own settings", at_start);
  log.info(
      fmt::format("the scene's own settings take {:.3g} ms of computing a frame; looking for cheaper ones: "
                  "probes of at most {:g} s",
                  expected_ms_, options.time_limit));
  try {
    Tuning tuning(scene, options.machine, {}, "--budget");
    tuning.observe_too(
        "energy");  // the others may stand still for as long as it runs: nothing has begun to melt
    TuneOptions tune;
    tune.seconds = options.time_limit;
    tune.cache = options.cache;
    const trade::Study study = tuning.study(tune);
    const trade::Known& known = first_that_changes(study);
    const std::string of = known.observable.name;
    const double frames = std::max(1.0, scene.time.end * scene.time.fps);
    const FitToBudget fit = most_exact_within(
        milliseconds_, frames, expect(trade::front(study, of, 24)),
        [&](const trade::Knobs& knobs) { return frame_cost(tuning.with(knobs), options.machine); });
    const trade::Choice& best = fit.choice;
    cost = fit.cost;
    scene = tuning.with(best.knobs);
    settings_ = tuning.settings_json(best.knobs);
    // A frame as the scene begins is timed; the laws have seen the flow that comes of it, which may ask for shorter steps.
    expected_ms_ = std::max(cost.frame_ms, 1000 * best.seconds / frames);
    say(fmt::format("{}; error of {} {}", tuning.settings_text(best.knobs), of,
                    error_text(known, best.error)),
        "");
  } catch (const Failure& failure) {
    log.warn(fmt::format("no other settings were found: {}", failure.what()));
    say("the scene's own settings", at_start);
  }
}

FrameBudget::Taken FrameBudget::take(meltsim::World& world, std::uint64_t frame, double span, double dt) {
  const auto index = static_cast<std::size_t>(frame - 1);
  std::uint64_t again = repeats_ && index < substeps_.size() ? substeps_[index] : 0;
  Taken taken;
  double wall = 0, each = 0;
  const auto steps = static_cast<int>(std::round(span / dt));
  int whole = 0;
  for (; whole < steps; ++whole) {
    const double left = milliseconds_ - wall, before = world.time();
    if (repeats_ ? again == 0 : whole > 0 && !(left > each)) break;
    const meltsim::Result<meltsim::TimedStep> r =
        repeats_ ? world.step_part(dt, again) : world.step_within(dt, left);
    if (!r) {
      taken.simulated += world.time() - before;
      taken.status = r.error();
      break;
    }
    taken.simulated += r->simulated;
    wall += r->wall_ms;
    each = r->substep_ms;
    again -= std::min(again, r->substeps);
    if (r->owed > 0) break;
  }
  taken.owed = whole < steps ? span - taken.simulated : 0;
  if (!repeats_) wall_ms_.push_back(wall);
  return taken;
}

std::uint64_t FrameBudget::frames(std::uint64_t planned) const {
  return repeats_ ? std::min<std::uint64_t>(planned, substeps_.size()) : planned;
}

std::string FrameBudget::report(double owed, double end) const {
  const std::string simulated = fmt::format("{:.4g} of {:.4g} s simulated", end - owed, end);
  if (repeats_) return fmt::format("repeated: sub-steps as recorded; {}", simulated);
  const auto within = std::count_if(wall_ms_.begin(), wall_ms_.end(),
                                    [this](double ms) { return ms <= tolerance * milliseconds_; });
  const double sum = std::accumulate(wall_ms_.begin(), wall_ms_.end(), 0.0);
  const double most = wall_ms_.empty() ? 0 : *std::max_element(wall_ms_.begin(), wall_ms_.end());
  return fmt::format(
      "budget: {} of {} frames within {:g} ms ({:g} times at most), mean {:.3g} ms, longest {:.3g} ms; {}",
      within, wall_ms_.size(), milliseconds_, tolerance,
      sum / std::max<double>(1, static_cast<double>(wall_ms_.size())), most, simulated);
}

Json FrameBudget::json(const std::vector<std::uint64_t>& substeps, double owed) const {
  Json json;
  json["milliseconds"] = milliseconds_;
  json["repeated"] = repeats_;
  if (!settings_.is_null()) json["settings"] = settings_;
  if (!repeats_ && expected_ms_ > 0)
    json["expected"] = {{"frame_ms", expected_ms_}, {"share", expected_share_}};
  json["substeps"] = substeps;
  json["not_simulated_s"] = owed;
  if (!wall_ms_.empty()) {
    json["frame_ms"] = wall_ms_;
    json["frames_within"] = std::count_if(wall_ms_.begin(), wall_ms_.end(),
                                          [this](double ms) { return ms <= tolerance * milliseconds_; });
  }
  return json;
}

}  // namespace runner
