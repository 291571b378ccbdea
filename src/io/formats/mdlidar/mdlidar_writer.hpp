#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// A row of vel_64_calib.csv. With a = rotation - rot_correction (clockwise), xy = r cos(vert) - v sin(vert):
/// x = xy cos a + h sin a, y = -xy sin a + h cos a, z = r sin(vert) + v cos(vert).
struct MdlidarLaser {
  double horiz_offset_m = 0;
  double vert_offset_m = 0;
  double rot_correction_rad = 0;
  double vert_correction_rad = 0;
};

struct MdlidarPoint {
  float range_m = -1;      ///< from the laser; -1: no return
  float rotation_deg = 0;  ///< hub angle, clockwise positive
  std::int32_t object_id = 0;
  bool dynamic = false;
};

/// One turn. `points` are sorted by laser in the order of the calibration, then by column; column c of n is
/// measured at start + c / (n - 1) (end - start).
struct MdlidarFrame {
  Time start;
  Time end;
  std::vector<MdlidarPoint> points;
  SE3 pose_p;  ///< position_p, orientation_p; the simulator's: world from sensor at `start`
  SE3 pose;    ///< position, orientation; the simulator's: world from sensor at `end`
};

/// Writes a recording in the format of the mdlidar dataset: `header`, `frame/data_<i>`, `vel_64_calib.csv`.
class MdlidarWriter {
 public:
  /// Creates the folder. Throws OutputError if that fails, ParameterError unless there are lasers, at least
  /// two points per laser and a positive frame period.
  MdlidarWriter(std::filesystem::path folder, const std::vector<MdlidarLaser>& lasers, int points_per_laser,
                Duration frame_period);
  /// Writes the next frame. Throws OutputError if that fails, InputError for a wrong number of points.
  void write(const MdlidarFrame& frame);
  /// Writes `header`: until then readers refuse the folder. Throws OutputError.
  void finish() const;

 private:
  [[nodiscard]] std::size_t points_per_frame() const {
    return lasers_ * static_cast<std::size_t>(points_per_laser_);
  }

  std::filesystem::path folder_;
  std::size_t lasers_;
  int points_per_laser_;
  Duration frame_period_;
  int frames_ = 0;
};

}  // namespace mapless
