#pragma once

/// @file
/// `mapless benchmark --paper`: the evaluation of the paper (section V). Two towns, a sensor of 64 x 2000
/// rays, the published method and the default method beside each other. Scans are simulated in memory, once
/// for all runs of a unit, and nothing but figures is kept.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "benchmark/plan.hpp"
#include "reports/json.hpp"

namespace mapless::app {

/// A detector that is run over the scans of a unit.
struct PaperRun {
  std::string method;     ///< "paper" or "default"
  std::string treatment;  ///< "full", "no motion compensation" or "no forward check"
  double threshold_m = 0;
  DetectorParameters parameters;
  Compensation compensation = Compensation::full;
  std::size_t lead = 0;  ///< scans before the first one evaluated that the detector is given

  [[nodiscard]] Json json() const;
};

/// 64 lasers x 2000 columns are the 128,000 rays a scan of the paper.
inline constexpr int kPaperColumns = 2000;

/// Consecutive scans of one town at one noise, and all detectors that are run over them: the unit of work
/// that is kept when the benchmark is interrupted.
struct PaperUnit {
  enum class Part { sweep, every_scan } part = Part::sweep;
  RecordingKey recording;       ///< names town, sensor, noise, seed and duration; no such folder is written
  int columns = kPaperColumns;  ///< of the sensor, in place of its own
  std::size_t first = 0, count = 0;
  std::vector<PaperRun> runs;
  bool pictures = false;  ///< draw the stages around one vehicle

  /// Name of its file without extension, unique in a plan.
  [[nodiscard]] std::string stem() const;
  [[nodiscard]] Json json() const;
  [[nodiscard]] LidarModel sensor() const;
};

struct PaperOptions {
  bool quick = false;
  std::vector<std::uint64_t> seeds = {1};  ///< the first one is used
  std::optional<double> duration_s;        ///< of each town; default 300, quick 20
};

/// Every unit of the benchmark: every scan at 0.02 m of noise, with the thresholds of the two profiles; then
/// the threshold sweeps on 20 of every 200 scans (quick: 100) at three levels of noise. Throws ParameterError
/// for a duration without a scan or beyond that of a scene.
[[nodiscard]] std::vector<PaperUnit> make_paper_plan(const PaperOptions& options);

}  // namespace mapless::app
