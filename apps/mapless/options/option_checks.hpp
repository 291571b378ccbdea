#pragma once

#include <CLI/App.hpp>

namespace mapless::app {

/// For numbers on the command line: each refuses with a line that says what is asked for. CLI11's own checks
/// let NaN through, take -1 for the largest unsigned number, and print bounds of 300 digits.

/// A whole number, at least `min`.
[[nodiscard]] CLI::Validator whole_number(unsigned long long min);
/// A finite number greater than 0.
[[nodiscard]] CLI::Validator positive_number();
/// A number from `min` to `max`.
[[nodiscard]] CLI::Validator number_between(double min, double max);

}  // namespace mapless::app
