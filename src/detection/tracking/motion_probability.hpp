#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "detection/evidence/point_evidence.hpp"
#include "detection/tracking/motion_classifier.hpp"

namespace mapless::inline v1 {

/// What tracking has decided about the proposed object of a point.
enum class ObjectMotion : std::uint8_t {
  none,         ///< the point belongs to no proposed object
  slow,         ///< static: slower than min_speed_mps
  unconfirmed,  ///< static for want of evidence or of a displacement
  moving
};
inline constexpr int kObjectMotions = 4;

/// What the probability of a point depends on. Everything else an object has (age, significance of the
/// velocity, number of points) changes it by less once its evidence is known.
struct MotionCues {
  ObjectMotion state = ObjectMotion::none;
  int votes = 0;        ///< PointEvidence::total
  double evidence = 0;  ///< TrackMotion::evidence of its object; 0: no object
};

/// `motion`: of the point's object after this scan; null: no object.
[[nodiscard]] MotionCues motion_cues(const PointEvidence& votes, const TrackMotion* motion);

/// 1, votes against and votes for the point (limited to [-8, 0] and [0, 16]), and the binary logarithm of
/// evidence / 100 (limited to [-2, 5]; 0 without an object).
[[nodiscard]] Eigen::Vector4d probability_terms(const MotionCues& cues);

/// The probability that a point moves: the logistic function of a weighted sum of its terms. The four weights
/// of each ObjectMotion are a logistic regression over simulated scenes, made by
/// benchmarks/fit_probability.cpp. docs/probability.md says how well it holds elsewhere.
[[nodiscard]] double motion_probability(const MotionCues& cues);

/// The probability of every point. `object`: number of its proposed object, 0: none. `motions`: by number
/// - 1.
[[nodiscard]] std::vector<float> motion_probabilities(const std::vector<PointEvidence>& votes,
                                                      const std::vector<std::uint16_t>& object,
                                                      const std::vector<TrackMotion>& motions);

}  // namespace mapless
