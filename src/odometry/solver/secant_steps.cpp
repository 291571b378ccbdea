#include "odometry/solver/secant_steps.hpp"

#include <cmath>

namespace mapless::inline v1 {
namespace {

// Fewest cosine of the angle between two steps in the same direction. Measured (docs/notebook/odometry.md,
// "Steps along a valley"): with .8 and .9 starts err alike, with .7 one flight errs by .22 m.
constexpr double kSameDirection = 0.8;
// The place where steps vanish is taken to be at most this many steps away. Chosen: steps that shrink by an
// eighth each; beyond that their ratio says little. Measured: with 4 and 16, 207 starts err by a tenth more.
constexpr double kFarthestSteps = 8;
// Weight of a rotation beside a translation [m]: points at this distance move as much by either, as in
// has_converged().
constexpr double kArm_m = 10;

double inner_product(const std::vector<Vector12d>& a, const std::vector<Vector12d>& b) {
  double out = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    out += a[k].head<3>().dot(b[k].head<3>()) + kArm_m * kArm_m * a[k].segment<3>(3).dot(b[k].segment<3>(3));
  }
  return out;
}

double norm(const std::vector<Vector12d>& a) { return std::sqrt(inner_product(a, a)); }

}  // namespace

std::vector<Vector12d> SecantSteps::extrapolated(const std::vector<Vector12d>& step) {
  std::vector<Vector12d> out = step;
  has_extrapolated_ =
      last_.size() == step.size() && inner_product(step, last_) > kSameDirection * norm(step) * norm(last_);
  if (has_extrapolated_) {
    // Moving by last_taken_ has changed the step by `change`. Were the iteration linear, moving `times` as
    // far again would leave the least of it.
    std::vector<Vector12d> change = step;
    for (std::size_t k = 0; k < step.size(); ++k) change[k] -= last_[k];
    const double most = kFarthestSteps * norm(step) / norm(last_taken_);
    double times = -inner_product(change, step) / inner_product(change, change);
    if (!(times > 0 && times < most)) times = most;  // the steps do not shrink, or hardly
    for (std::size_t k = 0; k < step.size(); ++k) out[k] += times * (last_taken_[k] + change[k]);
  }
  last_ = step;
  last_taken_ = out;
  return out;
}

}  // namespace mapless
