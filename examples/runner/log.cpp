// SPDX-License-Identifier: Apache-2.0
#include "log.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "numbers.hpp"

namespace runner {

namespace {

std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

Json progress_json(const Progress& p) {
  Json json;
  json["event"] = "progress";
  json["percent"] = 100 * p.done;
  json["time_s"] = p.time;
  json["end_s"] = p.end;  // null when a number of steps was asked for
  json["dt_s"] = p.dt;
  json["step"] = p.steps;
  json["n_fluid"] = p.fluid;
  json["n_solid"] = p.solid;
  json["melted_fraction"] = p.melted.value_or(0);
  json["ms_per_step"] = p.ms_per_step;
  json["real_time_ratio"] = p.real_time_ratio;
  json["eta_s"] = p.eta;
  return json;
}

std::size_t terminal_columns() {
  winsize size{};
  const bool known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return known ? size.ws_col : 80;
}

}  // namespace

std::string progress_text(const Progress& p) {
  // What matters most comes first: a narrow terminal cuts the rest off.
  const std::string end = std::isfinite(p.end) ? fmt::format("/{:.4g}", p.end) : "";
  return fmt::format(
      "{:>7}  t={:.4g}{} s  ETA {}  melted {}  liquid {}  solid {}  dt={:.3g} s  {:.3g} ms/step  "
      "{:.2g}x real time",
      percent_text(p.done), p.time, end, duration_text(p.eta), percent_text(p.melted.value_or(0)), p.fluid,
      p.solid, p.dt, p.ms_per_step, p.real_time_ratio);
}

std::string progress_bar(const Progress& p, std::size_t columns) {
  columns = std::min<std::size_t>(columns, 80);
  const std::string end = std::isfinite(p.end) ? fmt::format("/{:.3g}", p.end) : "";
  // What matters most comes first: a narrow terminal cuts the rest off.
  std::string text = fmt::format(" {:3.0f} % {:.3g}{} s", std::floor(100 * p.done), p.time, end);
  if (p.melted) text += fmt::format(" melted {:.0f} %", std::floor(100 * *p.melted));
  text +=
      fmt::format(" {:.3g} ms/step {:.2g}x ETA {}", p.ms_per_step, p.real_time_ratio, duration_text(p.eta));
  constexpr std::size_t shortest = 6;
  if (columns < text.size() + shortest) return text.substr(1, columns);
  const std::size_t length = columns - text.size() - 2;
  const auto full = static_cast<std::size_t>(p.done * static_cast<double>(length));
  return "[" + std::string(full, '#') + std::string(length - full, '.') + "]" + text;
}

Log::Log(LogStyle style, bool quiet)
    : style_(style), quiet_(quiet), terminal_(isatty(STDOUT_FILENO) == 1), last_shown_(Clock::now()) {}

void Log::clear_line() {
  if (!line_open_) return;
  std::fputs("\r\033[K", stdout);
  line_open_ = false;
}

void Log::line(const std::string& text) {
  clear_line();
  std::fputs((text + "\n").c_str(), stdout);
  std::fflush(stdout);
}

void Log::info(const std::string& message, const Json& fields) {
  if (quiet_) return;
  if (style_ == LogStyle::text) return line(message);
  Json json = {{"event", "info"}, {"message", message}};
  json.update(fields);
  line(dump(json));
}

void Log::warn(const std::string& message) {
  if (std::count(warnings_.begin(), warnings_.end(), message) > 0) return;
  warnings_.push_back(message);
  if (style_ == LogStyle::json) return line(dump({{"event", "warning"}, {"message", message}}));
  clear_line();
  std::fflush(stdout);
  std::fputs(("warning: " + message + "\n").c_str(), stderr);
}

void Log::error(const std::string& message, const std::string& event) {
  clear_line();
  if (style_ == LogStyle::json) line(dump({{"event", event}, {"message", message}}));
  std::fflush(stdout);
  std::fputs((message + "\n").c_str(), stderr);
}

void Log::show(const Progress& progress) {
  last_shown_ = Clock::now();
  shown_ = progress;
  if (style_ == LogStyle::json) return line(dump(progress_json(progress)));
  if (!terminal_) return line(progress_text(progress));
  // A line that wraps cannot be written over.
  std::fputs(("\r\033[K" + progress_bar(progress, terminal_columns() - 1)).c_str(), stdout);
  std::fflush(stdout);
  line_open_ = true;
}

void Log::progress(const Progress& progress) {
  // A terminal shows one line that changes; a file gets one every ten seconds.
  const double every = terminal_ && style_ == LogStyle::text ? 0.2 : 10;
  const std::chrono::duration<double> since = Clock::now() - last_shown_;
  if (!quiet_ && since.count() >= every) show(progress);
}

void Log::end_progress(const Progress& progress) {
  if (quiet_) return;
  const bool shown = shown_.steps == progress.steps && shown_.time == progress.time &&
                     shown_.end == progress.end && shown_.melted == progress.melted;
  if (terminal_ || !shown) show(progress);
  if (line_open_) std::fputs("\n", stdout);
  line_open_ = false;
}

}  // namespace runner
