#include <algorithm>

#include <fmt/format.h>

#include "trajectory/domain.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {
namespace {

// More than twice round the Earth: geocentric and map coordinates are within.
constexpr double kFarthest_m = 1e8;

void require_near(const TimedPose& pose, std::size_t number, const std::string& source) {
  const Eigen::Vector3d position = pose.T_v0.inverse().translation();
  if (position.norm() <= kFarthest_m) return;  // false for NaN
  throw InputError({source, fmt::format("position of pose {}", number),
                    fmt::format("{:g} {:g} {:g}", position.x(), position.y(), position.z()),
                    fmt::format("farther than {:g} m from the origin", kFarthest_m),
                    "give positions in metres, or leave the row out"});
}

}  // namespace

SampledTrajectory::SampledTrajectory(std::vector<TimedPose> poses, Duration max_extrapolation,
                                     std::string source)
    : poses_(std::move(poses)), max_extrapolation_(max_extrapolation), source_(std::move(source)) {
  IncreasingTimes times(source_, "pose");
  for (const TimedPose& pose : poses_) times.add(pose.time);
  times.finish();
  for (std::size_t i = 0; i < poses_.size(); ++i) require_near(poses_[i], i, source_);
  velocities_.reserve(poses_.size() - 1);
  for (std::size_t i = 0; i + 1 < poses_.size(); ++i) {
    const SE3 T_21 = poses_[i + 1].T_v0 * poses_[i].T_v0.inverse();
    velocities_.push_back(T_21.log() / (poses_[i + 1].time - poses_[i].time).seconds());
  }
}

Time SampledTrajectory::begin() const { return poses_.front().time - max_extrapolation_; }

Time SampledTrajectory::end() const { return poses_.back().time + max_extrapolation_; }

// The first and the last segment also serve before and after them.
std::size_t SampledTrajectory::segment(Time t) const {
  const auto after = std::upper_bound(poses_.begin() + 1, poses_.end() - 1, t,
                                      [](Time time, const TimedPose& pose) { return time < pose.time; });
  return static_cast<std::size_t>(after - poses_.begin()) - 1;
}

TrajectoryState SampledTrajectory::at(Time t) const {
  require_covered(t, begin(), end(), source_);
  const std::size_t i = segment(t);
  return {SE3::exp((t - poses_[i].time).seconds() * velocities_[i]) * poses_[i].T_v0, velocities_[i]};
}

void SampledTrajectory::sample(Time first, Duration period, std::span<TrajectoryState> states) const {
  std::size_t i = 0;
  Time t = first;
  for (std::size_t k = 0; k < states.size(); ++k, t = t + period) {
    require_covered(t, begin(), end(), source_);
    if (k == 0 || t >= poses_[i + 1].time) i = segment(t);
    states[k] = {SE3::exp((t - poses_[i].time).seconds() * velocities_[i]) * poses_[i].T_v0, velocities_[i]};
  }
}

}  // namespace mapless
