#pragma once

#include <string>

#include "export/cloud.hpp"

namespace mapless::app {

enum class CloudFormat { pcd, ply, las };

/// The bytes of a binary, little-endian file: PCD 0.7 (`DATA binary`), PLY 1.0 or LAS 1.4. Fields x, y, z,
/// then the columns as uint32. Coordinates are float32, and float64 if one of them is 8192 m or more from 0:
/// from there on the steps of float32 are 1 mm. LAS: point format 6, whole steps of 0.1 mm from the first
/// point (coarser where they would not reach), columns as extra bytes; without points' intensity or colour.
[[nodiscard]] std::string cloud_file(const Cloud& cloud, CloudFormat format);

}  // namespace mapless::app
