#include "options/parameter_options.hpp"

#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::app {

std::vector<ParameterReference> references_of(RunParameters& parameters) {
  std::vector<ParameterReference> out = parameter_references(parameters.detector);
  for (ParameterReference& p : parameter_references(parameters.odometry)) {
    p.key = "odometry." + p.key;
    out.push_back(std::move(p));
  }
  return out;
}

RunParameters ParameterOptions::all() const {
  RunParameters parameters = {detector_profile(profile), {}};
  const auto references = references_of(parameters);
  if (!config.empty()) read_parameters_file(config, references);
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw ParameterError({"--set", "", setting, "must be key=value", "'mapless config' lists the keys"});
    }
    assign_parameter(references, setting.substr(0, equals), setting.substr(equals + 1), "--set");
  }
  if (causal) parameters.detector.forward_gap = 0;
  return parameters;
}

void add_parameter_options(CLI::App& verb, ParameterOptions& options) {
  verb.add_option(
          "--profile", options.profile,
          "parameter set to start from: default; paper (the method as published, with sensible readings "
          "where the paper is silent); or paper-literal (with the plainest readings)")
      ->capture_default_str();
  verb.add_option("--config", options.config,
                  "YAML file of parameters, in the form that 'mapless config' prints; overrides the profile");
  verb.add_option("--set", options.settings,
                  "set one parameter, as key=value; overrides --config; may be repeated")
      ->expected(1)
      ->take_all();
}

std::string configuration_text(const ParameterOptions& options) {
  RunParameters parameters = options.all();
  RunParameters defaults;
  return fmt::format("# mapless {}: every parameter of the detector and of the odometry\n", MAPLESS_VERSION) +
         parameters_yaml(references_of(parameters), references_of(defaults));
}

}  // namespace mapless::app
