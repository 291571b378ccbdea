#include "detection/published/pointcloud_comparison.hpp"

#include <cmath>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

namespace mapless::inline v1 {
namespace {

CandidateVerdict compare_point(const PreparedScan& query, std::size_t i, const PreparedScan& reference,
                               const ComparisonParameters& parameters) {
  const Eigen::Vector3d& q = query.compensated.points_0[i];
  const Eigen::Vector3d normal = query.normals_0[i].cast<double>();
  const bool has_normal = !normal.isZero(0);
  if (!has_normal && query.scan().returns[i].range_m > parameters.max_range_without_normal_m) {
    return CandidateVerdict::matched;
  }
  const auto nearest = reference.neighbours.nearest(q);
  const Eigen::Vector3d& p = reference.compensated.points_0[static_cast<std::size_t>(nearest.index)];
  const double error = has_normal ? std::abs(normal.dot(p - q)) : nearest.distance_m;
  return error > parameters.error_threshold_m ? CandidateVerdict::dynamic : CandidateVerdict::matched;
}

}  // namespace

std::vector<CandidateVerdict> compare_pointclouds(const PreparedScan& query, const PreparedScan& reference,
                                                  const ComparisonParameters& parameters) {
  std::vector<CandidateVerdict> verdicts(query.compensated.points_0.size(), CandidateVerdict::not_compared);
  if (reference.compensated.points_0.empty()) return verdicts;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, verdicts.size(), 1024), [&](const auto& chunk) {
    for (std::size_t i = chunk.begin(); i != chunk.end(); ++i) {
      verdicts[i] = compare_point(query, i, reference, parameters);
    }
  });
  return verdicts;
}

}  // namespace mapless
