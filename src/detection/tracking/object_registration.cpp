#include "detection/tracking/object_registration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "detection/freespace/packed_points.hpp"
#include "detection/tracking/nearest_neighbour_cache.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Standard deviation of a point from the plane of another scan: range noise of both (sqrt(2) x 0.02 m), and
// surfaces that are not quite planes.
constexpr double kPlaneStd_m = 0.035;
// Prior of the turn rate about any axis [rad/s]: a vehicle of 10 m/s on a curve of 100 m radius.
constexpr double kTurnRateStd_rps = 0.1;
// Damping of the descent: a direction that the points do not constrain stays this near to the start.
constexpr double kStartStd_mps = 3;
// Standard deviation reported for such a direction: beyond any road speed.
constexpr double kUnknownStd_mps = 50;
// Of the Cauchy weight, in standard deviations: 2.385 is 95 % efficient on Gaussian residuals.
constexpr double kCauchyScale = 2.4;

// Descent from coarse to fine. Gates: the largest distance of corresponding points, by step; the first holds
// an error of the start of 20 m/s over 0.1 s. The scale of the Cauchy weights begins at kFirstScale_m and
// halves with every step. Chosen: wider gates let a neighbouring object in, narrower ones lose the start.
constexpr std::array<double, 5> kGates_m = {2, 1, 0.7, 0.5, 0.5};
constexpr double kFirstScale_m = 0.3;
constexpr std::size_t kMinSteps = 3;         // of these
constexpr double kConverged_m = 0.005;       // a quarter of the range noise
constexpr double kMinNormalAgreement = 0.7;  // cosine of 46 degrees between the normals of one place

// Neighbouring points err alike, so this many count as one; all edges of one side count as one point, since
// the grid of the rays shifts them together. Chosen: fewer make the velocity overconfident.
constexpr double kCorrelatedPoints = 6;
// Normals err by 3 degrees: sin^2 of that is the share of its information that a plane seems to have along
// itself. Measured: without it a wall's velocity along itself seems known to 1.6 m/s in place of 3 and more.
constexpr double kNormalLeak = 0.003;
constexpr double kDisplacementFloor_m = 0.015;  // of the standard deviation: most of the range noise

// Standard deviation of the shift of the mean point: a constant, and a share of the size.
constexpr double kMeanStd_m = 0.1, kMeanStdPerSize = 0.3;
constexpr double kNoOutlier_m = 1e3;  // scale of the mean's weight: it is never an outlier

// Misfit: the share of points seen through, plus this share of the mean squared distance of points, cut off
// where it is 1. Chosen: seen through outweighs it, as it alone excludes a motion.
constexpr double kPointShare = 0.2, kPointCutoff_m = 0.5;
// A misfit beyond kExplained makes the displacement uncertain by its excess times kMaxDoubt_m, or times the
// size of a smaller object.
constexpr double kExplained = 0.12, kMaxDoubt_m = 2;

// Rays contradict a displaced sample only where they end well beyond it: distances show a wrong motion by
// less. 0.5 m is more than range noise, the shape of an object and its turn between two scans explain.
// Measured: with one laser spacing more, and a window of three columns, IoU -.002 on 30 recordings of
// HDL-64E-S2 and +.001 on 30 of VLP-16 (mapless benchmark --scenes tilted town2 flyer --seeds 2301 ... 2310).
constexpr VotingParameters kWellBeyond = [] {
  VotingParameters parameters;
  parameters.tolerance_m = 0.5;
  parameters.tolerance_spacings = 0;
  parameters.max_ray_distance_spacings = 1;  // anywhere between two lasers
  parameters.window_columns = 1;             // the nearest firing of each
  parameters.window_deg = parameters.beside_window_deg = 0;
  return parameters;
}();

struct Twist {
  Vector3d velocity_0;                      // of the centre of the earlier snapshot [m/s]
  Vector3d turn_rate_0 = Vector3d::Zero();  // about it [rad/s]
};

// H x = g for a step x of (velocity, turn rate), with Cauchy weights.
struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  double square_sum = 0, weight_sum = 0;

  // A correspondence whose residual along `direction` is `residual` [m]; `lever` is its place from the centre
  // and `dt` the time between its two points [s]. `scale` [m] widens the weight.
  void add(const Vector3d& direction, const Vector3d& lever, double dt, double residual, double std_m,
           double scale) {
    const double normalised = residual / std_m;
    const double ratio = residual / (kCauchyScale * std::max(std_m, scale));
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

// The sample of the earlier snapshot nearest to each of the later one. A thread keeps it from one
// registration to the next: nothing is allocated once it is large enough.
struct Matches {
  NearestNeighbourCache surface;
  std::array<NearestNeighbourCache, kImageSides> edges;  // by side
  std::vector<Vector3d> points;                          // of the earlier snapshot, scratch
  PackedPoints displaced;                                // samples of one snapshot, scratch
};

class Registration {
 public:
  Registration(const ObjectSnapshot& now, const ObjectSnapshot& before, Matches& matches)
      : now_(now),
        before_(before),
        centre_0_(before.seen_box.center()),
        interval_s_((now.time - before.time).seconds()),
        matches_(matches) {
    matches_.surface.reset(now.surface.size());
    for (std::size_t side = 0; side < kImageSides; ++side)
      matches_.edges[side].reset(now.edges_of(side).size());
  }

  [[nodiscard]] RegisteredMotion from(const Vector3d& start) const {
    Twist motion{start};
    for (std::size_t i = 0; i < kGates_m.size(); ++i) {
      const double scale = kFirstScale_m / static_cast<double>(1u << i);
      match(motion);
      const NormalEquations equations = linearise(motion, kGates_m[i], scale);
      const Vector6d step = solve(equations, motion, start);
      motion.velocity_0 += step.head<3>();
      motion.turn_rate_0 += step.tail<3>();
      if (i + 1 > kMinSteps && step.head<3>().norm() * interval_s_ < kConverged_m) break;
    }
    match(motion);
    const NormalEquations equations = linearise(motion, kGates_m.back(), 0);
    const double unexplained = misfit(motion);
    const double farthest = std::min(kMaxDoubt_m, before_.seen_box.diagonal().norm());
    const double doubt = farthest * std::max(0.0, unexplained - kExplained) / interval_s_;
    return {motion.velocity_0, covariance(equations) + doubt * doubt * Matrix3d::Identity(), unexplained};
  }

 private:
  [[nodiscard]] static Vector6d solve(const NormalEquations& equations, const Twist& motion,
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

  // Of the velocity, marginalised over the turn rate.
  [[nodiscard]] Matrix3d covariance(const NormalEquations& equations) const {
    const double misfit = equations.weight_sum > 0 ? equations.square_sum / equations.weight_sum : 1;
    Matrix6d H = equations.H / (kCorrelatedPoints * std::max(misfit, 1.0));
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
    const double floor = kDisplacementFloor_m / interval_s_;
    return all + floor * floor * Matrix3d::Identity();
  }

  // Where a point of `now` was at the time of `before`, relative to the centre.
  [[nodiscard]] Vector3d moved_back(const Vector3d& p_0, double t_s, const Twist& motion) const {
    const double dt = interval_s_ + t_s;
    const Vector3d moved = p_0 - centre_0_ - dt * motion.velocity_0;
    return moved - dt * motion.turn_rate_0.cross(moved);
  }

  // Nearest samples of `before` to those of `now`, moved back.
  template <class Samples>
  void match(const Samples& now, const Samples& before, const Twist& motion,
             NearestNeighbourCache& neighbours) const {
    if (now.empty()) return;
    matches_.points.clear();
    for (const auto& b : before) matches_.points.push_back(b.p_0 - centre_0_ - b.t_s * motion.velocity_0);
    neighbours.update_points(matches_.points);
    for (std::size_t i = 0; i < now.size(); ++i)
      neighbours.update_query(i, moved_back(now[i].p_0, now[i].t_s, motion));
  }
  void match(const Twist& motion) const {
    match(now_.surface, before_.surface, motion, matches_.surface);
    for (std::size_t side = 0; side < kImageSides; ++side)
      match(now_.edges_of(side), before_.edges_of(side), motion, matches_.edges[side]);
  }

  [[nodiscard]] NormalEquations linearise(const Twist& motion, double gate_m, double scale) const {
    NormalEquations out;
    add_surface(motion, gate_m, scale, out);
    add_mean(motion, out);
    for (std::size_t side = 0; side < kImageSides; ++side) {
      NormalEquations edges;
      add_edges(side, motion, gate_m, scale, edges);
      out.add(edges, std::min(1.0, kCorrelatedPoints / std::max(edges.weight_sum, 1e-9)));
    }
    return out;
  }

  // Residual of two corresponding points under the motion, and the time between them.
  struct Pair {
    Vector3d lever, residual;
    double dt;
  };
  template <class Sample>
  [[nodiscard]] Pair pair(const Sample& a, const Sample& b, const Twist& motion) const {
    const double dt = interval_s_ + a.t_s - b.t_s;
    const Vector3d lever = b.p_0 - centre_0_;
    return {lever, a.p_0 - b.p_0 - dt * (motion.velocity_0 + motion.turn_rate_0.cross(lever)), dt};
  }

  void add_surface(const Twist& motion, double gate_m, double scale, NormalEquations& out) const {
    const double farthest = std::max(gate_m, before_.patch_m);
    for (std::size_t i = 0; i < now_.surface.size(); ++i) {
      const SurfaceSample& a = now_.surface[i];
      const NearestNeighbourCache::Neighbour& n = matches_.surface.nearest(i);
      if (n.square > farthest * farthest) continue;
      const SurfaceSample& b = before_.surface[n.index];
      if (!b.is_plane()) continue;
      const Pair p = pair(a, b, motion);
      if (a.is_plane() && std::abs(a.normal_0.dot(b.normal_0)) < kMinNormalAgreement) continue;
      const double off = b.normal_0.dot(p.residual);
      if ((p.residual - off * b.normal_0).norm() > farthest) continue;
      out.add(b.normal_0, p.lever, p.dt, off, kPlaneStd_m, scale);
    }
  }

  void add_mean(const Twist& motion, NormalEquations& out) const {
    const Vector3d shift = now_.mean_0 - before_.mean_0 - interval_s_ * motion.velocity_0;
    NormalEquations mean;
    for (int axis = 0; axis < 3; ++axis)
      mean.add(Vector3d::Unit(axis), Vector3d::Zero(), interval_s_, shift[axis],
               kMeanStd_m + kMeanStdPerSize * before_.seen_box.sizes()[axis], kNoOutlier_m);
    out.H += kCorrelatedPoints * mean.H;
    out.g += kCorrelatedPoints * mean.g;
  }

  void add_edges(std::size_t side, const Twist& motion, double gate_m, double scale,
                 NormalEquations& out) const {
    const double farthest = std::max(gate_m, before_.patch_m);
    const auto now = now_.edges_of(side), before = before_.edges_of(side);
    for (std::size_t i = 0; i < now.size(); ++i) {
      const NearestNeighbourCache::Neighbour& n = matches_.edges[side].nearest(i);
      if (n.square > farthest * farthest) continue;
      const EdgeSample& a = now[i];
      const EdgeSample& b = before[n.index];
      const Pair p = pair(a, b, motion);
      out.add(a.across_0, p.lever, p.dt, a.across_0.dot(p.residual), std::hypot(a.std_m, b.std_m), scale);
    }
  }

  [[nodiscard]] double misfit(const Twist& motion) const {
    return (seen_through(now_, before_, -interval_s_ * motion.velocity_0) +
            seen_through(before_, now_, interval_s_ * motion.velocity_0)) /
               2 +
           kPointShare * mean_distance();
  }

  // Share of the points of `of`, displaced, that rays of the scan of `by` passed through.
  [[nodiscard]] double seen_through(const ObjectSnapshot& of, const ObjectSnapshot& by,
                                    const Vector3d& displacement_0) const {
    if (!by.rays) return 0;
    const FreespaceProbe probe(*by.rays, by.mean_0, kWellBeyond);
    matches_.displaced.clear();
    for (const SurfaceSample& s : of.surface)
      matches_.displaced.add((s.p_0 + displacement_0 - by.mean_0).cast<float>(), 0);
    int through = 0;
    matches_.displaced.observe(probe, [&](std::size_t, const FreespaceProbe::Answer& answer) {
      through += answer.verdict == FreespaceVerdict::inside ? 1 : 0;
    });
    return static_cast<double>(through) / static_cast<double>(of.surface.size());
  }

  // Mean squared distance of the points of `now` to those of `before`, each cut off at 1.
  [[nodiscard]] double mean_distance() const {
    double sum = 0;
    for (std::size_t i = 0; i < now_.surface.size(); ++i)
      sum += std::min(matches_.surface.nearest(i).square / (kPointCutoff_m * kPointCutoff_m), 1.0);
    return sum / static_cast<double>(now_.surface.size());
  }

  const ObjectSnapshot& now_;
  const ObjectSnapshot& before_;
  Vector3d centre_0_;
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
