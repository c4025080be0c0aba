// SPDX-License-Identifier: Apache-2.0
// Which cases `meltsim validate` runs, what counts as a failure, and what it writes about it. The cases here
// are made up: what the real ones measure is not the matter.
#include <gtest/gtest.h>

#include <limits>

#include "failure.hpp"
#include "validation_results.hpp"

namespace runner {
namespace {

void nothing(const validation::Settings&, validation::Report&) {}

const std::vector<validation::Case> three{{"heat.slab", "a slab", "a book", false, nothing},
                                          {"heat.cube", "a cube", "a book", true, nothing},
                                          {"solid.bar", "a bar", "theory", false, nothing}};

std::vector<std::string> selected(const std::vector<std::string>& filters, bool long_cases) {
  std::vector<std::string> names;
  for (const validation::Case* one : select_cases(three, filters, long_cases)) names.emplace_back(one->name);
  return names;
}

CaseResult result(double value, double target) {
  CaseResult r;
  r.what = &three[0];
  r.seconds = 1.5;
  r.report.relative("temperature", value, 2, target, "a reason, with a comma");
  return r;
}

using Names = std::vector<std::string>;

TEST(ValidateSelection, FiltersAreGlobsOrPartsOfNames) {
  EXPECT_EQ(selected({}, false), (Names{"heat.slab", "solid.bar"}));
  EXPECT_EQ(selected({}, true), (Names{"heat.slab", "heat.cube", "solid.bar"}));
  EXPECT_EQ(selected({"heat"}, true), (Names{"heat.slab", "heat.cube"}));
  EXPECT_EQ(selected({"*b"}, true), (Names{"heat.slab"}));  // a glob is the whole name: not heat.cube
  EXPECT_EQ(selected({"solid.b?r", "slab"}, false), (Names{"heat.slab", "solid.bar"}));  // in their order
}

TEST(ValidateSelection, AFilterThatMatchesNothingIsAUsageErrorWithASuggestion) {
  const auto message = [](const std::string& filter) {
    try {
      select_cases(three, {"heat", filter}, false);
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.code(), ExitCode::usage);
      return std::string(failure.what());
    }
    return std::string("no error");
  };
  EXPECT_EQ(message("heat.slba"), "--filter: no case matches \"heat.slba\"; did you mean \"heat.slab\"?");
  EXPECT_EQ(message("zzz"),
            "--filter: no case matches \"zzz\"; known cases: heat.slab, heat.cube, solid.bar");
  EXPECT_EQ(message("cube"), "--filter: \"cube\" matches long cases only; add --long");
}

TEST(ValidateVerdict, ExitCodeIsOneWhenAnyRowFails) {
  const CaseResult good = result(2.02, 1.5), bad = result(2.2, 1.5);  // 1 % and 10 % off
  EXPECT_EQ(validation_exit_code({good, good}), 0);
  EXPECT_EQ(validation_exit_code({good, bad}), 1);
  EXPECT_EQ(verdict(good), "pass");
  EXPECT_EQ(verdict(bad), "FAIL: 1 of 1 rows");
}

TEST(ValidateVerdict, NotANumberErrorsAndEmptyReportsFail) {
  EXPECT_FALSE(passes(result(std::numeric_limits<double>::quiet_NaN(), 1e9)));
  CaseResult refused = result(2, 1);
  refused.report.error = "the World halted";
  EXPECT_EQ(verdict(refused), "FAIL: the World halted");
  EXPECT_EQ(validation_exit_code({refused}), 1);
  CaseResult silent;
  silent.what = &three[0];
  EXPECT_EQ(verdict(silent), "FAIL: it reported no rows");
  EXPECT_EQ(validation_exit_code({silent}), 1);
}

TEST(ValidateVerdict, AnyDeviationFromAReferenceOfZeroFails) {
  validation::Report report;
  report.relative("nothing", 0, 0, 1, "");
  report.relative("something", 1e-30, 0, 1, "");
  EXPECT_TRUE(passes(report.rows[0]));
  EXPECT_FALSE(passes(report.rows[1]));
}

TEST(ValidateOutput, TableShowsErrorTargetAndMarkPerRow) {
  CaseResult r = result(2.02, 1.5);
  r.report.absolute("front", 0.5, 0.2, 0.1, "dx", "");
  r.report.note = "coarse";
  const std::string table = validation_table({r});
  EXPECT_NE(table.find("heat.slab  temperature   2.02          2     1 %   1.5 %  pass      1.5\n"),
            std::string::npos)
      << table;
  EXPECT_NE(table.find("           front          0.5        0.2  0.3 dx  0.1 dx  FAIL\n"), std::string::npos)
      << table;
  EXPECT_NE(table.find("note  heat.slab: coarse\n"), std::string::npos) << table;
}

TEST(ValidateOutput, CsvHoldsOneLinePerRowAndQuotesCommas) {
  EXPECT_EQ(validation_csv({result(2.02, 1.5)}),
            "case,quantity,value,reference,error,target,unit,pass,seconds,reason\n"
            "heat.slab,temperature,2.02,2,1,1.5,%,1,1.5,\"a reason, with a comma\"\n");
  CaseResult refused;
  refused.what = &three[0];
  refused.report.error = "no";
  EXPECT_NE(validation_csv({refused}).find("heat.slab,FAIL: no,nan,"), std::string::npos);
}

TEST(ValidateOutput, JsonHoldsRowsPlotsAndTheMachine) {
  CaseResult r = result(2.2, 1.5);
  r.report.plots.push_back({"slab", "A slab", "x [m]", "T [C]", {{"ours", {0, 1}, {2, 3}, false}}});
  ValidationMachine machine;
  machine.cpu = "a processor";
  machine.commit = "abc";
  const Json json = validation_json(machine, {r}, true);
  EXPECT_EQ(json["machine"]["cpu"], "a processor");
  EXPECT_EQ(json["commit"], "abc");
  EXPECT_EQ(json["summary"]["failed"], 1);
  EXPECT_EQ(json["cases"][0]["rows"][0]["pass"], false);
  EXPECT_EQ(json["cases"][0]["plots"][0]["curves"][0]["y"], Json({2.0, 3.0}));
  EXPECT_EQ(plot_csv(r.report.plots[0]), "curve,reference,x,y\nours,0,0,2\nours,0,1,3\n");
  machine.commit = "";
  EXPECT_TRUE(validation_json(machine, {}, true)["commit"].is_null());
}

TEST(ValidateCases, NamesAreUniqueAndCarryTheirSubject) {
  Names names;
  for (const validation::Case& one : validation::all_cases()) {
    const std::string name = one.name;
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 0) << name;
    EXPECT_NE(name.find('.'), std::string::npos) << name;
    EXPECT_NE(std::string(one.source), "") << name;
    names.push_back(name);
  }
  EXPECT_FALSE(names.empty());
}

}  // namespace
}  // namespace runner
