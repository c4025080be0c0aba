// SPDX-License-Identifier: Apache-2.0
// Speed for accuracy: a few short runs of a problem tell what each setting costs and what error it makes in the
// quantities that matter; from these laws follow settings for an error asked for. docs/trade.md has the method.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "meltsim/export.hpp"
#include "meltsim/result.hpp"
#include "meltsim/types.hpp"
#include "meltsim/world.hpp"

namespace meltsim {
inline namespace v0 {
namespace trade {
/// A setting that trades accuracy for speed.
enum class Knob {
  spacing,      ///< of the particles; the support keeps its ratio to it
  sound_speed,  ///< compressibility falls with its square, the time step with it
  courant,      ///< length of a sub-step over the time that sound takes through a support radius
  step,         ///< longest step, where it is shorter than what sound and motion allow
  support       ///< over the spacing; compared, never chosen
};
inline constexpr std::size_t knob_count = 5;  ///< number of knobs

/// "spacing", "sound_speed", ...
MELTSIM_API const char* knob_name(Knob knob);

/// Settings as multiples of those of the problem: 1 = as the problem has it.
struct Knobs {
  std::array<double, knob_count> value{1, 1, 1, 1, 1};  ///< in the order of Knob
  int stir = 0;  ///< 0: none; n: the n-th start that differs by less than what any observable resolves

  double& operator[](Knob knob) { return value[static_cast<std::size_t>(knob)]; }       ///< its multiple
  double operator[](Knob knob) const { return value[static_cast<std::size_t>(knob)]; }  ///< its multiple
};

/// Multiples that a knob may have. A knob whose ends are equal is left alone.
struct Range {
  double least = 1, most = 1;  ///< smallest and largest multiple
};
using Ranges = std::array<Range, knob_count>;  ///< in the order of Knob

/// Spacing 0.25 to 4, sound speed 0.3 to 2, Courant number 0.5 to 1.5, the others 1.
MELTSIM_API Ranges default_ranges();

/// How the samples of an observable are reduced before they are compared.
enum class Reduce {
  curve,         ///< all of them
  last,          ///< the last one
  largest,       ///< the largest one
  late_mean,     ///< the mean of the second half, where an oscillation's phase does not matter
  time_to_reach  ///< when they first reach Observable::level, between samples linearly [s]; NaN: never
};

/// A number or a curve over time by which a simulation is judged.
struct Observable {
  std::string name;  ///< for messages and choices
  std::string unit;  ///< "m", "degrees", or empty
  double scale =
      0;  ///< [unit] that an error of 1 refers to; 0: the range of the curve, the magnitude of a number
  int components = 1;             ///< values per sample; errors are Euclidean distances
  Reduce reduce = Reduce::curve;  ///< what is compared
  double level = 0;               ///< of time_to_reach
  /// What is compared (`reduce`) of the exact answer, as many values as of a probe: samples and the start of a curve. NaN: none there. Empty: none
  /// is known.
  std::vector<double> exact;
  double order =
      2;  ///< at which its error falls with the spacing: 1 of fronts of melting, 2 inside; probes that say more are not believed
};

/// The result of one probe.
struct Measurement {
  Knobs knobs;  ///< as asked for
  Knobs
      actual;  ///< as built, read from the World: a spacing that has to fit a domain differs from the one asked for
  /// Per observable, what is compared: samples x components, or one number.
  std::vector<std::vector<double>> values;
  double work = 0;              ///< sub-steps x particles, weighted; see work_of_substep
  double wall_s = 0;            ///< on this machine
  std::uint64_t substeps = 0;   ///< sub-steps taken
  std::uint64_t particles = 0;  ///< the most there were
  std::uint64_t bytes = 0;      ///< memory of the World
  bool complete = true;         ///< false: it diverged or took too long, and `values` are of no use
  std::string problem;          ///< why not complete
};

/// A simulation whose settings are to be chosen.
struct Problem {
  /// Makes the World. Refusals (a domain too small for the support) are Errors. Spacings that it is asked for fit nothing: move each to one that what is in
  /// the scene is a whole number of (docs/trade.md), or errors are those of missing layers, which follow no law. What is left derived in
  /// the problem has to be set to turn it: World::resolved() of one that was built with Knobs{} says the sound speed.
  std::function<Result<World>(const Knobs&)> build;
  /// Appends the values of all observables, in their order, as the World is now. May synchronise.
  std::function<Status(World&, std::vector<double>&)> observe;
  /// Whether nothing more will change; the remaining samples repeat the last one. May be empty.
  std::function<bool(const std::vector<double>&)> finished;
  double end = 0;                         ///< [s]
  int samples = 50;                       ///< of the observables, evenly spaced; the start is one more
  double longest_step = infinity;         ///< [s] at Knob::step = 1
  double longest_sample_step = infinity;  ///< [s] that no step exceeds whatever the knobs
  /// [m^2/s], the largest there is times HeatDesc::time_scale: the cost of heat where nothing moves. 0: no heat.
  double diffusivity = 0;
  std::vector<Observable> observables;  ///< in the order of `observe`
  Ranges ranges = default_ranges();     ///< multiples that are allowed
  /// Runs a probe in place of build and observe, for at most so many wall seconds. May be empty.
  std::function<Result<Measurement>(const Knobs&, double)> run;
  double reference_work =
      0;  ///< work of Knobs{}; 0: found by building it, or without `build` from the probes
};
/// Limits of a study.
struct Options {
  /// What all probes together are planned for, by a nominal speed, so that plans repeat; they are broken off after twice as much.
  double seconds = 60;
  int probes = 15;       ///< at most
  double safety = 1.5;   ///< of Study::safety
  double finest = 0.6;   ///< spacing of the finest probe at least, as a multiple
  bool support = false;  ///< also compare a support of 0.8 times the problem's
  /// Called after each probe, with the number of probes planned. May be empty; false ends the study.
  std::function<bool(const Measurement&, int)> progress;
};

/// Largest and root-mean-square difference over the samples, in the observable's unit.
struct Difference {
  double max = 0, rms = 0;  ///< largest; root-mean-square
};

/// A knob's part of the error and of the cost: error(x) = error x^error_exponent, work(x) ~ x^cost_exponent, where x is
/// the knob's multiple.
struct Law {
  Knob knob = Knob::spacing;  ///< whose law it is
  double cost_exponent = 0;   ///< of the work
  double error = 0;           ///< at x = 1, in the unit
  double error_exponent = 1;  ///< of the error
  bool fitted =
      false;  ///< the exponent was measured; false: it is the nominal one, and the error the larger estimate
  /// Curves of three values of the knob turn back and forth, or differences between them do not fall as any exponent says, as where particles happen to
  /// lie otherwise: the exponent is the nominal one, and the error of the worst value as large as the largest difference between any two. Where
  /// curves go on the same way and differences hardly fall, the approach is slow: the exponent is the least that is believed.
  bool scatters = false;
  MELTSIM_API double at(double x) const;  ///< the error at this multiple, in the unit
  /// Whether two values of the knob could be compared. If not, choices leave it as it is, and errors do not count what it does.
  bool measured() const { return cost_exponent != 0 || error > 0; }
};

/// Results of a study for one observable.
struct Known {
  Observable observable;      ///< what it is about
  double scale = 1;           ///< in the unit; never 0
  std::vector<Law> laws;      ///< of the knobs that matter
  double spread = 0;          ///< largest difference between two starts that are alike, in the unit
  std::vector<double> limit;  ///< extrapolated, or exact
  double rms_share = 1;       ///< root-mean-square over largest difference
  double support_difference = 0, support_cost = 1;  ///< of 0.8 times the support, if compared
};

/// All that a front or a choice follows from; measuring it takes the time, using it takes none.
struct Study {
  std::vector<Known> observables;    ///< in the order of the problem
  std::vector<Measurement> probes;   ///< in the order run
  Ranges ranges{};                   ///< of the problem
  double reference_work = 0;         ///< work of Knobs{}
  double seconds_per_work = 0;       ///< on this machine
  double wall_s = 0;                 ///< time that it took [s]
  bool cut_short = false;            ///< wall time ran out, so another study may differ
  std::vector<std::string> notes;    ///< probes that diverged, and what follows
  double safety = Options{}.safety;  ///< a setting is chosen for the error asked for over this
};

/// Settings with their expected error and cost.
struct Choice {
  Knobs knobs;             ///< the settings
  double error = 0;        ///< expected largest error, in the unit
  double rms = 0;          ///< expected root-mean-square error
  double asked = 0;        ///< in the unit
  double work = 0;         ///< expected
  double seconds = 0;      ///< expected on this machine
  bool attainable = true;  ///< false: knobs, error and seconds are those of the smallest error there is
  bool chaotic = false;    ///< two starts that are alike differ by more than what was asked for
};

/// Work of one sub-step: (particles + those that a device computes in the same time as none) x (support / 2.5 spacings)^3
/// x (1 + 0.35 x sweeps of heat). A model, so that plans and choices do not depend on the clock.
MELTSIM_API double work_of_substep(double particles, double support_over_spacing, double heat_sweeps,
                                   Backend backend);

/// The difference of two observables' values as compared. NaN against NaN is none, NaN against a number is the scale.
MELTSIM_API Difference difference(const Observable& observable, double scale, const std::vector<double>& a,
                                  const std::vector<double>& b);

/// Reduces samples (samples x components, times ascending) to the values that are compared.
MELTSIM_API std::vector<double> reduce(const Observable& observable, const std::vector<double>& times,
                                       const std::vector<double>& values);

/// Runs one probe. Errors: invalid_argument (names the field), those of build and observe, interrupted (World::interrupt() of its World). A run that
/// diverges, or passes `wall_limit` [s], is a Measurement that is not complete.
MELTSIM_API Result<Measurement> measure(const Problem& problem, const Knobs& knobs,
                                        double wall_limit = infinity);

/// Probes: three spacings, and a run or two for each other knob, at most Options::probes. Errors: invalid_argument (names the
/// field; a problem whose coarsest probe takes longer than allowed), those of build and observe at the first probe, interrupted
/// (by Options::progress, or World::interrupt() of a probe's World).
MELTSIM_API Result<Study> study(const Problem& problem, const Options& options = {});

/// The cheapest settings whose expected error, `safety` times, is `error` (a share of the observable's scale); automatic: Study::safety. Errors:
/// invalid_argument (an observable the study does not have, or that had no value in any probe; an error that is not above 0).
MELTSIM_API Result<Choice> choose(const Study& study, const std::string& observable, double error,
                                  double safety = automatic);

/// The settings with the smallest expected error whose run takes at most so many seconds on this machine (Study::seconds_per_work): of a
/// budget per frame, the budget times the frames of the run. Choice::asked is what is expected; not attainable: even the cheapest
/// settings, which it has then, take longer. Errors: those of choose(), invalid_argument (seconds that are not above 0; a study whose
/// probes took no time).
MELTSIM_API Result<Choice> choose_within(const Study& study, const std::string& observable, double seconds);

/// `points` choices from the coarsest settings to the smallest attainable error, evenly spaced in its logarithm; fewer where
/// several of them have the same settings.
MELTSIM_API Result<std::vector<Choice>> front(const Study& study, const std::string& observable, int points);

/// Error of a run with these knobs that gave these values: by its own difference to a probe, as if knobs erred independently. Infinite where
/// that says nothing: an observable that the study does not have or that had no value, another number of values.
MELTSIM_API Difference delivered(const Study& study, std::size_t observable, const Knobs& actual,
                                 const std::vector<double>& values);

/// Mean and spread of one observable over runs whose starts are alike. Where single runs are chaotic, only means converge.
struct Mean {
  std::vector<double>
      values;         ///< as compared; the mean over the runs. NaN where fewer than two of them have a number
  double spread = 0;  ///< standard deviation of one run: the largest over the values, in the unit
  double error = 0;   ///< standard error of the mean: spread / root of the number of runs, in the unit
  int runs = 0;       ///< how many count: complete ones
};

/// Means over measurements that differ in their start alone, per observable. Those that are not complete do not count. Error:
/// invalid_argument where fewer than two are complete, or values are of different number.
MELTSIM_API Result<std::vector<Mean>> average(const std::vector<Observable>& observables,
                                              const std::vector<Measurement>& runs);

/// Runs the problem `runs` times, at least twice, with Knobs::stir 0 to runs - 1, and averages. `members`: what came of each, if
/// not null. `progress` is called after each, with the number of runs; may be empty; false ends it. Errors: those of measure() and of
/// average(), interrupted.
MELTSIM_API Result<std::vector<Mean>> ensemble(
    const Problem& problem, const Knobs& knobs, int runs, std::vector<Measurement>* members = nullptr,
    const std::function<bool(const Measurement&, int)>& progress = {});

}  // namespace trade
}  // namespace v0
}  // namespace meltsim
