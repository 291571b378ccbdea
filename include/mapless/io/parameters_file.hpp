#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <mapless/core/parameters.hpp>

namespace mapless::inline v1 {

/// Sets parameters from a YAML file whose maps are the groups of the keys ("freespace.backward_threshold_m"
/// is backward_threshold_m in the map freespace). Keys the file does not have keep their value. Throws
/// InputError for a file that cannot be read or is not YAML, ParameterError naming file, line and key for an
/// unknown or repeated key, a value of the wrong type or out of bounds.
void read_parameters_file(const std::filesystem::path& file,
                          const std::vector<ParameterReference>& parameters);

/// The parameters as such a file, with meaning, unit, bounds, default and source of each as comments; reads
/// back to the same values. `defaults` has the same keys in the same order.
[[nodiscard]] std::string parameters_yaml(const std::vector<ParameterReference>& parameters,
                                          const std::vector<ParameterReference>& defaults);

}  // namespace mapless
