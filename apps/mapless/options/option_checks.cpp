#include "options/option_checks.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <regex>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace mapless::app {
namespace {

constexpr std::size_t kLongestTopic = 200;  // a file name has 255 bytes, and DDS adds its own parts

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

CLI::Validator topic_name() {
  const auto check = [](const std::string& text) {
    static const std::regex names("(~/|/)?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*");
    if (text.size() > kLongestTopic)
      return fmt::format("{} bytes: longer than a name of a topic, {} bytes", text.size(), kLongestTopic);
    return std::regex_match(text, names)
               ? std::string()
               : fmt::format("'{}': not a name of a topic, which has letters, digits, _ and /", text);
  };
  return {check, "", "topic"};
}

CLI::Validator topic_prefix() {
  const auto check = [](const std::string& text) {
    return text.empty() || topic_name()(text + "points").empty()
               ? std::string()
               : fmt::format("'{}': not the beginning of a name of a topic, such as mapless/", text);
  };
  return {check, "", "prefix"};
}

CLI::Validator output_name() {
  const auto check = [](const std::string& text) {
    if (text.empty()) return std::string("is empty: give a name, or leave the option out");
    const bool control = std::any_of(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; });
    return control ? std::string("a line break or another control character is in the name: choose another")
                   : std::string();
  };
  return {check, "", "name"};
}

CLI::Validator not_empty() {
  const auto check = [](const std::string& text) {
    return text.empty() ? std::string("is empty: give a value, or leave the option out") : std::string();
  };
  return {check, "", "not empty"};
}

}  // namespace mapless::app
