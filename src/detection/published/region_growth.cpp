#include "detection/published/region_growth.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "detection/object_number.hpp"
#include "detection/published/point_pool.hpp"

namespace mapless::inline v1 {
namespace {

using Indices = std::vector<std::int32_t>;

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

class RegionGrowth {
 public:
  RegionGrowth(const PreparedScan& scan, const RegionGrowthParameters& parameters)
      : scan_(scan),
        parameters_(parameters),
        concave_sine_(std::sin(radians(parameters.concave_tolerance_deg))),
        parallel_cosine_(std::cos(radians(parameters.parallel_tolerance_deg))) {
    result_.verdict.assign(scan.scan().returns.size(), GrowthVerdict::not_reached);
    result_.object.assign(scan.scan().returns.size(), 0);
  }

  RegionGrowthResult grow(const std::vector<char>& dynamic) {
    const Indices seeds = seeds_of_large_clusters(dynamic);
    const std::vector<Indices> regions = regions_of(seeds);
    number_objects(regions);
    return std::move(result_);
  }

 private:
  [[nodiscard]] double link_of(std::int32_t i) const {
    const double range = scan_.scan().returns[static_cast<std::size_t>(i)].range_m;
    return parameters_.link_m + parameters_.link_per_m * range;
  }
  [[nodiscard]] const Eigen::Vector3d& point(std::int32_t i) const {
    return scan_.compensated.points_0[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] const Eigen::Vector3f& normal(std::int32_t i) const {
    return scan_.normals_0[static_cast<std::size_t>(i)];
  }
  GrowthVerdict& verdict(std::int32_t i) { return result_.verdict[static_cast<std::size_t>(i)]; }
  bool is_seed(std::int32_t i) { return verdict(i) == GrowthVerdict::seed; }

  // The sets of points of `pool` that chains of links connect, those that contain none of `starts` left out.
  // Two points are linked if they lie within the link of both and joined(i, j).
  template <class Joined>
  [[nodiscard]] std::vector<Indices> connected_sets(const Indices& starts, PointPool pool,
                                                    Joined&& joined) const {
    std::vector<char> reached(scan_.scan().returns.size(), 0);
    std::vector<Indices> sets;
    for (const std::int32_t start : starts) {
      if (reached[static_cast<std::size_t>(start)]) continue;
      reached[static_cast<std::size_t>(start)] = 1;
      Indices& members = sets.emplace_back(1, start);
      for (std::size_t k = 0; k < members.size(); ++k) {
        const std::int32_t i = members[k];
        pool.take_within(point(i), link_of(i), [&](std::int32_t j) {
          if (reached[static_cast<std::size_t>(j)]) return true;
          if ((point(j) - point(i)).norm() > link_of(j) || !joined(i, j)) return false;
          reached[static_cast<std::size_t>(j)] = 1;
          members.push_back(j);
          return true;
        });
      }
    }
    return sets;
  }

  // Clusters the dynamic points (RBNN) and returns those of clusters that are large enough.
  Indices seeds_of_large_clusters(const std::vector<char>& dynamic) {
    Indices points;
    for (std::size_t i = 0; i < dynamic.size(); ++i) {
      if (dynamic[i]) points.push_back(static_cast<std::int32_t>(i));
    }
    Indices seeds;
    const auto any_two = [](std::int32_t, std::int32_t) { return true; };
    for (const Indices& cluster : connected_sets(points, {scan_.compensated.points_0, points}, any_two)) {
      const bool large = cluster.size() >= static_cast<std::size_t>(parameters_.min_cluster_points);
      for (const std::int32_t i : cluster)
        verdict(i) = large ? GrowthVerdict::seed : GrowthVerdict::too_small;
      if (large) seeds.insert(seeds.end(), cluster.begin(), cluster.end());
    }
    return seeds;
  }

  // Normals of one direction, or neither point above the plane of the other (Moosmann et al., IV 2009).
  [[nodiscard]] bool parallel_or_convex(std::int32_t i, std::int32_t j) const {
    const Eigen::Vector3d n1 = normal(i).cast<double>(), n2 = normal(j).cast<double>();
    if (n1.isZero(0) || n2.isZero(0)) return false;
    if (n1.dot(n2) >= parallel_cosine_) return true;
    const Eigen::Vector3d d = point(j) - point(i);
    const double tolerance = d.norm() * concave_sine_;
    return n1.dot(d) <= tolerance && -n2.dot(d) <= tolerance;
  }

  // The seeds with all points that growth reaches from them.
  std::vector<Indices> regions_of(const Indices& seeds) {
    const PointPool seed_pool(scan_.compensated.points_0, seeds);
    Indices usable;
    for (std::size_t k = 0; k < result_.verdict.size(); ++k) {
      const auto i = static_cast<std::int32_t>(k);
      if (is_seed(i) || (!normal(i).isZero(0) && seed_pool.any_within(point(i), parameters_.max_growth_m))) {
        usable.push_back(i);
      }
    }
    return connected_sets(seeds, {scan_.compensated.points_0, usable}, [&](std::int32_t i, std::int32_t j) {
      return (is_seed(i) && is_seed(j)) || parallel_or_convex(i, j);
    });
  }

  void number_objects(const std::vector<Indices>& regions) {
    std::vector<std::pair<std::int32_t, const Indices*>> by_lowest;
    for (const Indices& region : regions) {
      by_lowest.emplace_back(*std::min_element(region.begin(), region.end()), &region);
    }
    std::sort(by_lowest.begin(), by_lowest.end());
    for (const auto& [lowest, region] : by_lowest) {
      const auto number = static_cast<std::uint16_t>(std::min(++result_.objects, kMaxObjectNumber));
      for (const std::int32_t i : *region) {
        if (!is_seed(i)) verdict(i) = GrowthVerdict::grown;
        result_.object[static_cast<std::size_t>(i)] = number;
      }
    }
  }

  const PreparedScan& scan_;
  const RegionGrowthParameters& parameters_;
  double concave_sine_;
  double parallel_cosine_;
  RegionGrowthResult result_;
};

}  // namespace

RegionGrowthResult grow_regions(const PreparedScan& scan, const std::vector<char>& dynamic,
                                const RegionGrowthParameters& parameters) {
  return RegionGrowth(scan, parameters).grow(dynamic);
}

}  // namespace mapless
