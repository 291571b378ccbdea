#include "detection/tracking/straight_paths.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "detection/object_number.hpp"
#include "detection/segmentation/object_evidence.hpp"
#include "detection/tracking/completion/body_completion.hpp"
#include "detection/tracking/motion_classifier.hpp"
#include "detection/tracking/object_members.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kScans = 12;  // that a path is followed. Measured: 8 to 15 give the same within .002
constexpr std::size_t kNewest = 2, kOldest = 5;  // scans since the spot that a velocity comes from
constexpr int kFewest = 5;                       // scans that a path meets
// Half the velocity of a walker stays within the reach of its path for most of the scans. It tells nothing
// of a path that meets this share of them. Measured: docs/notebook/detection.md, "Straight paths".
constexpr double kMetThroughout = 0.8;
constexpr double kMaxSpeed_mps = 40;
// What is seen of a thing differs from scan to scan, and so does its centre.
constexpr double kReach_m = 0.25, kReachSpacings = 0.4;
// A thing of more points has evidence enough; rails seen by a dense sensor have as many.
constexpr std::size_t kMostPoints = 50;
constexpr double kChance = 0.05;
// Among so many, any path meets others by chance; bounds the time, too.
constexpr double kMostVelocities = 200;

// The velocity of a path is known to about its reach in a second, and a share of itself.
constexpr double kPaceError_mps = 1, kPaceErrorShare = 0.08;
double spacing_rad(const LidarModel& model) {
  return std::max(2 * std::numbers::pi / model.columns, model.mean_elevation_step());
}

// P(k or more of n), each by p.
double binomial_tail(int k, int n, double p) {
  double sum = 0;
  for (int i = k; i <= n; ++i) {
    sum += std::exp(std::lgamma(n + 1) - std::lgamma(i + 1) - std::lgamma(n - i + 1) + i * std::log(p) +
                    (n - i) * std::log1p(-p));
  }
  return sum;
}

// Cells of 1 m, longer than most reaches; those 64 m apart share a number.
constexpr double kCell_m = 1;
constexpr std::uint32_t kCellsPerAxis = 64;

std::int64_t cell_along(double x) { return static_cast<std::int64_t>(std::floor(x / kCell_m)); }

std::uint32_t cell_of(std::int64_t x, std::int64_t y) {
  return (static_cast<std::uint32_t>(y) % kCellsPerAxis) * kCellsPerAxis +
         static_cast<std::uint32_t>(x) % kCellsPerAxis;
}

}  // namespace

StraightPaths::Spot StraightPaths::spot_of(const ObjectProposals& proposed,
                                           std::span<const std::int32_t> returns, double log_odds) {
  Vector3d sum = Vector3d::Zero();
  double range_m = 0;
  for (const std::int32_t i : returns) {
    sum += proposed.points.points[static_cast<std::size_t>(i)].cast<double>();
    range_m += static_cast<double>(proposed.scan->returns[static_cast<std::size_t>(i)].range_m);
  }
  const auto n = static_cast<double>(returns.size());
  return {proposed.points.origin_0 + sum / n,
          kReach_m + kReachSpacings * spacing_rad(*proposed.scan->model) * range_m / n, log_odds,
          returns.size(), 0};
}

std::vector<bool> StraightPaths::find(ObjectProposals& proposed, const std::vector<TrackedObject>& movers) {
  now_ = proposed.scan->start;
  sensor_velocity_0_ = proposed.sensor_velocity_0;
  Spots spots;
  spots.start = now_;
  tabulate_chances();
  const ObjectMembers members(proposed.object);
  std::vector<bool> on_path(proposed.evidence.size(), false);
  for (std::size_t n = 1; n <= on_path.size() && n < members.numbers(); ++n) {
    if (members.of(n).empty()) continue;
    spots.all.push_back(spot_of(proposed, members.of(n), proposed.evidence[n - 1].log_odds));
    spots.all.back().object = static_cast<std::uint16_t>(n);
    on_path[n - 1] = on_straight_path(spots.all.back());
  }
  ObjectEvidenceCollector evidence(*proposed.scan, proposed.points, proposed.votes,
                                   proposed.parameters.min_evidence);
  for (const std::vector<std::int32_t>& cluster : proposed.faint) {
    const ObjectEvidence of_cluster = evidence.collect(cluster);
    spots.all.push_back(spot_of(proposed, cluster, of_cluster.log_odds));
    if (proposed.objects >= kMaxObjectNumber || !on_straight_path(spots.all.back())) continue;
    std::uint16_t number = body_of(spots.all.back(), spots.all, movers);
    if (number == 0) {
      number = static_cast<std::uint16_t>(++proposed.objects);
      proposed.evidence.push_back(of_cluster);
      on_path.push_back(true);
    }
    for (const std::int32_t i : cluster) {
      proposed.object[static_cast<std::size_t>(i)] = number;
      proposed.trace[static_cast<std::size_t>(i)].growth = GrowthVerdict::grown;
    }
  }
  sort_into_cells(spots);
  earlier_.push_front(std::move(spots));
  if (earlier_.size() > kScans) earlier_.pop_back();
  return on_path;
}

void StraightPaths::sort_into_cells(Spots& spots) {
  const auto for_each_cell = [](const Spot& spot, auto&& visit) {
    const Vector3d& c = spot.centre_0;
    const std::int64_t last_x = cell_along(c.x() + spot.reach_m), last_y = cell_along(c.y() + spot.reach_m);
    for (std::int64_t y = cell_along(c.y() - spot.reach_m); y <= last_y; ++y) {
      for (std::int64_t x = cell_along(c.x() - spot.reach_m); x <= last_x; ++x) visit(cell_of(x, y));
    }
  };
  spots.cell_begin.assign(kCellsPerAxis * kCellsPerAxis + 1, 0);
  for (const Spot& spot : spots.all)
    for_each_cell(spot, [&](std::uint32_t cell) { ++spots.cell_begin[cell]; });
  std::partial_sum(spots.cell_begin.begin(), spots.cell_begin.end(), spots.cell_begin.begin());
  spots.within.resize(spots.cell_begin.back());
  spots.centres_0.resize(static_cast<Eigen::Index>(spots.all.size()), 3);
  for (std::size_t n = spots.all.size(); n-- > 0;) {
    spots.centres_0.row(static_cast<Eigen::Index>(n)) = spots.all[n].centre_0.transpose().array();
    for_each_cell(spots.all[n], [&](std::uint32_t cell) {
      spots.within[--spots.cell_begin[cell]] = static_cast<std::uint32_t>(n);
    });
  }
}

// The first spot whose reach a place is in; null: none.
const StraightPaths::Spot* StraightPaths::any_around(const Spots& spots, const Vector3d& place_0) {
  const std::uint32_t cell = cell_of(cell_along(place_0.x()), cell_along(place_0.y()));
  for (std::uint32_t k = spots.cell_begin[cell]; k < spots.cell_begin[cell + 1]; ++k) {
    const Spot& spot = spots.all[spots.within[k]];
    if ((spot.centre_0 - place_0).squaredNorm() <= spot.reach_m * spot.reach_m) return &spot;
  }
  return nullptr;
}

// None if there are more than kMostVelocities.
std::vector<Vector3d> StraightPaths::velocities_to(const Spot& spot) const {
  const std::size_t end = std::min(kOldest, earlier_.size());
  std::array<Eigen::ArrayXd, kOldest> in_range;  // 1 for each spot that a velocity comes from, or 0
  double count = 0;
  for (std::size_t k = kNewest - 1; k < end; ++k) {
    const Eigen::ArrayX3d& from_0 = earlier_[k].centres_0;
    const double most2 = std::pow(kMaxSpeed_mps * seconds_since(earlier_[k]), 2);
    const double *x = from_0.col(0).data(), *y = from_0.col(1).data(), *z = from_0.col(2).data();
    in_range[k].resize(from_0.rows());
    double* in = in_range[k].data();
    for (Eigen::Index n = 0; n < from_0.rows(); ++n) {  // without branches: two at once
      const double dx = x[n] - spot.centre_0.x(), dy = y[n] - spot.centre_0.y(),
                   dz = z[n] - spot.centre_0.z();
      in[n] = dx * dx + dy * dy + dz * dz <= most2 ? 1.0 : 0.0;
    }
    count += in_range[k].sum();
    if (count > kMostVelocities) return {};
  }
  std::vector<Vector3d> velocities;
  velocities.reserve(static_cast<std::size_t>(count));
  for (std::size_t k = kNewest - 1; k < end; ++k) {
    for (Eigen::Index n = 0; n < in_range[k].size(); ++n) {
      if (in_range[k][n] == 0) continue;
      velocities.emplace_back((spot.centre_0 - earlier_[k].all[static_cast<std::size_t>(n)].centre_0) /
                              seconds_since(earlier_[k]));
    }
  }
  return velocities;
}

// The scans in which the path that leads to a spot with a velocity meets another; none if fewer than `least`.
StraightPaths::Met StraightPaths::meet(const Spot& spot, const Vector3d& velocity_0, int least) const {
  Met met;
  for (std::size_t k = 0; k < earlier_.size(); ++k) {
    if (met.scans + static_cast<int>(earlier_.size() - k) < least) return {};
    const Spot* other = any_around(earlier_[k], spot.centre_0 - seconds_since(earlier_[k]) * velocity_0);
    if (other == nullptr) continue;
    ++met.scans;
    met.log_odds += other->log_odds;
  }
  return met;
}

int StraightPaths::most_met_by_others(const Spot& spot, const Vector3d& velocity_0, int met) const {
  Vector3d::Index smallest = 0;
  velocity_0.cwiseAbs().minCoeff(&smallest);
  const Vector3d& v = velocity_0;
  const Vector3d a = v.cross(Vector3d::Unit(smallest)).normalized() * v.norm();
  const Vector3d b = v.cross(a) / v.norm();
  const std::array<Vector3d, 5> others = {-v, a, -a, b, -b};
  int most = 0;
  for (const Vector3d& other : others) most = std::max(most, meet(spot, other, 0).scans);
  if (met < kMetThroughout * static_cast<double>(earlier_.size()))
    most = std::max(most, meet(spot, v / 2, 0).scans);
  // In the opposite order: from one scan beyond the oldest back towards the spot.
  const double oldest_s = seconds_since(earlier_.back());
  Spot beyond = spot;
  beyond.centre_0 -= oldest_s * (1 + 1 / static_cast<double>(earlier_.size())) * v;
  return std::max(most, meet(beyond, -v, 0).scans);
}

bool StraightPaths::keeps_pace(const Vector3d& velocity_0) const {
  return (velocity_0 - sensor_velocity_0_).norm() < kPaceError_mps + kPaceErrorShare * velocity_0.norm();
}

void StraightPaths::tabulate_chances() {
  const auto scans = static_cast<int>(earlier_.size());
  if (chances_.size() == static_cast<std::size_t>((scans + 1) * (scans + 1))) return;
  chances_.clear();
  for (int most = 0; most <= scans; ++most) {
    const double p = (most + 0.5) / (scans + 1);
    for (int met = 0; met <= scans; ++met)
      chances_.push_back(binomial_tail(std::max(met - 1, 0), scans - 1, p));
  }
}

// The fewest scans that a path must meet if one of others meets `most` and `velocities` are tried; more than
// there are: no path is told from chance.
int StraightPaths::fewest_to_meet(int most, std::size_t velocities) const {
  const auto scans = static_cast<int>(earlier_.size());
  int fewest = kFewest;
  while (fewest <= scans && static_cast<double>(velocities) * chance(fewest, most) >= kChance) ++fewest;
  return fewest;
}

bool StraightPaths::on_straight_path(const Spot& spot) const {
  const auto scans = static_cast<int>(earlier_.size());
  if (scans < kFewest || spot.points > kMostPoints) return false;
  // Most is seen in place again and again: no path can stand out there.
  int most = meet(spot, Vector3d::Zero(), 0).scans;
  if (fewest_to_meet(most, 1) > scans) return false;
  const std::vector<Vector3d> velocities = velocities_to(spot);
  if (velocities.empty()) return false;
  const int fewest = fewest_to_meet(most, velocities.size());
  Met best;
  Vector3d velocity_0 = Vector3d::Zero();
  for (const Vector3d& one : velocities) {
    const Met met = meet(spot, one, std::max(fewest, best.scans + 1));
    if (met.scans <= best.scans) continue;
    best = met;
    velocity_0 = one;
  }
  if (best.scans < fewest) return false;
  if (keeps_pace(velocity_0) && spot.log_odds + best.log_odds < std::log(kOddsOfMover)) return false;
  most = std::max(most, most_met_by_others(spot, velocity_0, best.scans));
  return best.scans >= fewest_to_meet(most, velocities.size());
}

// The object that a faint cluster is a part of; 0: none.
std::uint16_t StraightPaths::body_of(const Spot& spot, const std::vector<Spot>& spots,
                                     const std::vector<TrackedObject>& movers) const {
  for (const TrackedObject& mover : movers) {
    const Vector3d centre_0 = mover.centre_0 + (now_ - mover.time).seconds() * mover.velocity_0;
    const Vector3d half_0 = mover.extent_0 / 2;
    const auto reaches = [&](const Spot& one) {
      const double beside_m = std::min(half_0.norm(), static_cast<double>(kMaxBodyReach_m));
      return ((one.centre_0 - centre_0).array().abs() <= half_0.array() + beside_m).all();
    };
    if (!reaches(spot)) continue;
    for (std::size_t n = 0; n < spots.size() && spots[n].object != 0; ++n) {
      if (reaches(spots[n])) return spots[n].object;
    }
  }
  return 0;
}

}  // namespace mapless
