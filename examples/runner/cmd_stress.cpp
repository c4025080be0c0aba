// SPDX-License-Identifier: Apache-2.0
// `meltsim stress`: what holds at the extremes.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>

#include "build_world.hpp"
#include "commands.hpp"
#include "failure.hpp"
#include "files.hpp"
#include "show/map_svg.hpp"
#include "stress/setup.hpp"

namespace runner {

namespace {

using stress::Outcome;
using stress::Verdict;

struct Column {
  meltsim::Backend backend;
  meltsim::Precision precision;
  std::string name() const {
    return fmt::format("{} {}", backend_name(backend),
                       precision == meltsim::Precision::double_precision ? "double" : "single");
  }
};

std::string full_name(const stress::Setup& cell) { return cell.axis + ": " + cell.value; }

bool wanted(const stress::Setup& cell, const StressOptions& options) {
  if (cell.long_one && !options.long_cells) return false;
  if (options.filters.empty()) return true;
  const std::string name = full_name(cell);
  return std::any_of(options.filters.begin(), options.filters.end(),
                     [&](const std::string& part) { return name.find(part) != std::string::npos; });
}

std::vector<Column> columns_of(const StressOptions& options) {
  std::vector<meltsim::Backend> backends = options.backends;
  if (backends.empty()) {
    backends.push_back(meltsim::Backend::cpu);
    if (!meltsim::build_info().devices.empty()) backends.push_back(meltsim::Backend::cuda);
  }
  std::vector<Column> columns;
  for (const meltsim::Backend backend : backends)
    for (const meltsim::Precision precision : options.precisions) columns.push_back({backend, precision});
  return columns;
}

std::string csv_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c == '\n' ? ' ' : c);
  return quoted + "\"";
}

class Stress {
 public:
  Stress(const StressOptions& options, std::vector<stress::Setup> cells)
      : options_(options), cells_(std::move(cells)), columns_(columns_of(options)) {}

  int run() {
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      fmt::print("{}{}", c == 0 ? "columns: " : ", ", columns_[c].name());
    }
    fmt::print("; . holds, c clamped with a flag, r refused with a fix, X fails\n");
    std::string axis;
    for (const stress::Setup& cell : cells_) {
      if (cell.axis != axis) fmt::print("{}{:26}", axis.empty() ? "" : "\n", cell.axis);
      axis = cell.axis;
      outcomes_.emplace_back();
      std::string marks;
      for (const Column& column : columns_) {
        stress::Setup setup = cell;
        setup.world.backend = column.backend;
        setup.world.precision = column.precision;
        outcomes_.back().push_back(stress::run_cell(std::move(setup)));
        const Outcome& o = outcomes_.back().back();
        marks += ".crX"[static_cast<std::size_t>(o.verdict)];
        ++counts_[static_cast<std::size_t>(o.verdict)];
      }
      fmt::print(" {}{}", cell.value, " " + marks);
      std::fflush(stdout);
    }
    fmt::print("\n\n");
    print_failures();
    fmt::print("{} hold, {} clamped, {} refused, {} fail; {:.1f} s\n", counts_[0], counts_[1], counts_[2],
               counts_[3], std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    if (!options_.out.empty()) write();
    return counts_[3] == 0 ? 0 : 1;
  }

 private:
  void print_failures() {
    for (std::size_t i = 0; i < cells_.size(); ++i)
      for (std::size_t c = 0; c < columns_.size(); ++c)
        if (outcomes_[i][c].verdict == Verdict::fails)
          fmt::print("FAILS {}{}{} ({}): {}\n", full_name(cells_[i]), cells_[i].drawn.empty() ? "" : ", ",
                     cells_[i].drawn, columns_[c].name(), outcomes_[i][c].note);
  }

  void write() {
    make_directories(options_.out);
    std::string csv =
        "axis,value,backend,precision,verdict,note,energy_gain,max_speed,particles,substeps,time,wall_s\n";
    std::vector<MapRow> rows;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (rows.empty() || rows.back().label != cells_[i].axis) rows.push_back({cells_[i].axis, {}});
      MapCell field{cells_[i].value, {}, {}};
      for (std::size_t c = 0; c < columns_.size(); ++c) {
        const Outcome& o = outcomes_[i][c];
        const bool twice = columns_[c].precision == meltsim::Precision::double_precision;
        csv += fmt::format("{},{},{},{},{},{},{:.4g},{:.4g},{},{},{:.6g},{:.3g}\n", csv_text(cells_[i].axis),
                           csv_text(cells_[i].value), backend_name(columns_[c].backend),
                           twice ? "double" : "single", stress::name_of(o.verdict), csv_text(o.note),
                           o.energy, o.speed, o.particles, o.substeps, o.time, o.wall_s);
        field.kinds.push_back(static_cast<int>(o.verdict));
        field.titles.push_back(fmt::format("{} ({}): {}{}{}", full_name(cells_[i]), columns_[c].name(),
                                           stress::name_of(o.verdict), o.note.empty() ? "" : ": ", o.note));
      }
      rows.back().cells.push_back(field);
    }
    std::vector<std::string> names;
    for (const Column& column : columns_) names.push_back(column.name());
    write_file(options_.out + "/stability.csv", csv);
    write_file(options_.out + "/stability.svg", map_svg("What holds at the extremes", names,
                                                        {{"holds", "#2e9e4f"},
                                                         {"clamped, with a flag", "#8fc93a"},
                                                         {"refused, with the fix", "#4a7fd6"},
                                                         {"fails", "#d1392b"}},
                                                        rows));
    fmt::print("wrote {0}/stability.csv and {0}/stability.svg\n", options_.out);
  }

  const StressOptions& options_;
  std::vector<stress::Setup> cells_;
  std::vector<Column> columns_;
  std::vector<std::vector<Outcome>> outcomes_;  ///< per cell and column
  std::array<std::size_t, 4> counts_{};
};

}  // namespace

int cmd_stress(const StressOptions& options) {
  std::vector<stress::Setup> cells;
  if (options.draws == 0) cells = stress::all_cells();
  for (std::uint64_t k = 0; k < options.draws; ++k) cells.push_back(stress::drawn_cell(options.seed, k));
  cells.erase(std::remove_if(cells.begin(), cells.end(),
                             [&](const stress::Setup& cell) { return !wanted(cell, options); }),
              cells.end());
  if (options.list) {
    for (const stress::Setup& cell : cells) fmt::print("{}\n", full_name(cell));
    return 0;
  }
  if (cells.empty())
    throw Failure(ExitCode::usage, "--filter: no cell has that in its name; see meltsim stress --list");
  if (exists(options.out))
    throw Failure(ExitCode::io, options.out + ": exists already; name another directory");
  return Stress(options, std::move(cells)).run();
}

}  // namespace runner
