// SPDX-License-Identifier: Apache-2.0
// A table on disk that grows row by row.
#pragma once

#include <fstream>
#include <string>
#include <vector>

namespace runner {

std::vector<std::string> split_commas(const std::string& line);
std::string csv_number(double value);  ///< 9 digits; "nan" where there is no value

class CsvFile {
 public:
  /// Starts a new table.
  CsvFile(std::string path, const std::string& header);
  /// Goes on with a table: rows later than `time` were written after the checkpoint and are dropped, for they
  /// are computed again. Returns the rows kept in `kept` when it is given.
  static CsvFile resume(std::string path, const std::string& header, std::size_t time_column, double time,
                        std::vector<std::string>* kept = nullptr);

  void row(const std::string& line) { buffer_ += line + "\n"; }
  void flush();  ///< fails when the disk is full

 private:
  explicit CsvFile(std::string path);
  void open();

  std::string path_;
  std::string buffer_;
  std::ofstream file_;
};

}  // namespace runner
