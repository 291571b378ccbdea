#include "detection/tracking/object_registration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "detection/tracking/nearest_neighbour_cache.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPlaneStd_m = 0.035;     // range noise of both scans, and planes that are none quite
constexpr double kTurnRateStd_rps = 0.1;  // about any axis
constexpr double kStartStd_mps = 3;       // keeps what the points do not tell near the start
constexpr double kUnknownStd_mps = 50;    // of what they do not tell, in the result
constexpr std::size_t kFewestIterations = 3;
constexpr double kRobustScale = 2.4;     // standard deviations, of the Cauchy weight
constexpr double kFirstScale_m = 0.3;    // of the weights, halved with every step
constexpr double kSmallStep_m = 0.005;   // a step by less is the last
constexpr double kLeastAgreement = 0.7;  // cosine between normals of one place
// Gates, by step: how far apart two points may be that are one.
constexpr std::array<double, 5> kGates_m = {2, 1, 0.7, 0.5, 0.5};

// Neighbouring points err alike: so many count as one. All edges of a side together count as one point, since
// the grid of the rays shifts them all the same way.
constexpr double kCorrelation = 6;
// Normals err by 3 degrees, so a plane seems to tell this share of its information along itself.
constexpr double kNormalLeak = 0.003;
constexpr double kFloor_m = 0.015;  // no displacement is better known
// The shift of the mean point: what is seen of an object changes by about so much.
constexpr double kAnyDistance_m = 1e3;  // the mean is never an outlier
constexpr double kMeanStd_m = 0.1, kMeanStdPerSize = 0.3;
// The more so where most of its outline is no edge: what hides it, or the fan of the rays, cuts it anywhere.
constexpr double kMostlyEdges = 0.6;
constexpr double kCutFactor = 2.5;

// Of the misfit: shares of distances between points, and of edges, each cut off.
constexpr double kPointShare = 0.2, kPointCutoff_m = 0.5;
constexpr double kEdgeShare = 0.5, kEdgeCutoff_m = 0.4;
// A motion that leaves more than this unexplained may be off, by so much or the size of the object for all
// that is beyond.
constexpr double kExplained = 0.12, kDoubt_m = 2;

struct Motion {
  Vector3d velocity_0;
  Vector3d turn_rate_0 = Vector3d::Zero();
};

// Of (velocity, turn rate), with robust weights.
struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  double square_sum = 0, weight_sum = 0;

  // direction . (what is left between the points) = residual.
  void add(const Vector3d& direction, const Vector3d& lever, double dt, double residual, double std_m,
           double scale) {
    const double normalised = residual / std_m;
    const double ratio = residual / (kRobustScale * std::max(std_m, scale));
    const double weight = 1 / (1 + ratio * ratio);
    Vector6d J;
    J << direction, lever.cross(direction);
    J *= dt / std_m;
    H += weight * J * J.transpose();
    g += weight * normalised * J;
    square_sum += weight * normalised * normalised;
    weight_sum += weight;
  }
  void add(const NormalEquations& other, double share) {
    H += share * other.H;
    g += share * other.g;
    square_sum += share * other.square_sum;
    weight_sum += share * other.weight_sum;
  }
};

// Which sample of the earlier view is nearest to each of the later one. A thread keeps it from one
// registration to the next: nothing is allocated once it is large enough.
struct Matches {
  NearestNeighbourCache surface;
  std::array<NearestNeighbourCache, kImageSides> edges;  // by side
  std::vector<Vector3d> points;                          // of the earlier view at work
};

class Registration {
 public:
  Registration(const ObjectSnapshot& now, const ObjectSnapshot& before, Matches& matches)
      : now_(now),
        before_(before),
        middle_0_(before.seen_box.center()),
        interval_s_((now.time - before.time).seconds()),
        matches_(matches) {
    matches_.surface.restart(now.surface.size());
    for (std::size_t side = 0; side < kImageSides; ++side)
      matches_.edges[side].restart(now.edges_of(side).size());
  }

  [[nodiscard]] RegisteredMotion from(const Vector3d& start) const {
    Motion motion{start};
    for (std::size_t i = 0; i < kGates_m.size(); ++i) {
      const double scale = kFirstScale_m / static_cast<double>(1u << i);
      match(motion);
      const NormalEquations equations = linearise(motion, kGates_m[i], scale);
      const Vector6d step = solve(equations, motion, start);
      motion.velocity_0 += step.head<3>();
      motion.turn_rate_0 += step.tail<3>();
      if (i + 1 > kFewestIterations && step.head<3>().norm() * interval_s_ < kSmallStep_m) break;
    }
    match(motion);
    const NormalEquations equations = linearise(motion, kGates_m.back(), 0);
    const double unexplained = misfit(motion);
    const double farthest = std::min(kDoubt_m, before_.seen_box.diagonal().norm());
    const double doubt = farthest * std::max(0.0, unexplained - kExplained) / interval_s_;
    return {motion.velocity_0, covariance(equations) + doubt * doubt * Matrix3d::Identity(), unexplained};
  }

 private:
  [[nodiscard]] static Vector6d solve(const NormalEquations& equations, const Motion& motion,
                                      const Vector3d& start) {
    Matrix6d H = equations.H;
    Vector6d g = equations.g;
    const double start_weight = 1 / (kStartStd_mps * kStartStd_mps);
    const double turn_weight = 1 / (kTurnRateStd_rps * kTurnRateStd_rps);
    H.diagonal().head<3>().array() += start_weight;
    H.diagonal().tail<3>().array() += turn_weight;
    g.head<3>() += start_weight * (start - motion.velocity_0);
    g.tail<3>() -= turn_weight * motion.turn_rate_0;
    return H.ldlt().solve(g);
  }

  // Of the velocity, whatever the turn rate.
  [[nodiscard]] Matrix3d covariance(const NormalEquations& equations) const {
    const double misfit = equations.weight_sum > 0 ? equations.square_sum / equations.weight_sum : 1;
    Matrix6d H = equations.H / (kCorrelation * std::max(misfit, 1.0));
    H.diagonal().tail<3>().array() += 1 / (kTurnRateStd_rps * kTurnRateStd_rps);
    const Matrix3d turn = H.bottomRightCorner<3, 3>();
    const Matrix3d mixed = H.topRightCorner<3, 3>();
    const Matrix3d known = H.topLeftCorner<3, 3>() - mixed * turn.ldlt().solve(mixed.transpose());
    const double least = 1 / (kUnknownStd_mps * kUnknownStd_mps);
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(known);
    const double leak = kNormalLeak * solver.eigenvalues()[2];
    const Vector3d information = (solver.eigenvalues().array() - leak).max(0) + least;
    const Matrix3d all =
        solver.eigenvectors() * information.cwiseInverse().asDiagonal() * solver.eigenvectors().transpose();
    const double floor = kFloor_m / interval_s_;
    return all + floor * floor * Matrix3d::Identity();
  }

  // Where a point of `now` was at the time of `before`, from the middle.
  [[nodiscard]] Vector3d taken_back(const Vector3d& p_0, double t_s, const Motion& motion) const {
    const double dt = interval_s_ + t_s;
    const Vector3d moved = p_0 - middle_0_ - dt * motion.velocity_0;
    return moved - dt * motion.turn_rate_0.cross(moved);
  }

  // Which sample of `before` is nearest to each of `now`.
  template <class Samples>
  void match(const Samples& now, const Samples& before, const Motion& motion,
             NearestNeighbourCache& neighbours) const {
    if (now.empty()) return;
    matches_.points.clear();
    for (const auto& b : before) matches_.points.push_back(b.p_0 - middle_0_ - b.t_s * motion.velocity_0);
    neighbours.move_points(matches_.points);
    for (std::size_t i = 0; i < now.size(); ++i)
      neighbours.move_place(i, taken_back(now[i].p_0, now[i].t_s, motion));
  }
  void match(const Motion& motion) const {
    match(now_.surface, before_.surface, motion, matches_.surface);
    for (std::size_t side = 0; side < kImageSides; ++side)
      match(now_.edges_of(side), before_.edges_of(side), motion, matches_.edges[side]);
  }

  [[nodiscard]] NormalEquations linearise(const Motion& motion, double gate_m, double scale) const {
    NormalEquations out;
    add_surface(motion, gate_m, scale, out);
    add_mean(motion, out);
    for (std::size_t side = 0; side < kImageSides; ++side) {
      NormalEquations edges;
      add_edges(side, motion, gate_m, scale, edges);
      out.add(edges, std::min(1.0, kCorrelation / std::max(edges.weight_sum, 1e-9)));
    }
    return out;
  }

  // What is left between two points, and the instants between them.
  struct Pair {
    Vector3d lever, left;
    double dt;
  };
  template <class Sample>
  [[nodiscard]] Pair pair(const Sample& a, const Sample& b, const Motion& motion) const {
    const double dt = interval_s_ + a.t_s - b.t_s;
    const Vector3d lever = b.p_0 - middle_0_;
    return {lever, a.p_0 - b.p_0 - dt * (motion.velocity_0 + motion.turn_rate_0.cross(lever)), dt};
  }

  void add_surface(const Motion& motion, double gate_m, double scale, NormalEquations& out) const {
    const double farthest = std::max(gate_m, before_.patch_m);
    for (std::size_t i = 0; i < now_.surface.size(); ++i) {
      const SurfaceSample& a = now_.surface[i];
      const NearestNeighbourCache::Neighbour& n = matches_.surface.of(i);
      if (n.square > farthest * farthest) continue;
      const SurfaceSample& b = before_.surface[n.index];
      if (!b.is_plane()) continue;
      const Pair p = pair(a, b, motion);
      if (a.is_plane() && std::abs(a.normal_0.dot(b.normal_0)) < kLeastAgreement) continue;
      const double off = b.normal_0.dot(p.left);
      if ((p.left - off * b.normal_0).norm() > farthest) continue;
      out.add(b.normal_0, p.lever, p.dt, off, kPlaneStd_m, scale);
    }
  }

  void add_mean(const Motion& motion, NormalEquations& out) const {
    const Vector3d left = now_.mean_0 - before_.mean_0 - interval_s_ * motion.velocity_0;
    const bool whole = std::min(now_.edge_share, before_.edge_share) > kMostlyEdges;
    const double per_size = kMeanStdPerSize * (whole ? 1 : kCutFactor);
    NormalEquations middle;
    for (int axis = 0; axis < 3; ++axis)
      middle.add(Vector3d::Unit(axis), Vector3d::Zero(), interval_s_, left[axis],
                 kMeanStd_m + per_size * before_.seen_box.sizes()[axis], kAnyDistance_m);
    out.H += kCorrelation * middle.H;
    out.g += kCorrelation * middle.g;
  }

  void add_edges(std::size_t side, const Motion& motion, double gate_m, double scale,
                 NormalEquations& out) const {
    const double farthest = std::max(gate_m, before_.patch_m);
    const auto now = now_.edges_of(side), before = before_.edges_of(side);
    for (std::size_t i = 0; i < now.size(); ++i) {
      const NearestNeighbourCache::Neighbour& n = matches_.edges[side].of(i);
      if (n.square > farthest * farthest) continue;
      const EdgeSample& a = now[i];
      const EdgeSample& b = before[n.index];
      const Pair p = pair(a, b, motion);
      out.add(a.across_0, p.lever, p.dt, a.across_0.dot(p.left), std::hypot(a.std_m, b.std_m), scale);
    }
  }

  [[nodiscard]] double misfit(const Motion& motion) const {
    return (seen_through(now_, before_, -interval_s_ * motion.velocity_0) +
            seen_through(before_, now_, interval_s_ * motion.velocity_0)) /
               2 +
           kPointShare * mean_distance() + kEdgeShare * edge_distance(motion);
  }

  // Share of the points of `of`, moved, that the scan of `by` looked through.
  [[nodiscard]] static double seen_through(const ObjectSnapshot& of, const ObjectSnapshot& by,
                                           const Vector3d& displacement_0) {
    if (!by.sight) return 0;
    int count = 0;
    for (const SurfaceSample& s : of.surface) count += by.sight->through(s.p_0 + displacement_0) ? 1 : 0;
    return static_cast<double>(count) / static_cast<double>(of.surface.size());
  }

  // Of the points of `now` from those of `before`, each cut off, 0 to 1.
  [[nodiscard]] double mean_distance() const {
    double sum = 0;
    for (std::size_t i = 0; i < now_.surface.size(); ++i)
      sum += std::min(matches_.surface.of(i).square / (kPointCutoff_m * kPointCutoff_m), 1.0);
    return sum / static_cast<double>(now_.surface.size());
  }

  // Of the edges, each less what the spacing of the rays explains and cut off, 0 to 1.
  [[nodiscard]] double edge_distance(const Motion& motion) const {
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t side = 0; side < kImageSides; ++side) {
      const auto now = now_.edges_of(side), before = before_.edges_of(side);
      if (before.empty()) continue;
      for (std::size_t i = 0; i < now.size(); ++i) {
        const EdgeSample& a = now[i];
        const EdgeSample& b = before[matches_.edges[side].of(i).index];
        const double off =
            std::max(std::abs(a.across_0.dot(pair(a, b, motion).left)) - a.std_m - b.std_m, 0.0);
        sum += std::min(off * off / (kEdgeCutoff_m * kEdgeCutoff_m), 1.0);
      }
      count += now.size();
    }
    return count == 0 ? 0 : sum / static_cast<double>(count);
  }

  const ObjectSnapshot& now_;
  const ObjectSnapshot& before_;
  Vector3d middle_0_;
  double interval_s_;
  Matches& matches_;
};

}  // namespace

RegisteredMotion register_snapshots(const ObjectSnapshot& now, const ObjectSnapshot& before,
                                    const Vector3d& start) {
  thread_local Matches matches;
  return Registration(now, before, matches).from(start);
}

}  // namespace mapless
