#include "live/measurement_queue.hpp"

#include <cmath>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace mapless::inline v1 {
namespace {

// Ten seconds of an inertial sensor at 1 kHz.
constexpr std::size_t kMostWaiting = 10'000;

const char* name_of_input(bool wheels) { return wheels ? "wheel odometry" : "imu"; }

}  // namespace

void MeasurementQueue::add(Measured measured, std::optional<Time> newest_cloud, Time now, Health& health) {
  const char* input = name_of_input(measured.linear.has_value());
  if (!measured.angular.allFinite() || (measured.linear && !measured.linear->allFinite())) {
    health.report(LiveLevel::warning, fmt::format("{} value", input),
                  fmt::format("{}: a velocity that is not finite is not used", input), now);
    return;
  }
  const double ahead_s = newest_cloud ? (measured.time - *newest_cloud).seconds() : 0;
  if (std::abs(ahead_s) > parameters_.max_gap_s) {
    health.report(LiveLevel::warning, fmt::format("{} clock", input),
                  fmt::format("{}: its stamps are {:.3f} s {} those of the clouds, and it is not used; give "
                              "both one clock",
                              input, std::abs(ahead_s), ahead_s > 0 ? "after" : "before"),
                  now);
    return;
  }
  waiting_.push_back(std::move(measured));
  if (waiting_.size() > kMostWaiting) waiting_.pop_front();
}

std::vector<MotionMeasurement> MeasurementQueue::take(const std::string& lidar_frame, Time begin, Time end,
                                                      const TransformBuffer& transforms, Time now,
                                                      Health& health) {
  std::vector<MotionMeasurement> taken;
  std::deque<Measured> later;
  bool imu = false, wheels = false;
  for (Measured& one : waiting_) {
    if (one.time > end) {
      later.push_back(std::move(one));
      continue;
    }
    (one.linear ? wheels : imu) |= one.time >= begin;
    const auto T_lf = transforms.fixed(lidar_frame, one.frame);
    if (!T_lf) {
      health.report(LiveLevel::warning, "place of a measurement",
                    fmt::format("{}: no static transforms place frame {} on {}, and it is not used",
                                name_of_input(one.linear.has_value()), one.frame, lidar_frame),
                    now);
      continue;
    }
    MotionMeasurement measured;
    measured.time = one.time;
    if (one.linear) {
      // The origin of the lidar, in the frame of the wheels, moves along on a rigid body.
      const Eigen::Vector3d lidar_f = T_lf->inverse().translation();
      measured.quantity = MeasuredMotion::speed;
      measured.value.x() = (*one.linear + one.angular.cross(lidar_f)).norm();
    } else {
      measured.quantity = MeasuredMotion::angular_velocity;
      measured.value = T_lf->rotation() * one.angular;
    }
    taken.push_back(measured);
  }
  waiting_ = std::move(later);
  used_ += taken.size();
  report_missing(imu, wheels, now, health);
  return taken;
}

void MeasurementQueue::report_missing(bool imu, bool wheels, Time now, Health& health) const {
  for (const bool of_wheels : {false, true}) {
    const bool wanted = of_wheels ? parameters_.use_wheel_odometry : parameters_.use_imu;
    if (!wanted || (of_wheels ? wheels : imu)) continue;
    health.report(LiveLevel::warning, fmt::format("no {}", name_of_input(of_wheels)),
                  fmt::format("{}: nothing was measured during the cloud; own odometry goes on without it",
                              name_of_input(of_wheels)),
                  now);
  }
}

}  // namespace mapless
