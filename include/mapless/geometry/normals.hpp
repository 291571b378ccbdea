#pragma once

#include <array>
#include <span>
#include <string_view>
#include <tuple>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/parameters.hpp>

namespace mapless::inline v1 {

struct CompensatedScan;
class NearestNeighbours;

enum class NormalMethod { image_window, nearest_neighbours };
inline constexpr std::array<std::string_view, 2> kNormalMethodNames = {"image_window", "nearest_neighbours"};
constexpr std::span<const std::string_view> choice_names(NormalMethod) { return kNormalMethodNames; }

enum class ImageAlignment { raw, aligned };
inline constexpr std::array<std::string_view, 2> kImageAlignmentNames = {"raw", "aligned"};
constexpr std::span<const std::string_view> choice_names(ImageAlignment) { return kImageAlignmentNames; }

struct NormalParameters {
  NormalMethod method = NormalMethod::image_window;
  int window_rows = 3;
  int window_columns = 7;
  double gate_m = 0.10;
  double min_incidence_deg = 5.0;
  int neighbours = 10;
  int min_points = 5;
  double max_thickness_ratio = 0.25;
  double min_width_ratio = 0.05;

  static constexpr auto declarations() {
    using P = NormalParameters;
    return std::tuple{
        declare(&P::method, "method",
                "where a point's neighbours come from: a window of the aligned scan image, or the k nearest "
                "in space",
                "paper step 2; method.md 2"),
        declare_odd(&P::window_rows, "window_rows", "lasers", 1, 15, "height of the image window",
                    "method.md 2"),
        declare_odd(&P::window_columns, "window_columns", "columns", 1, 31,
                    "least width of the image window; it is widened to be as wide as it is high where "
                    "lasers are sparse",
                    "method.md 2"),
        declare(&P::gate_m, "gate_m", "m", 0.0, 10.0,
                "window points farther from the point than gate_m + range x angle between the two beams / "
                "sin(min_incidence_deg) do not count",
                "method.md 2"),
        declare(&P::min_incidence_deg, "min_incidence_deg", "deg", 0.1, 90.0,
                "the flattest incidence at which neighbouring beams are taken to hit one surface; see gate_m",
                "method.md 2"),
        declare(&P::neighbours, "neighbours", "points", 3, 100, "k of method nearest_neighbours",
                "paper step 2"),
        declare(&P::min_points, "min_points", "points", 3, 100,
                "with fewer points, itself included, a point has no normal", "paper step 2"),
        declare(&P::max_thickness_ratio, "max_thickness_ratio", "", 0.0, 1.0,
                "planar: smallest over middle standard deviation of the neighbours at most this",
                "method.md 2"),
        declare(&P::min_width_ratio, "min_width_ratio", "", 0.0, 1.0,
                "not line-like: middle over largest standard deviation of the neighbours at least this",
                "method.md 2"),
    };
  }
};

/// One normal per return, in the world frame, unit length, oriented towards the origin of the return's own
/// ray; zero where the point has none.
[[nodiscard]] std::vector<Eigen::Vector3f> estimate_normals(const CompensatedScan& scan,
                                                            const NearestNeighbours& neighbours,
                                                            const NormalParameters& parameters);

}  // namespace mapless
