#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// Where the sensor was, and how it moved, at one instant.
struct TrajectoryState {
  SE3 T_v0;        ///< world (0) to sensor (v)
  Vector6d varpi;  ///< body-centric velocity, d/dt T_v0 = varpi^ T_v0 [m/s, rad/s]
};

/// A continuous-time trajectory T_v0(t), varpi(t) (paper step 1).
class Trajectory {
 public:
  virtual ~Trajectory() = default;
  /// First and last instant it can be asked for, extrapolation included.
  [[nodiscard]] virtual Time begin() const = 0;
  [[nodiscard]] virtual Time end() const = 0;
  /// Throws TrajectoryDomainError outside [begin, end].
  [[nodiscard]] virtual TrajectoryState at(Time t) const = 0;
  /// The same at `first`, `period` later and so on, one for each of `states`; throws as at() does. A
  /// trajectory may take less time for all of them than for each by itself.
  virtual void sample(Time first, Duration period, std::span<TrajectoryState> states) const;
};

/// A sensor that stands still at the origin, at all times.
class StationaryTrajectory final : public Trajectory {
 public:
  [[nodiscard]] Time begin() const override;
  [[nodiscard]] Time end() const override;
  [[nodiscard]] TrajectoryState at(Time t) const override;
};

struct TimedPose {
  Time time;
  SE3 T_v0;
};

/// Poses at given times (ground truth, another system's output): constant body-centric velocity between two
/// of them, T(t) = exp(r ln(T_2 T_1^-1)) T_1, and beyond the ends by at most `max_extrapolation`.
class SampledTrajectory final : public Trajectory {
 public:
  /// `poses` by strictly increasing time, at least two, none farther than 1e8 m from the origin; throws
  /// InputError naming `source` otherwise.
  SampledTrajectory(std::vector<TimedPose> poses, Duration max_extrapolation, std::string source);
  [[nodiscard]] Time begin() const override;
  [[nodiscard]] Time end() const override;
  [[nodiscard]] TrajectoryState at(Time t) const override;
  void sample(Time first, Duration period, std::span<TrajectoryState> states) const override;
  [[nodiscard]] const std::vector<TimedPose>& poses() const { return poses_; }

 private:
  [[nodiscard]] std::size_t segment(Time t) const;

  std::vector<TimedPose> poses_;
  std::vector<Vector6d> velocities_;  // between pose i and i + 1
  Duration max_extrapolation_;
  std::string source_;
};

/// One knot of the Gaussian-process trajectory.
struct TrajectoryKnot {
  Time time;
  SE3 T_v0;
  Vector6d varpi;
};

/// Gaussian process on SE(3) with white noise on acceleration: the posterior mean between knots (Anderson and
/// Barfoot, IROS 2015; method.md section 3).
class GaussianProcessTrajectory final : public Trajectory {
 public:
  /// `knots` by strictly increasing time, at least two; throws InputError naming `source` otherwise.
  GaussianProcessTrajectory(std::vector<TrajectoryKnot> knots, std::string source);
  [[nodiscard]] Time begin() const override { return knots_.front().time; }
  [[nodiscard]] Time end() const override { return knots_.back().time; }
  [[nodiscard]] TrajectoryState at(Time t) const override;
  void sample(Time first, Duration period, std::span<TrajectoryState> states) const override;

 private:
  std::vector<TrajectoryKnot> knots_;
  std::string source_;
};

/// Interpolation between two knots (method.md section 3).
class KnotSegment {
 public:
  KnotSegment(const TrajectoryKnot& k1, const TrajectoryKnot& k2);
  /// `t` in [k1.time, k2.time].
  [[nodiscard]] TrajectoryState at(Time t) const;

 private:
  TrajectoryKnot k1_;
  double dt_;
  Vector6d xi_, velocity_2_;  // of knot 2 in the coordinates of knot 1
};

/// KnotSegment(k1, k2).at(t).
[[nodiscard]] TrajectoryState interpolate(const TrajectoryKnot& k1, const TrajectoryKnot& k2, Time t);

}  // namespace mapless
