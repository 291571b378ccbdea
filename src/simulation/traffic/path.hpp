#pragma once

#include <functional>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// Height of the ground [m] at (x, y).
using Terrain = std::function<double(double x, double y)>;

/// A smooth line in the x-y plane, by arc length; its ends continue straight.
class Path {
 public:
  /// At least two points; consecutive ones differ.
  explicit Path(const std::vector<Eigen::Vector2d>& waypoints);
  [[nodiscard]] double length_m() const { return static_cast<double>(points_.size() - 1) * kStep; }
  [[nodiscard]] Eigen::Vector2d at(double s) const;
  /// Unit vector along the chord of `span_m` about s: how a vehicle of that wheelbase points.
  [[nodiscard]] Eigen::Vector2d heading(double s, double span_m) const;

 private:
  static constexpr double kStep = 1;
  [[nodiscard]] Eigen::Vector2d point(long i) const;
  std::vector<Eigen::Vector2d> points_;  // kStep apart
};

/// Body on the ground at p, x along `heading`, z along the ground's normal.
[[nodiscard]] SE3 pose_on_ground(const Eigen::Vector2d& p, const Eigen::Vector2d& heading,
                                 const Terrain& terrain);

/// How far along its path something is, sampled; the acceleration is constant between two samples.
class Track {
 public:
  static constexpr double kStep_s = 0.1;
  Track(std::shared_ptr<const Path> path, double wheelbase_m, Terrain terrain)
      : path_(std::move(path)), wheelbase_m_(wheelbase_m), terrain_(std::move(terrain)) {}
  /// `aside_m` to the left of the path.
  void add(double s, double v, double aside_m = 0) {
    s_.push_back(s);
    v_.push_back(v);
    aside_.push_back(aside_m);
  }
  /// Beyond the last sample the speed is kept.
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
