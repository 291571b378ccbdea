#pragma once

#include <functional>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// Height of the ground [m] at (x, y) [m], in the level frame 0.
using Terrain = std::function<double(double x, double y)>;

/// A smooth curve in the x-y plane of frame 0, parametrised by arc length s [m]. It continues straight beyond
/// its ends.
class Path {
 public:
  /// A smooth curve along at least two waypoints [m], consecutive ones different.
  explicit Path(const std::vector<Eigen::Vector2d>& waypoints);
  [[nodiscard]] double length_m() const { return static_cast<double>(points_.size() - 1) * kStep; }
  [[nodiscard]] Eigen::Vector2d at(double s) const;
  /// Unit vector along the chord of length `span_m` centred on s: the heading of a vehicle with that
  /// wheelbase.
  [[nodiscard]] Eigen::Vector2d heading(double s, double span_m) const;

 private:
  static constexpr double kStep = 1;  // [m]
  [[nodiscard]] Eigen::Vector2d point(long i) const;
  std::vector<Eigen::Vector2d> points_;  // at arc lengths 0, kStep, 2 kStep ...
};

/// Pose T_0b of a body on the ground at p: x along `heading`, z along the normal of the ground.
[[nodiscard]] SE3 pose_on_ground(const Eigen::Vector2d& p, const Eigen::Vector2d& heading,
                                 const Terrain& terrain);

/// The motion of a road user along its path, sampled every kStep_s from time 0 on with constant acceleration
/// between two samples. The last speed is kept beyond the last sample.
class Track {
 public:
  static constexpr double kStep_s = 0.1;
  Track(std::shared_ptr<const Path> path, double wheelbase_m, Terrain terrain)
      : path_(std::move(path)), wheelbase_m_(wheelbase_m), terrain_(std::move(terrain)) {}
  /// Appends a sample: distance s [m] along the path, speed v [m/s], and lateral offset to the left of the
  /// path [m].
  void add(double s, double v, double aside_m = 0) {
    s_.push_back(s);
    v_.push_back(v);
    aside_.push_back(aside_m);
  }
  /// Distance along the path at time t_s.
  [[nodiscard]] double distance_m(double t_s) const;
  [[nodiscard]] double speed(double t_s) const;
  [[nodiscard]] SE3 pose(double t_s) const;
  [[nodiscard]] const Path& path() const { return *path_; }

 private:
  std::shared_ptr<const Path> path_;
  double wheelbase_m_;
  Terrain terrain_;
  [[nodiscard]] double aside_m(double t_s) const;
  std::vector<double> s_, v_, aside_;
};

}  // namespace mapless
