#include "parameters.hpp"

#include <string>

#include <fmt/format.h>

#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless_ros {
namespace {

// The default as ROS has it, so that tools show its type.
rclcpp::ParameterValue default_of(const mapless::ParameterReference& parameter) {
  if (const auto* flag = std::get_if<bool*>(&parameter.value)) return rclcpp::ParameterValue(**flag);
  if (const auto* integer = std::get_if<int*>(&parameter.value)) return rclcpp::ParameterValue(**integer);
  if (const auto* number = std::get_if<double*>(&parameter.value)) return rclcpp::ParameterValue(**number);
  return rclcpp::ParameterValue(parameter.text());
}

std::string text_of(const rclcpp::ParameterValue& value) {
  switch (value.get_type()) {
    case rclcpp::ParameterType::PARAMETER_BOOL:
      return value.get<bool>() ? "true" : "false";
    case rclcpp::ParameterType::PARAMETER_INTEGER:
      return std::to_string(value.get<std::int64_t>());
    case rclcpp::ParameterType::PARAMETER_DOUBLE:
      return fmt::format("{}", value.get<double>());
    case rclcpp::ParameterType::PARAMETER_STRING:
      return value.get<std::string>();
    default:
      return rclcpp::to_string(value);  // a list, which is refused by its text
  }
}

// Numbers without a point are taken for numbers with one: the type may differ from the default's.
rcl_interfaces::msg::ParameterDescriptor descriptor_of(const std::string& description) {
  rcl_interfaces::msg::ParameterDescriptor descriptor;
  descriptor.description = description;
  descriptor.read_only = true;
  descriptor.dynamic_typing = true;
  return descriptor;
}

void refuse_unknown(rclcpp::Node& node) {
  for (const auto& [name, value] : node.get_node_parameters_interface()->get_parameter_overrides()) {
    if (node.has_parameter(name) || name.starts_with("qos_overrides.")) continue;
    throw mapless::ParameterError({std::string("node ") + node.get_name(), "parameter", name, "is not known",
                                   "see config/labeller.yaml for all of them"});
  }
}

}  // namespace

void declare_parameters(rclcpp::Node& node, mapless::LiveOptions& options) {
  for (const mapless::LiveSetting& setting : mapless::live_settings(options)) {
    *setting.value =
        text_of(node.declare_parameter(std::string(setting.name), rclcpp::ParameterValue(*setting.value),
                                       descriptor_of(std::string(setting.help))));
  }
  for (const mapless::ParameterReference& parameter : mapless::live_parameters(options)) {
    const auto description =
        fmt::format("{} [{}] {} to {}", parameter.help, parameter.unit, parameter.min, parameter.max);
    const auto value =
        node.declare_parameter(parameter.key, default_of(parameter), descriptor_of(description));
    parameter.assign(text_of(value), std::string("node ") + node.get_name());
  }
  refuse_unknown(node);
  if (!options.sensor_name.empty()) options.sensor = mapless::model_from_name_or_file(options.sensor_name);
  if (!options.static_map_file.empty()) (void)mapless::cloud_format_of(options.static_map_file);
}

}  // namespace mapless_ros
