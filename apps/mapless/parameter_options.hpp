#pragma once

#include <string>
#include <vector>

#include <CLI/App.hpp>

#include <mapless/detection/parameters.hpp>

namespace mapless::app {

/// How the parameters of the detector are chosen: a profile, then a file, then single values, then --causal.
struct ParameterOptions {
  std::string profile = "default";
  std::string config;
  std::vector<std::string> settings;  ///< key=value
  bool causal = false;

  /// Throws ParameterError, or InputError for the file.
  [[nodiscard]] DetectorParameters chosen() const;
};

/// Adds --profile, --config, --set.
void add_parameter_options(CLI::App& verb, ParameterOptions& options);

/// The parameters as a commented configuration file.
[[nodiscard]] std::string configuration_text(DetectorParameters parameters);

}  // namespace mapless::app
