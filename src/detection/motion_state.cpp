#include "detection/motion_state.hpp"

#include <Eigen/Cholesky>

#include "detection/longest_absence.hpp"

namespace mapless {
namespace {

// Of the new objects with fewer points every second one is a border effect, and gone in the next scan.
constexpr int kSurePoints = 15;

// A velocity tells more than the advance where its standard deviation is at most so large, or it is more
// than so many of them.
constexpr double kKnownStd_mps = 0.5;
constexpr double kSure = 2;

constexpr double kMostUnproven_m = 1;  // several times what the rays tell

// What slides along itself, or is far, has no velocity that could be told from 0.
bool velocity_is_known(const TrackedObject& object) {
  const double square = object.velocity_0.dot(object.velocity_covariance_0.ldlt().solve(object.velocity_0));
  return object.velocity_std_0().maxCoeff() <= kKnownStd_mps || square > kSure * kSure;
}

}  // namespace

MotionState next_state(const MotionState& last, const TrackedObject& object, float advance_m, Time now,
                       const VotingParameters& parameters) {
  MotionState next;
  next.seen = now;
  const bool advances = static_cast<double>(advance_m) >= parameters.min_advance_m;
  if (object.age == 1) {
    next.moves = advances && object.points >= kSurePoints;
    return next;
  }
  const double speed_mps = object.velocity_0.norm();
  next.slow = velocity_is_known(object) ? speed_mps < parameters.min_speed_mps : !advances;
  next.unproven_m = advances ? 0 : last.unproven_m + speed_mps * (now - last.seen).seconds();
  const bool stops = (last.slow && next.slow) || next.unproven_m >= kMostUnproven_m;
  next.moves = last.moves ? !stops : advances && !next.slow;
  return next;
}

void forget_absent(MotionStates& states, Time now) {
  std::erase_if(states,
                [now](const auto& entry) { return (now - entry.second.seen).seconds() > kLongestAbsence_s; });
}

}  // namespace mapless
