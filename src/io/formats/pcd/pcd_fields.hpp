#pragma once

#include <optional>

#include "io/formats/pcd/pcd.hpp"
#include <mapless/lidar/scan_builder.hpp>

namespace mapless::inline v1 {

/// The fields of a scan for ScanBuilder: x, y, z; where present ring (or laser) and t (or time, timestamp):
/// integers are nanoseconds, floating numbers seconds, since the scan's start unless plainly absolute. Refers
/// to `cloud`, which must outlive it. Throws InputError where x, y or z is absent.
[[nodiscard]] PointFields fields_of(const PcdCloud& cloud);

/// The earliest time of a point, where points have absolute times. Throws InputError for fields that
/// ScanBuilder refuses.
[[nodiscard]] std::optional<Time> first_time(const PcdCloud& cloud);

}  // namespace mapless
