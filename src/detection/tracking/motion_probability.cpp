#include "detection/tracking/motion_probability.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace mapless::inline v1 {
namespace {

// Votes beyond these limits, and evidence beyond these doublings of kUsualEvidence, change the share of
// moving points no more: the limits are where the counted shares level off.
constexpr int kMostAgainst = -8, kMostFor = 16;
constexpr double kUsualEvidence = 100, kFewestDoublings = -2, kMostDoublings = 5;

// By ObjectMotion: constant, per vote against (a negative number), per vote for, per doubling of the
// evidence. Printed by benchmarks/fit_probability.cpp; docs/probability.md has the command. Slow objects have
// few votes against them: the weight found, -0.13, is set to 0.
const std::array<Eigen::Vector4d, kObjectMotions> kWeights = {{
    {-5.09, 0.44, 0.25, 0.00},
    {-5.16, 0.00, 0.06, 0.34},
    {-2.23, 0.26, 0.10, 0.08},
    {0.51, 0.45, 0.20, 0.57},
}};

}  // namespace

MotionCues motion_cues(const PointEvidence& votes, const TrackMotion* motion) {
  if (motion == nullptr) return {ObjectMotion::none, votes.total(), 0};
  const ObjectMotion stationary = motion->slow ? ObjectMotion::slow : ObjectMotion::unconfirmed;
  return {motion->moves ? ObjectMotion::moving : stationary, votes.total(), motion->evidence};
}

Eigen::Vector4d probability_terms(const MotionCues& cues) {
  const double doublings = cues.state == ObjectMotion::none
                               ? 0
                               : std::clamp(std::log2(std::max(cues.evidence, 1.0) / kUsualEvidence),
                                            kFewestDoublings, kMostDoublings);
  return {1, static_cast<double>(std::clamp(cues.votes, kMostAgainst, 0)),
          static_cast<double>(std::clamp(cues.votes, 0, kMostFor)), doublings};
}

double motion_probability(const MotionCues& cues) {
  return 1 / (1 + std::exp(-kWeights[static_cast<std::size_t>(cues.state)].dot(probability_terms(cues))));
}

std::vector<float> motion_probabilities(const std::vector<PointEvidence>& votes,
                                        const std::vector<std::uint16_t>& object,
                                        const std::vector<TrackMotion>& motions) {
  // Hardly any point belongs to an object: the others differ by their votes alone.
  std::array<float, kMostFor - kMostAgainst + 1> of_no_object;
  for (int v = kMostAgainst; v <= kMostFor; ++v)
    of_no_object[static_cast<std::size_t>(v - kMostAgainst)] =
        static_cast<float>(motion_probability({ObjectMotion::none, v, 0}));
  std::vector<float> out(votes.size());
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (object[i] == 0) {
      const int limited = std::clamp(votes[i].total(), kMostAgainst, kMostFor);
      out[i] = of_no_object[static_cast<std::size_t>(limited - kMostAgainst)];
    } else {
      out[i] = static_cast<float>(motion_probability(motion_cues(votes[i], &motions[object[i] - 1U])));
    }
  }
  return out;
}

}  // namespace mapless
