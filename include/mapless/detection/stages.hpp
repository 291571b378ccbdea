#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include <mapless/detection/parameters.hpp>
#include <mapless/geometry/freespace_verdict.hpp>

namespace mapless::inline v1 {

/// Whether a point may be dynamic at all. Published method: its distance from the reference scan. Voting:
/// dynamic if any scan is evidence for it, matched if scans only observed a surface there.
enum class CandidateVerdict : std::uint8_t { not_compared, matched, dynamic };

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

/// The verdict of every stage on one point. Method "voting" fills `past` and `future` with the sign of a sum
/// of votes: inside above 0, border below, unobserved at 0.
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
using StageNames = std::array<std::string_view, kStageCount>;
inline constexpr StageNames kVotingStageNames = {"candidates", "past evidence", "past and future",
                                                 "neighbour support", "region growth"};
inline constexpr StageNames kPublishedStageNames = {"pointcloud comparison", "freespace backward",
                                                    "freespace forward", "box filter", "region growth"};
/// What each stage is called in tables.
[[nodiscard]] constexpr const StageNames& stage_names(DetectionMethod method) {
  return method == DetectionMethod::voting ? kVotingStageNames : kPublishedStageNames;
}

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
