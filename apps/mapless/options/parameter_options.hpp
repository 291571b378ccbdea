#pragma once

#include <string>
#include <vector>

#include <CLI/App.hpp>

#include <mapless/detection/parameters.hpp>
#include <mapless/odometry/parameters.hpp>

namespace mapless::app {

/// All parameters of a run.
struct RunParameters {
  DetectorParameters detector;
  OdometryParameters odometry;
};

/// The detector's parameters under their own keys, those of odometry under "odometry.".
[[nodiscard]] std::vector<ParameterReference> references_of(RunParameters& parameters);

/// How the parameters are chosen: a profile, then a file, then single values, then --causal.
struct ParameterOptions {
  std::string profile = "default";
  std::string config;
  std::vector<std::string> settings;  ///< key=value
  bool causal = false;

  /// All three throw ParameterError, or InputError for a file that cannot be read.
  [[nodiscard]] RunParameters all() const;
  [[nodiscard]] DetectorParameters chosen() const { return all().detector; }
  [[nodiscard]] OdometryParameters odometry() const { return all().odometry; }
};

/// Adds --profile, --config, --set.
void add_parameter_options(CLI::App& verb, ParameterOptions& options);

/// The parameters as a commented configuration file.
[[nodiscard]] std::string configuration_text(const ParameterOptions& options);

}  // namespace mapless::app
