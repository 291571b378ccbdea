#pragma once

#include <CLI/App.hpp>

namespace mapless::app {

/// Checks of numbers on the command line, with messages that name the bounds. CLI11's own checks accept NaN,
/// read -1 as the largest unsigned number, and print bounds of 300 digits.

/// A whole number, at least `min`.
[[nodiscard]] CLI::Validator whole_number(unsigned long long min);
/// A finite number greater than 0.
[[nodiscard]] CLI::Validator positive_number();
/// A number from `min` to `max`.
[[nodiscard]] CLI::Validator number_between(double min, double max);

}  // namespace mapless::app
