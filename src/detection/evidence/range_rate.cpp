#include "detection/evidence/range_rate.hpp"

#include <cmath>
#include <cstddef>
#include <cstdlib>

namespace mapless::inline v1 {
namespace {

// On a more inclined surface an offset shows where the ray passed, not motion. Measured on 24
// recordings of highways, flyers and others: with 2, the road near the sensor is found dynamic (highway IoU
// .974 to .960); with 1 it is not.
constexpr float kMaxSlope = 1;
// A line through zero has one degree of freedom: with fewer than four offsets, the mean square of what is
// left says little. They must also be half of all, since two surfaces would share the others.
constexpr std::size_t kMinAgreeing = 4;
constexpr std::size_t kOffsetsPerAgreeing = 2;
// The first estimate is of scans this near [scans]: in 0.2 s, 5 m/s^2 change the distance gone by 0.1 m.
constexpr int kNearGap = 2;
// Chosen: the first adds the farther scans, the second takes out those that only the first estimate took in.
constexpr int kRefinements = 2;
// An offset this many standard deviations off is of another surface: .3 % of a Gaussian is farther. The
// distance gone adds this share of itself, since no motion is quite uniform. Chosen: braking at 2 m/s^2 from
// 10 m/s changes it by a fifth in 2 s.
constexpr float kOutlierDeviations = 3, kUnevenShare = 0.2F;
// Of the residuals that agree, in squared standard deviations; 1 is expected. Chosen: twice that leaves room
// for the share above.
constexpr float kMaxMeanSquare = 2;
// Slopes and the grid of the rays feign up to this many metres a scan: 0.3 m/s at 10 Hz, above the 0.2 m/s
// from which an object counts as dynamic. Chosen.
constexpr float kMinStep_m = 0.03F;
constexpr float kSignificantDeviations = 6;  // chosen; 10 gives the same

float weight(const RangeOffset& offset, float range_std_m, float slope) {
  const float inclined_m = slope * offset.aside_m;
  return 1 / (range_std_m * range_std_m + inclined_m * inclined_m);
}

// A line through zero: short_by_m = step_m x gap.
struct Line {
  float moment = 0, information = 0;  // weighted sums of gap x short_by_m, and of gap^2 [1/m, 1/m^2]
  void add(const RangeOffset& offset, float weight) {
    const auto gap = static_cast<float>(offset.gap);
    moment += weight * gap * offset.short_by_m;
    information += weight * gap * gap;
  }
  [[nodiscard]] float step_m() const { return information > 0 ? moment / information : 0; }
};

}  // namespace

bool moves_along_rays(std::span<RangeOffset> offsets, float range_std_m, float slope) {
  if (offsets.size() < kMinAgreeing || slope > kMaxSlope) return false;
  Line line;
  for (const RangeOffset& offset : offsets) {
    if (std::abs(offset.gap) <= kNearGap) line.add(offset, weight(offset, range_std_m, slope));
  }
  for (int round = 0; round < kRefinements; ++round) {
    std::size_t agreeing = 0;
    Line refined;
    for (RangeOffset& offset : offsets) {
      const float w = weight(offset, range_std_m, slope);
      const float gone_m = line.step_m() * static_cast<float>(offset.gap);
      offset.agrees = std::abs(offset.short_by_m - gone_m) <=
                      kOutlierDeviations / std::sqrt(w) + kUnevenShare * std::abs(gone_m);
      if (!offset.agrees) continue;
      ++agreeing;
      refined.add(offset, w);
    }
    if (agreeing < kMinAgreeing || kOffsetsPerAgreeing * agreeing < offsets.size()) return false;
    line = refined;
  }
  float square_sum = 0, agreeing = 0;
  for (const RangeOffset& offset : offsets) {
    if (!offset.agrees) continue;
    const float off_m = offset.short_by_m - line.step_m() * static_cast<float>(offset.gap);
    square_sum += weight(offset, range_std_m, slope) * off_m * off_m;
    ++agreeing;
  }
  const float step_m = std::abs(line.step_m());
  return square_sum <= kMaxMeanSquare * agreeing && step_m >= kMinStep_m &&
         step_m * std::sqrt(line.information) >= kSignificantDeviations;
}

}  // namespace mapless
