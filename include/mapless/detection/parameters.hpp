#pragma once

#include <array>
#include <span>
#include <string_view>
#include <tuple>

#include <mapless/core/parameters.hpp>
#include <mapless/geometry/normals.hpp>

namespace mapless::inline v1 {

/// Step 2, pointcloud comparison.
struct ComparisonParameters {
  double error_threshold_m = 0.2;
  double max_range_without_normal_m = 25;

  static constexpr auto declarations() {
    using P = ComparisonParameters;
    return std::tuple{
        declare(&P::error_threshold_m, "error_threshold_m", "m", 0.001, 10.0,
                "a point farther than this from the reference scan (point-to-plane, else point-to-point) is "
                "dynamic",
                "paper step 2"),
        declare(&P::max_range_without_normal_m, "max_range_without_normal_m", "m", 0.0, 1000.0,
                "a point beyond this range that has no normal is static: on far ground point-to-point proves "
                "nothing",
                "method.md 2"),
    };
  }
};

/// Step 3, freespace check (paper Eq. 1 and 2).
struct FreespaceParameters {
  double backward_threshold_m = 0.2;
  double forward_threshold_m = 0.1;
  bool require_near_ray = true;
  double max_ray_distance_m = 0.05;
  double max_ray_distance_spacings = 1.0;
  int border_window_rows = 3;
  int border_window_columns = 5;
  double border_radius_per_m = 0.006;
  bool no_return_is_free = true;

  static constexpr auto declarations() {
    using P = FreespaceParameters;
    return std::tuple{
        declare(&P::backward_threshold_m, "backward_threshold_m", "m", 0.001, 10.0,
                "a ray of the reference scan that ends this near the plane of the point is on its border",
                "paper step 3"),
        declare(&P::forward_threshold_m, "forward_threshold_m", "m", 0.001, 10.0,
                "the same for a ray of the later scan", "paper step 3; method.md 2"),
        declare(&P::require_near_ray, "require_near_ray",
                "answer unobserved, hence static, where no ray passes near the point", "method.md 2"),
        declare(&P::max_ray_distance_m, "max_ray_distance_m", "m", 0.0, 10.0,
                "a ray is near within max_ray_distance_m + max_ray_distance_spacings x laser spacing x range",
                "method.md 2"),
        declare(&P::max_ray_distance_spacings, "max_ray_distance_spacings", "laser spacings", 0.0, 100.0,
                "see max_ray_distance_m", "method.md 2"),
        declare_odd(
            &P::border_window_rows, "border_window_rows", "lasers", 1, 15,
            "height of the window of rays around the nearest one of which any can make a point border; "
            "1: none but the nearest",
            "method.md 2"),
        declare_odd(&P::border_window_columns, "border_window_columns", "columns", 1, 31,
                    "width of that window", "method.md 2"),
        declare(&P::border_radius_per_m, "border_radius_per_m", "m/m", 0.0, 1.0,
                "a ray of the window makes a point border if it ends within the threshold + "
                "border_radius_per_m x "
                "range of it",
                "method.md 2"),
        declare(&P::no_return_is_free, "no_return_is_free",
                "a ray recorded as 'nothing within range' proves free space up to the maximum range; "
                "recordings that "
                "cannot tell it from a faulty return are not affected",
                "paper V; method.md 2"),
    };
  }
};

/// Step 4, box filter.
struct BoxFilterParameters {
  ImageAlignment image = ImageAlignment::aligned;
  int score_threshold = 10;

  static constexpr auto declarations() {
    using P = BoxFilterParameters;
    return std::tuple{
        declare(&P::image, "image",
                "rows of the scan image as recorded, or shifted by each laser's azimuth offset so that "
                "neighbours in "
                "the image are neighbours in space",
                "method.md 2"),
        declare(&P::score_threshold, "score_threshold", "pixels", 0, 12,
                "a 3 x 4 window that matches the pattern in more pixels than this holds outliers; 12 "
                "switches the "
                "filter off",
                "paper step 4"),
    };
  }
};

/// Step 5, region growth.
struct RegionGrowthParameters {
  double link_m = 0.12;
  double link_per_m = 0.015;
  int min_cluster_points = 10;
  double max_growth_m = 2.0;
  double concave_tolerance_deg = 5.0;

  static constexpr auto declarations() {
    using P = RegionGrowthParameters;
    return std::tuple{
        declare(&P::link_m, "link_m", "m", 0.001, 10.0,
                "two points are linked within link_m + link_per_m x range (of the nearer)",
                "paper step 5; method.md 2"),
        declare(&P::link_per_m, "link_per_m", "m/m", 0.0, 1.0, "see link_m", "method.md 2"),
        declare(&P::min_cluster_points, "min_cluster_points", "points", 1, 10000,
                "a cluster of fewer dynamic points is static and does not grow", "method.md 2"),
        declare(&P::max_growth_m, "max_growth_m", "m", 0.0, 1000.0,
                "growth stops this far from the nearest dynamic point of a cluster", "method.md 2"),
        declare(&P::concave_tolerance_deg, "concave_tolerance_deg", "deg", 0.0, 45.0,
                "parallel or convex: neither point rises more than distance x sin(concave_tolerance_deg) "
                "above the "
                "other's plane",
                "paper step 5"),
    };
  }
};

/// How the detector decides: freespace voting over many scans, or the five steps as published.
enum class DetectionMethod { voting, published };
inline constexpr std::array<std::string_view, 2> kDetectionMethodNames = {"voting", "published"};
constexpr std::span<const std::string_view> choice_names(DetectionMethod) { return kDetectionMethodNames; }

/// Method "voting": every point is put to several earlier scans and a later one.
struct VotingParameters {
  int references = 12;
  int first_gap = 1;
  int start_scans = 5;
  double tolerance_m = 0.08;
  double tolerance_spacings = 0.4;
  double max_ray_distance_m = 0.1;
  double max_ray_distance_spacings = 0.5;
  int window_columns = 5;
  double link_m = 0.12;
  double link_per_m = 0.015;
  double link_spacings = 1.5;
  double max_occluder_distance_m = 2.0;
  int seed_score = 32;
  int min_seeds = 2;
  bool grow = true;
  double min_advance_m = 0.03;
  double min_speed_mps = 0.2;
  int min_evidence = 100;

  static constexpr auto declarations() {
    using P = VotingParameters;
    return std::tuple{
        declare(&P::references, "references", "scans", 1, 14,
                "how many earlier scans are asked: 1, 2, 3, 4, 6, 8, 12, ... times first_gap back",
                "paper step 2, 3"),
        declare(&P::first_gap, "first_gap", "scans", 1, 10, "how far back the first of them lies",
                "paper step 2"),
        declare(&P::start_scans, "start_scans", "scans", 1, 100,
                "the first labels wait for so many scans, all put to one another", "docs/method.md"),
        declare(&P::tolerance_m, "tolerance_m", "m", 0.001, 10.0,
                "a ray ends on the surface of a point within tolerance_m (at least four standard deviations "
                "of the scan's noise) + tolerance_spacings x laser spacing x range",
                "paper step 3"),
        declare(&P::tolerance_spacings, "tolerance_spacings", "laser spacings", 0.0, 100.0,
                "see tolerance_m: a slanting surface is nearer on one laser than on the next",
                "docs/method.md"),
        declare(&P::max_ray_distance_m, "max_ray_distance_m", "m", 0.0, 10.0,
                "the nearest ray speaks for a point within max_ray_distance_m + max_ray_distance_spacings x "
                "laser spacing x range",
                "method.md 2"),
        declare(&P::max_ray_distance_spacings, "max_ray_distance_spacings", "laser spacings", 0.0, 100.0,
                "see max_ray_distance_m", "method.md 2"),
        declare_odd(&P::window_columns, "window_columns", "columns", 1, 31,
                    "how many firings of the lasers above and below a point are looked at", "method.md 2"),
        declare(&P::max_occluder_distance_m, "max_occluder_distance_m", "m", 0.0, 100.0,
                "an occluder within this distance of the point that has since left its place is taken to be "
                "part of the same object",
                "docs/method.md"),
        declare(&P::link_m, "link_m", "m", 0.001, 10.0,
                "neighbours in the scan image belong together within link_m + range x (the larger of "
                "link_per_m and link_spacings x laser spacing)",
                "paper step 5; method.md 2"),
        declare(&P::link_per_m, "link_per_m", "m/m", 0.0, 1.0, "see link_m", "method.md 2"),
        declare(&P::link_spacings, "link_spacings", "laser spacings", 0.0, 100.0, "see link_m",
                "method.md 2"),
        declare(&P::seed_score, "seed_score", "votes", 0, 1000,
                "votes of a point and its neighbours, summed, that make it a seed: border effects have few",
                "paper step 4"),
        declare(&P::min_seeds, "min_seeds", "points", 1, 10000,
                "a cluster of fewer seeds is static and does not grow", "method.md 2"),
        declare(&P::grow, "grow",
                "seeds grow over linked points whose votes are above 0, or that some scan saw through unless "
                "most saw a surface there, and fill holes",
                "paper step 5"),
        declare(&P::min_advance_m, "min_advance_m", "m", 0.0, 10.0,
                "the share of an object's points seen through a moment ago, times its size, is about how far "
                "it went: with less it does not begin to move",
                "docs/method.md"),
        declare(&P::min_speed_mps, "min_speed_mps", "m/s", 0.0, 100.0,
                "an object that is followed and slower than this stands", "docs/method.md"),
        declare(&P::min_evidence, "min_evidence", "votes", 0, 100000,
                "an object begins to move with so many votes of its points (half where a surface was seen; "
                "of one row no more) and of its earlier scans (half for each back); solid bodies with a "
                "quarter, what flickers or has a velocity known badly with more",
                "docs/method.md"),
    };
  }
};

/// Everything the detector can be told.
struct DetectorParameters {
  DetectionMethod method = DetectionMethod::voting;
  int forward_gap = 1;
  VotingParameters voting;
  int scan_gap = 8;
  NormalParameters normals;
  ComparisonParameters comparison;
  FreespaceParameters freespace;
  BoxFilterParameters box_filter;
  RegionGrowthParameters region_growth;

  static constexpr auto declarations() {
    using P = DetectorParameters;
    return std::tuple{
        declare(&P::method, "method",
                "voting: every point is put to several earlier scans and a later one; published: the five "
                "steps of the paper, which alone use scan_gap, normals, comparison, freespace, box_filter "
                "and region_growth",
                "paper; docs/method.md"),
        declare(&P::scan_gap, "scan_gap", "scans", 1, 100,
                "the reference scan is this many scans before the query scan; at the start of a recording "
                "the first scan, or "
                "the later scan if that is farther off",
                "paper step 2"),
        declare(&P::forward_gap, "forward_gap", "scans", 0, 100,
                "the forward freespace check uses the scan this many after the query scan, which is also the "
                "latency; "
                "0: causal, no forward check",
                "paper step 3"),
        group(&P::voting, "voting"),
        group(&P::normals, "normals"),
        group(&P::comparison, "comparison"),
        group(&P::freespace, "freespace"),
        group(&P::box_filter, "box_filter"),
        group(&P::region_growth, "region_growth"),
    };
  }
};

/// "default", or "paper": the method as published, with the readings of method.md section 2 where it is
/// silent and none of the improvements. Throws ParameterError for any other name.
[[nodiscard]] DetectorParameters detector_profile(std::string_view name);

}  // namespace mapless
