#pragma once

#include <filesystem>
#include <vector>

#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// Reads the start of every scan from times.txt: decimal seconds, one per line; '#' starts a comment. Throws
/// InputError naming file, line and value for text that is not a time, times that do not increase, and a
/// number of times other than `scan_count`.
[[nodiscard]] std::vector<Time> read_scan_times(const std::filesystem::path& file, std::size_t scan_count);

}  // namespace mapless
