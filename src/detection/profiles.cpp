#include <limits>

#include <mapless/core/errors.hpp>
#include <mapless/detection/parameters.hpp>

namespace mapless::inline v1 {
namespace {

// The method as published; where it is silent, the plainest reading.
DetectorParameters paper_profile() {
  DetectorParameters p;
  p.method = DetectionMethod::published;
  p.scan_gap = 4;
  p.forward_gap = 1;
  p.comparison.error_threshold_m = 0.5;
  p.comparison.max_range_without_normal_m = 1000;
  p.freespace.backward_threshold_m = 0.5;
  p.freespace.forward_threshold_m = 0.5;
  p.freespace.require_near_ray = false;
  p.freespace.border_window_rows = 1;
  p.freespace.border_window_columns = 1;
  p.freespace.no_return_is_free = false;
  p.box_filter.image = ImageAlignment::raw;
  p.region_growth.link_m = 0.5;
  p.region_growth.link_per_m = 0;
  p.region_growth.min_cluster_points = 1;
  p.region_growth.max_growth_m = 1000;
  return p;
}

}  // namespace

DetectorParameters detector_profile(std::string_view name) {
  if (name == "default") return {};
  if (name == "paper") return paper_profile();
  throw ParameterError({"--profile", "", std::string(name), "no such profile", "use default or paper"});
}

}  // namespace mapless
