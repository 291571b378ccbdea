#include <mapless/core/errors.hpp>
#include <mapless/detection/parameters.hpp>

namespace mapless::inline v1 {
namespace {

constexpr double kUnlimited_m = 1000;  // far beyond the range of any sensor

// The method as published: its own numbers, no improvements, and where it is silent the sensible reading.
DetectorParameters paper_profile() {
  DetectorParameters p;
  p.method = DetectionMethod::published;
  p.scan_gap = 4;
  p.forward_gap = 1;
  p.comparison.error_threshold_m = 0.5;
  p.freespace.backward_threshold_m = 0.5;
  p.freespace.forward_threshold_m = 0.5;
  p.freespace.border_window_rows = 1;
  p.freespace.border_window_columns = 1;
  p.freespace.no_return_is_free = false;
  p.box_filter.score_threshold = 10;
  return p;
}

// The same with the plainest reading wherever the paper is silent; docs/paper_map.md has both side by side.
DetectorParameters paper_literal_profile() {
  DetectorParameters p = paper_profile();
  p.normals.method = NormalMethod::nearest_neighbours;
  p.comparison.max_range_without_normal_m = kUnlimited_m;
  p.freespace.require_near_ray = false;
  p.box_filter.image = ImageAlignment::raw;
  p.region_growth.link_m = 0.5;
  p.region_growth.link_per_m = 0;
  p.region_growth.min_cluster_points = 1;
  p.region_growth.max_growth_m = kUnlimited_m;
  p.region_growth.concave_tolerance_deg = 0;
  return p;
}

}  // namespace

DetectorParameters detector_profile(std::string_view name) {
  if (name == "default") return {};
  if (name == "paper") return paper_profile();
  if (name == "paper-literal") return paper_literal_profile();
  throw ParameterError(
      {"--profile", "", std::string(name), "no such profile", "use default, paper or paper-literal"});
}

}  // namespace mapless
