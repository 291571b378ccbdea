#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>
#include <mapless/detection/detector.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/odometry/lidar_odometry.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// The states of the motion over a run. Memory does not grow with the number of scans, but for 8 bytes a
/// restart.
class OdometryReport {
 public:
  /// Adds the scan that `update` is of. Scans come in the order in which odometry processed them.
  void add(const LidarScan& scan, const OdometryUpdate& update);

  [[nodiscard]] std::size_t scans() const { return scans_; }
  /// Number of scans with this state, as known by now.
  [[nodiscard]] std::size_t count(MotionState state) const;
  /// Numbers of the scans, counted from 0, with which a new map began after a loss.
  [[nodiscard]] const std::vector<std::size_t>& restarts() const { return restarts_; }
  /// Number of scans that begin more than half a scan's duration after the scan before them.
  [[nodiscard]] std::size_t gaps() const { return gaps_; }

  /// One line that lists the problems met; empty where there were none.
  [[nodiscard]] std::string trouble() const;

 private:
  void settle(std::size_t still_open);

  std::size_t scans_ = 0;
  std::array<std::size_t, 3> counts_ = {};  // by state, of the scans whose state no later scan changes
  std::optional<std::size_t> first_lost_;   // of these scans
  std::vector<MotionState> undecided_;      // of the last scans, while the motion of the first is not decided
  bool starting_ = true;
  std::vector<std::size_t> restarts_;
  std::size_t gaps_ = 0;
  Time last_end_;  // of the scan before
};

/// The share of points called moving, over a run. It tells scans whose poses, or whose place among the
/// others, are wrong: the static world then moves at once.
class MovingShare {
 public:
  /// Numbers of points by the azimuth at which they were measured, the turn in equal sectors.
  static constexpr std::size_t kSectors = 16;
  using Sectors = std::array<std::size_t, kSectors>;

  /// Scan number `k` of the recording; in their order.
  void add(std::size_t k, const Sectors& moving, const Sectors& points);
  /// The same, of a labelled scan.
  void add(std::size_t k, const Detection& detection);
  /// One line; empty where nothing is suspicious.
  [[nodiscard]] std::string trouble() const;

 private:
  std::size_t scans_ = 0, rises_ = 0, first_rise_ = 0;
  double rise_from_ = 0, rise_to_ = 0;  // of the first one
  std::size_t moving_ = 0, points_ = 0;
  struct Shares {
    double all = 0;
    double least_half = 0;  // the least of any half turn
  };
  static Shares shares_of(const Sectors& moving, const Sectors& points);
  std::array<Shares, 3> before_{};  // of the last scans
};

/// What limits the motion estimate of one scan, in one line; empty where its motion is good.
[[nodiscard]] std::string trouble_of(const OdometryUpdate& update);

/// Settings of an OnlineDetector.
struct OnlineDetectorOptions {
  DetectorParameters detection;
  OdometryParameters odometry;  ///< not used where poses are given
  /// Runs the detection of a scan at the same time as the odometry of the next scan, on a second thread.
  /// The labels are the same, but they come with the next call (see OnlineDetector::catch_up).
  bool side_by_side = false;
  /// Threads of the detection where it runs side by side; 0: all that oneTBB has.
  int detection_threads = 0;
  /// Detector::explain; empty: nothing is explained.
  std::function<bool(Time)> explain = {};
};

/// One scan with the label of every point and the motion of its sensor. Owns everything that it refers to: it
/// may be kept, and used on another thread, while the detector goes on or after the detector has gone.
struct LabelledScan {
  /// Labels per return of the scan, and the objects. `detection.sequence_number` counts the scans pushed,
  /// from 0. Where the motion is lost, no point has a label: `detection.motion_known` is false.
  Detection detection;
  /// T_v0(t) over the whole scan: the one given, or what odometry had estimated when the labels were made,
  /// which begins a second or more before the scan, or with the first scan of the drive.
  std::shared_ptr<const Trajectory> trajectory;
  /// What odometry found with this scan; null where poses were given. trouble_of() puts it into words.
  std::shared_ptr<const OdometryUpdate> odometry;

  [[nodiscard]] const LidarScan& scan() const { return *detection.scan; }
  /// Sensor to world at the scan's start.
  [[nodiscard]] SE3 T_0v() const { return trajectory->at(scan().start).T_v0.inverse(); }
  /// What is known of the motion; good where poses were given.
  [[nodiscard]] MotionState motion_state() const { return odometry ? odometry->state : MotionState::good; }
  /// Per record of the input, in its order and length (LidarScan::input_size): the number of the moving
  /// object the point belongs to, 0 for static points, for records without a return, and for all records of
  /// a scan whose motion is lost.
  [[nodiscard]] std::vector<std::uint16_t> object_by_input() const;
  /// Detection::probability per record of the input; NaN where it is not known: for records without a return,
  /// where the motion is lost, and with method "published".
  [[nodiscard]] std::vector<float> probability_by_input() const;
};

/// The whole method, online: scans in, labelled scans with poses out (arXiv 1809.06972).
///
///     mapless::OnlineDetector online;
///     for (std::size_t k = 0; k < recording->size(); ++k)
///       for (const mapless::LabelledScan& found : online.push(recording->read(k))) use(found);
///     for (const mapless::LabelledScan& found : online.flush()) use(found);
///
/// For each scan: (1) lidar odometry extends the trajectory, unless poses are given; (2) the detector labels
/// the points; (3) the points labelled dynamic are removed from the map of the odometry. Step 3 waits until
/// the odometry of the next scan is done, whether or not the two run side by side: results are the same, byte
/// for byte, for any number of threads.
///
/// Labelled scans come out in the order pushed, `latency()` scans late. The first ones come together:
/// odometry needs five to ten scans to find the motion during the first (LidarOdometry::started), and the
/// detector VotingParameters::start_scans.
///
/// Not thread-safe: one call at a time.
class OnlineDetector {
 public:
  /// Throws ParameterError for a parameter out of bounds.
  explicit OnlineDetector(const OnlineDetectorOptions& options = {});
  ~OnlineDetector();
  OnlineDetector(OnlineDetector&&) noexcept;
  OnlineDetector& operator=(OnlineDetector&&) noexcept;

  /// Takes the next scan and returns the labelled scans that are ready.
  ///
  /// `given`: T_v0(t), covering the scan; null: lidar odometry estimates it, with world 0 the sensor frame at
  /// the start of the first scan. Either every scan has given poses or none. A scan that was already motion-
  /// compensated is taken back to the measured rays (restore_measured_rays), for which poses must be given.
  ///
  /// Throws InputError for a scan that does not start after the one before, for a compensated scan without
  /// given poses, and where given poses follow estimated ones or the reverse; TrajectoryDomainError where
  /// `given` does not cover the scan. The scan is then not taken, and the detector can go on with another.
  [[nodiscard]] std::vector<LabelledScan> push(const std::shared_ptr<const LidarScan>& scan,
                                               const std::shared_ptr<const Trajectory>& given = nullptr);
  [[nodiscard]] std::vector<LabelledScan> push(LidarScan scan,
                                               const std::shared_ptr<const Trajectory>& given = nullptr);

  /// Detector::learn_own_vehicle, from a scan before the first one pushed, with given poses.
  void learn_own_vehicle(const LidarScan& scan, const Trajectory& given);

  /// What another sensor measures of the motion, before the scan during which it is measured is pushed:
  /// LidarOdometry::add_measurement. Without effect where poses are given.
  void add_measurement(const MotionMeasurement& measured);

  /// Runs now, on the calling thread, the detection that the next push would run side by side with odometry,
  /// and returns its labelled scans; nothing without OnlineDetectorOptions::side_by_side. For a live sensor:
  /// call it where the next scan has not arrived yet.
  [[nodiscard]] std::vector<LabelledScan> catch_up();

  /// Labels the scans that are still held back, with what is known now. The detector can then go on.
  [[nodiscard]] std::vector<LabelledScan> flush();

  /// Detector::new_rays and Detector::add_rays_of_another_sensor.
  [[nodiscard]] std::vector<std::shared_ptr<const RayImage>> new_rays();
  void add_rays_of_another_sensor(std::shared_ptr<const RayImage> rays);

  /// Scans between a scan and its labels, once started: forward_gap, without side_by_side.
  [[nodiscard]] int latency() const;
  /// Outcomes of the odometry so far; all zero where poses are given.
  [[nodiscard]] const OdometryReport& odometry_report() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A labelled scan of one sensor of a rig. Times are on the clock of the rig.
struct RigScan {
  std::size_t sensor = 0;  ///< index in the list of sensors
  /// `detection.sequence_number` counts the scans pushed of this sensor. `trajectory` is null where the
  /// motion is not known over the whole scan; `motion_known` is false then.
  LabelledScan labelled;
};

/// Several lidars on one vehicle: one motion, and the labels of every scan of each (OnlineDetector).
///
/// The motion of the rig is that of its first sensor: given, or estimated by lidar odometry from the scans of
/// that sensor alone. The motion of the other sensors follows from their places on the vehicle. Each ray has
/// the pose of its own sensor at its own instant. Where rays of one sensor passed through a point of a later
/// scan of another, that is evidence that the point is dynamic. Apart from that each sensor has its own
/// labels, objects and ids. A rig of one sensor gives the labels of an OnlineDetector.
///
/// Where the motion is estimated, a scan of another sensor waits until the scans of the first sensor during
/// it are labelled. No point of it gets a label (`detection.motion_known` is false) where the motion of the
/// first sensor is lost, where it is not known over the whole scan, and where kMostWaiting scans wait behind
/// it. A new map of the odometry is a new world for all sensors, and the scans that wait then get no labels.
///
/// Results are the same for any number of threads. Not thread-safe: one call at a time.
class RigDetector {
 public:
  /// Throws ParameterError for no sensors, an empty name, two of one name, and a parameter out of bounds.
  /// OnlineDetectorOptions::side_by_side is without effect.
  explicit RigDetector(std::vector<RigSensor> sensors, const OnlineDetectorOptions& options = {});
  ~RigDetector();
  RigDetector(RigDetector&&) noexcept;
  RigDetector& operator=(RigDetector&&) noexcept;

  /// Takes the next scan of a sensor, on the clock of the sensor, and returns the labelled scans that are
  /// ready, those of each sensor in the order pushed. Scans of different sensors are pushed as they come: a
  /// scan is evidence for scans of other sensors that are labelled after it was pushed.
  ///
  /// `given`: T_v0(t) of the first sensor on the clock of the rig, covering the scan; null: estimated. Either
  /// every scan has given poses or none. Throws ParameterError for a sensor that does not exist or a null
  /// scan, and what OnlineDetector::push throws; the scan is then not taken.
  [[nodiscard]] std::vector<RigScan> push(std::size_t sensor, std::shared_ptr<const LidarScan> scan,
                                          const std::shared_ptr<const Trajectory>& given = nullptr);
  /// Labels the scans that are still held back. The detector can then go on.
  [[nodiscard]] std::vector<RigScan> flush();

  [[nodiscard]] const std::vector<RigSensor>& sensors() const;
  /// Outcomes of the odometry, with the scans of the first sensor; all zero where poses are given.
  [[nodiscard]] const OdometryReport& odometry_report() const;

  static constexpr std::size_t kMostWaiting = 40;  ///< scans of one sensor

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mapless
