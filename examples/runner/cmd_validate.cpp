// SPDX-License-Identifier: Apache-2.0
// `meltsim validate`: runs the cases of examples/validation and compares them with their references.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <thread>

#include "build_world.hpp"
#include "commands.hpp"
#include "failure.hpp"
#include "files.hpp"
#include "library_error.hpp"
#include "validation_results.hpp"

namespace runner {

namespace {

std::string cpu_name() {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line)) {
    const std::size_t colon = line.find(": ");
    if (line.compare(0, 10, "model name") == 0 && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "";
}

/// A World that holds nothing says where the cases will run, and refuses what cannot be had.
ValidationMachine machine_of(const ValidateOptions& options, const validation::Settings& settings) {
  auto world = meltsim::World::create(validation::world_desc(settings));
  if (!world) throw Failure(exit_code(world.error().code), world.error().message);
  const meltsim::Resolved resolved = world->resolved();
  ValidationMachine machine;
  machine.cpu = cpu_name();
  machine.cpus = static_cast<int>(std::thread::hardware_concurrency());
  machine.backend = backend_name(resolved.backend);
  machine.device = resolved.device_name;
  machine.reason = resolved.backend_reason;
  machine.precision = settings.precision == meltsim::Precision::double_precision ? "double" : "single";
  machine.threads = options.machine.threads;
  machine.long_cases = options.long_cases;
  machine.version = meltsim::build_info().version;
  if (const char* commit = std::getenv("MELTSIM_COMMIT")) machine.commit = commit;
  machine.date = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  return machine;
}

void make_directory(const std::string& out) {
  if (exists(out + "/validation.json"))
    throw Failure(ExitCode::io, out + ": holds a validation already, which is kept; choose another --out");
  make_directories(out);
}

void write_results(const std::string& out, const ValidationMachine& machine,
                   const std::vector<CaseResult>& results, bool finished) {
  if (out.empty()) return;
  write_file(out + "/validation.csv", validation_csv(results));
  const Json json = validation_json(machine, results, finished);
  write_file(out + "/validation.json", json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
  for (const CaseResult& result : results) {
    for (const validation::Plot& plot : result.report.plots)
      write_file(fmt::format("{}/{}.csv", out, plot.name), plot_csv(plot));
  }
}

CaseResult run_case(const validation::Case& one, const validation::Settings& settings) {
  CaseResult result;
  result.what = &one;
  const auto start = std::chrono::steady_clock::now();
  try {
    one.run(settings, result.report);
  } catch (const std::exception& error) {
    result.report.error = fmt::format("stopped with an exception: {}", error.what());
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

int list_cases(const std::vector<const validation::Case*>& cases) {
  for (const validation::Case* one : cases)
    fmt::print("{:<28}{:<6}{}\n", one->name, one->is_long ? "long" : "", one->what);
  return 0;
}

}  // namespace

int cmd_validate(const ValidateOptions& options) {
  // A list shows what there is, long or not.
  const auto cases =
      select_cases(validation::all_cases(), options.filters, options.long_cases || options.list);
  if (options.list) return list_cases(cases);
  validation::Settings settings;
  settings.backend = options.machine.backend;
  settings.precision = options.machine.precision;
  settings.threads = options.machine.threads;
  settings.long_cases = options.long_cases;
  settings.draws = options.draws;
  settings.seed = options.seed;
  const ValidationMachine machine = machine_of(options, settings);
  if (!options.out.empty()) make_directory(options.out);
  fmt::print("meltsim {}, {} precision, {}: {} ({})\n", machine.version, machine.precision, machine.backend,
             machine.device, machine.reason);
  std::vector<CaseResult> results;
  for (const validation::Case* one : cases) {
    fmt::print("[{:>2}/{}] {:<28}", results.size() + 1, cases.size(), one->name);
    std::fflush(stdout);
    results.push_back(run_case(*one, settings));
    fmt::print("{:7.1f} s  {}\n", results.back().seconds, verdict(results.back()));
    std::fflush(stdout);
    write_results(options.out, machine, results,
                  results.size() == cases.size());  // a long run may be stopped
  }
  fmt::print("\n{}", validation_table(results));
  std::size_t passed = 0;
  for (const CaseResult& result : results) passed += passes(result) ? 1u : 0u;
  fmt::print("{} of {} cases pass\n", passed, results.size());
  return validation_exit_code(results);
}

}  // namespace runner
