#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include <mapless/detection/parameters.hpp>
#include <mapless/geometry/freespace_verdict.hpp>

namespace mapless::inline v1 {

/// Whether a point differs from the reference scans at all. Method "published": answer of the pointcloud
/// comparison. Method "voting": `dynamic` where some reference scan saw through the point or its occluder
/// left, `matched` where otherwise some saw a surface.
enum class ComparisonVerdict : std::uint8_t { not_compared, matched, dynamic };

/// Answer of the filter of border effects: the box filter of the paper, or the support of the linked
/// neighbours.
enum class BoxVerdict : std::uint8_t { not_asked, kept, removed };

/// Answer of clustering and region growth.
enum class GrowthVerdict : std::uint8_t {
  not_reached,
  seed,
  grown,
  too_small,    ///< too few seeds
  static_track  ///< its track is classified as static (method "voting")
};

/// Every stage's verdict on one point. Method "voting" fills `past` with the sign of the votes of the earlier
/// scans and `future` with that of all scans: `inside` for positive sums, `border` for negative ones.
struct StageTrace {
  ComparisonVerdict candidate = ComparisonVerdict::not_compared;
  FreespaceVerdict past = FreespaceVerdict::not_asked;
  FreespaceVerdict future = FreespaceVerdict::not_asked;
  BoxVerdict filtered = BoxVerdict::not_asked;
  GrowthVerdict growth = GrowthVerdict::not_reached;

  bool operator==(const StageTrace&) const = default;
};

/// Stages in the order of the pipeline; the bits of a .stages file.
enum class Stage : std::uint8_t { candidate, past, future, filtered, growth };
inline constexpr int kStageCount = 5;
using StageNames = std::array<std::string_view, kStageCount>;
inline constexpr StageNames kVotingStageNames = {"candidates", "past evidence", "past and future",
                                                 "neighbour support", "region growth"};
inline constexpr StageNames kPublishedStageNames = {"pointcloud comparison", "freespace backward",
                                                    "freespace forward", "box filter", "region growth"};
/// What each stage is called in tables.
[[nodiscard]] constexpr const StageNames& stage_names(DetectionMethod method) {
  return method == DetectionMethod::voting ? kVotingStageNames : kPublishedStageNames;
}

/// Whether the point counts as dynamic once `stage` is done.
[[nodiscard]] constexpr bool dynamic_after(const StageTrace& t, Stage stage) {
  switch (stage) {
    case Stage::candidate:
      return t.candidate == ComparisonVerdict::dynamic;
    case Stage::past:
      return t.past == FreespaceVerdict::inside;
    case Stage::future:  // replaces the answer of `past` for the points it was queried about
      return t.future == FreespaceVerdict::inside ||
             (t.future == FreespaceVerdict::not_asked && t.past == FreespaceVerdict::inside);
    case Stage::filtered:
      return t.filtered == BoxVerdict::kept;
    case Stage::growth:
      return t.growth == GrowthVerdict::seed || t.growth == GrowthVerdict::grown;
  }
  return false;
}

}  // namespace mapless
