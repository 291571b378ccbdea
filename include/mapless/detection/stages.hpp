#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace mapless::inline v1 {

/// Whether a point may be dynamic at all. Published method: its distance from the reference scan. Voting:
/// dynamic if any scan is evidence for it, matched if scans only observed a surface there.
enum class CandidateVerdict : std::uint8_t { not_compared, matched, dynamic };

/// The place of a point among the rays of another scan (paper step 3). For voting, of the sum of the votes:
/// inside above 0, border below, unobserved at 0.
enum class FreespaceVerdict : std::uint8_t {
  not_evaluated,
  inside,     ///< the ray passes beyond the point's plane: it is where space was free
  border,     ///< the ray ends on the point's plane
  outside,    ///< the ray ends in front of the point: it was occluded
  unobserved  ///< no ray passes near, or the nearest has no usable return
};

/// The box filter of the published method, or the seeds of voting (votes of a point and its neighbours).
enum class FilterVerdict : std::uint8_t { not_evaluated, kept, removed };

/// Clustering and region growth.
enum class GrowthVerdict : std::uint8_t {
  not_reached,
  seed,
  grown,
  too_small,    ///< its cluster has too few seeds
  static_track  ///< its track is classified as static (method "voting")
};

/// The verdict of every stage on one point.
struct StageTrace {
  CandidateVerdict candidate = CandidateVerdict::not_compared;  ///< paper step 2
  FreespaceVerdict past = FreespaceVerdict::not_evaluated;      ///< step 3, backward: earlier scans
  FreespaceVerdict future =
      FreespaceVerdict::not_evaluated;  ///< step 3, forward: a later scan; voting: all scans
  FilterVerdict filtered = FilterVerdict::not_evaluated;  ///< step 4
  GrowthVerdict growth = GrowthVerdict::not_reached;      ///< step 5

  bool operator==(const StageTrace&) const = default;
};

/// The stages of the pipeline in order, see StageTrace.
enum class Stage : std::uint8_t { candidate, past, future, filtered, growth };
inline constexpr int kStageCount = 5;
inline constexpr std::array<std::string_view, kStageCount> kStageNames = {
    "candidates", "past freespace", "future freespace", "filter", "region growth"};

/// Whether the point is dynamic after `stage`.
[[nodiscard]] constexpr bool dynamic_after(const StageTrace& t, Stage stage) {
  switch (stage) {
    case Stage::candidate:
      return t.candidate == CandidateVerdict::dynamic;
    case Stage::past:
      return t.past == FreespaceVerdict::inside;
    case Stage::future:  // where it was evaluated it replaces the verdict of the past scans
      return t.future == FreespaceVerdict::inside ||
             (t.future == FreespaceVerdict::not_evaluated && t.past == FreespaceVerdict::inside);
    case Stage::filtered:
      return t.filtered == FilterVerdict::kept;
    case Stage::growth:
      return t.growth == GrowthVerdict::seed || t.growth == GrowthVerdict::grown;
  }
  return false;
}

}  // namespace mapless
