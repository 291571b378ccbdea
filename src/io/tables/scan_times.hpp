#pragma once

#include <filesystem>
#include <vector>

#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// Starts of the scans of a recording: decimal seconds, one a line; '#' starts a comment. Throws InputError
/// naming file, line and value for text that is no time, times that do not increase, and more or fewer of
/// them than `scan_count`.
[[nodiscard]] std::vector<Time> read_scan_times(const std::filesystem::path& file, std::size_t scan_count);

}  // namespace mapless
