#include "odometry/registration/motion_support.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mapless::inline v1 {
namespace {

// The support of a scan is its mean robust weight plus this times the logarithm of the smallest constraint
// ratio. Both constants are the logistic regression of wrong motions (more than 0.5 m off over 4 scans) on
// those two, over 48 recordings of the second simulator (docs/notebook/odometry.md, "Is the motion right?").
constexpr double kWeightOfConstraint = 0.042;
constexpr double kMinSupport = 0.257;
// A map is young during this many scans from the decision on its start on. Measured on the 20 motorway starts
// of these: the support of right motions grows from .10 to .26 within 20 scans; that of the wrong ones is -.1
// to .26, so that the state can be degenerate at most.
constexpr std::size_t kYoungScans = 15;
constexpr double kMinYoungSupport = 0.08;
// Smallest constraint ratio in the logarithm: a tenth of the least ratio that counts as constrained.
constexpr double kLeastConstraintRatio = 1e-5;

}  // namespace

void MotionSupport::add(double mean_robust_weight, const Degeneracy& degeneracy) {
  const double ratio = std::max(degeneracy.constraint_ratio[0], kLeastConstraintRatio);
  support_[added_++ % kScans] = mean_robust_weight + kWeightOfConstraint * std::log(ratio);
}

MotionState MotionSupport::state() const {
  if (added_ == 0) return MotionState::good;
  const std::size_t count = std::min(added_, kScans);
  const auto end = support_.begin() + static_cast<std::ptrdiff_t>(count);
  const double mean = std::accumulate(support_.begin(), end, 0.0) / static_cast<double>(count);
  if (mean >= kMinSupport) return MotionState::good;
  return added_ < kYoungScans && mean >= kMinYoungSupport ? MotionState::degenerate : MotionState::lost;
}

}  // namespace mapless
