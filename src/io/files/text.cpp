#include "io/files/text.hpp"

#include <algorithm>
#include <cstdint>

#include <mapless/io/files.hpp>

namespace mapless::inline v1 {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// digits x 10^exponent
struct Decimal {
  std::string digits;
  long long exponent = 0;
};

std::optional<Decimal> parse_unsigned_decimal(std::string_view text) {
  Decimal decimal;
  const std::size_t e = text.find_first_of("eE");
  if (e != std::string_view::npos) {
    const auto exponent = parse_number<int>(text.substr(e + 1));
    if (!exponent) return std::nullopt;
    decimal.exponent = *exponent;
    text = text.substr(0, e);
  }
  bool after_point = false;
  for (const char c : text) {
    if (c == '.' && !after_point) {
      after_point = true;
    } else if (is_digit(c)) {
      decimal.digits += c;
      if (after_point) --decimal.exponent;
    } else {
      return std::nullopt;
    }
  }
  if (decimal.digits.empty()) return std::nullopt;
  decimal.digits.erase(0, decimal.digits.find_first_not_of('0'));
  return decimal;
}

// Rounds half up.
std::optional<std::int64_t> to_integer(Decimal decimal) {
  if (decimal.digits.empty()) return 0;
  const long long length = static_cast<long long>(decimal.digits.size()) + decimal.exponent;
  if (length < 0) return 0;
  if (length > 19) return std::nullopt;
  const auto size = static_cast<std::size_t>(length);
  const bool round_up = decimal.digits.size() > size && decimal.digits[size] >= '5';
  decimal.digits.resize(size, '0');
  const auto integer = size == 0 ? 0 : parse_number<std::int64_t>(decimal.digits);
  if (!integer || *integer == INT64_MAX) return std::nullopt;
  return *integer + (round_up ? 1 : 0);
}

}  // namespace

std::optional<Time> parse_decimal_seconds(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  std::optional<Decimal> decimal = parse_unsigned_decimal(text);
  if (!decimal) return std::nullopt;
  decimal->exponent += 9;
  const std::optional<std::int64_t> ns = to_integer(std::move(*decimal));
  if (!ns || *ns > Time::kLargestOutside_ns) return std::nullopt;
  return Time::from_nanoseconds(negative ? -*ns : *ns);
}

std::optional<double> parse_double(std::string_view text) { return parse_number<double>(text); }
std::optional<long long> parse_integer(std::string_view text) { return parse_number<long long>(text); }

std::vector<std::string_view> split_lines(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    lines.push_back(line);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::vector<std::string_view> split_words(std::string_view line) {
  std::vector<std::string_view> words;
  std::size_t begin = line.find_first_not_of(kBlanks);
  while (begin != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

std::vector<std::string> read_lines(const std::filesystem::path& file) {
  const std::string text = read_whole_file(file);
  std::vector<std::string> lines;
  for (std::string_view line : split_lines(text)) {
    while (line.ends_with(' ')) line.remove_suffix(1);
    lines.emplace_back(line);
  }
  while (!lines.empty() && lines.back().empty()) lines.pop_back();
  return lines;
}

}  // namespace mapless
