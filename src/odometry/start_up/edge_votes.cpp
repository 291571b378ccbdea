#include "odometry/start_up/edge_votes.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <tbb/parallel_for.h>

#include "odometry/map/edge_grid.hpp"
#include "odometry/map/points_in_world.hpp"

namespace mapless::inline v1 {
namespace {

// Edges of each scan that vote. Chosen: 25 turn rates x 400^2 pairs take some ten milliseconds.
constexpr std::size_t kVoters = 400;
// Edges of the first scan that those of the second may coincide with. Chosen: so many take 0.2 ms a step.
constexpr std::size_t kEdges = 4000;
// Motions with most votes that are refined, in so many steps. Chosen: the steps move a motion by up to
// EdgeGrid::kReach_m each; a motion wrong by half a bin takes two or three.
constexpr std::size_t kRefined = 16;
constexpr int kSteps = 5;
// Standard deviation of an edge's distance from the same edge in another scan: the distances between
// neighbouring rays, across and along the edge. Chosen.
constexpr double kEdgeSigma_m = 0.2;
// Fewest agreement of the best motion. Measured on motorways with sixteen lasers: .2 to .35, of the
// best wrong motion .04 to .12 (docs/notebook/odometry.md, "Edges at the start").
constexpr double kMinAgreement = 0.15;
// Motions with less than this part of the best one's agreement are dropped, and all but so many. Measured on
// the same scans: the best wrong motion has .2 to .35 of it, moving with the traffic; in dense traffic more.
constexpr double kMinAgreementOfMost = 0.4;
constexpr std::size_t kMaxMotions = 5;
// Velocities closer to each other are one motion. Derived: 0.05 m per scan at 10 Hz, a tenth of the gate, and
// 0.6 deg per scan.
constexpr double kAlikeSpeed_mps = 0.5;
constexpr double kAlikeTurnRate_radps = 0.1;
// Keeps the system of equations solvable: a thousandth of the weight of one edge.
constexpr double kDamping = 1e-5;
// Within this time the motion is taken to first order: 0.06 mm at 200 deg/s and 30 m, (w t)^2 / 2 x range.
constexpr double kStep_s = 1e-3;
// Largest speed, 160 km/h.
constexpr double kMaxSpeed_mps = 45;
// Bins of the translation between the scans, of either sign: so many that they reach kMaxSpeed_mps, up to
// those of 5 Hz. Chosen: about EdgeGrid::kReach_m; more bins, where scans are missing, would take megabytes.
constexpr double kBin_m = 0.5;
constexpr double kMostBins = 18;
// Most translations of one turn rate. Chosen: the static world and two groups of moving objects.
constexpr std::size_t kPeaks = 3;

struct Edge {
  Eigen::Vector3d position_v;
  double time_s;  // since the start of the first scan
};

// At most `most` edges, from all over the scan.
std::vector<Edge> edges_of(const UsableScan& scan, Time origin, std::size_t most) {
  std::vector<Edge> out;
  const std::size_t size = scan.edges.size(), number = std::min(size, most);
  const double start_s = (scan.start - origin).seconds();
  for (std::size_t i = 0; i < number; ++i) {
    const ScanPoint& edge = scan.edges[i * size / number];
    out.push_back({edge.position_v.cast<double>(), start_s + 1e-9 * edge.time_ns});
  }
  return out;
}

// The sum of the translations that fell into a bin, and their number.
struct Bin {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int votes = 0;

  void add(const Bin& other) {
    sum += other.sum;
    votes += other.votes;
  }
};

class Votes {
 public:
  explicit Votes(double interval_s)
      : interval_s_(interval_s),
        reach_(static_cast<int>(std::lround(std::min(kMaxSpeed_mps * interval_s / kBin_m, kMostBins)))),
        side_(2 * reach_ + 1),
        bins_(static_cast<std::size_t>(side_ * side_ * side_)) {}

  void add(const Eigen::Vector3d& velocity) {
    const Eigen::Vector3d at = (interval_s_ / kBin_m * velocity).array() + reach_;
    if (!((at.array() > -0.5).all() && (at.array() < side_ - 0.5).all())) return;
    const Eigen::Array3i n = at.array().round().cast<int>();
    bins_[bin_at(n[0], n[1], n[2])].add({velocity, 1});
  }

  // The mean velocities of the cubes of 2 x 2 x 2 bins with most votes, no two of which share a bin.
  [[nodiscard]] std::vector<Bin> peaks() const {
    std::vector<Bin> cubes;
    for (int x = 0; x + 1 < side_; ++x)
      for (int y = 0; y + 1 < side_; ++y)
        for (int z = 0; z + 1 < side_; ++z)
          if (const Bin cube = cube_at(x, y, z); cube.votes > 0) cubes.push_back(cube);
    std::stable_sort(cubes.begin(), cubes.end(),
                     [](const Bin& a, const Bin& b) { return a.votes > b.votes; });
    std::vector<Bin> out;
    for (const Bin& cube : cubes) {
      if (out.size() == kPeaks) break;
      const Eigen::Vector3d mean = cube.sum / cube.votes;
      const bool near = std::any_of(out.begin(), out.end(), [&](const Bin& one) {
        return interval_s_ * (one.sum / one.votes - mean).cwiseAbs().maxCoeff() < 2 * kBin_m;
      });
      if (!near) out.push_back(cube);
    }
    return out;
  }

 private:
  [[nodiscard]] Bin cube_at(int x, int y, int z) const {
    Bin out;
    for (int corner = 0; corner < 8; ++corner)
      out.add(bins_[bin_at(x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2))]);
    return out;
  }

  [[nodiscard]] std::size_t bin_at(int x, int y, int z) const {
    return static_cast<std::size_t>((x * side_ + y) * side_ + z);
  }

  double interval_s_;
  int reach_, side_;
  std::vector<Bin> bins_;
};

std::vector<Eigen::Vector3d> turn_rates() {
  std::vector<Eigen::Vector3d> out = {Eigen::Vector3d::Zero()};
  for (const double turn_rate_radps : {0.85, 1.7, 2.55, 3.4}) {
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      for (const double sign : {1., -1.}) out.push_back(sign * turn_rate_radps * Eigen::Vector3d::Unit(axis));
  }
  return out;
}

// A static point at q at time s is at p = R(w (t - s)) q + (t - s) v at time t.
std::vector<Bin> peaks_at(const Eigen::Vector3d& turn_rate, const std::vector<Edge>& first,
                          const std::vector<Edge>& second, double interval_s) {
  Votes votes(interval_s);
  Vector6d turn = Vector6d::Zero();
  turn.tail<3>() = interval_s * turn_rate;
  const Eigen::Matrix3d R = SE3::exp(turn).rotation();
  const double reach_m = kMaxSpeed_mps * interval_s;
  for (const Edge& earlier : first) {
    const Eigen::Vector3d q = R * earlier.position_v;
    for (const Edge& later : second) {
      const Eigen::Vector3d translation = later.position_v - q;
      if (translation.squaredNorm() > reach_m * reach_m) continue;
      votes.add(translation / (later.time_s - earlier.time_s));
    }
  }
  return votes.peaks();
}

struct VotedVelocity {
  int votes;
  Vector6d varpi;
};

std::vector<VotedVelocity> voted_velocities(const std::vector<Edge>& first, const std::vector<Edge>& second,
                                            double interval_s) {
  std::vector<VotedVelocity> out;
  for (const Eigen::Vector3d& turn_rate : turn_rates()) {
    for (const Bin& peak : peaks_at(turn_rate, first, second, interval_s)) {
      out.push_back({peak.votes, Vector6d::Zero()});
      out.back().varpi << peak.sum / peak.votes, turn_rate;
    }
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const VotedVelocity& a, const VotedVelocity& b) { return a.votes > b.votes; });
  return out;
}

// The edges at time 0 under a constant velocity.
std::vector<Eigen::Vector3d> at_origin(const std::vector<Edge>& edges, const Vector6d& varpi) {
  std::vector<Eigen::Vector3d> out;
  out.reserve(edges.size());
  double step_s = -1;
  SE3 T;
  for (const Edge& edge : edges) {
    if (step_s < 0 || edge.time_s - step_s > kStep_s) {
      step_s = edge.time_s;
      T = SE3::exp(-step_s * varpi);
    }
    const Eigen::Vector3d& p = edge.position_v;
    out.push_back(T * (p - (edge.time_s - step_s) * (varpi.head<3>() + varpi.tail<3>().cross(p))));
  }
  return out;
}

// Point-to-point registration with a constant velocity. A change of varpi by d moves the edge p of the second
// scan, against those of the first, by -interval_s (d_v + d_w x p).
EdgeMotion refined(const Vector6d& start, const std::vector<Edge>& first, const std::vector<Edge>& second,
                   double interval_s) {
  EdgeMotion out;
  out.varpi = start;
  for (int step = 0;; ++step) {
    EdgeGrid grid;
    grid.insert(at_origin(first, out.varpi));
    const std::vector<Eigen::Vector3d> points_0 = at_origin(second, out.varpi);
    if (step == kSteps) {
      out.agreement = grid.agreement(points_0) / static_cast<double>(points_0.size());
      return out;
    }
    Matrix6d information = kDamping * Matrix6d::Identity();
    Vector6d gradient = Vector6d::Zero();
    for (const Eigen::Vector3d& p_0 : points_0) {
      const Eigen::Vector3d* edge = grid.nearest(p_0);
      if (edge == nullptr) continue;
      const double weight = EdgeGrid::weight(*edge, p_0);
      Eigen::Matrix<double, 3, 6> J;
      J << interval_s * Eigen::Matrix3d::Identity(), -interval_s * hat(p_0);
      information += weight * J.transpose() * J;
      gradient += weight * J.transpose() * (p_0 - *edge);
    }
    out.varpi += information.ldlt().solve(gradient);
    out.information = information / (kEdgeSigma_m * kEdgeSigma_m);
  }
}

}  // namespace

bool are_alike(const Vector6d& varpi_a, const Vector6d& varpi_b) {
  const Vector6d difference = varpi_a - varpi_b;
  return difference.head<3>().norm() < kAlikeSpeed_mps && difference.tail<3>().norm() < kAlikeTurnRate_radps;
}

std::vector<EdgeMotion> edge_motions(const UsableScan& first, const UsableScan& second) {
  const std::vector<Edge> earlier = edges_of(first, first.start, kEdges),
                          later = edges_of(second, first.start, kVoters);
  if (std::min(earlier.size(), later.size()) < kMinEdges) return {};
  const double interval_s = (second.start - first.start).seconds();
  std::vector<VotedVelocity> voted =
      voted_velocities(edges_of(first, first.start, kVoters), later, interval_s);
  voted.resize(std::min(voted.size(), kRefined));
  std::vector<EdgeMotion> found(voted.size());
  tbb::parallel_for(std::size_t{0}, voted.size(),
                    [&](std::size_t i) { found[i] = refined(voted[i].varpi, earlier, later, interval_s); });
  std::stable_sort(found.begin(), found.end(),
                   [](const EdgeMotion& a, const EdgeMotion& b) { return a.agreement > b.agreement; });
  const double most = found.empty() ? 0 : found.front().agreement;
  if (most < kMinAgreement) return {};
  std::vector<EdgeMotion> out;
  for (const EdgeMotion& one : found) {
    if (one.agreement < kMinAgreementOfMost * most || out.size() == kMaxMotions) break;
    if (std::none_of(out.begin(), out.end(),
                     [&](const EdgeMotion& other) { return are_alike(one.varpi, other.varpi); }))
      out.push_back(one);
  }
  return out;
}

std::vector<Eigen::Vector3d> edges_in_world(const std::vector<ScanPoint>& edges, Time scan_start,
                                            const TrajectoryKnot& k1, const TrajectoryKnot& k2) {
  std::vector<Eigen::Vector3d> out;
  for (const MapPoint& point : points_in_world(edges, scan_start, k1, k2)) out.push_back(point.p_0);
  return out;
}

}  // namespace mapless
