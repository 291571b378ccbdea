#pragma once

#include <vector>

#include "odometry/solver/knot_perturbation.hpp"

namespace mapless::inline v1 {

/// Makes an iteration go faster that converges slowly along one direction: where a step has the direction of
/// the one before, the two tell how far away the place is at which steps vanish, and it goes there at once
/// (Anderson acceleration with a memory of one step: Walker and Ni, SIAM J. Numer. Anal. 49 (2011)).
class SecantSteps {
 public:
  /// The step of every knot to take in place of `step`, which the iteration itself would take.
  [[nodiscard]] std::vector<Vector12d> extrapolated(const std::vector<Vector12d>& step);
  /// Whether the newest step was lengthened.
  [[nodiscard]] bool has_extrapolated() const { return has_extrapolated_; }

 private:
  std::vector<Vector12d> last_, last_taken_;
  bool has_extrapolated_ = false;
};

}  // namespace mapless
