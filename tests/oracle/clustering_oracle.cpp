#include "oracle/clustering_oracle.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

namespace mapless::test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

class UnionFind {
 public:
  explicit UnionFind(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(std::size_t a, std::size_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> parent_;
};

bool near(const OraclePoint& a, const OraclePoint& b, const RegionGrowthParameters& p) {
  const double radius = p.link_m + p.link_per_m * std::min(a.range_m, b.range_m);
  return (a.position_0 - b.position_0).norm() <= radius;
}

bool parallel_or_convex(const OraclePoint& a, const OraclePoint& b, const RegionGrowthParameters& p) {
  if (a.normal_0.squaredNorm() == 0 || b.normal_0.squaredNorm() == 0) return false;
  if (a.normal_0.cast<double>().dot(b.normal_0.cast<double>()) >=
      std::cos(p.parallel_tolerance_deg * kDegree))
    return true;
  const Eigen::Vector3d step = b.position_0 - a.position_0;
  const double tolerance = step.norm() * std::sin(p.concave_tolerance_deg * kDegree);
  return a.normal_0.cast<double>().dot(step) <= tolerance &&
         b.normal_0.cast<double>().dot(-step) <= tolerance;
}

/// Dynamic points of clusters that are large enough.
std::vector<char> surviving_seeds(const std::vector<OraclePoint>& points, const RegionGrowthParameters& p) {
  UnionFind clusters(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (points[i].dynamic && points[j].dynamic && near(points[i], points[j], p)) clusters.unite(i, j);
  std::vector<int> size(points.size(), 0);
  for (std::size_t i = 0; i < points.size(); ++i) ++size[clusters.find(i)];
  std::vector<char> seed(points.size(), 0);
  for (std::size_t i = 0; i < points.size(); ++i)
    seed[i] = points[i].dynamic && size[clusters.find(i)] >= p.min_cluster_points ? 1 : 0;
  return seed;
}

/// Seeds, and the other points that growth may use.
std::vector<char> usable_points(const std::vector<OraclePoint>& points, const std::vector<char>& seed,
                                const RegionGrowthParameters& p) {
  std::vector<char> usable = seed;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < points.size() && !usable[i]; ++j)
      usable[i] = seed[j] && (points[i].position_0 - points[j].position_0).norm() <= p.max_growth_m ? 1 : 0;
  }
  return usable;
}

}  // namespace

OracleObjects objects_by_pairs(const std::vector<OraclePoint>& points, const RegionGrowthParameters& p) {
  const std::vector<char> seed = surviving_seeds(points, p);
  const std::vector<char> usable = usable_points(points, seed, p);
  UnionFind regions(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (usable[i] && usable[j] && near(points[i], points[j], p) &&
          ((seed[i] && seed[j]) || parallel_or_convex(points[i], points[j], p)))
        regions.unite(i, j);

  std::map<std::size_t, std::uint16_t> numbers;  // by a region's lowest index, which is its root
  for (std::size_t i = 0; i < points.size(); ++i)
    if (seed[i]) numbers[regions.find(i)] = 0;
  OracleObjects answer;
  for (auto& [root, number] : numbers) number = static_cast<std::uint16_t>(++answer.objects);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto region = numbers.find(regions.find(i));
    const bool reached = region != numbers.end();
    answer.object.push_back(reached ? region->second : std::uint16_t{0});
    answer.verdict.push_back(seed[i]             ? GrowthVerdict::seed
                             : reached           ? GrowthVerdict::grown
                             : points[i].dynamic ? GrowthVerdict::too_small
                                                 : GrowthVerdict::not_reached);
  }
  return answer;
}

}  // namespace mapless::test
