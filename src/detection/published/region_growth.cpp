#include "detection/published/region_growth.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

#include "detection/object_number.hpp"
#include "detection/segmentation/disjoint_sets.hpp"
#include "geometry/nearest_neighbours.hpp"

namespace mapless::inline v1 {
namespace {

class RegionGrowth {
 public:
  RegionGrowth(const PreparedScan& scan, const RegionGrowthParameters& parameters)
      : scan_(scan),
        parameters_(parameters),
        concave_sine_(std::sin(parameters.concave_tolerance_deg * std::numbers::pi / 180)),
        on_edge_(scan.scan().returns.size(), 0),
        objects_(scan.scan().returns.size()) {
    result_.verdict.assign(scan.scan().returns.size(), GrowthVerdict::not_reached);
    result_.object.assign(scan.scan().returns.size(), 0);
  }

  RegionGrowthResult grow(const std::vector<char>& dynamic) {
    const std::vector<std::int32_t> seeds = keep_large_clusters(dynamic);
    spread(seeds);
    number_objects();
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
  GrowthVerdict& verdict(std::int32_t i) { return result_.verdict[static_cast<std::size_t>(i)]; }

  // All points linked to i: within the link of both, i itself left out.
  const std::vector<std::int32_t>& linked(std::int32_t i) {
    scan_.neighbours.within(point(i), link_of(i), linked_);
    std::erase_if(linked_,
                  [&](std::int32_t j) { return j == i || (point(j) - point(i)).norm() > link_of(j); });
    return linked_;
  }

  // Clusters the dynamic points (RBNN) and returns those of clusters that are large enough.
  std::vector<std::int32_t> keep_large_clusters(const std::vector<char>& dynamic) {
    std::vector<std::int32_t> points;
    for (std::size_t i = 0; i < dynamic.size(); ++i) {
      if (dynamic[i]) points.push_back(static_cast<std::int32_t>(i));
    }
    DisjointSets clusters(dynamic.size());
    for (const std::int32_t i : points) {
      for (const std::int32_t j : linked(i)) {
        if (dynamic[static_cast<std::size_t>(j)]) {
          clusters.unite(i, j);
        } else {
          on_edge_[static_cast<std::size_t>(i)] = 1;
        }
      }
    }
    std::vector<std::int32_t> size(dynamic.size(), 0);
    for (const std::int32_t i : points) ++size[static_cast<std::size_t>(clusters.find(i))];
    std::vector<std::int32_t> seeds;
    for (const std::int32_t i : points) {
      const bool large = size[static_cast<std::size_t>(clusters.find(i))] >= parameters_.min_cluster_points;
      verdict(i) = large ? GrowthVerdict::seed : GrowthVerdict::too_small;
      if (!large) continue;
      seeds.push_back(i);
      objects_.unite(i, clusters.find(i));
    }
    return seeds;
  }

  // Neither point rises above the other's plane by more than the tolerance (Moosmann et al., IV 2009).
  [[nodiscard]] bool parallel_or_convex(std::int32_t i, std::int32_t j) const {
    const Eigen::Vector3f& n1 = scan_.normals_0[static_cast<std::size_t>(i)];
    const Eigen::Vector3f& n2 = scan_.normals_0[static_cast<std::size_t>(j)];
    if (n1.isZero(0) || n2.isZero(0)) return false;
    const Eigen::Vector3d d = point(j) - point(i);
    const double tolerance = d.norm() * concave_sine_;
    return n1.cast<double>().dot(d) <= tolerance && -n2.cast<double>().dot(d) <= tolerance;
  }

  // From the seeds to every point that a chain of convex links reaches, not too far from some seed.
  void spread(const std::vector<std::int32_t>& seeds) {
    if (seeds.empty()) return;
    std::vector<Eigen::Vector3d> seed_points;
    for (const std::int32_t i : seeds) seed_points.push_back(point(i));
    const NearestNeighbours seed_tree(std::move(seed_points));
    // A seed linked to nothing but dynamic points has its whole neighbourhood in its own cluster.
    std::vector<std::int32_t> front;
    std::copy_if(seeds.begin(), seeds.end(), std::back_inserter(front),
                 [this](std::int32_t i) { return on_edge_[static_cast<std::size_t>(i)] != 0; });
    while (!front.empty()) {
      const std::int32_t i = front.back();
      front.pop_back();
      for (const std::int32_t j : linked(i)) {
        if (verdict(j) == GrowthVerdict::seed && verdict(i) == GrowthVerdict::seed) continue;
        if (!parallel_or_convex(i, j)) continue;
        if (verdict(j) == GrowthVerdict::not_reached || verdict(j) == GrowthVerdict::too_small) {
          if (seed_tree.nearest(point(j)).distance_m > parameters_.max_growth_m) continue;
          verdict(j) = GrowthVerdict::grown;
          front.push_back(j);
        }
        objects_.unite(i, j);
      }
    }
  }

  void number_objects() {
    std::vector<std::uint16_t> number(result_.verdict.size(), 0);
    for (std::size_t i = 0; i < result_.verdict.size(); ++i) {
      if (result_.verdict[i] != GrowthVerdict::seed && result_.verdict[i] != GrowthVerdict::grown) continue;
      auto& n = number[static_cast<std::size_t>(objects_.find(static_cast<std::int32_t>(i)))];
      if (n == 0) n = static_cast<std::uint16_t>(std::min(++result_.objects, kMaxObjectNumber));
      result_.object[i] = n;
    }
  }

  const PreparedScan& scan_;
  const RegionGrowthParameters& parameters_;
  double concave_sine_;
  std::vector<char> on_edge_;  // linked to a point that is not dynamic
  DisjointSets objects_;
  RegionGrowthResult result_;
  std::vector<std::int32_t> linked_;
};

}  // namespace

RegionGrowthResult grow_regions(const PreparedScan& scan, const std::vector<char>& dynamic,
                                const RegionGrowthParameters& parameters) {
  return RegionGrowth(scan, parameters).grow(dynamic);
}

}  // namespace mapless
