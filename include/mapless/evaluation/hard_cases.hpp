#pragma once

/// @file
/// The cases that the paper names as open (section VI): points seen through a fence, points with only sky
/// behind, and the delay with which a start or a stop is noticed.

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <mapless/evaluation/evaluator.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Recall of the dynamic points that are hard to see. Neighbours of a point are cells of the same laser.
struct SightReport {
  /// Points seen through a gap (a fence, a hedge, railings): on either side, within kGapReach_deg, the same
  /// laser has a static return that is nearer by more than kGapDepth_m.
  Found through_gap;
  /// Points with only sky behind: on either side, the first cell of the laser that is not of the same true
  /// object has no return within range. Faulty and absent cells are skipped. Zero for recordings that do not
  /// distinguish ReturnCode::nothing from ReturnCode::faulty.
  Found before_sky;
};
/// Chosen: slats up to 0.17 m apart, seen from 10 m, hide the next point on either side.
inline constexpr double kGapReach_deg = 1;
/// Chosen: farther than the parts of one object lie in front of each other.
inline constexpr double kGapDepth_m = 0.5;

/// Accumulates a SightReport scan by scan.
class SightEvaluator {
 public:
  /// With a limit, points farther from their laser do not count. Throws ParameterError as Evaluator does.
  explicit SightEvaluator(std::optional<double> max_range_m = {});

  /// `labels` are those of `scan`. Throws InputError if their lengths differ.
  void add(const LidarScan& scan, const ScanLabels& labels);

  [[nodiscard]] const SightReport& report() const { return report_; }

 private:
  void add_row(const LidarScan& scan, const ScanLabels& labels, int row);

  std::optional<double> max_range_m_;
  SightReport report_;
};

/// Delays of one kind of event.
struct Delays {
  std::int64_t events = 0;
  std::int64_t never = 0;  ///< not noticed within 25 scans
  /// Smallest delay [scans] within which at least 50 % (median) or 90 % (p90) of all events are noticed.
  /// Absent if fewer events than that are noticed at all.
  std::optional<double> median_scans, p90_scans;
};

/// Delays between the start or stop of a true object and the labels that show it. Only scans in which the
/// object has points with a true label, and a true speed (object_states.csv), are counted; "next" and "last"
/// refer to these scans.
struct DelayReport {
  /// From the first scan above 0.2 m/s to the first one with half of the object's points labelled dynamic. A
  /// start: below 0.1 m/s in the scans six to two before, at most 0.2 m/s in the last; 0.5 m/s within the
  /// next 25, and at least 20 points in the first.
  Delays start;
  /// From the first scan below 0.1 m/s to the first one with less than a tenth of the object's points
  /// labelled dynamic. A stop: above 0.5 m/s within the last 12 scans, at most 0.1 m/s in the next ten, of
  /// which there are at least five, and at least 20 points in the first.
  Delays stop;
};

/// Accumulates a DelayReport scan by scan. Keeps a few numbers per object and scan.
class DelayEvaluator {
 public:
  /// With a limit, points farther from their laser do not count. Throws ParameterError as Evaluator does.
  explicit DelayEvaluator(const ObjectTruth& truth, std::optional<double> max_range_m = {});

  /// Scans by increasing number. Throws InputError if the spans differ in length.
  void add(const ScanLabels& scan);

  /// Absent if the recording has no object_states.csv.
  [[nodiscard]] std::optional<DelayReport> report() const;

 private:
  struct Sighting {
    std::size_t scan = 0;
    double speed_mps = 0;
    std::int64_t points = 0, called = 0;
  };
  using History = std::vector<Sighting>;  // of one object
  static bool starts(const History& history, std::size_t at);
  static bool stops(const History& history, std::size_t at);

  bool has_states_;
  std::map<std::pair<std::size_t, std::uint32_t>, double> speeds_mps_;  // by scan and object
  std::optional<double> max_range_m_;
  std::map<std::uint32_t, History> histories_;
};

}  // namespace mapless
