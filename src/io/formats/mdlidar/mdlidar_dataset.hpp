#pragma once

/// @file
/// Folder mdlidar: recordings of the dataset of the paper. A path goes in, a Dataset comes out; MdlidarWriter
/// writes them. Nothing outside includes its Protobuf messages.

#include <filesystem>
#include <memory>

#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {

/// True for a recording of mdlidar, the dataset of the paper (arXiv 1809.06972): `town_N/` with the protobuf
/// messages `header` and `frame/data_<i>` (mdlidar.proto), and `vel_64_calib.csv` there or one folder up (a
/// row per laser: horizontal offset [m], vertical offset [m], rotational correction [rad], vertical
/// correction [rad]). Points are sorted by laser, then column; range -1 is a missing return of unknown
/// reason. Rotation is in degrees clockwise, times in nanoseconds, column c of n at start + c / (n - 1) (end
/// - start). Direction and instants of the poses are not documented and are found from the scans
/// (choose_pose_reading), unless `options` give them; trajectory() throws InputError where no reading fits.
[[nodiscard]] bool looks_mdlidar(const std::filesystem::path& path);
[[nodiscard]] std::unique_ptr<Dataset> open_mdlidar(const std::filesystem::path& path,
                                                    const DatasetOptions& options);

}  // namespace mapless
