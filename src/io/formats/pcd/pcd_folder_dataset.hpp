#pragma once

#include <filesystem>
#include <memory>

#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {

/// A folder of *.pcd that is no native sequence.
[[nodiscard]] bool looks_pcd_folder(const std::filesystem::path& path);

/// Scans in the order of their names; starts from times.txt, else from names that are Unix times
/// (nanoseconds, or seconds), else from absolute times of the points. Fields x y z; where present ring (or
/// laser) and t (or time, timestamp: integers are nanoseconds, floating numbers seconds, since the scan's
/// start unless they are plainly absolute). The sensor is that of the options; throws InputError without one.
[[nodiscard]] std::unique_ptr<Dataset> open_pcd_folder(const std::filesystem::path& path,
                                                       const DatasetOptions& options);

}  // namespace mapless
