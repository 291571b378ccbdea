#pragma once

/// @file
/// Folder native: this project's own recordings (method.md section 4), which keep everything a LidarScan
/// holds. A path goes in, a Dataset comes out; NativeWriter writes them.

#include <filesystem>
#include <memory>

#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {

/// True for a folder with sensor.yaml and scans/.
[[nodiscard]] bool looks_native(const std::filesystem::path& path);
[[nodiscard]] std::unique_ptr<Dataset> open_native(const std::filesystem::path& path,
                                                   const DatasetOptions& options);

}  // namespace mapless
