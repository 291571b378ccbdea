#pragma once

#include <string>

#include "export/cloud.hpp"

namespace mapless::app {

/// The bytes of a LAS 1.4 file, see cloud_file.
[[nodiscard]] std::string las_file(const Cloud& cloud);

}  // namespace mapless::app
