#pragma once

#include <string_view>

namespace mapless::inline v1 {

/// Checks of single arguments of public functions. (Whole parameter structs: require_within_bounds of
/// core/parameters.hpp.)

/// Throws ParameterError that names the function, the argument, its value and its bounds unless
/// min <= value <= max; NaN is out of bounds. The argument's name ends with its unit: "max_range_m".
void require_between(std::string_view function, std::string_view argument, double value, double min,
                     double max);

/// Throws that error.
[[noreturn]] void refuse_argument(std::string_view function, std::string_view argument, double value,
                                  double min, double max);

/// Throws ParameterError that names the function and the argument for a null pointer.
void require_given(std::string_view function, std::string_view argument, const void* pointer);

}  // namespace mapless
