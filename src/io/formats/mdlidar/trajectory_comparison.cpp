#include "io/formats/mdlidar/trajectory_comparison.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <tbb/parallel_for.h>

#include "core/median.hpp"
#include "geometry/nearest_neighbours.hpp"
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {
namespace {

using Scan = std::shared_ptr<const LidarScan>;

// Two scans this far apart still see the same surfaces, and a difference of 1 m/s^2 moves them 0.1 m.
constexpr double kMaxPairGap_s = 0.8;
// A pair of scans is taken at once where the trajectories differ by this: a tenth of it, a scale wrong by
// 10 %, is what detection takes for motion (0.2 m by default).
constexpr double kAmpleDifference_m = 2;
// A quarter of the default distance from which detection takes points as moving (0.2 m).
constexpr double kLeastDifference_m = 0.05;
// That distance: with less, points keep their place.
constexpr double kLeastDisplacement_m = 0.2;
// Where differences of two trajectories are evaluated, and points compared: what detection is about.
constexpr double kNearby_m = 10;
constexpr double kMaxComparedRange_m = 40;
// Scans are compared in as many pairs, from as many equal parts of the recording.
constexpr std::size_t kPairs = 3;
// Chosen: the median of 100 points from at most three pairs of scans.
constexpr std::size_t kLeastPoints = 100;
// Chosen: of a scan of 128,000 rays every sixth.
constexpr std::size_t kMostQueries = 20'000;

struct ScanPair {
  std::size_t first;
  std::size_t second;
  double difference_m;
};

// Difference of displacements from instant t to instant u: T_v0(u) T_v0(t)^-1 by a and by b.
double difference(const SE3& T_a, const SE3& T_b) {
  const Vector6d xi = (T_a * T_b.inverse()).log();
  return xi.head<3>().norm() + kNearby_m * xi.tail<3>().norm();
}

// Poses of the scan at its start, its end and evenly in between.
constexpr int kInstants = 5;
using Poses = std::array<SE3, kInstants>;
Poses poses_in(const Trajectory& trajectory, const ScanInterval& scan) {
  Poses poses;
  const std::int64_t length_ns = (scan.end - scan.start).nanoseconds();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto since_ns = length_ns * static_cast<std::int64_t>(i) / (kInstants - 1);
    poses[i] = trajectory.at(scan.start + Duration::from_nanoseconds(since_ns)).T_v0;
  }
  return poses;
}

// A surface near the sensor is seen up to a quarter of a turn earlier or later in the second scan.
double difference(const Poses& a_1, const Poses& b_1, const Poses& a_2, const Poses& b_2) {
  double most = 0;
  for (std::size_t i = 0; i < a_1.size(); ++i) {
    for (std::size_t j = i == 0 ? 0 : i - 1; j < std::min(a_1.size(), i + 2); ++j) {
      most = std::max(most, difference(a_2[j] * a_1[i].inverse(), b_2[j] * b_1[i].inverse()));
    }
  }
  return most;
}

// The pair of scans to compare whose first scan is one of [begin, end).
std::optional<ScanPair> choose_pair(const std::vector<Poses>& a, const std::vector<Poses>& b,
                                    const std::vector<ScanInterval>& scans, std::size_t begin,
                                    std::size_t end) {
  std::optional<ScanPair> best;
  for (std::size_t first = begin; first < end; ++first) {
    for (std::size_t second = first + 1; second < scans.size(); ++second) {
      if ((scans[second].start - scans[first].start).seconds() > kMaxPairGap_s) break;
      const double d = difference(a[first], b[first], a[second], b[second]);
      if (!best || d > best->difference_m) best = ScanPair{first, second, d};
      if (d >= kAmpleDifference_m) return best;
    }
  }
  return best;
}

std::vector<ScanPair> choose_pairs(const Trajectory& a, const Trajectory& b,
                                   const std::vector<ScanInterval>& scans) {
  std::vector<Poses> poses_a, poses_b;
  for (const ScanInterval& scan : scans) {
    poses_a.push_back(poses_in(a, scan));
    poses_b.push_back(poses_in(b, scan));
  }
  std::vector<ScanPair> pairs;
  for (std::size_t part = 0; part < kPairs; ++part) {
    const auto pair = choose_pair(poses_a, poses_b, scans, part * scans.size() / kPairs,
                                  (part + 1) * scans.size() / kPairs);
    if (pair) pairs.push_back(*pair);
  }
  return pairs;
}

// Displacements of the points of one scan from the surfaces of another, under one trajectory.
class Displacements {
 public:
  Displacements(const Scan& query, const Scan& reference, const Trajectory& trajectory)
      : query_(compensate(query, trajectory)),
        normals_0_(estimate_normals(query_, NearestNeighbours({}), {})),
        reference_points_0_(compensate(reference, trajectory).points_0),
        reference_(reference_points_0_) {}

  [[nodiscard]] bool has_normal(std::size_t i) const { return !normals_0_[i].isZero(0); }

  // Perpendicular to the surface. None where the reference has no point near.
  [[nodiscard]] std::optional<double> of(std::size_t i) const {
    const Eigen::Vector3d& q = query_.points_0[i];
    const auto nearest = reference_.nearest(q);
    if (nearest.index < 0 || nearest.distance_m > kMaxDisplacement_m) return std::nullopt;
    const Eigen::Vector3d& p = reference_points_0_[static_cast<std::size_t>(nearest.index)];
    return std::abs(normals_0_[i].cast<double>().dot(p - q));
  }

 private:
  CompensatedScan query_;
  std::vector<Eigen::Vector3f> normals_0_;
  std::vector<Eigen::Vector3d> reference_points_0_;
  NearestNeighbours reference_;
};

// Displacements of one point under both trajectories.
struct PointDisplacements {
  double a_m;
  double b_m;
};

std::optional<PointDisplacements> displacements_of_point(const Displacements& a, const Displacements& b,
                                                         std::size_t i) {
  if (!a.has_normal(i) || !b.has_normal(i)) return std::nullopt;
  const std::optional<double> by_a = a.of(i), by_b = b.of(i);
  if (!by_a && !by_b) return std::nullopt;  // hidden in the other scan, or displaced too far by both
  return PointDisplacements{by_a.value_or(kMaxDisplacement_m), by_b.value_or(kMaxDisplacement_m)};
}

// Appends the displacements of the points of `query` from `reference`.
void add_displacements(const Scan& query, const Scan& reference, const Trajectory& a, const Trajectory& b,
                       std::vector<PointDisplacements>& displacements) {
  const Displacements by_a(query, reference, a), by_b(query, reference, b);
  const std::size_t stride = query->returns.size() / kMostQueries + 1;
  std::vector<std::optional<PointDisplacements>> found(query->returns.size() / stride);
  tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t k) {
    const std::size_t i = k * stride;
    if (query->returns[i].range_m <= kMaxComparedRange_m) found[k] = displacements_of_point(by_a, by_b, i);
  });
  for (const auto& point : found) {
    if (point) displacements.push_back(*point);
  }
}

struct PairDisplacements {
  double difference_m = 0;  // of the trajectories, largest of the pairs
  std::vector<PointDisplacements> points;
};

PairDisplacements displacements_in_pairs(const Trajectory& a, const Trajectory& b,
                                         const std::vector<ScanInterval>& scans, const ScanReader& read) {
  PairDisplacements found;
  for (const ScanPair& pair : choose_pairs(a, b, scans)) {
    found.difference_m = std::max(found.difference_m, pair.difference_m);
    if (pair.difference_m < kLeastDifference_m) continue;
    const Scan query = read(pair.first), reference = read(pair.second);
    if (query && reference) add_displacements(query, reference, a, b, found.points);
  }
  return found;
}

}  // namespace

bool TrajectoryComparison::same() const { return difference_m < kLeastDifference_m; }

bool TrajectoryComparison::measured() const { return points >= kLeastPoints; }

bool StaticDisplacement::measured() const { return points >= kLeastPoints; }

TrajectoryComparison compare_trajectories(const Trajectory& a, const Trajectory& b,
                                          const std::vector<ScanInterval>& scans, const ScanReader& read) {
  const PairDisplacements found = displacements_in_pairs(a, b, scans, read);
  std::vector<double> by_a, by_b;
  for (const PointDisplacements& point : found.points) {
    if (std::abs(point.a_m - point.b_m) < kLeastDifference_m) continue;
    by_a.push_back(point.a_m);
    by_b.push_back(point.b_m);
  }
  TrajectoryComparison comparison;
  comparison.difference_m = found.difference_m;
  comparison.points = by_a.size();
  if (comparison.points == 0) return comparison;
  comparison.displacement_a_m = median(std::move(by_a));
  comparison.displacement_b_m = median(std::move(by_b));
  return comparison;
}

StaticDisplacement measure_static_displacement(const Trajectory& trajectory,
                                               const std::vector<ScanInterval>& scans,
                                               const ScanReader& read) {
  std::vector<double> displacements;
  const PairDisplacements found = displacements_in_pairs(trajectory, StationaryTrajectory(), scans, read);
  for (const PointDisplacements& point : found.points) {
    if (point.b_m >= kLeastDisplacement_m) displacements.push_back(point.a_m);
  }
  StaticDisplacement result;
  result.points = displacements.size();
  if (result.points > 0) result.median_m = median(std::move(displacements));
  return result;
}

}  // namespace mapless
