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
// to .26, so that without edges the state is degenerate at most.
constexpr std::size_t kYoungScans = 15;
// With less support than this a motion is lost, young or with edges.
constexpr double kLeastSupport = 0.08;
// The edges support a motion if they agree by this much with those of the scan before, and the mean robust
// weight is at least the second number. Measured on VLP-16 motorways, means over five scans: right motions
// have .17 to .45, and wrong ones .04 to .16 but for 4 of 92 scans (docs/notebook/odometry.md, "Edges and the
// state"). The weight is low where the map is blurred: in a forest edges agree by .3 although each scan errs
// by .03 m.
constexpr double kMinEdgeAgreement = 0.16;
constexpr double kMinWeightWithEdges = 0.35;
// Smallest constraint ratio in the logarithm: a tenth of the least ratio that counts as constrained.
constexpr double kLeastConstraintRatio = 1e-5;

}  // namespace

void MotionSupport::add(double mean_robust_weight, const Degeneracy& degeneracy) {
  const double ratio = std::max(degeneracy.constraint_ratio[0], kLeastConstraintRatio);
  weight_[added_ % kScans] = mean_robust_weight;
  support_[added_ % kScans] = mean_robust_weight + kWeightOfConstraint * std::log(ratio);
  ++added_;
  if (!needs_edges()) edge_agreement_.reset();
}

double MotionSupport::mean(const Last& last) const {
  const std::size_t count = std::min(added_, kScans);
  return std::accumulate(last.begin(), last.begin() + static_cast<std::ptrdiff_t>(count), 0.0) /
         static_cast<double>(count);
}

bool MotionSupport::needs_edges() const { return added_ > 0 && mean(support_) < kMinSupport; }

void MotionSupport::add_edges(double agreement) {
  const double before = edge_agreement_.value_or(agreement);
  edge_agreement_ = before + (agreement - before) / static_cast<double>(kScans);
}

MotionState MotionSupport::state() const {
  if (!needs_edges()) return MotionState::good;
  if (mean(support_) < kLeastSupport) return MotionState::lost;
  if (edge_agreement_ >= kMinEdgeAgreement && mean(weight_) >= kMinWeightWithEdges) return MotionState::good;
  return added_ < kYoungScans ? MotionState::degenerate : MotionState::lost;
}

}  // namespace mapless
