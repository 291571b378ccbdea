#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/number_text.hpp"
#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// Parses decimal seconds ("1317042272.283701593", "1.5e-3") to whole nanoseconds, exactly; further digits
/// round half away from 0. Nothing for text that is not one number, or beyond 126 years. (A double resolves
/// 0.2 microseconds.)
[[nodiscard]] std::optional<Time> parse_decimal_seconds(std::string_view text);

/// The whole text as a number (inf and nan included), or nothing.
[[nodiscard]] std::optional<double> parse_double(std::string_view text);
[[nodiscard]] std::optional<long long> parse_integer(std::string_view text);

/// The lines of a text without their ends (\n or \r\n); a final line end starts no further line.
[[nodiscard]] std::vector<std::string_view> split_lines(std::string_view text);
/// The lines of a text file without their ends and trailing blanks; empty lines at the end are dropped.
/// Throws InputError.
[[nodiscard]] std::vector<std::string> read_lines(const std::filesystem::path& file);
/// The words of a line, separated by blanks and tabs.
[[nodiscard]] std::vector<std::string_view> split_words(std::string_view line);

}  // namespace mapless
