#pragma once

#include <array>
#include <span>
#include <string_view>
#include <tuple>

#include <mapless/core/parameters.hpp>
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {

/// Step 2, pointcloud comparison.
struct ComparisonParameters {
  double error_threshold_m = 0.2;
  double max_range_without_normal_m = 25;

  static constexpr auto declarations() {
    using P = ComparisonParameters;
    return std::tuple{
        declare(&P::error_threshold_m, "error_threshold_m", "m", 0.001, 10.0,
                "a point is a candidate for dynamic if it is farther than this from the reference scan "
                "(point-to-plane, or point-to-point without a normal)",
                "paper step 2"),
        declare(&P::max_range_without_normal_m, "max_range_without_normal_m", "m", 0.0, 1000.0,
                "a point without a normal beyond this range is static: on far ground its point-to-point "
                "distance is the spacing of the rings",
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
                "a ray of the reference scan that ends within this distance of the plane of the point makes "
                "the point border",
                "paper step 3"),
        declare(&P::forward_threshold_m, "forward_threshold_m", "m", 0.001, 10.0,
                "the same as backward_threshold_m, for a ray of the later scan", "paper step 3; method.md 2"),
        declare(&P::require_near_ray, "require_near_ray",
                "a point is unobserved, hence static, if no ray passes near it", "method.md 2"),
        declare(&P::max_ray_distance_m, "max_ray_distance_m", "m", 0.0, 10.0,
                "a ray is near within max_ray_distance_m + max_ray_distance_spacings x laser spacing x range",
                "method.md 2"),
        declare(&P::max_ray_distance_spacings, "max_ray_distance_spacings", "laser spacings", 0.0, 100.0,
                "see max_ray_distance_m", "method.md 2"),
        declare_odd(
            &P::border_window_rows, "border_window_rows", "lasers", 1, 15,
            "height of the window of rays around the nearest one in which each ray can make a point border; "
            "1: the nearest alone",
            "method.md 2"),
        declare_odd(&P::border_window_columns, "border_window_columns", "columns", 1, 31,
                    "width of the window of border_window_rows", "method.md 2"),
        declare(&P::border_radius_per_m, "border_radius_per_m", "m/m", 0.0, 1.0,
                "a ray of the window makes a point border if it ends within the threshold + "
                "border_radius_per_m x range of it",
                "method.md 2"),
        declare(&P::no_return_is_free, "no_return_is_free",
                "a ray recorded as 'nothing within range' observes free space up to the maximum range; no "
                "effect on recordings that do not distinguish it from a faulty return",
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
        declare(
            &P::image, "image",
            "rows of the scan image as recorded (raw), or shifted by each laser's azimuth offset, so that "
            "neighbours in the image are neighbours in space (aligned)",
            "method.md 2"),
        declare(&P::score_threshold, "score_threshold", "pixels", 0, 12,
                "points of a 3 x 4 window that matches the outlier pattern in more pixels than this are "
                "removed; 12 switches the filter off",
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
  double parallel_tolerance_deg = 10.0;

  static constexpr auto declarations() {
    using P = RegionGrowthParameters;
    return std::tuple{
        declare(
            &P::link_m, "link_m", "m", 0.001, 10.0,
            "two points are linked if their distance is at most link_m + link_per_m x range of the nearer",
            "paper step 5; method.md 2"),
        declare(&P::link_per_m, "link_per_m", "m/m", 0.0, 1.0, "see link_m", "method.md 2"),
        declare(&P::min_cluster_points, "min_cluster_points", "points", 1, 10000,
                "a cluster of fewer dynamic points becomes static and does not grow", "method.md 2"),
        declare(&P::max_growth_m, "max_growth_m", "m", 0.0, 1000.0,
                "a cluster grows at most this far from its nearest dynamic point", "method.md 2"),
        declare(&P::concave_tolerance_deg, "concave_tolerance_deg", "deg", 0.0, 45.0,
                "convex: a cluster grows between two points of which neither lies "
                "more than distance x sin(concave_tolerance_deg) above the plane of the other",
                "paper step 5"),
        declare(
            &P::parallel_tolerance_deg, "parallel_tolerance_deg", "deg", 0.0, 90.0,
            "parallel: a cluster also grows between two points whose normals differ by at most this angle",
            "paper step 5"),
    };
  }
};

/// voting: several scans vote on each point; published: the five steps of the paper.
enum class DetectionMethod { voting, published };
inline constexpr std::array<std::string_view, 2> kDetectionMethodNames = {"voting", "published"};
constexpr std::span<const std::string_view> choice_names(DetectionMethod) { return kDetectionMethodNames; }

/// Method "voting" (default): several earlier scans and a later one vote on every point (docs/method.md 7).
struct VotingParameters {
  int references = 12;
  int first_gap = 1;
  int start_scans = 5;
  double tolerance_m = 0.08;
  double tolerance_spacings = 0.4;
  double max_ray_distance_m = 0.1;
  double max_ray_distance_spacings = 0.5;
  int window_columns = 5;
  double window_deg = 1.0;
  double beside_window_deg = 2.0;
  double link_m = 0.12;
  double link_per_m = 0.015;
  double link_spacings = 1.5;
  double max_occluder_distance_m = 2.0;
  int seed_score = 32;
  int min_seeds = 2;
  bool grow = true;
  double min_displacement_m = 0.03;
  double min_speed_mps = 0.2;
  int min_evidence = 75;

  /// Those of the evidence of points, then those of objects.
  static constexpr auto evidence_declarations() {
    using P = VotingParameters;
    return std::tuple{
        declare(
            &P::references, "references", "scans", 1, 14,
            "number of earlier reference scans: 1, 2, 3, 4, 6, 8, 12, ... times first_gap before the scan",
            "paper step 2, 3"),
        declare(&P::first_gap, "first_gap", "scans", 1, 10,
                "gap between a scan and its nearest reference scan", "paper step 2"),
        declare(&P::start_scans, "start_scans", "scans", 1, 100,
                "the first labels are returned after this many scans, each compared with all the others; 1: "
                "no wait",
                "method.md 7"),
        declare(&P::tolerance_m, "tolerance_m", "m", 0.001, 10.0,
                "a ray that ends within tolerance_m + tolerance_spacings x laser spacing x range of a point "
                "observed its surface; raised to four standard deviations of the scan's range noise",
                "paper step 3"),
        declare(&P::tolerance_spacings, "tolerance_spacings", "laser spacings", 0.0, 100.0,
                "see tolerance_m: a slanted surface is nearer on one laser than on the next", "method.md 7"),
        declare(&P::max_ray_distance_m, "max_ray_distance_m", "m", 0.0, 10.0,
                "a point is unobserved by a scan unless a ray passes within max_ray_distance_m + "
                "max_ray_distance_spacings x laser spacing x range of it",
                "method.md 7"),
        declare(&P::max_ray_distance_spacings, "max_ray_distance_spacings", "laser spacings", 0.0, 100.0,
                "see max_ray_distance_m", "method.md 7"),
        declare_odd(
            &P::window_columns, "window_columns", "columns", 1, 31,
            "minimum width of the window of rays about a point, as an angle, in columns of a horizontal "
            "beam; the window is on the two lasers above and below the point; if one of its rays ends "
            "at the range of the point, the scan observed a surface there",
            "method.md 7"),
        declare(&P::window_deg, "window_deg", "deg", 0.0, 10.0,
                "the window has at least as many columns as lie within this angle, up to 31", "method.md 7"),
        declare(
            &P::beside_window_deg, "beside_window_deg", "deg", 0.0, 10.0,
            "where a ray beside the window, within this angle, ended at a point's range, rays through the "
            "point count half, as those farther aside do: so leaves and railings look",
            "method.md 7"),
        declare(&P::max_occluder_distance_m, "max_occluder_distance_m", "m", 0.0, 100.0,
                "an occluder within this distance of the point that has since left its place is taken to be "
                "part of the same object",
                "method.md 7"),
    };
  }
  static constexpr auto object_declarations() {
    using P = VotingParameters;
    return std::tuple{
        declare(&P::link_m, "link_m", "m", 0.001, 10.0,
                "neighbours in the scan image are linked if their distance is at most link_m + range x the "
                "larger of link_per_m and link_spacings x laser spacing",
                "paper step 5; method.md 7"),
        declare(&P::link_per_m, "link_per_m", "m/m", 0.0, 1.0, "see link_m", "method.md 7"),
        declare(&P::link_spacings, "link_spacings", "laser spacings", 0.0, 100.0, "see link_m",
                "method.md 7"),
        declare(
            &P::seed_score, "seed_score", "votes", 0, 1000,
            "a point is a seed if its votes and those of its linked neighbours in the 3 x 5 window sum to at "
            "least this; border effects are too small",
            "paper step 4"),
        declare(&P::min_seeds, "min_seeds", "points", 1, 10000,
                "a cluster of fewer linked seeds becomes static and does not grow", "method.md 7"),
        declare(&P::grow, "grow",
                "seeds grow over linked points with votes above 0, or with votes of at least -12 that some "
                "scan saw through, and holes are filled",
                "paper step 5"),
        declare(
            &P::min_displacement_m, "min_displacement_m", "m", 0.0, 10.0,
            "a track begins to move only if rays show at least this displacement over the last scans: the "
            "share of the object's points seen through recently, times its size",
            "method.md 7"),
        declare(&P::min_speed_mps, "min_speed_mps", "m/s", 0.0, 100.0,
                "a track is static below this speed; where its velocity is not known, without an observed "
                "displacement",
                "method.md 7"),
        declare(&P::min_evidence, "min_evidence", "votes", 0, 100000,
                "evidence a track needs before it is labelled dynamic: the sum of its points' votes (x the "
                "cosine of the beam's elevation; x 0.5 where a scan observed a surface; capped at this value "
                "per laser row), plus past evidence "
                "halved per scan; half for rigid bodies and for velocities that the rays confirm; more for "
                "objects on "
                "surfaces observed seconds ago, for uncertain velocities, and within 3 m of many clusters "
                "too faint for objects, as in foliage",
                "method.md 7"),
    };
  }
  static constexpr auto declarations() {
    return std::tuple_cat(evidence_declarations(), object_declarations());
  }
};

/// All parameters of Detector.
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
        declare(
            &P::method, "method",
            "voting: several earlier scans and a later one vote on every point; published: the five steps "
            "of the paper; scan_gap, normals, comparison, freespace, box_filter and region_growth apply "
            "to published alone",
            "paper; method.md 7"),
        declare(&P::scan_gap, "scan_gap", "scans", 1, 100,
                "the reference scan is this many scans before the query scan; at the start of a recording "
                "it is the first scan, or the later scan if that is farther away",
                "paper step 2"),
        declare(&P::forward_gap, "forward_gap", "scans", 0, 100,
                "the later scan is this many scans after the query scan, which is the latency; 0: causal, "
                "without a later scan",
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

/// The parameters of a named profile: "default" (method voting); "paper" (the method as published, with the
/// sensible readings of docs/paper_map.md where the paper is silent, and without improvements);
/// "paper-literal" (the plainest readings instead). Throws ParameterError for any other name.
[[nodiscard]] DetectorParameters detector_profile(std::string_view name);

}  // namespace mapless
