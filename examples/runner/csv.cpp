// SPDX-License-Identifier: Apache-2.0
#include "csv.hpp"

#include <fmt/format.h>

#include <cmath>
#include <sstream>

#include "failure.hpp"
#include "files.hpp"
#include "numbers.hpp"

namespace runner {

std::vector<std::string> split_commas(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',') cells.emplace_back();
    else cells.back() += c;
  }
  return cells;
}

std::string csv_number(double value) { return std::isnan(value) ? "nan" : fmt::format("{:.9g}", value); }

CsvFile::CsvFile(std::string path) : path_(std::move(path)) {}

CsvFile::CsvFile(std::string path, const std::string& header) : path_(std::move(path)) {
  write_file(path_, header + "\n");
  open();
}

CsvFile CsvFile::resume(std::string path, const std::string& header, std::size_t time_column, double time,
                        std::vector<std::string>* kept) {
  if (!exists(path)) return {std::move(path), header};
  std::istringstream old(read_file(path));
  std::string line, content = header + "\n";
  const double last = parse_number(csv_number(time)).value_or(time);  // rows hold nine digits
  std::getline(old, line);                                            // the header
  while (std::getline(old, line)) {
    const std::vector<std::string> cells = split_commas(line);
    const auto at = cells.size() > time_column ? parse_number(cells[time_column]) : std::nullopt;
    if (!at || *at > last) continue;
    content += line + "\n";
    if (kept != nullptr) kept->push_back(line);
  }
  write_file(path, content);
  CsvFile csv(std::move(path));
  csv.open();
  return csv;
}

void CsvFile::open() {
  file_.open(path_, std::ios::binary | std::ios::app);
  if (!file_) throw Failure(ExitCode::io, path_ + ": cannot be opened for appending");
}

void CsvFile::flush() {
  file_ << buffer_;
  buffer_.clear();
  file_.flush();
  if (!file_) throw Failure(ExitCode::io, path_ + ": cannot be written; is the disk full?");
}

}  // namespace runner
