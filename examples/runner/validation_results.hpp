// SPDX-License-Identifier: Apache-2.0
// What `meltsim validate` makes of the cases' reports: which ran, which passed, and the files it writes.
#pragma once

#include <string>
#include <vector>

#include "scene.hpp"
#include "validation/validation.hpp"

namespace runner {

struct CaseResult {
  const validation::Case* what = nullptr;
  validation::Report report;
  double seconds = 0;
};

/// Where a validation ran.
struct ValidationMachine {
  std::string cpu;      ///< model name, empty when the system does not say
  int cpus = 0;         ///< logical processors
  std::string backend;  ///< "cpu" or "cuda"
  std::string device;   ///< what the backend says it computes on
  std::string reason;   ///< why this backend
  std::string precision;
  int threads = 0;  ///< as asked for; 0 = all
  bool long_cases = false;
  std::string version, commit, date;  ///< commit: of MELTSIM_COMMIT, may be empty; date: UTC, ISO 8601
};

/// error <= target; a NaN never passes.
bool passes(const validation::Row& row);
/// No error, at least one row, and every row passes.
bool passes(const CaseResult& result);
/// 0 when every case passes, else 1.
int validation_exit_code(const std::vector<CaseResult>& results);

/// The cases that the filters name, in their order, long ones only if asked for. No filter = all. A filter
/// holds * or ? and matches the whole name, or is a part of it. One that matches nothing is a usage error.
std::vector<const validation::Case*> select_cases(const std::vector<validation::Case>& cases,
                                                  const std::vector<std::string>& filters, bool long_cases);

std::string validation_table(const std::vector<CaseResult>& results);
std::string validation_csv(const std::vector<CaseResult>& results);
Json validation_json(const ValidationMachine& machine, const std::vector<CaseResult>& results, bool finished);
/// curve,reference,x,y: one row per point.
std::string plot_csv(const validation::Plot& plot);

/// "pass", or "FAIL: 2 of 7 rows".
std::string verdict(const CaseResult& result);

}  // namespace runner
