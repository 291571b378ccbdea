#include "io/tables/csv.hpp"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "io/files/text.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

std::vector<std::string_view> split_cells(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

}  // namespace

void CsvLine::refuse(std::string field, std::string_view value, std::string problem) const {
  throw InputError({where, std::move(field), std::string(value), std::move(problem), std::string(remedy)});
}

long long CsvLine::integer(std::size_t cell, std::string field, long long least, long long most) const {
  const auto value = parse_integer(cells[cell]);
  if (!value || *value < least || *value > most) {
    refuse(std::move(field), cells[cell],
           most == std::numeric_limits<long long>::max()
               ? fmt::format("not a number from {}", least)
               : fmt::format("not a number from {} to {}", least, most));
  }
  return *value;
}

double CsvLine::number(std::size_t cell) const {
  const auto value = parse_double(cells[cell]);
  if (!value || !std::isfinite(*value))
    refuse(std::string(split_cells(head)[cell]), cells[cell], "not a finite number");
  return *value;
}

Time CsvLine::time(std::size_t cell, std::string field) const {
  const auto value = parse_decimal_seconds(cells[cell]);
  if (!value) refuse(std::move(field), cells[cell], "not decimal seconds");
  return *value;
}

std::vector<CsvLine> csv_lines(const std::filesystem::path& file, std::string_view text,
                               std::string_view head, std::string_view remedy) {
  const std::vector<std::string_view> lines = split_lines(text);
  const std::size_t width = split_cells(head).size();
  std::vector<CsvLine> out;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    CsvLine line{fmt::format("{}:{}", file.string(), i + 1), remedy, split_cells(lines[i]), head};
    if (i == 0 && lines[i] != head) line.refuse("head", lines[i], fmt::format("not {}", head));
    if (line.cells.size() != width) line.refuse("line", lines[i], fmt::format("not {} values", width));
    if (i > 0) out.push_back(std::move(line));
  }
  if (lines.empty()) throw InputError({file.string(), "head", "", "the file is empty", "restore it"});
  return out;
}

}  // namespace mapless
