#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "detection/freespace/beam_fan.hpp"
#include <mapless/core/time.hpp>
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {

/// How far each ray of one scan went, and from where: all that FreespaceProbe needs of a scan later. About a
/// twentieth of the scan's size, since it holds neither points nor normals.
class RayImage {
 public:
  /// `before`: an image of an earlier scan. Of the same sensor, both share one BeamFan.
  /// `open`: cells without a return whose ray met nothing all the same (OpenSky), or empty.
  explicit RayImage(const CompensatedScan& scan, const RayImage* before = nullptr,
                    const std::vector<bool>& open = {});

  /// The hub at one instant, in single precision.
  struct Pose {
    Eigen::Matrix4f T_h0;  ///< world about origin_0() to hub; its last row is not used
    /// How points at rest move in a hub that does not turn, from one column to the next: a step of linear [m]
    /// + angular [rad] x p; of three numbers each.
    Eigen::Vector4f linear, angular;
    [[nodiscard]] Eigen::Vector3f operator*(const Eigen::Vector3f& q) const {
      return T_h0.topLeftCorner<3, 3>() * q + T_h0.topRightCorner<3, 1>();
    }
  };

  [[nodiscard]] const LidarModel& model() const { return *model_; }
  [[nodiscard]] const BeamFan& fan() const { return *fan_; }
  [[nodiscard]] int rows() const { return static_cast<int>(model_->lasers.size()); }
  [[nodiscard]] int columns() const { return static_cast<int>(poses_.size()); }
  /// Length of the cell's ray [m]: to its return, or the maximum range where nothing was within range, as the
  /// recording says or OpenSky finds; NaN where the firing is faulty or absent.
  [[nodiscard]] float range_m(int laser, int column) const { return row_m(laser)[column]; }
  /// range_m of all columns of a laser, and NaN for kBeside columns before the first and after the last.
  [[nodiscard]] const float* row_m(int laser) const {
    return ranges_m_.data() + static_cast<std::size_t>(laser) * (poses_.size() + kBeside) + kBeside;
  }
  static constexpr std::size_t kBeside = 16;  // half the widest window of FreespaceProbe, and one

  /// Keeps which returns were found dynamic. `object`: one element per return of `scan`, 0 for static;
  /// `scan`: the one this image was made of.
  void mark_dynamic(const LidarScan& scan, const std::vector<std::uint16_t>& object);
  /// Whether the cell's return was found dynamic; false before mark_dynamic.
  [[nodiscard]] bool dynamic(int laser, int column) const {
    return !dynamic_.empty() &&
           dynamic_[static_cast<std::size_t>(laser) * poses_.size() + static_cast<std::size_t>(column)];
  }
  /// Of the scan.
  [[nodiscard]] Time start() const { return start_; }
  /// Position of the sensor at the scan's start, in the world [m].
  [[nodiscard]] const Eigen::Vector3d& origin_0() const { return origin_0_; }
  /// Pose of the hub at the instant of a column.
  [[nodiscard]] const Pose& pose(int column) const { return poses_[static_cast<std::size_t>(column)]; }

 private:
  std::shared_ptr<const LidarModel> model_;
  std::shared_ptr<const BeamFan> fan_;  // where it is stays when the image is moved
  Time start_;
  Eigen::Vector3d origin_0_ = Eigen::Vector3d::Zero();
  std::vector<Pose> poses_;      // one per column
  std::vector<float> ranges_m_;  // row-major, with kBeside more columns before each row and after the last
  std::vector<bool> dynamic_;    // row-major; empty until marked
};

}  // namespace mapless
