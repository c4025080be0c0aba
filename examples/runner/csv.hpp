// SPDX-License-Identifier: Apache-2.0
// A table on disk that grows row by row.
#pragma once

#include <string>
#include <vector>

#include "files.hpp"

namespace runner {

std::vector<std::string> split_commas(const std::string& line);
/// 9 digits, as printf's %.9g writes them; "nan" where there is no value.
std::string csv_number(double value);
/// Characters that write_csv_number() needs room for.
inline constexpr std::size_t longest_csv_number = 24;
/// The same at `to`; the end of what it wrote.
char* write_csv_number(char* to, double value);

class CsvFile {
 public:
  /// Starts a new table.
  CsvFile(std::string path, const std::string& header);
  /// Goes on with a table: rows later than `time` were written after the checkpoint and are dropped, for they
  /// are computed again, and so are rows that have not as many cells as the header. Returns the rows kept in `kept` when it is given.
  static CsvFile resume(std::string path, const std::string& header, std::size_t time_column, double time,
                        std::vector<std::string>* kept = nullptr);

  void row(const std::string& line) { text(line.data(), line.size()).push_back('\n'); }
  /// Part of a row, or rows; every row ends with a line break. Returns what waits to be written.
  std::string& text(const char* from, std::size_t size) {
    if (buffer_.size() + size > large) flush();
    if (size > large) return checked(file_.write({from, size}));
    return buffer_.append(from, size);
  }
  void flush();  ///< fails when the disk is full

 private:
  static constexpr std::size_t large = std::size_t{1} << 20;
  CsvFile(const std::string& path, std::string content, bool);
  std::string& checked(int why);  ///< fails where it is not 0; what waits to be written

  std::string path_;
  std::string buffer_;
  OpenFile file_;  ///< the one that was made: whatever takes its name later is not written to
};

}  // namespace runner
