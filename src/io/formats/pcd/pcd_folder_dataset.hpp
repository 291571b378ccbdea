#pragma once

/// @file
/// Folder pcd: recordings as folders of PCD files, with or without rings, times and sensor model. A path goes
/// in, a Dataset comes out; native recordings use read_pcd and write_pcd too.

#include <filesystem>
#include <memory>

#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {

/// True for a folder of *.pcd that is no native recording.
[[nodiscard]] bool looks_pcd_folder(const std::filesystem::path& path);

/// Opens the folder. Scans in the order of their names, or of their numbers where all names are numbers
/// (2.pcd before 10.pcd). Their starts come from times.txt, else from names that are Unix times (nanoseconds
/// or seconds), else from absolute times of the points. Fields: x y z;
/// optional ring (or laser) and t (or time, timestamp): integers are nanoseconds, floating numbers seconds,
/// since the start of the scan unless they are beyond eleven days. The sensor is that of the options, else
/// estimated; throws InputError if neither is possible.
[[nodiscard]] std::unique_ptr<Dataset> open_pcd_folder(const std::filesystem::path& path,
                                                       const DatasetOptions& options);

}  // namespace mapless
