#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <mapless/lidar/lidar_scan.hpp>

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
  std::string name;  ///< "beams", "times", "ranges", "pose scale", "pose times", "poses", ...
  Trust trust = Trust::unknown;
  std::string measured;  ///< what was found, one line, for every trust
  std::string where;     ///< file of the first scan that contradicts; empty where none does
  std::string problem;  ///< what contradicts, with the likely mistake where one of the usual ones explains it
  std::string remedy;
};

/// Holds the scans of a run against what is said about them, one after the other, where check_recording looks
/// at a few: points against their beams, ranges and times in every third scan; whether a scan is the one
/// before it once more, or exchanged with it, in each. Says only what is clearly wrong.
class ScanWatch {
 public:
  ScanWatch();
  ~ScanWatch();
  ScanWatch(const ScanWatch&) = delete;
  ScanWatch& operator=(const ScanWatch&) = delete;

  /// Scan k as it was read, after the one before it.
  void add(const LidarScan& scan, std::size_t k);
  /// "doubtful beams: scan 4 (and 2 others): ..."; empty where nothing contradicts.
  [[nodiscard]] std::vector<std::string> lines() const;
  /// The lines, for a run without end: what they say is forgotten.
  [[nodiscard]] std::vector<std::string> take_lines();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mapless
