#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>

#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// The whole text as a number (a leading '+' is allowed; inf and nan are numbers), or nothing.
template <class Number>
[[nodiscard]] std::optional<Number> parse_number(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// Seconds with nine decimals, exactly; io's parse_decimal_seconds reads them back.
[[nodiscard]] std::string decimal_seconds(Time time);

}  // namespace mapless
