#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <mapless/detection/parameters.hpp>
#include <mapless/detection/stages.hpp>
#include <mapless/detection/tracked_object.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Wall time of each step for one scan [s].
struct StageSeconds {
  double compensation = 0;
  double neighbours = 0;  ///< building the search structure
  double normals = 0;
  double comparison = 0;
  double backward = 0;
  double forward = 0;
  double box_filter = 0;
  double region_growth = 0;
  double tracking = 0;

  [[nodiscard]] double total() const {
    return compensation + neighbours + normals + comparison + backward + forward + box_filter +
           region_growth + tracking;
  }
  [[nodiscard]] StageSeconds operator+(const StageSeconds& o) const {
    return {compensation + o.compensation, neighbours + o.neighbours,       normals + o.normals,
            comparison + o.comparison,     backward + o.backward,           forward + o.forward,
            box_filter + o.box_filter,     region_growth + o.region_growth, tracking + o.tracking};
  }
};

/// The answer for one scan. Vectors have one element per return of `scan`, in its order.
struct Detection {
  std::shared_ptr<const LidarScan> scan;
  std::size_t sequence_number = 0;    ///< 0 for the first scan the detector was given
  std::vector<StageTrace> trace;      ///< each stage's verdict
  std::vector<std::uint16_t> object;  ///< 0 for static, else 1, 2, ...: one number per object of this scan
  int objects = 0;
  std::vector<TrackedObject> tracked;  ///< those objects over time, by number
  StageSeconds seconds;

  [[nodiscard]] bool dynamic(std::size_t i) const { return object[i] != 0; }
};

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
