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
  float range_m = -1;      ///< -1: no return
  float rotation_deg = 0;  ///< of the hub, clockwise
  std::int32_t object_id = 0;
  bool dynamic = false;
};

/// One turn. `points` are laser after laser in the order of the calibration, each by column; column c of n is
/// measured at start + c / (n - 1) (end - start).
struct MdlidarFrame {
  Time start;
  Time end;
  std::vector<MdlidarPoint> points;
  SE3 T_0v_start;  ///< world from sensor
  SE3 T_0v_end;
};

/// Writes a recording of the mdlidar dataset's format: `header`, `frame/data_<i>`, `vel_64_calib.csv`.
class MdlidarWriter {
 public:
  /// Makes the folder. Throws OutputError where that fails.
  MdlidarWriter(std::filesystem::path folder, const std::vector<MdlidarLaser>& lasers, int points_per_laser,
                Duration frame_period);
  /// Writes the next frame. Throws OutputError where it cannot, InputError for a wrong number of points.
  void write(const MdlidarFrame& frame);

 private:
  std::filesystem::path folder_;
  std::size_t points_per_frame_;
  int frames_ = 0;
};

}  // namespace mapless
