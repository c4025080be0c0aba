// SPDX-License-Identifier: Apache-2.0
#include "validation_results.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "csv.hpp"
#include "failure.hpp"
#include "suggest.hpp"

namespace runner {

namespace {

using validation::Case;
using validation::Curve;
using validation::Plot;
using validation::Row;

/// * stands for any text, ? for one character.
bool glob(const char* pattern, const char* text) {
  for (; *pattern != '\0'; ++pattern, ++text) {
    if (*pattern == '*') {
      for (const char* rest = text;; ++rest) {
        if (glob(pattern + 1, rest)) return true;
        if (*rest == '\0') return false;
      }
    }
    if (*text == '\0' || (*pattern != '?' && *pattern != *text)) return false;
  }
  return *text == '\0';
}

bool matches(const std::string& filter, const std::string& name) {
  const bool is_glob = filter.find_first_of("*?") != std::string::npos;
  return is_glob ? glob(filter.c_str(), name.c_str()) : name.find(filter) != std::string::npos;
}

/// As a cell of a table on disk: quoted where a comma or a quote would break it.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string with_unit(double value, const std::string& unit) {
  return unit.empty() || unit == "-" ? fmt::format("{:.3g}", value) : fmt::format("{:.3g} {}", value, unit);
}

std::size_t failed_rows(const CaseResult& result) {
  const auto& rows = result.report.rows;
  return static_cast<std::size_t>(
      std::count_if(rows.begin(), rows.end(), [](const Row& row) { return !passes(row); }));
}

/// Columns as wide as their widest cell; the first two to the left, numbers to the right.
std::string aligned(const std::vector<std::vector<std::string>>& lines) {
  std::vector<std::size_t> widths;
  for (const auto& line : lines) {
    widths.resize(std::max(widths.size(), line.size()));
    for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], line[i].size());
  }
  std::string text;
  for (const auto& line : lines) {
    std::string out;
    for (std::size_t i = 0; i < line.size(); ++i) {
      if (i > 0) out += "  ";
      out += i < 2 ? fmt::format("{:<{}}", line[i], widths[i]) : fmt::format("{:>{}}", line[i], widths[i]);
    }
    out.erase(out.find_last_not_of(' ') + 1);
    text += out + "\n";
  }
  return text;
}

Json curve_json(const Curve& curve) {
  return {{"name", curve.name}, {"reference", curve.reference}, {"x", curve.x}, {"y", curve.y}};
}

Json plot_json(const Plot& plot) {
  Json json = {{"name", plot.name},
               {"title", plot.title},
               {"x_label", plot.x_label},
               {"y_label", plot.y_label},
               {"file", plot.name + ".csv"}};
  json["curves"] = Json::array();
  for (const Curve& curve : plot.curves) json["curves"].push_back(curve_json(curve));
  return json;
}

Json case_json(const CaseResult& result) {
  const validation::Report& report = result.report;
  Json json = {{"name", result.what->name},    {"what", result.what->what}, {"source", result.what->source},
               {"long", result.what->is_long}, {"seconds", result.seconds}, {"pass", passes(result)},
               {"rows", Json::array()},        {"note", report.note},       {"error", report.error},
               {"plots", Json::array()}};
  for (const Row& row : report.rows) {
    json["rows"].push_back({{"quantity", row.quantity},
                            {"value", row.value},
                            {"reference", row.reference},
                            {"error", row.error},
                            {"target", row.target},
                            {"unit", row.unit},
                            {"reason", row.reason},
                            {"pass", passes(row)}});
  }
  for (const Plot& plot : report.plots) json["plots"].push_back(plot_json(plot));
  return json;
}

}  // namespace

bool passes(const Row& row) { return row.error <= row.target; }

bool passes(const CaseResult& result) {
  return result.report.error.empty() && !result.report.rows.empty() && failed_rows(result) == 0;
}

int validation_exit_code(const std::vector<CaseResult>& results) {
  return std::all_of(results.begin(), results.end(), [](const CaseResult& r) { return passes(r); }) ? 0 : 1;
}

std::vector<const Case*> select_cases(const std::vector<Case>& cases, const std::vector<std::string>& filters,
                                      bool long_cases) {
  std::vector<std::string> names;
  for (const Case& one : cases) names.emplace_back(one.name);
  for (const std::string& filter : filters) {
    bool any = false, any_short = false;
    for (const Case& one : cases) {
      if (!matches(filter, one.name)) continue;
      any = true;
      any_short = any_short || !one.is_long;
    }
    if (!any) {
      throw Failure(ExitCode::usage, fmt::format("--filter: no case matches \"{}\"{}", filter,
                                                 suggestion(filter, names, "cases")));
    }
    if (!any_short && !long_cases) {
      throw Failure(ExitCode::usage,
                    fmt::format("--filter: \"{}\" matches long cases only; add --long", filter));
    }
  }
  std::vector<const Case*> selected;
  for (const Case& one : cases) {
    const bool named =
        filters.empty() || std::any_of(filters.begin(), filters.end(),
                                       [&](const auto& filter) { return matches(filter, one.name); });
    if (named && (long_cases || !one.is_long)) selected.push_back(&one);
  }
  return selected;
}

std::string verdict(const CaseResult& result) {
  if (passes(result)) return "pass";
  if (!result.report.error.empty()) return "FAIL: " + result.report.error;
  if (result.report.rows.empty()) return "FAIL: it reported no rows";
  return fmt::format("FAIL: {} of {} rows", failed_rows(result), result.report.rows.size());
}

std::string validation_table(const std::vector<CaseResult>& results) {
  std::vector<std::vector<std::string>> lines{
      {"case", "quantity", "value", "reference", "error", "target", "", "seconds"}};
  for (const CaseResult& result : results) {
    std::string name = result.what->name, seconds = fmt::format("{:.1f}", result.seconds);
    if (!passes(result) && (!result.report.error.empty() || result.report.rows.empty())) {
      lines.push_back({name, verdict(result), "", "", "", "", "FAIL", seconds});
      name = seconds = "";
    }
    for (const Row& row : result.report.rows) {
      lines.push_back({name, row.quantity, fmt::format("{:.6g}", row.value),
                       fmt::format("{:.6g}", row.reference), with_unit(row.error, row.unit),
                       with_unit(row.target, row.unit), passes(row) ? "pass" : "FAIL", seconds});
      name = seconds = "";
    }
  }
  std::string text = aligned(lines);
  for (const CaseResult& result : results) {
    if (!result.report.note.empty())
      text += fmt::format("note  {}: {}\n", result.what->name, result.report.note);
  }
  return text;
}

std::string validation_csv(const std::vector<CaseResult>& results) {
  std::string text = "case,quantity,value,reference,error,target,unit,pass,seconds,reason\n";
  for (const CaseResult& result : results) {
    const std::string name = cell(result.what->name);
    if (!result.report.error.empty() || result.report.rows.empty()) {
      text += fmt::format("{},{},nan,nan,nan,nan,-,0,{},\n", name, cell(verdict(result)),
                          csv_number(result.seconds));
    }
    for (const Row& row : result.report.rows) {
      text += fmt::format("{},{},{},{},{},{},{},{},{},{}\n", name, cell(row.quantity), csv_number(row.value),
                          csv_number(row.reference), csv_number(row.error), csv_number(row.target),
                          cell(row.unit), passes(row) ? 1 : 0, csv_number(result.seconds), cell(row.reason));
    }
  }
  return text;
}

std::string plot_csv(const Plot& plot) {
  std::string text = "curve,reference,x,y\n";
  for (const Curve& curve : plot.curves) {
    const std::size_t points = std::min(curve.x.size(), curve.y.size());
    for (std::size_t i = 0; i < points; ++i) {
      text += fmt::format("{},{},{},{}\n", cell(curve.name), curve.reference ? 1 : 0, csv_number(curve.x[i]),
                          csv_number(curve.y[i]));
    }
  }
  return text;
}

Json validation_json(const ValidationMachine& machine, const std::vector<CaseResult>& results,
                     bool finished) {
  Json json;
  json["format"] = 1;
  json["version"] = machine.version;
  json["commit"] = machine.commit.empty() ? Json(nullptr) : Json(machine.commit);
  json["date"] = machine.date;
  json["machine"] = {{"cpu", machine.cpu}, {"cpus", machine.cpus}};
  json["backend"] = {{"name", machine.backend}, {"device", machine.device}, {"reason", machine.reason}};
  json["precision"] = machine.precision;
  json["threads"] = machine.threads;
  json["long"] = machine.long_cases;
  json["finished"] = finished;
  json["cases"] = Json::array();
  std::size_t failed = 0;
  double seconds = 0;
  for (const CaseResult& result : results) {
    json["cases"].push_back(case_json(result));
    failed += passes(result) ? 0u : 1u;
    seconds += result.seconds;
  }
  json["summary"] = {{"cases", results.size()}, {"failed", failed}, {"seconds", seconds}};
  return json;
}

}  // namespace runner
