#pragma once

#include <string>

#include <mapless/lidar/lidar_model.hpp>

namespace mapless::app {

/// A named model, or one of OS1-64 and OS1-128 with another number of columns: OS1-128x2048. Throws
/// ParameterError.
[[nodiscard]] LidarModel speed_sensor(const std::string& name);

}  // namespace mapless::app
