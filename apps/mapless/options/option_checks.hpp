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

/// A name of a topic as ROS 2 has them: letters, digits, underscores and slashes, no digit first; relative,
/// absolute (/) or private (~/).
[[nodiscard]] CLI::Validator topic_name();
/// What may be put before the name of a topic; empty: nothing.
[[nodiscard]] CLI::Validator topic_prefix();
/// A name of a file or folder to write: without control characters, which would break the lines of whoever
/// prints it, and not empty.
[[nodiscard]] CLI::Validator output_name();
/// Any text but the empty one, which is a variable of a script that is not set.
[[nodiscard]] CLI::Validator not_empty();

}  // namespace mapless::app
