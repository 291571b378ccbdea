#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <mapless/lidar/lidar_model.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/simulation/scene.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// A surface that moves faster than this is dynamic in the true labels (paper, section V) [m/s].
inline constexpr double kDynamicSpeed_mps = 0.2;

struct SensorOptions {
  double range_noise_m = 0.02;  ///< standard deviation of the Gaussian range noise, 0 to 10
  bool faulty = true;           ///< dark, glass and grazed surfaces give no return at random
  std::uint64_t seed = 1;
};

/// One turn. Each vector has one entry per firing, ordered by laser, then column.
struct SimulatedScan {
  Time start;
  std::vector<LidarRecord> records;
  std::vector<std::uint32_t> labels;  ///< class and object id (io/labels.hpp); 0 without a return
  std::vector<float> intensities;     ///< 0 to 1
};

/// A lidar that moves along a trajectory through a world. Every ray starts at the pose of its laser at its
/// own firing time. Noise and faults depend on seed, scan, laser and column only.
class SimulatedSensor {
 public:
  /// `world` must outlive the sensor; scan() prepares it, so that two sensors of one world take turns. Throws
  /// ParameterError for a null model or trajectory and for options out of bounds, InputError for an invalid
  /// model (validate).
  SimulatedSensor(std::shared_ptr<const LidarModel> model, std::shared_ptr<const Trajectory> trajectory,
                  SimulatedWorld& world, SensorOptions options);

  /// Scan `number`, which starts at time number / rotation_rate_hz. Throws TrajectoryDomainError if the
  /// trajectory does not cover it.
  [[nodiscard]] SimulatedScan scan(int number);
  /// The same scan as the input of odometry and detection, without its truth.
  [[nodiscard]] std::shared_ptr<const LidarScan> lidar_scan(int number);
  /// `cast` of this sensor, as above.
  [[nodiscard]] std::shared_ptr<const LidarScan> lidar_scan(const SimulatedScan& cast) const;

 private:
  void cast_column(int number, int column, SimulatedScan& out) const;
  void finish_record(int number, int laser, int column, const Eigen::Matrix3d& C_vh,
                     const std::optional<RayHit>& hit, SimulatedScan& out) const;
  [[nodiscard]] double fault_probability(const RayHit& hit) const;
  [[nodiscard]] Time firing_time(Time start, int column, int laser) const;

  std::shared_ptr<const LidarModel> model_;
  std::shared_ptr<const Trajectory> trajectory_;
  SimulatedWorld& world_;
  SensorOptions options_;
  std::vector<Eigen::Vector3d> directions_h_;  // of each laser, in the hub
  Duration column_period_;
  Duration first_firing_, last_firing_;  // least and largest firing offset of the lasers
};

/// Writes a simulated recording in one of the formats of sequence_formats().
class SequenceWriter {
 public:
  virtual ~SequenceWriter() = default;
  /// Appends the next scan in order of time. Throws OutputError.
  virtual void add(const SimulatedScan& scan) = 0;
  /// Completes the recording: until then its readers refuse the folder. Throws OutputError.
  virtual void finish() = 0;
};

/// "native", "mdlidar" and "kitti". mdlidar stores the true pose at the start and the end of each frame, and
/// neither the reason of a missing return nor firing times within a column. KITTI clouds are
/// motion-compensated to the middle of their scan, as in the KITTI odometry dataset, with labels/ beside
/// velodyne/.
[[nodiscard]] const std::vector<std::string>& sequence_formats();

/// The model with the properties that the format can store: without firing offsets for mdlidar, and with
/// turns that begin at the rear for KITTI, whose readers recover the time of a point from its azimuth.
[[nodiscard]] LidarModel model_for_format(LidarModel model, std::string_view format);

/// Creates `folder` and a writer of this format into it. The writer adds objects.csv and, scan by scan,
/// object_states.csv (io/labels.hpp). Throws OutputError if the folder exists or cannot be created,
/// ParameterError for an unknown format or a null model, InputError for an invalid model (validate).
[[nodiscard]] std::unique_ptr<SequenceWriter> make_sequence_writer(std::string_view format,
                                                                   const std::filesystem::path& folder,
                                                                   std::shared_ptr<const LidarModel> model,
                                                                   const Scene& scene);

}  // namespace mapless
