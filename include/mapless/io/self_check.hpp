#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <mapless/io/dataset.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// How far a recording contradicts what is said about it.
enum class Trust : std::uint8_t {
  unknown,   ///< nothing to check, or too few points
  right,     ///< no contradiction
  doubtful,  ///< in a part of the scans, or by little: the result may be wrong
  wrong,     ///< the result would be worthless
};

/// "unknown", "right", "doubtful" or "wrong".
[[nodiscard]] std::string_view name_of(Trust trust);

/// One part of the self-check.
struct CheckResult {
  std::string name;  ///< "beams", "times", "ranges" or "poses"
  Trust trust = Trust::unknown;
  std::string measured;  ///< what was found, one line, for every trust
  std::string where;     ///< file of the first scan that contradicts; empty where none does
  std::string problem;  ///< what contradicts, with the likely mistake where one of the usual ones explains it
  std::string remedy;
};

/// Holds a recording against what is said about it, on a few scans: points against the beams and columns of
/// the sensor, their ranges against its limits, times against the angle turned, and, where `given` is not
/// null, poses against the scans (docs/reliability.md, "The self-check"). Looks at scans spread over
/// [first, first + count). A scan that cannot be read is left out. Costs the reading of up to 40 scans.
[[nodiscard]] std::vector<CheckResult> check_recording(const Dataset& dataset,
                                                       const std::shared_ptr<const Trajectory>& given,
                                                       std::size_t first, std::size_t count);

/// Throws InputError for the first result that is wrong.
void require_trusted(const std::vector<CheckResult>& results);

}  // namespace mapless
