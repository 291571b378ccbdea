#include "options/option_checks.hpp"

#include <charconv>
#include <cmath>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace mapless::app {
namespace {

template <class Number>
bool parse(const std::string& text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

CLI::Validator whole_number(unsigned long long min) {
  const auto check = [min](const std::string& text) {
    unsigned long long number = 0;
    const bool good = parse(text, number) && number >= min;
    return good ? std::string() : fmt::format("{}: not a whole number of at least {}", text, min);
  };
  return {check, "", "whole number"};
}

CLI::Validator positive_number() {
  const auto check = [](const std::string& text) {
    double number = 0;
    const bool good = parse(text, number) && std::isfinite(number) && number > 0;
    return good ? std::string() : fmt::format("{}: not a finite number greater than 0", text);
  };
  return {check, "", "positive number"};
}

CLI::Validator number_between(double min, double max) {
  const auto check = [min, max](const std::string& text) {
    double number = 0;
    const bool good = parse(text, number) && number >= min && number <= max;  // false for NaN
    return good ? std::string() : fmt::format("{}: not a number from {} to {}", text, min, max);
  };
  return {check, fmt::format("FLOAT in [{} - {}]", min, max), "number between"};
}

}  // namespace mapless::app
