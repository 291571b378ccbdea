#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <mapless/core/time.hpp>
#include <mapless/detection/detection.hpp>
#include <mapless/detection/parameters.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

class DetectionPipeline;
class MovingObjects;

/// Tells, online, which returns of each scan belong to things that move now (arXiv 1809.06972).
///
/// Scans go in one by one, by increasing time. The detection of a scan comes out `latency()` scans later,
/// because a later scan is asked too; `flush` gives the rest, checked against the last scan there is. The
/// first detections come together, with scan VotingParameters::start_scans, as their scans have hardly an
/// earlier one to ask. While the recording is young, what earlier scans there are answer; a scan with none,
/// and no later one, is static throughout.
class Detector {
 public:
  explicit Detector(const DetectorParameters& parameters = {});
  ~Detector();
  Detector(Detector&&) noexcept;
  Detector& operator=(Detector&&) noexcept;

  /// Throws InputError for a scan that starts before the last one, TrajectoryDomainError where the trajectory
  /// does not cover it; the detector is then as it was before the call. Returns the detections that this scan
  /// makes ready, in order: none, one, or at the start several.
  std::vector<Detection> process(std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory);

  /// The detections not yet returned, in order. The detector can then go on.
  std::vector<Detection> flush();

  /// Scans between a scan and its detection, once started: forward_gap.
  [[nodiscard]] int latency() const { return parameters_.forward_gap; }
  [[nodiscard]] const DetectorParameters& parameters() const { return parameters_; }

 private:
  [[nodiscard]] std::size_t first_detections_at() const;  // scans in
  Detection next();

  DetectorParameters parameters_;
  std::unique_ptr<DetectionPipeline> pipeline_;
  std::unique_ptr<MovingObjects> moving_;
  Time newest_start_;
  std::size_t next_number_ = 0;     // of the next scan in
  std::size_t next_detection_ = 0;  // of the next detection out
};

}  // namespace mapless
