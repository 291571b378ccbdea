#include "detection/published/pointcloud_comparison.hpp"

#include <cmath>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

namespace mapless::inline v1 {
namespace {

// Compares points one after the other. Neighbours in a row of the scan have reference points near each other.
class Comparison {
 public:
  Comparison(const PreparedScan& query, const PreparedScan& reference, const ComparisonParameters& parameters)
      : query_(query), reference_(reference), parameters_(parameters) {}

  CandidateVerdict verdict(std::size_t i) {
    const Eigen::Vector3d& q = query_.compensated.points_0[i];
    // Where any reference point is within the threshold, both errors are: the nearest is at most as far, and
    // its distance from a plane through q at most that from q.
    if (nearest_.index >= 0 && (nearest_point() - q).norm() <= parameters_.error_threshold_m) {
      return CandidateVerdict::matched;
    }
    const Eigen::Vector3d normal = query_.normals_0[i].cast<double>();
    const bool has_normal = !normal.isZero(0);
    if (!has_normal && query_.scan().returns[i].range_m > parameters_.max_range_without_normal_m) {
      return CandidateVerdict::matched;
    }
    nearest_ = reference_.neighbours.nearest(q, nearest_);
    const double error = has_normal ? std::abs(normal.dot(nearest_point() - q)) : nearest_.distance_m;
    return error > parameters_.error_threshold_m ? CandidateVerdict::dynamic : CandidateVerdict::matched;
  }

 private:
  [[nodiscard]] const Eigen::Vector3d& nearest_point() const {
    return reference_.compensated.points_0[static_cast<std::size_t>(nearest_.index)];
  }

  const PreparedScan& query_;
  const PreparedScan& reference_;
  const ComparisonParameters& parameters_;
  NearestNeighbours::Neighbour nearest_;  // of the point searched last
};

}  // namespace

std::vector<CandidateVerdict> compare_pointclouds(const PreparedScan& query, const PreparedScan& reference,
                                                  const ComparisonParameters& parameters) {
  std::vector<CandidateVerdict> verdicts(query.compensated.points_0.size(), CandidateVerdict::not_compared);
  if (reference.compensated.points_0.empty()) return verdicts;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, verdicts.size(), 1024), [&](const auto& chunk) {
    Comparison comparison(query, reference, parameters);
    for (std::size_t i = chunk.begin(); i != chunk.end(); ++i) {
      verdicts[i] = comparison.verdict(i);
    }
  });
  return verdicts;
}

}  // namespace mapless
