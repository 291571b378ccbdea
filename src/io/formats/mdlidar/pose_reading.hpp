#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/formats/mdlidar/mdlidar_files.hpp"
#include "io/formats/mdlidar/trajectory_comparison.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Meaning of the poses of an mdlidar recording, which its documentation does not define.
struct PoseReading {
  PoseDirection direction = PoseDirection::world_from_sensor;
  FramePoseInstant instant = FramePoseInstant::end;
};

/// The poses of the frames, read in one way, and at constant velocity beyond the first and last frame. Throws
/// InputError naming `source` for no frame, and for frames that are not in the order of their times.
[[nodiscard]] SampledTrajectory trajectory_of(const std::vector<MdlidarFrameSummary>& frames,
                                              const PoseReading& reading, const std::string& source);

/// How the poses of a recording are read, and why.
struct PoseReadingChoice {
  PoseReading reading;
  std::shared_ptr<const Trajectory> trajectory;
  std::vector<std::string> notes;      ///< for the user: what was chosen, by which figures
  std::optional<ErrorDetail> refusal;  ///< set where static points move under every reading
};

/// Chooses the direction of the poses, then the instant of `position`, each by comparing the scans under both
/// trajectories (compare_trajectories), where `direction` or `instant` does not give it. Where the scans
/// cannot decide, PoseReading{} is taken.
[[nodiscard]] PoseReadingChoice choose_pose_reading(const std::vector<MdlidarFrameSummary>& frames,
                                                    std::optional<PoseDirection> direction,
                                                    std::optional<FramePoseInstant> instant,
                                                    const std::string& source, const ScanReader& read);

}  // namespace mapless
