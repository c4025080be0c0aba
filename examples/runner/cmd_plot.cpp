// SPDX-License-Identifier: Apache-2.0
// `meltsim plot DIR`: stats.csv as plots.svg and plots.png.
#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "commands.hpp"
#include "csv.hpp"
#include "failure.hpp"
#include "files.hpp"
#include "run_directory.hpp"
#include "show/plot_script.hpp"
#include "show/programs.hpp"
#include "show/run_frames.hpp"

namespace runner {

namespace {

/// Whether no row of stats.csv has a particle.
bool always_empty(const std::string& table) {
  std::istringstream rows(table);
  std::string row;
  std::getline(rows, row);
  const std::vector<std::string> header = split_commas(row);
  while (std::getline(rows, row)) {
    const std::vector<std::string> cells = split_commas(row);
    for (std::size_t i = 0; i < std::min(cells.size(), header.size()); ++i)
      if ((header[i] == "n_fluid" || header[i] == "n_solid") && cells[i] != "0") return false;
  }
  return true;
}

}  // namespace

int cmd_plot(const std::string& path) {
  const RunDirectory directory{path, {}};
  const Scene scene = run_scene_of(directory);
  if (!exists(directory.file("stats.csv")))
    throw Failure(ExitCode::io, directory.file("stats.csv") + ": is missing; run the scene again");
  const std::string gnuplot = find_program("gnuplot");
  if (gnuplot.empty()) {
    throw Failure(
        ExitCode::usage,
        fmt::format(
            "plot: gnuplot is not in PATH (Debian/Ubuntu: apt install gnuplot-nox); {} has plots that "
            "need only a browser",
            directory.file("index.html")));
  }
  const std::string table = read_file(directory.file("stats.csv"));
  const auto rows = std::count(table.begin(), table.end(), '\n');  // with the header
  const bool empty = always_empty(table);
  const Scratch scratch;
  write_file(scratch.file("stats.csv"), table);
  for (const char* name : {"plots.svg", "plots.png"}) {
    const std::string script = plot_script("stats.csv", name, scene.title.empty() ? path : scene.title,
                                           name[6] == 's', rows < 3, empty);
    write_file(scratch.file("plots.gp"), script);
    const int status = run_program({gnuplot, "plots.gp"}, scratch);
    if (status != 0 || !exists(scratch.file(name))) {
      const std::string said = directory.file("plots.log");
      scratch.take(program_log, said);
      throw Failure(ExitCode::io,
                    fmt::format("{}: gnuplot ended with {}; it said why in {}", path, status, said));
    }
    scratch.take(name, directory.file(name));
    fmt::print("{}\n", directory.file(name));
  }
  return 0;
}

}  // namespace runner
