#include <algorithm>

#include <fmt/format.h>

#include "trajectory/domain.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

SampledTrajectory::SampledTrajectory(std::vector<TimedPose> poses, Duration max_extrapolation,
                                     std::string source)
    : poses_(std::move(poses)), max_extrapolation_(max_extrapolation), source_(std::move(source)) {
  if (max_extrapolation_ < Duration()) {
    throw ParameterError({source_, "max_extrapolation", fmt::format("{} s", max_extrapolation_.seconds()),
                          "is negative", "give 0 to forbid any extrapolation"});
  }
  if (max_extrapolation_.nanoseconds() > Time::kLargestOutside_ns) {
    throw ParameterError({source_, "max_extrapolation", fmt::format("{} s", max_extrapolation_.seconds()),
                          "is more than 126 years", "give seconds"});
  }
  PoseChecks checks(source_, "pose");
  for (const TimedPose& pose : poses_) checks.add(pose.time, pose.T_v0);
  checks.finish();
  velocities_.reserve(poses_.size() - 1);
  for (std::size_t i = 0; i + 1 < poses_.size(); ++i) {
    const SE3 T_21 = poses_[i + 1].T_v0 * poses_[i].T_v0.inverse();
    velocities_.push_back(T_21.log() / (poses_[i + 1].time - poses_[i].time).seconds());
  }
}

Time SampledTrajectory::begin() const { return poses_.front().time - max_extrapolation_; }

Time SampledTrajectory::end() const { return poses_.back().time + max_extrapolation_; }

// The segment t lies in; the first segment for instants before it, the last for instants after it.
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
  require_period(period);
  std::size_t i = 0;
  Time t = first;
  for (std::size_t k = 0; k < states.size(); ++k, t = t + period) {
    require_covered(t, begin(), end(), source_);
    if (k == 0 || t >= poses_[i + 1].time) i = segment(t);
    states[k] = {SE3::exp((t - poses_[i].time).seconds() * velocities_[i]) * poses_[i].T_v0, velocities_[i]};
  }
}

}  // namespace mapless
