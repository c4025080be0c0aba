// SPDX-License-Identifier: Apache-2.0
// Settings from laws: the cheapest whose errors add up to the one asked for.
#include <algorithm>
#include <cmath>

#include "engine/text.hpp"
#include "meltsim/trade.hpp"
#include "trade/check.hpp"
#include "world/guarded.hpp"

namespace meltsim {
inline namespace v0 {
namespace trade {

namespace {

Error invalid(const std::string& message) { return {ErrorCode::invalid_argument, message}; }

/// A knob's law and how far it may be turned.
struct Turn {
  Law law;
  double cheap, dear;  ///< the ends of its range by cost
  double weight;       ///< relative change of cost per relative change of error
  double least, most;  ///< error at the ends
};

std::vector<Turn> turns_of(const Study& study, const Known& known) {
  std::vector<Turn> turns;
  for (const Law& law : known.laws) {
    const Range range = study.ranges[static_cast<std::size_t>(law.knob)];
    const double slope = law.cost_exponent;
    const double cheap = slope < 0 ? range.most : range.least, dear = slope < 0 ? range.least : range.most;
    Turn turn{law, cheap, dear, 0, law.at(dear), law.at(cheap)};
    // A setting that costs more and is worse is never chosen.
    if (turn.least >= turn.most) turn.least = turn.most;
    else turn.weight = std::abs(slope / law.error_exponent);
    turns.push_back(turn);
  }
  return turns;
}

double sum_at(const std::vector<Turn>& turns, double multiplier) {
  double sum = 0;
  for (const Turn& t : turns) sum += std::clamp(multiplier * t.weight, t.least, t.most);
  return sum;
}

/// Minimises the product of x^cost under sum of errors <= allowed: every error is in proportion to its weight, or at an end
/// of its range (Lagrange; convex in the logarithms of the errors).
double multiplier_for(const std::vector<Turn>& turns, double allowed) {
  double low = -700, high = 700;
  for (int i = 0; i < 200; ++i) {
    const double middle = (low + high) / 2;
    (sum_at(turns, std::exp(middle)) <= allowed ? low : high) = middle;
  }
  return std::exp(low);
}

Choice at_multiplier(const Study& study, const Known& known, const std::vector<Turn>& turns,
                     double multiplier) {
  Choice choice;
  double work = study.reference_work;
  for (const Turn& t : turns) {
    const double error = std::clamp(multiplier * t.weight, t.least, t.most);
    double x = t.cheap;
    if (error <= t.least && t.least < t.most) x = t.dear;
    else if (error < t.most) x = std::pow(error / t.law.error, 1 / t.law.error_exponent);
    x = std::clamp(x, std::min(t.cheap, t.dear), std::max(t.cheap, t.dear));
    choice.knobs[t.law.knob] = x;
    choice.error += t.law.at(x);
    work *= std::pow(x, t.law.cost_exponent);
  }
  choice.error += known.spread / 2;
  choice.rms = choice.error * known.rms_share;
  choice.work = work;
  choice.seconds = work * study.seconds_per_work;
  return choice;
}

Result<const Known*> find(const Study& study, const std::string& name) {
  std::string names;
  for (const Known& known : study.observables) {
    if (known.observable.name != name) {
      names += (names.empty() ? "" : ", ") + known.observable.name;
      continue;
    }
    if (known.limit.empty() || has_value(known.limit)) return &known;  // laws may be given without values
    return invalid("observable: \"" + name +
                   "\" had no value in any probe, so nothing is known of its error; name another one, or "
                   "simulate for longer");
  }
  return invalid("observable: \"" + name + "\" is none of the study's: " + names);
}

Result<Choice> choose_now(const Study& study, const std::string& name, double error, double safety) {
  const Result<const Known*> found = find(study, name);
  if (!found) return found.error();
  const Known* known = *found;
  if (safety == automatic) safety = study.safety;
  if (!(error > 0) || !std::isfinite(error))
    return invalid("error: expected a share above 0, got " + core::to_text(error));
  if (!(safety >= 1) || !std::isfinite(safety))
    return invalid("safety: expected 1 or more, got " + core::to_text(safety));
  const std::vector<Turn> turns = turns_of(study, *known);
  const double asked = error * known->scale, allowed = asked / safety - known->spread / 2;
  const bool attainable = allowed > 0 && sum_at(turns, 0) <= allowed;
  Choice choice = at_multiplier(study, *known, turns, attainable ? multiplier_for(turns, allowed) : 0);
  choice.asked = asked;
  choice.attainable = attainable;
  choice.chaotic = known->spread > asked;
  return choice;
}

Result<Choice> within_now(const Study& study, const std::string& name, double seconds) {
  const Result<const Known*> found = find(study, name);
  if (!found) return found.error();
  const Known* known = *found;
  if (!(seconds > 0)) return invalid("seconds: expected a time above 0 s, got " + core::to_text(seconds));
  if (!(study.seconds_per_work > 0) || !(study.reference_work > 0))
    return invalid("study: expected what a run costs, got seconds_per_work " +
                   core::to_text(study.seconds_per_work) + " and reference_work " +
                   core::to_text(study.reference_work));
  const std::vector<Turn> turns = turns_of(study, *known);
  const auto at = [&](double multiplier) { return at_multiplier(study, *known, turns, multiplier); };
  Choice best = at(0);
  if (!(best.seconds <= seconds)) {
    // Errors grow with the multiplier and costs fall.
    double low = -700, high = 700;
    best = at(std::exp(high));
    best.attainable = best.seconds <= seconds;
    for (int i = 0; i < 200 && best.attainable; ++i) {
      const double middle = (low + high) / 2;
      (at(std::exp(middle)).seconds <= seconds ? high : low) = middle;
    }
    if (best.attainable) best = at(std::exp(high));
  }
  best.asked = best.error;
  best.chaotic = known->spread > best.asked;
  return best;
}

Result<std::vector<Choice>> front_now(const Study& study, const std::string& name, int points) {
  const Result<const Known*> found = find(study, name);
  if (!found) return found.error();
  const Known* known = *found;
  if (points < 2) return invalid("points: expected 2 or more, got " + std::to_string(points));
  const std::vector<Turn> turns = turns_of(study, *known);
  double most = 0;
  for (const Turn& t : turns) most += t.most;
  const double least = sum_at(turns, 0);
  std::vector<Choice> choices;
  for (int i = 0; i < points; ++i) {
    const double part = static_cast<double>(i) / (points - 1);
    const double allowed = least > 0 ? most * std::pow(least / most, part) : most * (1 - part);
    const bool end = i + 1 == points;
    Choice choice = at_multiplier(study, *known, turns, end ? 0 : multiplier_for(turns, allowed));
    choice.asked = choice.error;
    if (choices.empty() || choice.knobs.value != choices.back().knobs.value) choices.push_back(choice);
  }
  return choices;
}

}  // namespace

Result<Choice> choose(const Study& study, const std::string& observable, double error, double safety) {
  return core::guarded<Result<Choice>>([&] { return choose_now(study, observable, error, safety); });
}

Result<Choice> choose_within(const Study& study, const std::string& observable, double seconds) {
  return core::guarded<Result<Choice>>([&] { return within_now(study, observable, seconds); });
}

Result<std::vector<Choice>> front(const Study& study, const std::string& observable, int points) {
  return core::guarded<Result<std::vector<Choice>>>([&] { return front_now(study, observable, points); });
}

namespace {

/// Probes at the problem's settings but for their spacing, finest first.
std::vector<const Measurement*> spacing_twins(const Study& study) {
  std::vector<const Measurement*> twins;
  for (const Measurement& m : study.probes) {
    bool plain = m.complete && m.knobs.stir == 0;
    for (const Knob knob : {Knob::sound_speed, Knob::courant, Knob::step, Knob::support})
      plain = plain && std::abs(m.knobs[knob] - 1) < 1e-9;
    if (plain) twins.push_back(&m);
  }
  std::sort(twins.begin(), twins.end(), [](const Measurement* a, const Measurement* b) {
    return a->actual[Knob::spacing] < b->actual[Knob::spacing];
  });
  return twins;
}

/// Error of a run at spacing x from the finest probe that is coarser enough (Richardson's extrapolation), -1 where there is
/// none. Nearer ones would multiply what is no error of the spacing (Celik et al., J. Fluids Eng. 130:078001, 2008: 1.3 at least).
double beside(const std::vector<const Measurement*>& twins, std::size_t observable, const Known& known,
              double x, const Law& law, const std::vector<double>& values) {
  constexpr double coarser = 1.3;
  for (const Measurement* twin : twins) {
    const double other = twin->actual[Knob::spacing];
    if (other < coarser * x || observable >= twin->values.size()) continue;
    const double of_run = std::pow(x, law.error_exponent), of_probe = std::pow(other, law.error_exponent);
    return difference(known.observable, known.scale, values, twin->values[observable]).max * of_run /
           (of_probe - of_run);
  }
  return -1;
}

}  // namespace

Difference delivered(const Study& study, std::size_t observable, const Knobs& actual,
                     const std::vector<double>& values) {
  Difference none{infinity, infinity};
  if (observable >= study.observables.size()) return none;
  const Known& known = study.observables[observable];
  const Observable& o = known.observable;
  if (values.size() != known.limit.size() || !has_value(known.limit)) return none;
  if (!o.exact.empty()) return difference(o, known.scale, values, o.exact);
  double others = 0;
  const Law* spacing = nullptr;
  for (const Law& law : known.laws) {
    if (law.knob == Knob::spacing) spacing = &law;
    else others = std::hypot(others, law.at(actual[law.knob]));
  }
  const double x = actual[Knob::spacing];
  const std::vector<const Measurement*> twins = spacing_twins(study);
  const bool finer = !twins.empty() && x < 0.9 * twins.front()->actual[Knob::spacing];
  const Difference to_limit = difference(o, known.scale, values, known.limit);
  const double rms_share = to_limit.max > 0 ? to_limit.rms / to_limit.max : known.rms_share;
  double error = to_limit.max;
  if (spacing != nullptr && spacing->scatters) {
    error = finer ? std::hypot(spacing->at(x), others) : std::max(error, spacing->at(x));
  } else if (spacing != nullptr && finer) {
    // The run is nearer to the limit than the probes that the limit was extrapolated from: it is the better twin.
    const double apart = beside(twins, observable, known, x, *spacing, values);
    if (apart >= 0) error = std::hypot(apart, others);
  }
  error = std::hypot(error, known.spread / 2);
  return {error, error * rms_share};
}

}  // namespace trade
}  // namespace v0
}  // namespace meltsim
