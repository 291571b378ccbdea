#pragma once

#include <filesystem>
#include <memory>

#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {

/// A folder with sensor.yaml and scans/ (method.md section 4).
[[nodiscard]] bool looks_native(const std::filesystem::path& path);
[[nodiscard]] std::unique_ptr<Dataset> open_native(const std::filesystem::path& path,
                                                   const DatasetOptions& options);

}  // namespace mapless
