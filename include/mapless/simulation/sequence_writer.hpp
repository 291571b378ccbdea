#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <mapless/lidar/lidar_model.hpp>
#include <mapless/simulation/scene.hpp>
#include <mapless/simulation/simulated_sensor.hpp>

namespace mapless::inline v1 {

/// Writes a simulated recording in one of the formats of sequence_formats().
class SequenceWriter {
 public:
  virtual ~SequenceWriter() = default;
  /// Scans in order. Throws OutputError.
  virtual void add(const SimulatedScan& scan) = 0;
  /// Makes what was added so far a recording.
  virtual void finish() = 0;
};

/// "native", "mdlidar" and "kitti". mdlidar keeps the true frames' poses at each frame's start and end, and
/// tells neither faulty from empty nor firing times within a column. KITTI clouds are compensated to the
/// middle of their scan, as those of the KITTI odometry data set are, with labels/ beside velodyne/.
[[nodiscard]] const std::vector<std::string>& sequence_formats();

/// The model as the format can hold it: without firing times within a column for mdlidar, with turns that
/// begin at the rear for KITTI, whose readers take a point's time from its azimuth.
[[nodiscard]] LidarModel model_for_format(LidarModel model, std::string_view format);

/// Makes the folder; also writes objects.csv and, scan by scan, object_states.csv (io/object_truth.hpp).
/// Throws OutputError where the folder exists or cannot be made, ParameterError for an unknown format.
[[nodiscard]] std::unique_ptr<SequenceWriter> make_sequence_writer(std::string_view format,
                                                                   const std::filesystem::path& folder,
                                                                   std::shared_ptr<const LidarModel> model,
                                                                   const Scene& scene);

}  // namespace mapless
