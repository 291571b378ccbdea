#include "core/argument_checks.hpp"

#include <string>

#include <fmt/format.h>

#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {

void require_between(std::string_view function, std::string_view argument, double value, double min,
                     double max) {
  if (value >= min && value <= max) return;  // false for NaN
  refuse_argument(function, argument, value, min, max);
}

void refuse_argument(std::string_view function, std::string_view argument, double value, double min,
                     double max) {
  throw ParameterError({std::string(function), std::string(argument), fmt::format("{}", value),
                        "out of bounds", fmt::format("give a value from {} to {}", min, max)});
}

void require_given(std::string_view function, std::string_view argument, const void* pointer) {
  if (pointer != nullptr) return;
  throw ParameterError(
      {std::string(function), std::string(argument), "null", "points to nothing", "give an object"});
}

}  // namespace mapless
