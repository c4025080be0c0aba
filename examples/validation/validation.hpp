// SPDX-License-Identifier: Apache-2.0
// What a validation case is. A case builds Worlds through the public API, runs them, and reports rows (a
// number, its reference, the target) and plots (ours against the reference). One file per subject:
// cases_<subject>.cpp.
#pragma once

#include <string>
#include <vector>

#include "meltsim/meltsim.hpp"

namespace validation {

/// How to run: handed to every World a case makes.
struct Settings {
  meltsim::Backend backend = meltsim::Backend::automatic;
  meltsim::Precision precision = meltsim::Precision::single_precision;
  int threads = 0;
  bool long_cases = false;      ///< also those that take minutes on a CPU
  int draws = 3;                ///< of each case that is drawn at random
  unsigned long long seed = 1;  ///< of those draws
};

/// One line of the table. `error` is what is compared: pass means error <= target.
struct Row {
  std::string quantity;  ///< what was measured, e.g. "temperature at the centre, Fo 0.1"
  double value = 0;      ///< ours
  double reference = 0;  ///< theirs
  double error = 0;      ///< in the unit of the target
  double target = 0;
  std::string unit;    ///< of error and target: "%", "dx", "C", "-"
  std::string reason;  ///< why this target
};

/// A curve of a plot; `reference` ones are drawn as points or dashed.
struct Curve {
  std::string name;
  std::vector<double> x, y;
  bool reference = false;
};

struct Plot {
  std::string name;  ///< file name without directory and extension
  std::string title, x_label, y_label;
  std::vector<Curve> curves;
};

struct Report {
  std::vector<Row> rows;
  std::vector<Plot> plots;
  std::string note;   ///< what falls short and why; shown below the table
  std::string error;  ///< not empty: the case could not run (a World refused or halted)

  /// Adds a row with error = |value - reference| / |reference| in percent.
  void relative(const std::string& quantity, double value, double reference, double target_percent,
                const std::string& reason);
  /// Adds a row with error = |value - reference| in `unit`.
  void absolute(const std::string& quantity, double value, double reference, double target,
                const std::string& unit, const std::string& reason);
};

struct Case {
  const char* name;    ///< "heat.slab": what --filter matches
  const char* what;    ///< one line
  const char* source;  ///< where the reference comes from
  bool is_long;        ///< minutes on a CPU: runs with --long only
  void (*run)(const Settings&, Report&);
};

/// All cases, in the order of the table. Every subject's file defines one list; cases.cpp joins them.
const std::vector<Case>& all_cases();
std::vector<Case> heat_cases();
std::vector<Case> phase_cases();
std::vector<Case> liquid_cases();
std::vector<Case> viscous_cases();
std::vector<Case> flow_cases();
std::vector<Case> tension_cases();
std::vector<Case> species_cases();
std::vector<Case> coupling_cases();
std::vector<Case> solid_cases();
std::vector<Case> surface_cases();
std::vector<Case> drawn_cases();
std::vector<Case> drawn_liquids_cases();
std::vector<Case> drawn_surfaces_cases();

/// A WorldDesc with the settings filled in.
meltsim::WorldDesc world_desc(const Settings& s);

}  // namespace validation
