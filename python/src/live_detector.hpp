#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <mapless/io/dataset.hpp>
#include <mapless/lidar/scan_builder.hpp>
#include <mapless/lidar/self_check.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace mapless::python {

/// The labels of one scan, per record of the input in its order, and the motion of its sensor.
struct FoundScan {
  std::size_t scan = 0;  ///< number of the scan among those pushed, from 0
  std::int64_t stamp_ns = 0;
  std::vector<std::uint32_t> label;   ///< labels_of
  std::vector<std::uint32_t> object;  ///< TrackedObject::id of the moving object; 0: static or no return
  std::vector<std::uint8_t> stages;   ///< stage_masks_of
  std::vector<float> probability;     ///< LabelledScan::probability_by_input
  std::vector<TrackedObject> objects;
  std::shared_ptr<const Trajectory> trajectory;
  SE3 T_0v;  ///< at the start of the scan
  MotionState motion_state = MotionState::good;
  std::string trouble;  ///< trouble_of the odometry; empty where there was none
};

/// OnlineDetector for clouds in memory. An unknown sensor is recovered from the first scans; they are kept
/// until then.
class LiveDetector {
 public:
  /// `sensor`: a named model or calibration file; empty: recovered. `rotation_rate_hz`: replaces that of the
  /// model. `settings`: parameters by key, as the configuration file writes them. Throws ParameterError.
  LiveDetector(const std::string& sensor, std::optional<double> rotation_rate_hz, const std::string& profile,
               const std::map<std::string, std::string>& settings);

  /// Whether `cloud` of the next push must stay valid after the call.
  [[nodiscard]] bool keeps_clouds() const { return !builder_; }
  [[nodiscard]] std::vector<FoundScan> push(Cloud cloud, std::shared_ptr<const Trajectory> given);
  [[nodiscard]] std::vector<FoundScan> push(const std::shared_ptr<const LidarScan>& scan,
                                            const std::shared_ptr<const Trajectory>& given);
  /// OnlineDetector::add_measurement.
  void add_measurement(const MotionMeasurement& measured) { detector_.add_measurement(measured); }
  [[nodiscard]] std::vector<FoundScan> flush();
  [[nodiscard]] int latency() const { return detector_.latency(); }
  /// Name of the sensor, and how it was recovered; empty until it is.
  [[nodiscard]] std::string sensor() const { return builder_ ? builder_->model()->name : ""; }
  [[nodiscard]] std::vector<std::string> notes() const;
  [[nodiscard]] std::string odometry_trouble() const { return detector_.odometry_report().trouble(); }
  /// What contradicts in the scans pushed since the last call: ScanWatch::take_lines.
  [[nodiscard]] std::vector<std::string> take_doubts() { return watch_.take_lines(); }

 private:
  [[nodiscard]] std::vector<FoundScan> push_built(const Cloud& cloud,
                                                  const std::shared_ptr<const Trajectory>& given);
  [[nodiscard]] std::vector<FoundScan> recover();

  OnlineDetector detector_;
  ScanWatch watch_;
  std::size_t watched_ = 0;
  std::optional<double> rotation_rate_hz_;
  std::optional<ScanBuilder> builder_;
  std::vector<std::pair<Cloud, std::shared_ptr<const Trajectory>>> waiting_;  // for the sensor
};

}  // namespace mapless::python
