// SPDX-License-Identifier: Apache-2.0
#include "children.hpp"

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

namespace fuzz {

namespace {

using Clock = std::chrono::steady_clock;

/// Exit status of a child that reported its finding itself; sanitizers use others.
constexpr int violated = 99;

double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

[[noreturn]] void run_child(std::uint64_t first, std::uint64_t end, const Case& one, Progress& progress) {
  for (std::uint64_t item = first; item < end; ++item) {
    progress.item = item;
    const std::string violation = one(item, progress);
    if (!violation.empty()) {
      std::printf("case %llu: %s\n", static_cast<unsigned long long>(item), violation.c_str());
      std::fflush(stdout);
      _exit(violated);  // the next child goes on behind it
    }
    progress.done = progress.done + 1;
  }
  // Leaks are looked for at exit, which destructors of statics belong to.
  std::exit(0);
}

/// Waits for the child; true: it hung and was ended.
bool watch(pid_t child, const Progress& progress, double hang_seconds, int& status) {
  std::uint64_t calls = progress.calls;
  Clock::time_point moved = Clock::now();
  while (waitpid(child, &status, WNOHANG) == 0) {
    usleep(2000);
    if (progress.calls != calls) {
      calls = progress.calls;
      moved = Clock::now();
    }
    if (seconds_since(moved) < hang_seconds) continue;
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
    return true;
  }
  return false;
}

}  // namespace

bool parse(int argc, char** argv, Options& options,
           const std::function<bool(const std::string&, const std::string&)>& other, const char* usage) {
  for (int i = 1; i < argc; i += 2) {
    const std::string name = argv[i], value = i + 1 < argc ? argv[i + 1] : "";
    char* end = nullptr;
    const double number = std::strtod(value.c_str(), &end);
    const bool numeric = !value.empty() && *end == '\0' && number >= 0;
    if (name == "--cases" && numeric) options.count = static_cast<std::uint64_t>(number);
    else if (name == "--first" && numeric) options.first = static_cast<std::uint64_t>(number);
    else if (name == "--seconds" && numeric) options.seconds = number;
    else if (name == "--hang" && numeric) options.hang_seconds = number;
    else if (name == "--here" && numeric) options.here = number != 0;
    else if (value.empty() || !other(name, value)) {
      std::fprintf(stderr,
                   "%s: %s?\nusage: [--cases N] [--first K] [--seconds S] [--hang S] [--here 0|1] %s\n",
                   argv[0], name.c_str(), usage);
      return false;
    }
  }
  return true;
}

namespace {

int run_here(const Options& options, const Case& one) {
  Progress progress;
  const Clock::time_point start = Clock::now();
  std::uint64_t item = options.first, findings = 0;
  for (; item < options.first + options.count; ++item) {
    if (options.seconds > 0 && seconds_since(start) >= options.seconds) break;
    const std::string violation = one(item, progress);
    if (violation.empty()) continue;
    ++findings;
    std::printf("case %llu: %s\n", static_cast<unsigned long long>(item), violation.c_str());
  }
  std::printf("%llu cases from %llu on ran to their end, %llu findings, %.0f s\n",
              static_cast<unsigned long long>(item - options.first - findings),
              static_cast<unsigned long long>(options.first), static_cast<unsigned long long>(findings),
              seconds_since(start));
  return findings == 0 && item > options.first ? 0 : 1;
}

}  // namespace

int run(const Options& options, const Case& one) {
  if (options.here) return run_here(options, one);
  void* const shared =
      mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) {
    std::perror("mmap");
    return 1;
  }
  Progress& progress = *new (shared) Progress;
  const Clock::time_point start = Clock::now();
  std::uint64_t item = options.first, done = 0, findings = 0;
  const std::uint64_t end = options.first + options.count;
  while (item < end && (options.seconds <= 0 || seconds_since(start) < options.seconds)) {
    progress.item = item;
    progress.done = 0;
    std::fflush(stdout);
    const std::uint64_t last = std::min(end, item + options.per_child);
    const pid_t child = fork();
    if (child < 0) {
      std::perror("fork");
      return 1;
    }
    if (child == 0) run_child(item, last, one, progress);
    int status = 0;
    const bool hung = watch(child, progress, options.hang_seconds, status);
    done += progress.done;
    item = last;
    if (!hung && WIFEXITED(status) && WEXITSTATUS(status) == 0) continue;
    ++findings;
    item = progress.item + 1;
    const auto number = static_cast<unsigned long long>(progress.item);
    if (hung)
      std::printf("case %llu: no answer for %g s from: %s\n", number, options.hang_seconds, progress.what);
    else if (WIFSIGNALED(status))
      std::printf("case %llu: ended by signal %d in: %s\n", number, WTERMSIG(status), progress.what);
    else if (WEXITSTATUS(status) != violated)
      std::printf("case %llu: the process exited with %d in: %s\n", number, WEXITSTATUS(status),
                  progress.what);
  }
  std::printf("%llu cases from %llu on ran to their end, %llu findings, %.0f s\n",
              static_cast<unsigned long long>(done), static_cast<unsigned long long>(options.first),
              static_cast<unsigned long long>(findings), seconds_since(start));
  return findings == 0 && done > 0 ? 0 : 1;
}

}  // namespace fuzz
