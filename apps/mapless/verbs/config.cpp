#include <memory>
#include <sstream>
#include <string>
#include <variant>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/parameter_options.hpp"
#include "reports/json.hpp"
#include "reports/json_text.hpp"
#include "verbs/verbs.hpp"
#include <mapless/io/files.hpp>
#include <mapless/live/live_options.hpp>

namespace mapless::app {
namespace {

struct ConfigOptions {
  ParameterOptions parameters;
  bool json = false;
  bool ros2 = false;
};

void add_value(Json& schema, const ParameterReference& p) {
  if (const auto* flag = std::get_if<bool*>(&p.value)) {
    schema["type"] = "boolean";
    schema["default"] = **flag;
    return;
  }
  if (const auto* choice = std::get_if<ChoiceReference>(&p.value)) {
    schema["type"] = "string";
    schema["enum"] = choice->names;
    schema["default"] = p.text();
    return;
  }
  if (const auto* integer = std::get_if<int*>(&p.value)) {
    schema["type"] = "integer";
    schema["default"] = **integer;
    schema["minimum"] = static_cast<int>(p.min);
    schema["maximum"] = static_cast<int>(p.max);
    if (p.odd) schema["not"] = {{"multipleOf", 2}};
    return;
  }
  schema["type"] = "number";
  schema["default"] = *std::get<double*>(p.value);
  schema["minimum"] = p.min;
  schema["maximum"] = p.max;
}

Json object_schema() {
  return {{"type", "object"}, {"additionalProperties", false}, {"properties", Json::object()}};
}

// JSON Schema, with the unit and the source of each parameter beside its description.
Json schema_of(RunParameters parameters, const std::string& profile) {
  Json root = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
               {"title", "Parameters of mapless, profile " + profile}};
  root.update(object_schema());
  for (const ParameterReference& p : references_of(parameters)) {
    Json* group = &root;
    std::size_t begin = 0;
    for (std::size_t dot = 0; (dot = p.key.find('.', begin)) != std::string::npos; begin = dot + 1) {
      Json& child = (*group)["properties"][p.key.substr(begin, dot - begin)];
      if (child.is_null()) child = object_schema();
      group = &child;
    }
    Json& schema = (*group)["properties"][p.key.substr(begin)];
    add_value(schema, p);
    schema["unit"] = p.unit;
    schema["description"] = p.help;
    schema["source"] = p.source;
  }
  return root;
}

// A file of parameters for the node of ros2/mapless_ros.
std::string ros2_text(const ConfigOptions& options) {
  const RunParameters parameters = options.parameters.all();
  LiveOptions live, defaults;
  live.detector = {parameters.detector, parameters.odometry};
  std::string text =
      "# Parameters of mapless_ros, as 'mapless config --ros2' prints them.\n/**:\n  ros__parameters:\n";
  for (const LiveSetting& setting : live_settings(live))
    text += fmt::format("    {}: \"{}\"  # {}\n", setting.name, *setting.value, setting.help);
  std::istringstream lines(parameters_yaml(live_parameters(live), live_parameters(defaults)));
  for (std::string line; std::getline(lines, line);) text += line.empty() ? "\n" : "    " + line + "\n";
  return text;
}

int print_config(const ConfigOptions& options) {
  if (options.ros2) {
    fmt::print("{}", ros2_text(options));
    return 0;
  }
  if (options.json) {
    fmt::print("{}", json_text(schema_of(options.parameters.all(), options.parameters.profile)));
  } else {
    fmt::print("{}", configuration_text(options.parameters));
  }
  return 0;
}

}  // namespace

void add_config(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand(
      "config",
      "Print every parameter with its unit, bounds, default, meaning and source, as a file for --config");
  const auto options = std::make_shared<ConfigOptions>();
  add_parameter_options(*verb, options->parameters);
  verb->add_flag("--json", options->json, "print a JSON schema of the parameters");
  verb->add_flag("--ros2", options->ros2, "print a file of parameters of the ROS 2 node")->excludes("--json");
  verb->callback([options, &exit_code] { exit_code = print_config(*options); });
}

}  // namespace mapless::app
