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
/// object_states.csv (io/object_tables.hpp). Throws OutputError if the folder exists or cannot be created,
/// ParameterError for an unknown format or a null model, InputError for an invalid model (validate).
[[nodiscard]] std::unique_ptr<SequenceWriter> make_sequence_writer(std::string_view format,
                                                                   const std::filesystem::path& folder,
                                                                   std::shared_ptr<const LidarModel> model,
                                                                   const Scene& scene);

}  // namespace mapless
