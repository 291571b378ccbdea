#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// One line of a table and where it stands, for messages. Refers to the table's text.
struct CsvLine {
  std::string where;
  std::string_view remedy;
  std::vector<std::string_view> cells;
  std::string_view head;

  /// Throws InputError.
  [[noreturn]] void refuse(std::string field, std::string_view value, std::string problem) const;
  /// Each throws InputError where the cell is no such thing.
  [[nodiscard]] long long integer(std::size_t cell, std::string field, long long least,
                                  long long most = std::numeric_limits<long long>::max()) const;
  [[nodiscard]] double number(std::size_t cell) const;  // named as in the head
  [[nodiscard]] Time time(std::size_t cell, std::string field) const;
};

/// The lines of a comma-separated table below its first, which must be `head`; all as many cells. Throws
/// InputError naming file and line, with `remedy`.
[[nodiscard]] std::vector<CsvLine> csv_lines(const std::filesystem::path& file, std::string_view text,
                                             std::string_view head, std::string_view remedy);

}  // namespace mapless
