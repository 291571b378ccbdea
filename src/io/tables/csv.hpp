#pragma once

/// @file
/// Folder tables: label files, tables of objects, times and trajectories, and the folder of a result. Rows go
/// in, files come out, and back; every reader throws InputError naming file, line and value.

#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// One line of a table. Refers to the text of the table.
struct CsvLine {
  std::string where;
  std::string_view remedy;
  std::vector<std::string_view> cells;
  std::string_view head;

  /// Throws InputError.
  [[noreturn]] void refuse(std::string field, std::string_view value, std::string problem) const;
  /// Each throws InputError if the cell is not such a value.
  [[nodiscard]] long long integer(std::size_t cell, std::string field, long long least,
                                  long long most = std::numeric_limits<long long>::max()) const;
  [[nodiscard]] double number(std::size_t cell) const;  // named as in the header line
  [[nodiscard]] Time time(std::size_t cell, std::string field) const;
};

/// The lines of a comma-separated table after the header line, which must be `head`; all have the same number
/// of cells. Throws InputError naming file and line, with `remedy`.
[[nodiscard]] std::vector<CsvLine> csv_lines(const std::filesystem::path& file, std::string_view text,
                                             std::string_view head, std::string_view remedy);

}  // namespace mapless
