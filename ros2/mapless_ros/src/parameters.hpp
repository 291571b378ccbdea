#pragma once

#include <rclcpp/rclcpp.hpp>

#include <mapless/live/live_options.hpp>

namespace mapless_ros {

/// Declares every setting and parameter of `options` (live_settings, live_parameters), read-only, and takes
/// the values given. Throws mapless::ParameterError for a value out of bounds, and for an override that is no
/// parameter.
void declare_parameters(rclcpp::Node& node, mapless::LiveOptions& options);

}  // namespace mapless_ros
