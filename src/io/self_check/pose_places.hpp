#pragma once

#include <cstddef>
#include <vector>

#include "io/self_check/pose_pair.hpp"
#include <mapless/io/dataset.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Time between the two scans of a pair [s]: a person on foot moves by 0.7 m, an accelerating car differs
/// from a constant velocity by less than 0.4 m.
inline constexpr double kPairApart_s = 0.5;
/// Displacement that a turn counts as [m/rad].
inline constexpr double kLever_m = 10;

/// Where the poses are looked at: pairs of neighbouring scans, and of scans half a second apart.
struct Place {
  LidarScan first, next, last;
};

/// How far after scan k the second scan of its pair is; no pair reaches beyond scan `last`.
[[nodiscard]] std::size_t scans_apart(const Dataset& dataset, std::size_t k, std::size_t last);

/// Scans where pairs that reach over a jump of the poses begin, and ones that end with a pose that is off
/// alone: there and back, which no pair over it sees. The largest jumps among the `count` scans from `first`
/// on; none where `said` does not cover them.
[[nodiscard]] std::vector<std::size_t> places_at_jumps(const Dataset& dataset, const Motion& said,
                                                       std::size_t first, std::size_t count);

/// The numbers in order, each once, and so early that their pairs are half a second apart where the scans
/// `first` to `last` allow it.
[[nodiscard]] std::vector<std::size_t> within(const Dataset& dataset, std::size_t first, std::size_t last,
                                              std::vector<std::size_t> numbers);

}  // namespace mapless
