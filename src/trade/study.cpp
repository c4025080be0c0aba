// SPDX-License-Identifier: Apache-2.0
// Which probes are run, and the laws that come of them.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "engine/text.hpp"
#include "meltsim/trade.hpp"
#include "trade/check.hpp"
#include "trade/fit.hpp"
#include "trade/measure.hpp"
#include "world/guarded.hpp"

namespace meltsim {
inline namespace v0 {
namespace trade {

namespace {

using Clock = std::chrono::steady_clock;

// Spacings of probes follow each other by this factor, or by less where coarse ones are not possible.
constexpr double ladder = 1.3, least_ladder = 1.08;
// Work of all probes over that of the finest: 1, four or five at 1/1.3^4 of it, one at 1/1.3^8, and a choice to be tried.
constexpr double probes_worth = 3.5;
// Work per second that probes are planned by: of a CPU's thread (so many of them count), of a GPU.
constexpr double work_per_second_cpu = 1.0e6, work_per_second_cuda = 2e8;
// Probes that take so many times what was planned are broken off.
constexpr double patience = 2;
constexpr double smallest_scale = 1e-300;

Error invalid(const std::string& message) { return {ErrorCode::invalid_argument, message}; }

/// Probes that differ from the middle spacing's in one knob.
struct Group {
  Knob knob;
  std::vector<std::size_t> probes;
};

class Studying {
 public:
  Studying(const Problem& problem, const Options& options) : problem_(problem), options_(options) {}

  Result<Study> run() && {
    if (const Status ready = refer(); !ready) return ready.error();
    study_.ranges = problem_.ranges;
    if (const Status planned = choose_spacings(); !planned) return planned.error();
    plan();
    for (std::size_t i = 0; i < planned_.size() && !stopped_; ++i)
      if (const Status done = probe(planned_[i], i == 0); !done) return done.error();
    if (stopped_) return Error{ErrorCode::interrupted, "study: stopped by Options::progress"};
    if (turns(Knob::spacing) && twins(Knob::spacing, 0).size() < 2)
      return invalid("seconds: no two spacings could be probed" +
                     (study_.notes.empty() ? std::string() : " (" + study_.notes.front() + ")") +
                     "; raise the time limit, or shorten the run");
    narrow_ranges();
    for (std::size_t k = 0; k < problem_.observables.size(); ++k) know(k);
    rate();
    study_.wall_s = elapsed();
    return std::move(study_);
  }

 private:
  double elapsed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  /// The problem as it is: its settings and its work.
  Status refer() {
    if (const Status s = check_names(problem_.observables); !s) return s;
    if (const Status s = check(problem_); !s) return s;
    if (const Status s = check(options_); !s) return s;
    study_.safety = options_.safety;
    study_.reference_work = problem_.reference_work;
    if (problem_.run && (problem_.reference_work > 0 || !problem_.build)) return {};
    Result<World> world = problem_.build(Knobs{});
    if (!world) return world.error();
    if (const Status ready = world->prepare(); !ready) return ready.error();
    reference_ = reference_of(*world);
    backend_ = world->backend();
    threads_ = std::max(1, world->desc().threads > 0 ? world->desc().threads : build_info().cpu_threads);
    const StepResult now = world->synchronize();
    const double longest = std::min({world->stable_dt(), problem_.longest_step, problem_.longest_sample_step,
                                     problem_.end / std::max(1, problem_.samples)});
    study_.reference_work =
        std::ceil(problem_.end / longest) *
        work_of_substep(*world, static_cast<double>(now.fluid + now.solid), longest, problem_.diffusivity);
    return {};
  }

  double work_per_second() const {
    return backend_ == Backend::cuda ? work_per_second_cuda : work_per_second_cpu * std::min(threads_, 16);
  }

  const Range& range(Knob knob) const { return problem_.ranges[static_cast<std::size_t>(knob)]; }
  bool turns(Knob knob) const { return range(knob).most > range(knob).least * 1.01; }

  Status choose_spacings() {
    const Range& allowed = range(Knob::spacing);
    if (!turns(Knob::spacing)) {
      middle_ = coarse_ = fine_ = 1;
      return {};
    }
    const double budget = options_.seconds * work_per_second();
    // Particles grow with the third power of 1 / spacing, sub-steps with the first.
    fine_ = std::max(
        {options_.finest, allowed.least, std::pow(probes_worth * study_.reference_work / budget, 0.25)});
    double factor = ladder;
    if (fine_ * factor * factor > allowed.most)
      factor = std::max(least_ladder, std::sqrt(allowed.most / fine_));
    fine_ = std::min(fine_, allowed.most / (factor * factor));
    const double seconds = probes_worth * study_.reference_work / std::pow(fine_, 4) / work_per_second();
    if (seconds > 4 * options_.seconds)
      return invalid("seconds: the coarsest probes of this scene take about " + number(seconds) +
                     " s, more than " + number(options_.seconds) +
                     " s; raise the time limit, or shorten the run");
    middle_ = fine_ * factor;
    coarse_ = middle_ * factor;
    if (!problem_.run) tell_apart();
    return {};
  }

  /// The spacing that the problem makes of a multiple, as a multiple: it may move it to fit what is in the scene.
  double as_built(double multiple) const {
    Knobs knobs;
    knobs[Knob::spacing] = multiple;
    const Result<World> world = problem_.build(knobs);
    return world ? world->desc().spacing / reference_.spacing : multiple;
  }

  /// Makes the finer probes finer until three spacings are built as three: where coarse ones are not possible they lie close to each
  /// other, and may all be moved to the same.
  void tell_apart() {
    constexpr double finer = 1.04, apart = 1.06;
    constexpr int most_tries = 6;
    const auto below = [&](double& spacing, double above) {
      double built = as_built(spacing);
      for (int i = 0;
           i < most_tries && built * apart > above && spacing / finer >= range(Knob::spacing).least; ++i)
        built = as_built(spacing /= finer);
      return built;
    };
    const double middle = below(middle_, as_built(coarse_));
    fine_ = std::min(fine_, middle_ / finer);
    below(fine_, middle);
  }

  /// The most informative probes first, so that a time limit drops the others.
  void plan() {
    add({}, Knob::spacing);
    if (coarse_ > middle_) add({{Knob::spacing, coarse_}}, Knob::spacing);
    const bool sound = turns(Knob::sound_speed), courant = turns(Knob::courant), step = turns(Knob::step);
    if (sound) twin(Knob::sound_speed, std::max(0.5, range(Knob::sound_speed).least));
    if (courant) twin(Knob::courant, range(Knob::courant).most);
    if (step) twin(Knob::step, range(Knob::step).most >= 1.9 ? 2 : std::max(0.5, range(Knob::step).least));
    add({}, Knob::spacing, 1);
    if (fine_ < middle_) add({{Knob::spacing, fine_}}, Knob::spacing);
    if (sound) twin(Knob::sound_speed, range(Knob::sound_speed).least);
    if (step) twin(Knob::step, range(Knob::step).most >= 3.9 ? 4 : std::max(0.25, range(Knob::step).least));
    if (options_.support) twin(Knob::support, 0.8);
    if (planned_.size() > static_cast<std::size_t>(options_.probes))
      planned_.resize(static_cast<std::size_t>(options_.probes));
  }

  struct Planned {
    Knobs knobs;
    Knob of;
  };

  void add(const std::vector<std::pair<Knob, double>>& values, Knob of, int stir = 0) {
    Planned planned{{}, of};
    planned.knobs[Knob::spacing] = middle_;
    for (const auto& [knob, value] : values) planned.knobs[knob] = value;
    planned.knobs.stir = stir;
    for (const Planned& other : planned_)
      if (other.knobs.value == planned.knobs.value && other.knobs.stir == stir) return;
    planned_.push_back(planned);
  }
  void twin(Knob knob, double value) { add({{knob, value}}, knob); }

  Status probe(const Planned& planned, bool first) {
    const double left = patience * options_.seconds - elapsed();
    if (!first && left <= 0) {
      study_.cut_short = true;
      return {};
    }
    Result<Measurement> result =
        measure_from(problem_, planned.knobs, first ? patience * options_.seconds : left,
                     problem_.run ? nullptr : &reference_);
    if (!result && (first || result.error().code == ErrorCode::interrupted)) return result.error();
    if (!result) {
      study_.notes.push_back(text(planned, "gave no result: " + result.error().message));
      return {};
    }
    if (!result->complete && result->problem.empty())
      result->problem = "it is not complete, and says not why";
    if (result->complete && result->values.size() != problem_.observables.size())
      return invalid("Problem::run: expected the values of " + std::to_string(problem_.observables.size()) +
                     " observables, got " + std::to_string(result->values.size()));
    if (const Status s = check_exact(problem_, *result); result->complete && !s) return s;
    if (!result->complete) {
      if (first && result->problem == too_long)
        return invalid("seconds: the first probe took longer than " + number(patience * options_.seconds) +
                       " s; raise the time limit, or shorten the run");
      if (first)
        return Error{ErrorCode::halted, "the probe at " + what(planned) + " failed: " + result->problem +
                                            "; it has the problem's own settings otherwise: a larger sound "
                                            "speed, or a smaller Courant number, may hold"};
      study_.notes.push_back(text(planned, result->problem));
      if (elapsed() > patience * options_.seconds) study_.cut_short = true;
      failed_.push_back(planned);
    }
    stopped_ = options_.progress && !options_.progress(*result, static_cast<int>(planned_.size()));
    groups_.push_back(planned.of);
    study_.probes.push_back(std::move(*result));
    return {};
  }

  /// Three significant digits.
  static std::string number(double value) {
    const bool few = value < 999.5;
    return core::number_text(value, few ? std::chars_format::general : std::chars_format::fixed, few ? 3 : 0);
  }
  std::string what(const Planned& planned) const {
    return std::string(knob_name(planned.of)) + " x " + number(planned.knobs[planned.of]);
  }
  std::string text(const Planned& planned, const std::string& why) const {
    return "probe with " + what(planned) + ": " + why;
  }

  /// Diverged settings are not chosen, nor settings beyond them; knobs without a twin stay as they are.
  void narrow_ranges() {
    for (const Knob knob : {Knob::sound_speed, Knob::courant, Knob::step})
      if (turns(knob) && twins(knob, 0).size() < 2) {
        study_.ranges[static_cast<std::size_t>(knob)] = {1, 1};
        study_.notes.push_back(
            std::string(knob_name(knob)) +
            ": no two values of it could be compared, so it stays as it is, and what is said of errors "
            "does not count what it does");
      }
    for (const Planned& planned : failed_) {
      Range& range = study_.ranges[static_cast<std::size_t>(planned.of)];
      const double x = planned.knobs[planned.of];
      if (planned.of == Knob::spacing) range.most = std::min(range.most, middle_);
      else if (x < 1) range.least = std::max(range.least, std::sqrt(x));
      else range.most = std::min(range.most, std::sqrt(x));
    }
    if (!turns(Knob::spacing)) return;
    // Laws are not applied beyond a factor 4 of the probed range.
    Range& spacing = study_.ranges[static_cast<std::size_t>(Knob::spacing)];
    spacing.least = std::max(spacing.least, fine_ / 4);
    spacing.most = std::min(spacing.most, coarse_);
  }

  const Measurement* good(std::size_t i) const {
    return study_.probes[i].complete ? &study_.probes[i] : nullptr;
  }

  std::vector<Twin> twins(Knob knob, std::size_t k) const {
    std::vector<Twin> list;
    for (std::size_t i = 0; i < study_.probes.size(); ++i) {
      const Measurement* m = good(i);
      if (m == nullptr || m->knobs.stir != 0 || !(i == 0 || groups_[i] == knob)) continue;
      list.push_back({m->actual[knob], m->work, &m->values[k]});
    }
    return list;
  }

  void know(std::size_t k) {
    Known known;
    known.observable = problem_.observables[k];
    const Observable& o = known.observable;
    const std::vector<double>& base = study_.probes[0].values[k];
    known.scale = scale_of(o, base);
    for (std::size_t i = 1; i < study_.probes.size(); ++i)
      if (const Measurement* m = good(i); m != nullptr && m->knobs.stir != 0)
        known.spread = std::max(known.spread, difference(o, known.scale, base, m->values[k]).max);
    double others = 0;
    for (const Knob knob : {Knob::sound_speed, Knob::courant, Knob::step}) {
      if (!turns(knob)) continue;
      Law law = fit(knob, o, known.scale, twins(knob, k), known.spread);
      others += law.at(1);
      known.laws.push_back(law);
    }
    if (turns(Knob::spacing)) {
      const std::vector<Twin> spacings = twins(Knob::spacing, k);
      Law law = fit(Knob::spacing, o, known.scale, spacings, known.spread);
      if (law.cost_exponent == 0) law.cost_exponent = -4;
      if (!o.exact.empty()) law = fit_exact(o, known.scale, law, spacings, others);
      known.laws.insert(known.laws.begin(), law);
      const std::size_t n = spacings.size();
      if (n >= 2) {
        const Difference d = difference(o, known.scale, *spacings[n - 2].values, *spacings[n - 1].values);
        if (d.max > 0) known.rms_share = d.rms / d.max;
      }
    }
    known.limit = limit_of(known, k);
    compare_support(known, k);
    if (const char* const nothing = says_nothing(o, k))
      study_.notes.push_back(
          o.name + ": " + nothing +
          ", so what is said of its error means nothing; name another observable, or simulate for longer");
    study_.observables.push_back(std::move(known));
  }

  /// Why the values of an observable say nothing of errors; null if they do.
  const char* says_nothing(const Observable& o, std::size_t k) const {
    bool any = false;
    for (std::size_t i = 0; i < study_.probes.size(); ++i)
      any = any || (good(i) != nullptr && has_value(study_.probes[i].values[k]));
    if (!any && o.reduce == Reduce::time_to_reach) return "never reaches its level in any probe";
    if (!any) return "has no value in any probe";
    if (!o.exact.empty() || !stands_still(k)) return nullptr;
    return o.reduce == Reduce::curve ? "is the same at all times with all settings"
                                     : "is the same with all settings";
  }

  /// Whether all values of all probes are alike.
  bool stands_still(std::size_t k) const {
    const std::vector<double>& base = study_.probes[0].values[k];
    for (std::size_t i = 0; i < study_.probes.size(); ++i) {
      if (good(i) == nullptr) continue;
      for (const double value : study_.probes[i].values[k])
        if (!(value == base.front())) return false;
    }
    return !base.empty();
  }

  static double scale_of(const Observable& o, const std::vector<double>& values) {
    if (o.scale > 0) return o.scale;
    double least = infinity, most = -infinity;
    for (const double value : values) {
      if (!std::isfinite(value)) continue;
      least = std::min(least, value);
      most = std::max(most, value);
    }
    const double range = o.reduce == Reduce::curve ? most - least : std::max(std::abs(least), std::abs(most));
    return std::isfinite(range) ? std::max(range, smallest_scale) : 1;
  }

  /// The finest spacing's values, extended in each knob along the twins' differences.
  std::vector<double> limit_of(const Known& known, std::size_t k) const {
    if (!known.observable.exact.empty()) return known.observable.exact;
    std::vector<double> limit = finest(Knob::spacing).values[k];
    for (const Law& law : known.laws) {
      // From the worse to the better of the two best twins.
      std::vector<Twin> list = twins(law.knob, k);
      if (list.size() < 2) continue;
      std::sort(list.begin(), list.end(),
                [&](const Twin& a, const Twin& b) { return law.at(a.x) > law.at(b.x); });
      const Twin &worse = list[list.size() - 2], &better = list.back();
      const double pw = std::pow(worse.x, law.error_exponent), pb = std::pow(better.x, law.error_exponent);
      if (!(pw > pb * 1.001) || law.scatters || !(law.error > 0)) continue;  // scatter and chaos lead nowhere
      // Knobs but the spacing are at 1 in the finest probe.
      const double rest = (law.knob == Knob::spacing ? pb : 1) / (pw - pb);
      for (std::size_t i = 0; i < limit.size(); ++i) {
        const double step = (*better.values)[i] - (*worse.values)[i];
        if (std::isfinite(step)) limit[i] += rest * step;
      }
    }
    return limit;
  }

  const Measurement& finest(Knob) const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < study_.probes.size(); ++i)
      if (good(i) != nullptr && groups_[i] == Knob::spacing && study_.probes[i].knobs.stir == 0 &&
          study_.probes[i].actual[Knob::spacing] < study_.probes[best].actual[Knob::spacing])
        best = i;
    return study_.probes[best];
  }

  void compare_support(Known& known, std::size_t k) const {
    for (std::size_t i = 1; i < study_.probes.size(); ++i) {
      if (groups_[i] != Knob::support || good(i) == nullptr) continue;
      known.support_difference =
          difference(known.observable, known.scale, study_.probes[0].values[k], study_.probes[i].values[k])
              .max;
      known.support_cost = study_.probes[i].work / study_.probes[0].work;
    }
  }

  /// Rate of the most expensive probes, which are the most like a run.
  void rate() {
    const Measurement* dearest = nullptr;
    for (const Measurement& m : study_.probes)
      if (m.complete && m.work > 0 && (dearest == nullptr || m.work > dearest->work)) dearest = &m;
    if (dearest != nullptr) study_.seconds_per_work = dearest->wall_s / dearest->work;
    // Cost of the problem itself: the probes count speeds that its start does not have.
    const Measurement& base = study_.probes[0];
    if (problem_.run && study_.reference_work > 0) return;
    if (base.work > 0 && !study_.observables.empty()) {
      double exponent = -4;
      for (const Law& law : study_.observables[0].laws)
        if (law.knob == Knob::spacing) exponent = law.cost_exponent;
      study_.reference_work = base.work * std::pow(1 / base.actual[Knob::spacing], exponent);
    }
  }

  const Problem& problem_;
  const Options& options_;
  Clock::time_point start_ = Clock::now();
  Study study_;
  Reference reference_;
  Backend backend_ = Backend::cpu;
  int threads_ = 1;
  double coarse_ = 1, middle_ = 1, fine_ = 1;
  bool stopped_ = false;
  std::vector<Planned> planned_, failed_;
  std::vector<Knob> groups_;  ///< per probe, the knob that it is a twin in
};

}  // namespace

Result<Study> study(const Problem& problem, const Options& options) {
  return core::guarded<Result<Study>>([&] { return Studying(problem, options).run(); });
}

}  // namespace trade
}  // namespace v0
}  // namespace meltsim
