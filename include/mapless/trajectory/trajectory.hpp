#pragma once

/// @file
/// Room trajectory: where the sensor was, as a continuous function of time. In go timed poses (from a file,
/// from the odometry); out come pose and velocity at any instant within the time domain. A trajectory does
/// not change once it is made, and every member function is thread-safe.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// Pose and velocity of the sensor at one instant.
struct TrajectoryState {
  SE3 T_v0;        ///< sensor (v) from world (0): p_v = T_v0 * p_0
  Vector6d varpi;  ///< body-centric velocity, d/dt T_v0 = varpi^ T_v0 [m/s, rad/s]
};

/// A continuous-time trajectory T_v0(t), varpi(t) (paper, section III-A, step 1).
class Trajectory {
 public:
  virtual ~Trajectory() = default;
  /// First and last instant of the time domain, extrapolation included.
  [[nodiscard]] virtual Time begin() const = 0;
  [[nodiscard]] virtual Time end() const = 0;
  /// Throws TrajectoryDomainError outside [begin, end].
  [[nodiscard]] virtual TrajectoryState at(Time t) const = 0;
  /// States at the instants first + i period, i = 0 ... states.size() - 1. Faster than as many calls of at().
  /// Throws ParameterError for a negative period, TrajectoryDomainError as at() does.
  virtual void sample(Time first, Duration period, std::span<TrajectoryState> states) const;
};

/// A sensor that does not move: T_v0 is the identity at all times.
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

/// Poses at given times (ground truth, output of another system) with constant body-centric velocity between
/// two of them: T(t) = exp(r ln(T_2 T_1^-1)) T_1, r = (t - t_1) / (t_2 - t_1). The first and the last
/// velocity extrapolate by at most `max_extrapolation` beyond the ends.
class SampledTrajectory final : public Trajectory {
 public:
  /// `poses`: at least two, by strictly increasing time, rotations orthonormal to 1e-3, positions within
  /// 1e8 m of the origin. Throws InputError naming `source` (a file name, for messages) otherwise, and
  /// ParameterError for a negative `max_extrapolation`.
  SampledTrajectory(std::vector<TimedPose> poses, Duration max_extrapolation, std::string source);
  [[nodiscard]] Time begin() const override;
  [[nodiscard]] Time end() const override;
  [[nodiscard]] TrajectoryState at(Time t) const override;
  void sample(Time first, Duration period, std::span<TrajectoryState> states) const override;
  [[nodiscard]] const std::vector<TimedPose>& poses() const { return poses_; }

 private:
  [[nodiscard]] std::size_t segment(Time t) const;

  std::vector<TimedPose> poses_;
  std::vector<Vector6d> velocities_;  // [i] from pose i to pose i + 1
  Duration max_extrapolation_;
  std::string source_;
};

/// One knot of the Gaussian-process trajectory.
struct TrajectoryKnot {
  Time time;
  SE3 T_v0;
  Vector6d varpi;
};

/// Gaussian process on SE(3) with white noise on acceleration: its posterior mean between knots (Anderson and
/// Barfoot, IROS 2015; method.md section 3).
class GaussianProcessTrajectory final : public Trajectory {
 public:
  /// `knots`: at least two, by strictly increasing time, poses as SampledTrajectory requires them, velocities
  /// finite. Throws InputError naming `source` otherwise.
  GaussianProcessTrajectory(std::vector<TrajectoryKnot> knots, std::string source);
  [[nodiscard]] Time begin() const override { return knots_.front().time; }
  [[nodiscard]] Time end() const override { return knots_.back().time; }
  [[nodiscard]] TrajectoryState at(Time t) const override;
  void sample(Time first, Duration period, std::span<TrajectoryState> states) const override;

 private:
  std::vector<TrajectoryKnot> knots_;
  std::string source_;
};

/// Interpolation between two knots (method.md section 3). Throws ParameterError unless k1.time < k2.time.
class KnotSegment {
 public:
  KnotSegment(const TrajectoryKnot& k1, const TrajectoryKnot& k2);
  /// `t` in [k1.time, k2.time].
  [[nodiscard]] TrajectoryState at(Time t) const;

 private:
  TrajectoryKnot k1_;
  double dt_;
  Vector6d xi_, velocity_2_;  // pose and velocity of knot 2 in the local coordinates ln(T T_1^-1) of knot 1
};

/// KnotSegment(k1, k2).at(t).
[[nodiscard]] TrajectoryState interpolate(const TrajectoryKnot& k1, const TrajectoryKnot& k2, Time t);

/// What a MotionMeasurement is of.
enum class MeasuredMotion : std::uint8_t {
  velocity,          ///< of the lidar, in its axes [m/s]
  speed,             ///< norm of the velocity of the lidar, whatever its direction [m/s]
  angular_velocity,  ///< of the lidar, about its axes [rad/s]
};

/// A lidar of a rig: one of several that are fixed to one vehicle (frame b).
struct RigSensor {
  std::string name;
  SE3 T_bv;               ///< vehicle from sensor: where the sensor is on the vehicle, and its orientation
  Duration clock_offset;  ///< to be added to the sensor's times: the clock of the rig is its first sensor's
  std::string model;      ///< a named model or a calibration file; empty: that of its recording
};

/// The motion of one sensor of a rig, from that of another: T_w0(t) = T_wv T_v0(t).
class MountedTrajectory final : public Trajectory {
 public:
  /// `of_v`: not null. `T_wv`: sensor w from sensor v, which does not change. The velocities at both ends of
  /// its domain extrapolate by `extrapolation`.
  MountedTrajectory(std::shared_ptr<const Trajectory> of_v, const SE3& T_wv,
                    Duration extrapolation = Duration());
  [[nodiscard]] Time begin() const override { return of_v_->begin() - extrapolation_; }
  [[nodiscard]] Time end() const override { return of_v_->end() + extrapolation_; }
  [[nodiscard]] TrajectoryState at(Time t) const override;

 private:
  std::shared_ptr<const Trajectory> of_v_;
  SE3 T_wv_;
  Duration extrapolation_;
};

/// What another sensor measures of the motion of the lidar at one instant: wheels, radar, an inertial sensor.
struct MotionMeasurement {
  Time time;  ///< on the clock of the scans
  MeasuredMotion quantity = MeasuredMotion::velocity;
  /// Three components in the sensor axes at `time`. Of a speed: the first, at least 0; the others are 0.
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  /// Standard deviation of every component, in the unit of `value`; greater than 0. None: the parameter for
  /// this quantity (OdometryParameters::velocity_sigma_mps and so on).
  std::optional<double> sigma;
};

}  // namespace mapless
