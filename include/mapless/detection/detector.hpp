#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include <mapless/core/time.hpp>
#include <mapless/detection/detection.hpp>
#include <mapless/detection/parameters.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

class DetectionPipeline;
class MovingObjects;
class RayImage;

/// Labels every return of each scan as dynamic or static, online (arXiv 1809.06972). In: scans by increasing
/// time, with the sensor's trajectory. Out: one Detection per scan, in order. No map, training, ground plane
/// or class list is used.
///
/// The detection of a scan is returned `latency()` scans later, because a later scan is evidence, too;
/// flush() returns the rest, with the last scan as the later one. Method "voting" returns the first
/// detections together, with scan VotingParameters::start_scans, since their scans have few earlier ones. In
/// the first scans those earlier scans are used that exist; a scan without any earlier or later one is static
/// throughout.
class Detector {
 public:
  /// Throws ParameterError naming the parameter, its value and its bounds if any is out of bounds.
  explicit Detector(const DetectorParameters& parameters = {});
  ~Detector();
  Detector(Detector&&) noexcept;
  Detector& operator=(Detector&&) noexcept;

  /// Learns the own vehicle, and which rays return at all, from a scan before the first one that is
  /// processed, which is not labelled. That is all that a detector knows of scans long ago: of a drive that
  /// is labelled from its middle on, the detections are those of the whole once the references have come
  /// around.
  void learn_own_vehicle(const LidarScan& scan, const Trajectory& trajectory);

  /// Adds the next scan. `trajectory` gives the pose of the sensor (T_v0, world 0 to sensor v) and is used
  /// during the call alone. Returns the detections that are ready, in order: none, one, or at the start
  /// several. Throws InputError for a scan that does not start after the last one, and TrajectoryDomainError
  /// where the trajectory does not cover it; the detector is then as it was before the call.
  std::vector<Detection> process(std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory);

  /// Returns the detections not returned yet, in order. Scans can be added afterwards.
  std::vector<Detection> flush();

  /// Detections from now on get an explanation (explanation.hpp): of their objects, and of every point where
  /// `points` is true of the start of the scan. Method "voting" alone. Labels do not change. Costs about 10
  /// MB and as much time again for each scan whose points are explained.
  void explain(std::function<bool(Time)> points);

  /// The rays of the scans processed since the last call, oldest first, for the detectors of other sensors on
  /// the same vehicle; none with method "published".
  [[nodiscard]] std::vector<std::shared_ptr<const RayImage>> new_rays();
  /// Takes the rays of a scan of another sensor whose trajectory is in the same world, on the same clock:
  /// where they passed through a point of a later scan of this one, the point is probably dynamic. Without
  /// effect with method "published".
  void add_rays_of_another_sensor(std::shared_ptr<const RayImage> rays);

  /// Scans between a scan and its detection, after the start: forward_gap.
  [[nodiscard]] int latency() const { return parameters_.forward_gap; }
  [[nodiscard]] const DetectorParameters& parameters() const { return parameters_; }

 private:
  [[nodiscard]] std::size_t first_detections_at() const;  // number of scans added
  Detection next();

  DetectorParameters parameters_;
  std::unique_ptr<DetectionPipeline> pipeline_;
  std::unique_ptr<MovingObjects> moving_;
  Time newest_start_;
  std::size_t next_number_ = 0;     // of the next scan to add
  std::size_t next_detection_ = 0;  // of the next detection to return
  std::size_t next_rays_ = 0;       // of the first scan whose rays new_rays() did not return
};

}  // namespace mapless
