// SPDX-License-Identifier: Apache-2.0
// Laws from twins, choices from laws, probes of Worlds.
#include "meltsim/trade.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace meltsim;
using trade::Knob;
using trade::Knobs;

/// A problem whose errors and costs are known: y(t) = 1 + t (C x^p + D c^q), work x^-4 c / courant.
struct Made {
  double spacing_error = 0.04, spacing_exponent = 1, sound_error = 0.01, sound_exponent = -2;
  double stirred = 0;       ///< how far a stirred start ends from a plain one
  double breaks_below = 0;  ///< sound speed multiple below which a run diverges

  double error(double x, double c) const {
    return spacing_error * std::pow(x, spacing_exponent) + sound_error * std::pow(c, sound_exponent);
  }
  static double work(double x, double c, double courant) { return std::pow(x, -4) * c / courant; }

  trade::Problem problem() const {
    trade::Problem p;
    p.end = 1;
    p.observables.resize(1);
    p.observables[0].name = "y";
    p.observables[0].scale = 1;
    p.reference_work = 1;
    p.run = [made = *this](const Knobs& knobs, double) -> Result<trade::Measurement> {
      trade::Measurement m;
      m.knobs = m.actual = knobs;
      const double x = knobs[Knob::spacing], c = knobs[Knob::sound_speed];
      m.values.resize(1);
      for (int i = 0; i <= 10; ++i)
        m.values[0].push_back(1 + 0.1 * i * (made.error(x, c) + (knobs.stir != 0 ? made.stirred : 0)));
      m.work = work(x, c, knobs[Knob::courant]);
      m.wall_s = 2 * m.work;
      m.complete = c >= made.breaks_below;
      if (!m.complete) m.problem = "a particle is too fast";
      return m;
    };
    return p;
  }
};

/// A made problem whose curve depends on the spacing alone: of 11 samples, `curve(x, i)`.
template <class Curve>
trade::Problem with_curve(const Curve& curve) {
  trade::Problem problem = Made{}.problem();
  problem.run = [run = problem.run, curve](const Knobs& knobs, double limit) {
    Result<trade::Measurement> m = run(knobs, limit);
    for (std::size_t i = 0; i < m->values[0].size(); ++i) m->values[0][i] = curve(knobs[Knob::spacing], i);
    return m;
  };
  return problem;
}

const trade::Law& law(const trade::Known& known, Knob knob) {
  for (const trade::Law& l : known.laws)
    if (l.knob == knob) return l;
  ADD_FAILURE() << "no law of " << trade::knob_name(knob);
  return known.laws.front();
}

trade::Study study_of(const Made& made) {
  Result<trade::Study> study = trade::study(made.problem());
  EXPECT_TRUE(study) << (study ? "" : study.error().message);
  return study ? *study : trade::Study{};
}

TEST(Laws, ExponentsAndConstantsOfASumOfPowersAreFound) {
  for (const double p : {0.75, 1.0, 1.5, 2.0}) {
    Made made;
    made.spacing_exponent = p;
    const trade::Study study = study_of(made);
    const trade::Known& y = study.observables.at(0);
    // Differences of exact powers: only rounding is left (1e-16 of 1 in differences of 1e-3).
    EXPECT_NEAR(law(y, Knob::spacing).error_exponent, p, 1e-6);
    EXPECT_NEAR(law(y, Knob::spacing).error, made.spacing_error, 1e-8);
    EXPECT_NEAR(law(y, Knob::spacing).cost_exponent, -4, 1e-9);
    EXPECT_TRUE(law(y, Knob::spacing).fitted);
    EXPECT_NEAR(law(y, Knob::sound_speed).error_exponent, -2, 1e-6);
    EXPECT_NEAR(law(y, Knob::sound_speed).error, made.sound_error, 1e-8);
    EXPECT_NEAR(law(y, Knob::sound_speed).cost_exponent, 1, 1e-9);
    EXPECT_EQ(law(y, Knob::courant).error, 0);
    EXPECT_NEAR(y.limit.back(), 1, 1e-8);
  }
}

TEST(Laws, AnExponentOutsideOfWhatIsBelievedIsClampedAndTheLargerErrorTaken) {
  Made made;
  made.spacing_exponent = 6;
  const trade::Law l = law(study_of(made).observables.at(0), Knob::spacing);
  EXPECT_FALSE(l.fitted);
  EXPECT_NEAR(l.error_exponent, 2.1, 1e-6);  // the most that is believed
  // No twin differs by more than the law says.
  const double x1 = 0.6 * 1.69, x2 = 0.6 * 1.3;
  EXPECT_GE(l.at(x1) - l.at(x2), 0.999 * made.spacing_error * (std::pow(x1, 6) - std::pow(x2, 6)));
}

// Coarse probes of a melting front seem to converge faster than they will go on to.
TEST(Laws, AnOrderIsNotExceeded) {
  Made made;
  made.spacing_exponent = 2;
  trade::Problem problem = made.problem();
  problem.observables[0].order = 1;
  const Result<trade::Study> study = trade::study(problem);
  ASSERT_TRUE(study);
  const trade::Law l = law(study->observables.at(0), Knob::spacing);
  EXPECT_NEAR(l.error_exponent, 1.1, 1e-6);
  EXPECT_GT(l.at(0.3), made.spacing_error * 0.3 * 0.3);
  problem.observables[0].order = 0.5;
  EXPECT_EQ(trade::study(problem).error().message,
            "Observable::order: of \"y\": expected 1 or more, got 0.5");
}

// A made error of x^0.1 that every curve has at another time: differences of the largest values hardly fall from twin to twin, and curves do
// not go on the way they began. The error of the coarsest twin is as large as the largest difference, not that over a small change of x, and
// there is no limit ahead.
TEST(Laws, DifferencesThatDoNotFallAreScatter) {
  const Result<trade::Study> study = trade::study(with_curve([](double x, std::size_t i) {
    return i == (x > 0.9 ? 3u : x > 0.7 ? 6u : 9u) ? 1.05 : 1.0;
  }));
  ASSERT_TRUE(study);
  const trade::Known& y = study->observables.at(0);
  const trade::Law l = law(y, Knob::spacing);
  EXPECT_TRUE(l.scatters);
  EXPECT_FALSE(l.fitted);
  EXPECT_EQ(l.error_exponent, 1);
  const double x1 = 0.6 * 1.69;
  EXPECT_NEAR(l.at(x1), 0.05, 1e-6);
  // A run that is finer than all probes, and one as coarse as the coarsest, are estimated by the law, however near they are.
  trade::Knobs finer;
  finer[Knob::spacing] = 0.4;
  const double others = law(y, Knob::sound_speed).at(1);
  EXPECT_NEAR(trade::delivered(*study, 0, finer, y.limit).max, std::hypot(l.at(0.4), others), 1e-6);
  finer[Knob::spacing] = x1;
  EXPECT_NEAR(trade::delivered(*study, 0, finer, y.limit).max, l.at(x1), 1e-6);
}

// Differences that fall, but of curves that turn back: an exponent of them would be one of chance.
TEST(Laws, CurvesThatTurnBackAreScatter) {
  const Result<trade::Study> study = trade::study(with_curve([](double x, std::size_t i) {
    return 1 + 0.01 * static_cast<double>(i) * (x > 0.9 ? 0 : x > 0.7 ? 1 : 0.4);
  }));
  ASSERT_TRUE(study);
  const trade::Law l = law(study->observables.at(0), Knob::spacing);
  EXPECT_TRUE(l.scatters);
  EXPECT_NEAR(l.at(0.6 * 1.69), 0.1, 1e-6);
}

// A draught that changes by more from the middle probe to the finest than from the coarsest to the middle: the coarsest is as far off as it is
// from the finest at least, not as far as neighbours are from each other.
TEST(Laws, DifferencesThatGrowCountFromTheFirstToTheLast) {
  trade::Problem problem = Made{}.problem();
  problem.run = [](const Knobs& knobs, double) -> Result<trade::Measurement> {
    trade::Measurement m;
    m.knobs = m.actual = knobs;
    const double x = knobs[Knob::spacing];
    m.values = {{x > 0.9 ? 0.0678 : x > 0.7 ? 0.0776 : 0.0984}};
    m.work = Made::work(x, knobs[Knob::sound_speed], knobs[Knob::courant]);
    m.complete = true;
    return m;
  };
  const Result<trade::Study> study = trade::study(problem);
  ASSERT_TRUE(study);
  const trade::Law l = law(study->observables.at(0), Knob::spacing);
  EXPECT_TRUE(l.scatters);
  EXPECT_NEAR(l.at(0.6 * 1.69), 0.0984 - 0.0678, 1e-6);
}

// Starts that are alike differ by more than spacings do: nothing says where finer ones would lead.
TEST(Laws, NothingIsExtrapolatedFromWhatChaosHides) {
  Made made;
  made.stirred = 0.2;
  const trade::Study study = study_of(made);
  EXPECT_EQ(law(study.observables.at(0), Knob::spacing).error, 0);
  for (const trade::Measurement& probe : study.probes)
    if (probe.knobs.stir == 0 && std::fabs(probe.knobs[Knob::spacing] - 0.6) < 1e-9) {
      EXPECT_EQ(study.observables[0].limit, probe.values[0]);
    }
}

TEST(Laws, AKnobThatCouldNotBeComparedIsSaidToBeSo) {
  Made made;
  made.breaks_below = 0.9;
  const trade::Study study = study_of(made);
  EXPECT_FALSE(law(study.observables.at(0), Knob::sound_speed).measured());
  EXPECT_TRUE(law(study.observables.at(0), Knob::spacing).measured());
  const std::string said =
      "sound_speed: no two values of it could be compared, so it stays as it is, and what is said of errors "
      "does not "
      "count what it does";
  EXPECT_EQ(std::count(study.notes.begin(), study.notes.end(), said), 1) << study.notes.back();
}

// A made error of x^0.1, the same way at every spacing: what thins with the spacing goes on as slowly beyond the probes. The least exponent
// that is believed holds, which puts the error at the finest probe at six times the last difference.
TEST(Laws, WhatHardlyFallsButGoesOnTheSameWayIsSlow) {
  Made made;
  made.spacing_exponent = 0.1;
  const trade::Law l = law(study_of(made).observables.at(0), Knob::spacing);
  EXPECT_FALSE(l.scatters);
  EXPECT_FALSE(l.fitted);
  EXPECT_NEAR(l.error_exponent, 0.7, 1e-6);
  const double last = made.spacing_error * (std::pow(0.78, 0.1) - std::pow(0.6, 0.1));
  EXPECT_GT(l.at(0.6), 4 * last);
}

TEST(Laws, AnExactAnswerTellsTheErrorOfTheSpacingWithoutExtrapolation) {
  Made made;
  made.spacing_exponent = 1.4;
  trade::Problem problem = made.problem();
  problem.observables[0].exact.assign(11, 1.0);
  const Result<trade::Study> study = trade::study(problem);
  ASSERT_TRUE(study);
  EXPECT_NEAR(law(study->observables[0], Knob::spacing).error_exponent, 1.4, 1e-6);
  EXPECT_EQ(study->observables[0].limit, problem.observables[0].exact);
}

TEST(Choice, IsWithin15PercentOfTheBestOfAGridAtTheSameError) {
  for (const double p : {0.75, 1.0, 2.0}) {
    for (const double asked : {0.1, 0.05, 0.03}) {
      Made made;
      made.spacing_exponent = p;
      const trade::Study study = study_of(made);
      const Result<trade::Choice> choice = trade::choose(study, "y", asked, 1);
      ASSERT_TRUE(choice);
      ASSERT_TRUE(choice->attainable);
      const double x = choice->knobs[Knob::spacing], c = choice->knobs[Knob::sound_speed];
      EXPECT_LE(made.error(x, c), asked * (1 + 1e-6));
      double best = infinity;
      const trade::Range xs = study.ranges[0], cs = study.ranges[1];
      constexpr int points = 200;  // neighbours differ by 2 % in x and 1 % in c: 8 % in cost
      for (int i = 0; i <= points; ++i)
        for (int k = 0; k <= points; ++k) {
          const double gx = xs.least * std::pow(xs.most / xs.least, double(i) / points);
          const double gc = cs.least * std::pow(cs.most / cs.least, double(k) / points);
          if (made.error(gx, gc) <= asked) best = std::min(best, Made::work(gx, gc, 1.5));
        }
      EXPECT_LE(choice->work, 1.15 * best) << "p " << p << ", asked " << asked;
      EXPECT_NEAR(choice->work, Made::work(x, c, choice->knobs[Knob::courant]), 1e-6 * choice->work);
      EXPECT_NEAR(choice->seconds, 2 * choice->work, 1e-6 * choice->work);
      EXPECT_NEAR(choice->knobs[Knob::courant], 1.5, 1e-9);  // it costs no accuracy here
    }
  }
}

TEST(Choice, SafetyIsAMarginOfTheErrorAskedFor) {
  const Result<trade::Choice> choice = trade::choose(study_of(Made{}), "y", 0.06, 2);
  ASSERT_TRUE(choice && choice->attainable);
  EXPECT_NEAR(choice->error, 0.03, 1e-6);
}

TEST(Choice, BelowTheSmallestErrorThereIsItSaysWhatThatIs) {
  const trade::Study study = study_of(Made{});
  const Result<trade::Choice> choice = trade::choose(study, "y", 1e-4);
  ASSERT_TRUE(choice);
  EXPECT_FALSE(choice->attainable);
  EXPECT_FALSE(choice->chaotic);
  EXPECT_NEAR(choice->knobs[Knob::spacing], study.ranges[0].least, 1e-9);
  EXPECT_NEAR(choice->knobs[Knob::sound_speed], 2, 1e-9);
  EXPECT_NEAR(choice->error, Made{}.error(study.ranges[0].least, 2), 1e-8);
  EXPECT_GT(choice->seconds, 0);
  // The error that it names is one that can be asked for.
  EXPECT_TRUE(trade::choose(study, "y", choice->error * 1.001, 1)->attainable);
}

TEST(Choice, StartsThatAreAlikeAndDifferByMoreThanAskedAreChaos) {
  Made made;
  made.stirred = 0.2;
  const trade::Study study = study_of(made);
  EXPECT_NEAR(study.observables[0].spread, 0.2, 1e-12);
  const Result<trade::Choice> choice = trade::choose(study, "y", 0.05);
  ASSERT_TRUE(choice);
  EXPECT_FALSE(choice->attainable);
  EXPECT_TRUE(choice->chaotic);
  EXPECT_GE(choice->error, 0.1);  // half of the spread at least
}

TEST(Choice, WhatDivergedIsNotChosen) {
  Made made;
  made.breaks_below = 0.4;
  const trade::Study study = study_of(made);
  ASSERT_FALSE(study.notes.empty());
  EXPECT_NE(study.notes[0].find("sound_speed x 0.3"), std::string::npos) << study.notes[0];
  const Result<trade::Choice> choice = trade::choose(study, "y", 0.5);
  ASSERT_TRUE(choice);
  EXPECT_GE(choice->knobs[Knob::sound_speed], 0.4);
}

TEST(Choice, WhatNoTwinWasMadeOfIsLeftAlone) {
  Made made;
  made.breaks_below = 0.9;  // no sound speed but the problem's own
  const trade::Study study = study_of(made);
  EXPECT_EQ(trade::choose(study, "y", 0.5)->knobs[Knob::sound_speed], 1);
  // And without a second spacing nothing is known of the error.
  trade::Problem problem = made.problem();
  problem.run = [run = problem.run](const Knobs& knobs, double limit) {
    Result<trade::Measurement> m = run(knobs, limit);
    if (knobs[Knob::spacing] < 0.7 || knobs[Knob::spacing] > 0.9) {
      m->complete = false;
      m->problem = "it took longer than allowed";
    }
    return m;
  };
  const Result<trade::Study> none = trade::study(problem);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().message.find("seconds: no two spacings could be probed"), 0u)
      << none.error().message;
}

// An error of 0 of what does not change is no promise.
TEST(Study, SaysThatAnObservableStandsStill) {
  trade::Problem problem = Made{}.problem();
  EXPECT_TRUE(trade::study(problem)->notes.empty());
  problem.run = [run = problem.run](const Knobs& knobs, double limit) {
    Result<trade::Measurement> m = run(knobs, limit);
    std::fill(m->values[0].begin(), m->values[0].end(), 0.0);
    return m;
  };
  const trade::Study study = *trade::study(problem);
  ASSERT_EQ(study.notes.size(), 1u);
  EXPECT_EQ(study.notes[0].find("y: is the same at all times"), 0u) << study.notes[0];
  // With an exact answer that stands still it is right.
  problem.observables[0].exact.assign(11, 0.0);
  EXPECT_TRUE(trade::study(problem)->notes.empty());
}

TEST(Choice, IsTheSameTwice) {
  const trade::Study a = study_of(Made{}), b = study_of(Made{});
  EXPECT_EQ(trade::choose(a, "y", 0.05)->knobs.value, trade::choose(b, "y", 0.05)->knobs.value);
}

TEST(Choice, RefusesWhatMakesNoSense) {
  const trade::Study study = study_of(Made{});
  EXPECT_EQ(trade::choose(study, "z", 0.05).error().message, "observable: \"z\" is none of the study's: y");
  for (const double error : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), infinity})
    EXPECT_EQ(trade::choose(study, "y", error).error().code, ErrorCode::invalid_argument);
  EXPECT_FALSE(trade::choose(study, "y", 0.05, 0.5));
  EXPECT_FALSE(trade::front(study, "y", 1));
  EXPECT_FALSE(trade::study(trade::Problem{}));
  trade::Options options;
  options.seconds = 0;
  EXPECT_FALSE(trade::study(Made{}.problem(), options));
}

TEST(Front, FallsInErrorAndRisesInCostOverMoreThan30Times) {
  const Result<std::vector<trade::Choice>> front = trade::front(study_of(Made{}), "y", 8);
  ASSERT_TRUE(front);
  ASSERT_EQ(front->size(), 8u);
  for (std::size_t i = 1; i < front->size(); ++i) {
    EXPECT_LT((*front)[i].error, (*front)[i - 1].error);
    EXPECT_GT((*front)[i].work, (*front)[i - 1].work);
  }
  EXPECT_GT(front->back().work, 30 * front->front().work);
}

// Where no setting makes an error, all choices are the cheapest settings there are: one point, not eight alike.
TEST(Front, HasNoTwoPointsOfTheSameSettings) {
  trade::Study study = study_of(Made{});
  for (trade::Law& law : study.observables[0].laws) law.error = 0;
  const Result<std::vector<trade::Choice>> front = trade::front(study, "y", 8);
  ASSERT_TRUE(front);
  ASSERT_EQ(front->size(), 1u);
  EXPECT_GT((*front)[0].knobs[Knob::spacing], 1);
}

TEST(Study, ProbesAtMostWhatItIsAllowedTo) {
  trade::Options options;
  options.probes = 4;
  const Result<trade::Study> study = trade::study(Made{}.problem(), options);
  ASSERT_TRUE(study);
  EXPECT_EQ(study->probes.size(), 4u);
  EXPECT_LE(study_of(Made{}).probes.size(), 9u);
  options.progress = [](const trade::Measurement&, int planned) { return planned != 4; };
  EXPECT_EQ(trade::study(Made{}.problem(), options).error().code, ErrorCode::interrupted);
}

TEST(Delivered, ARunFinerThanAllProbesIsExtendedByItsOwnDifference) {
  const Made made;
  const trade::Study study = study_of(made);
  const auto estimate = [&](double x, double off) {
    Knobs knobs;
    knobs[Knob::spacing] = x;
    Result<trade::Measurement> run = made.problem().run(knobs, 1);
    run->values[0].back() += off;
    return trade::delivered(study, 0, knobs, run->values[0]).max;
  };
  // Within the probes by the limit; beyond, knobs err independently.
  for (const double x : {1.0, 0.6}) EXPECT_NEAR(estimate(x, 0), made.error(x, 1), 1e-8) << x;
  const double sound = law(study.observables.at(0), Knob::sound_speed).at(1);
  for (const double x : {0.53, 0.4, 0.2})
    EXPECT_NEAR(estimate(x, 0), std::hypot(made.error(x, 1) - sound, sound), 1e-8) << x;
  // A little finer than the finest probe (0.6): what is not of the spacing would be multiplied by 5 beside that, by 2 beside the next.
  EXPECT_LT(estimate(0.53, 0.01) - estimate(0.53, 0), 0.02);
}

TEST(Observables, AreReducedToWhatIsCompared) {
  trade::Observable o;
  const std::vector<double> times{0, 1, 2}, values{0, 0.4, 0.8};
  EXPECT_EQ(trade::reduce(o, times, values), values);
  o.reduce = trade::Reduce::last;
  EXPECT_EQ(trade::reduce(o, times, values), std::vector<double>{0.8});
  o.reduce = trade::Reduce::largest;
  EXPECT_EQ(trade::reduce(o, times, {1, std::nan(""), 0.5}), std::vector<double>{1});
  o.reduce = trade::Reduce::late_mean;
  EXPECT_NEAR(trade::reduce(o, times, values)[0], 0.6, 1e-15);
  EXPECT_NEAR(trade::reduce(o, times, {9, std::nan(""), 0.5})[0], 0.5, 1e-15);
  o.reduce = trade::Reduce::time_to_reach;
  o.level = 0.6;
  EXPECT_NEAR(trade::reduce(o, times, values)[0], 1.5, 1e-15);
  o.level = 0.9;
  EXPECT_TRUE(std::isnan(trade::reduce(o, times, values)[0]));
}

TEST(Observables, DifferencesAreLargestAndRootMeanSquare) {
  trade::Observable o;
  trade::Difference d = trade::difference(o, 1, {0, 0, 0, 0}, {0, 2, 0, 0});
  EXPECT_EQ(d.max, 2);
  EXPECT_EQ(d.rms, 1);
  o.components = 2;  // a path: distances
  EXPECT_EQ(trade::difference(o, 1, {0, 0, 1, 1}, {3, 4, 1, 1}).max, 5);
  o.components = 1;
  EXPECT_EQ(trade::difference(o, 7, {1, std::nan("")}, {1, 2}).max, 7);  // never reached against reached
  EXPECT_EQ(trade::difference(o, 7, {std::nan("")}, {std::nan("")}).max, 0);
}

/// A small column of water that collapses; what is left of its potential energy, and how fast it is.
trade::Problem column() {
  trade::Problem p;
  p.end = 0.1;
  p.samples = 2;  // a dozen steps each: whole ones blur the cost by a tenth
  p.observables.resize(2);
  p.observables[0].name = "potential";
  p.observables[1].name = "never";
  p.observables[1].reduce = trade::Reduce::time_to_reach;
  p.observables[1].level = 1e9;
  p.build = [](const Knobs& knobs) -> Result<World> {
    WorldDesc desc;
    desc.backend = Backend::cpu;
    desc.threads = 1;
    desc.spacing = 0.1 * knobs[Knob::spacing];
    desc.domain.bounded = true;
    desc.domain.max = {1, 1, 0.7};
    desc.courant = 0.4 * knobs[Knob::courant];  // 1.5 times the default is more than 0.6 by a rounding
    desc.sound_speed = 20 * knobs[Knob::sound_speed];
    desc.gravity.x = 1e-3 * knobs.stir;
    desc.heat.model = HeatModel::none;
    Result<World> world = World::create(desc);
    if (!world) return world;
    MaterialDesc water;
    water.name = "water";
    const Result<MaterialId> id = world->add_material(water);
    if (!id) return id.error();
    FluidDesc fluid;
    fluid.shape = Shape::box({0, 0, 0}, {0.5, 0.5, 0.7});
    fluid.material = *id;
    if (const auto added = world->add_fluid(fluid); !added) return added.error();
    return world;
  };
  p.observe = [](World& world, std::vector<double>& values) -> Status {
    const Result<Totals> totals = world.totals();
    if (!totals) return totals.error();
    values.push_back(totals->potential / totals->mass);
    values.push_back(totals->max_speed);
    return {};
  };
  return p;
}

// Three runs of two observables, one that did not end, and a time that one run never reaches.
TEST(Ensemble, MeanAndSpreadOfWhatEnded) {
  std::vector<trade::Observable> observables(2);
  observables[0].name = "front";
  observables[1].name = "melt_time";
  const double never = std::numeric_limits<double>::quiet_NaN();
  std::vector<trade::Measurement> runs(4);
  runs[0].values = {{1e6 + 1, 5}, {2}};
  runs[1].values = {{1e6 + 2, 5}, {never}};
  runs[2].values = {{1e6 + 6, 5}, {4}};
  runs[3].complete = false;
  const auto means = trade::average(observables, runs);
  ASSERT_TRUE(means) << means.error().message;
  EXPECT_EQ((*means)[0].runs, 3);
  EXPECT_DOUBLE_EQ((*means)[0].values[0], 1e6 + 3);
  EXPECT_DOUBLE_EQ((*means)[0].values[1], 5);
  EXPECT_DOUBLE_EQ((*means)[0].spread, std::sqrt((4 + 1 + 9) / 2.0));  // to the last digits, beside 1e6
  EXPECT_DOUBLE_EQ((*means)[0].error, (*means)[0].spread / std::sqrt(3.0));
  EXPECT_DOUBLE_EQ((*means)[1].values[0], 3);
  runs.resize(1);
  EXPECT_FALSE(trade::average(observables, runs));
  runs.push_back(runs[0]);
  runs[1].values[0].pop_back();
  const auto other = trade::average(observables, runs);
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message.find("\"front\" in different number"), std::string::npos);
}

TEST(Measure, AWorldIsSteppedToItsEndAndRepeats) {
  const trade::Problem problem = column();
  Knobs knobs;
  knobs[Knob::sound_speed] = 0.5;
  const Result<trade::Measurement> a = trade::measure(problem, knobs), b = trade::measure(problem, knobs);
  ASSERT_TRUE(a && b) << (a ? "" : a.error().message);
  EXPECT_TRUE(a->complete) << a->problem;
  EXPECT_EQ(a->values[0].size(), 3u);
  EXPECT_LT(a->values[0].back(), a->values[0].front());  // water falls
  EXPECT_TRUE(std::isnan(a->values[1].at(0)));
  EXPECT_EQ(a->values[0], b->values[0]);
  EXPECT_EQ(a->work, b->work);
  EXPECT_GT(a->substeps, 8u);
  EXPECT_NEAR(a->actual[Knob::sound_speed], 0.5, 1e-6);
  EXPECT_NEAR(a->actual[Knob::spacing], 1, 1e-12);
}

TEST(Measure, WhatCannotBeBuiltOrObservedIsAnError) {
  trade::Problem problem = column();
  Knobs knobs;
  knobs[Knob::spacing] = 10;  // the domain is too small for its support
  const Result<trade::Measurement> coarse = trade::measure(problem, knobs);
  ASSERT_FALSE(coarse);
  EXPECT_EQ(coarse.error().code, ErrorCode::invalid_argument);
  problem.observables.resize(3);
  EXPECT_NE(trade::measure(problem, Knobs{}).error().message.find("observe: expected 3 values"),
            std::string::npos);
  problem.build = [](const Knobs&) -> Result<World> { throw std::runtime_error("lost"); };
  EXPECT_EQ(trade::measure(problem, Knobs{}).error().message, "lost");
}

TEST(Measure, AProbeThatTakesTooLongIsNotComplete) {
  const Result<trade::Measurement> probe = trade::measure(column(), Knobs{}, 0);
  ASSERT_TRUE(probe);
  EXPECT_FALSE(probe->complete);
  EXPECT_EQ(probe->problem, "it took longer than allowed");
}

// A problem that moves its spacing to multiples of 0.2, of which none but 1 is within 9 % of 0.92, 0.99 and 1.07. Three probes of one spacing would tell nothing
// of it.
TEST(Study, ProbesDifferInTheSpacingThatIsBuilt) {
  trade::Problem problem = column();
  const auto build = problem.build;
  problem.build = [build](const Knobs& knobs) {
    Knobs moved = knobs;
    moved[Knob::spacing] = 0.2 * std::round(5 * knobs[Knob::spacing]);
    return build(moved);
  };
  problem.ranges[0] = {0.25, 1.07};
  trade::Options options;
  options.finest = 0.92;
  const Result<trade::Study> study = trade::study(problem, options);
  ASSERT_TRUE(study) << study.error().message;
  std::vector<double> spacings;
  for (const trade::Measurement& m : study->probes) spacings.push_back(m.actual[Knob::spacing]);
  std::sort(spacings.begin(), spacings.end());
  EXPECT_NEAR(spacings.front(), 0.6, 1e-9);
  EXPECT_NEAR(spacings.back(), 1, 1e-9);
  EXPECT_TRUE(
      std::any_of(spacings.begin(), spacings.end(), [](double x) { return std::fabs(x - 0.8) < 1e-9; }));
}

TEST(Study, OfAWorldGivesACostThatRisesWithResolutionAndSoundSpeed) {
  trade::Options options;
  options.seconds = 1e-3;  // planned; the coarsest probes that there may be
  trade::Problem problem = column();
  problem.ranges[0] = {0.25, 1.2};
  const Result<trade::Study> hasty = trade::study(problem, options);
  ASSERT_FALSE(hasty);
  EXPECT_EQ(hasty.error().message.find("seconds: the coarsest probes"), 0u) << hasty.error().message;
  options.seconds = 0.3;
  options.finest = 0.9;
  const Result<trade::Study> study = trade::study(problem, options);
  ASSERT_TRUE(study) << study.error().message;
  const trade::Known& potential = study->observables.at(0);
  // Laws of lattices of a hundred particles: whole particles and whole steps blur them.
  EXPECT_NEAR(law(potential, Knob::spacing).cost_exponent, -4, 2);
  EXPECT_NEAR(law(potential, Knob::sound_speed).cost_exponent, 1, 0.4);
  EXPECT_NEAR(law(potential, Knob::courant).cost_exponent, -1, 0.4);
  EXPECT_GT(study->seconds_per_work, 0);
  ASSERT_EQ(study->notes.size(), 1u);  // of a level that the column is never as high as
  EXPECT_EQ(study->notes[0].find("never: never reaches its level in any probe"), 0u) << study->notes[0];
}

/// Refused by study(), naming the field; by measure() and ensemble(), too, where a run of its own would go wrong.
TEST(Check, WhatAHostGetsWrongIsNamedBeforeAnythingRuns) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  using Change = std::function<void(trade::Problem&)>;
  const auto at = [](Knob knob) { return static_cast<std::size_t>(knob); };
  const std::vector<std::pair<std::string, Change>> wrong{
      {"Problem::end", [](auto& p) { p.end = infinity; }},
      {"Problem::samples", [](auto& p) { p.samples = 0; }},
      {"Problem::longest_step", [](auto& p) { p.longest_step = 0; }},  // steps of 0 s never end
      {"Problem::longest_step", [=](auto& p) { p.longest_step = nan; }},
      {"Problem::longest_sample_step", [](auto& p) { p.longest_sample_step = -1; }},
      {"Problem::diffusivity", [=](auto& p) { p.diffusivity = nan; }},
      {"Problem::reference_work", [](auto& p) { p.reference_work = -1; }},
      {"Problem::ranges: of sound_speed",
       [=](auto& p) {
         p.ranges[at(Knob::sound_speed)] = {0, 2};
       }},
      {"Problem::ranges: of spacing",
       [=](auto& p) {
         p.ranges[at(Knob::spacing)] = {2, 1};
       }},
      {"Problem::ranges: of courant",
       [=](auto& p) {
         p.ranges[at(Knob::courant)] = {1, infinity};
       }},
      {"Observable::scale: of \"potential\"", [](auto& p) { p.observables[0].scale = -1; }},
      {"Observable::components: of \"potential\"", [](auto& p) { p.observables[0].components = 0; }},
      {"Observable::components: of \"never\"", [](auto& p) { p.observables[1].components = 2; }},
      {"Observable::level: of \"never\"", [=](auto& p) { p.observables[1].level = nan; }},
      {"Observable::exact: of \"potential\"",
       [=](auto& p) {
         p.observables[0].exact = {nan, nan, nan};
       }},
      {"Problem::build", [](auto& p) { p.build = {}; }},
      {"Problem::observe", [](auto& p) { p.observe = {}; }}};
  for (const auto& [field, change] : wrong) {
    trade::Problem problem = column();
    change(problem);
    for (const Status& said :
         {Status(trade::study(problem).error()), Status(trade::measure(problem, {}).error()),
          Status(trade::ensemble(problem, {}, 2).error())}) {
      EXPECT_EQ(said.error().code, ErrorCode::invalid_argument) << field;
      EXPECT_EQ(said.error().message.find(field + ": expected"), 0u) << said.error().message;
    }
  }
  trade::Problem twice = column();
  twice.observables[1].name = "potential";
  EXPECT_EQ(
      trade::study(twice).error().message,
      "Observable::name: expected names that differ, as choose() goes by them, got \"potential\" twice");
  Knobs still;
  still[Knob::step] = 0;
  EXPECT_EQ(trade::measure(column(), still).error().message,
            "Knobs: step: expected a multiple above 0, got 0");
  for (const double safety : {0.5, -3.0, nan}) {
    trade::Options options;
    options.safety = safety;
    EXPECT_EQ(trade::study(Made{}.problem(), options).error().message.find("Options::safety: expected"), 0u);
  }
  trade::Options options;
  options.finest = nan;
  EXPECT_EQ(trade::study(Made{}.problem(), options).error().message.find("Options::finest: expected"), 0u);
}

TEST(Check, AnExactAnswerHasAsManyValuesAsAreCompared) {
  trade::Problem problem = Made{}.problem();
  for (const std::size_t n : {1u, 10u, 12u}) {
    problem.observables[0].exact.assign(n, 1.0);
    const auto study = trade::study(problem);
    ASSERT_FALSE(study) << n;
    EXPECT_EQ(study.error().message.find("Observable::exact: of \"y\": expected 11 values"), 0u)
        << study.error().message;
  }
  problem.observables[0].exact.assign(11, 1.0);
  EXPECT_TRUE(trade::study(problem));
}

// NaN against NaN is no difference: without a word, an error of 0 would be promised.
TEST(Study, OfWhatHasNoValueNothingIsPromised) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const bool reached : {false, true}) {
    trade::Problem problem =
        with_curve([&](double, std::size_t i) { return reached ? 0.1 * double(i) : nan; });
    if (reached) {
      problem.observables[0].reduce = trade::Reduce::time_to_reach;
      problem.observables[0].level = 2;
      problem.run = [run = problem.run, o = problem.observables[0], nan](const Knobs& knobs, double limit) {
        Result<trade::Measurement> m = run(knobs, limit);
        m->values[0] = {nan};
        return m;
      };
    }
    const auto study = trade::study(problem);
    ASSERT_TRUE(study) << study.error().message;
    ASSERT_EQ(study->notes.size(), 1u);
    EXPECT_EQ(study->notes[0].find(reached ? "y: never reaches its level" : "y: has no value in any probe"),
              0u)
        << study->notes[0];
    const auto choice = trade::choose(*study, "y", 0.01);
    ASSERT_FALSE(choice);
    EXPECT_EQ(choice.error().message.find("observable: \"y\" had no value in any probe"), 0u)
        << choice.error().message;
    EXPECT_FALSE(trade::front(*study, "y", 5));
    EXPECT_EQ(trade::delivered(*study, 0, Knobs{}, study->probes[0].values[0]).max, infinity);
  }
}

TEST(Study, OfWhatIsTheSameWithAllSettingsSaysSo) {
  for (const trade::Reduce reduce : {trade::Reduce::curve, trade::Reduce::last, trade::Reduce::largest}) {
    trade::Problem problem = Made{}.problem();
    problem.observables[0].reduce = reduce;
    problem.run = [run = problem.run, reduce](const Knobs& knobs, double limit) {
      Result<trade::Measurement> m = run(knobs, limit);
      m->values[0].assign(reduce == trade::Reduce::curve ? 11 : 1, 0.0);
      return m;
    };
    const auto study = trade::study(problem);
    ASSERT_TRUE(study) << study.error().message;
    ASSERT_EQ(study->notes.size(), 1u);
    EXPECT_EQ(study->notes[0].find("y: is the same"), 0u) << study->notes[0];
  }
}

TEST(Study, OfOptionsChoicesTakeTheirSafety) {
  trade::Options careful;
  careful.safety = 3;
  const auto study = trade::study(Made{}.problem(), careful), usual = trade::study(Made{}.problem());
  ASSERT_TRUE(study && usual);
  const auto by_study = trade::choose(*study, "y", 0.06), by_word = trade::choose(*usual, "y", 0.06, 3),
             as_usual = trade::choose(*usual, "y", 0.06);
  ASSERT_TRUE(by_study && by_word && as_usual);
  EXPECT_EQ(by_study->knobs.value, by_word->knobs.value);
  EXPECT_LT(by_study->error, 0.75 * as_usual->error);  // of half of it
}

// What choose() takes for an error costs some seconds: for so many seconds the same settings come back, as either is an optimum.
TEST(ChooseWithin, GivesTheSmallestErrorThatThereIsTimeFor) {
  const trade::Study study = study_of({});
  for (const double error : {0.03, 0.05, 0.08}) {
    const trade::Choice of_error = *trade::choose(study, "y", error, 1);
    ASSERT_TRUE(of_error.attainable);
    const auto of_time = trade::choose_within(study, "y", of_error.seconds * (1 + 1e-9));
    ASSERT_TRUE(of_time) << of_time.error().message;
    EXPECT_TRUE(of_time->attainable);
    EXPECT_NEAR(of_time->error, of_error.error, 1e-6);
    EXPECT_LE(of_time->seconds, of_error.seconds * (1 + 1e-9));
    for (std::size_t k = 0; k < trade::knob_count; ++k)
      EXPECT_NEAR(of_time->knobs.value[k], of_error.knobs.value[k], 1e-5) << k;
  }
  const std::vector<trade::Choice> front = *trade::front(study, "y", 5);
  const trade::Choice none = *trade::choose_within(study, "y", 0.5 * front.front().seconds);
  EXPECT_FALSE(none.attainable);
  EXPECT_EQ(none.knobs.value, front.front().knobs.value);
  const trade::Choice all = *trade::choose_within(study, "y", infinity);
  EXPECT_TRUE(all.attainable);
  EXPECT_EQ(all.knobs.value, front.back().knobs.value);
  EXPECT_FALSE(trade::choose_within(study, "x", 1));
  EXPECT_FALSE(trade::choose_within(study, "y", 0));
  trade::Study free_of_cost = study;
  free_of_cost.seconds_per_work = 0;
  EXPECT_FALSE(trade::choose_within(free_of_cost, "y", 1));
}

TEST(Study, FindsTheWorkOfTheProblemItself) {
  // Of Made: 1 at the problem's own settings.
  trade::Problem problem = Made{}.problem();
  problem.reference_work = 0;
  const auto by_probes = trade::study(problem);
  ASSERT_TRUE(by_probes);
  EXPECT_NEAR(by_probes->reference_work, 1, 1e-9);
  EXPECT_GT(trade::choose(*by_probes, "y", 0.06)->seconds, 0);
  problem.build = column().build;
  problem.end = 0.1;
  const auto built = trade::study(problem);
  ASSERT_TRUE(built);
  EXPECT_GT(built->reference_work, 1000);  // hundreds of particles, dozens of sub-steps
}

TEST(Study, AnInterruptOfAProbeEndsItAndIsNoDivergence) {
  for (const int at : {1, 3}) {
    trade::Problem problem = column();
    problem.observables.pop_back();
    int worlds = 0, samples = 0;
    problem.build = [&, build = problem.build](const Knobs& knobs) {
      samples = 0;
      ++worlds;
      return build(knobs);
    };
    int interrupted = 0;
    problem.observe = [&](World& world, std::vector<double>& values) -> Status {
      values.push_back(world.time());
      if (++samples == 1 && ++interrupted == at) world.interrupt();
      return {};
    };
    const auto study = trade::study(problem);
    ASSERT_FALSE(study);
    EXPECT_EQ(study.error().code, ErrorCode::interrupted) << study.error().message;
  }
}

TEST(Delivered, AnotherNumberOfValuesSaysNothing) {
  const trade::Study study = study_of({});
  for (const std::size_t n : {0u, 1u, 12u})
    EXPECT_EQ(trade::delivered(study, 0, Knobs{}, std::vector<double>(n, 1.0)).max, infinity) << n;
  EXPECT_LT(trade::delivered(study, 0, Knobs{}, std::vector<double>(11, 1.0)).max, 1e-6);
}

TEST(Ensemble, BuildsAWorldPerRunAndOneToReferTo) {
  trade::Problem problem = column();
  int built = 0;
  problem.build = [&, build = problem.build](const Knobs& knobs) {
    ++built;
    return build(knobs);
  };
  ASSERT_TRUE(trade::ensemble(problem, {}, 3));
  EXPECT_EQ(built, 4);
  int seen = 0;
  const auto stopped = trade::ensemble(problem, {}, 3, nullptr, [&](const trade::Measurement&, int of) {
    EXPECT_EQ(of, 3);
    return ++seen < 2;
  });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::interrupted);
  EXPECT_EQ(seen, 2);
}

}  // namespace
