#pragma once

#include <string>

#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {

/// The bytes of a LAS 1.4 file, see cloud_file.
[[nodiscard]] std::string las_file(const ExportCloud& cloud);

}  // namespace mapless
