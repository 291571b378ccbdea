#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace mapless::inline v1 {

/// What the pointcloud comparison said of a point.
enum class ComparisonVerdict : std::uint8_t { not_compared, matched, dynamic };

/// What a freespace check said of a point (paper step 3).
enum class FreespaceVerdict : std::uint8_t {
  not_asked,
  inside,     ///< the ray goes on beyond the point's plane: it stands where space was free
  border,     ///< the ray ends on the point's plane
  outside,    ///< the ray ends short of it: the point was hidden
  unobserved  ///< no ray passes near, or the nearest had no usable return
};

enum class BoxVerdict : std::uint8_t { not_asked, kept, removed };

/// What clustering and region growth said of a point.
enum class GrowthVerdict : std::uint8_t {
  not_reached,
  seed,
  grown,
  too_small,    ///< too few seeds
  static_track  ///< its track is classified as static (method "voting")
};

/// Every stage's verdict on one point.
struct StageTrace {
  ComparisonVerdict comparison = ComparisonVerdict::not_compared;
  FreespaceVerdict backward = FreespaceVerdict::not_asked;
  FreespaceVerdict forward = FreespaceVerdict::not_asked;
  BoxVerdict box = BoxVerdict::not_asked;
  GrowthVerdict growth = GrowthVerdict::not_reached;

  bool operator==(const StageTrace&) const = default;
};

/// The points after which `dynamic_after` can be asked, in pipeline order.
enum class Stage : std::uint8_t { comparison, backward, forward, box_filter, region_growth };
inline constexpr int kStageCount = 5;
inline constexpr std::array<std::string_view, kStageCount> kStageNames = {
    "pointcloud comparison", "freespace backward", "freespace forward", "box filter", "region growth"};

/// Whether the point counts as dynamic once `stage` is done.
[[nodiscard]] constexpr bool dynamic_after(const StageTrace& t, Stage stage) {
  switch (stage) {
    case Stage::comparison:
      return t.comparison == ComparisonVerdict::dynamic;
    case Stage::backward:
      return t.backward == FreespaceVerdict::inside;
    case Stage::forward:  // its verdict stands where it was asked
      return t.forward == FreespaceVerdict::inside ||
             (t.forward == FreespaceVerdict::not_asked && t.backward == FreespaceVerdict::inside);
    case Stage::box_filter:
      return t.box == BoxVerdict::kept;
    case Stage::region_growth:
      return t.growth == GrowthVerdict::seed || t.growth == GrowthVerdict::grown;
  }
  return false;
}

}  // namespace mapless
