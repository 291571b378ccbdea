#include "odometry/registration/recent_edges.hpp"

#include <algorithm>
#include <utility>

#include "odometry/map/edge_grid.hpp"

namespace mapless::inline v1 {
namespace {

// Edges contradict the motion if elsewhere they agree this many times better. Measured: of 19 windows of four
// scans that err by over .5 m all do, of 2,963 that err by less than .2 m one (tunnels and tilted sensors;
// docs/notebook/odometry.md, "Edges against the motion"). Edges that go with the sensor (the end of a wall
// behind a pillar) agree up to 3.7 times better at rest although the motion is right.
constexpr double kTimesBetter = 4;
// Fewer agreeing edges, as a part of all, may agree by chance. Measured: wrong motions have .25 and more.
constexpr double kLeastElsewhere = 0.2;
// The moves that are tried, either way: from what is no error of the estimate to 10 m/s at 10 Hz, in steps of
// half the reach of an edge.
constexpr double kFirstMove_m = 0.3;
constexpr double kMoveStep_m = EdgeGrid::kReach_m / 2;
constexpr double kMostMove_m = 4;

std::vector<Eigen::Vector3d> moved(std::vector<Eigen::Vector3d> points_0, const Eigen::Vector3d& by_0) {
  for (Eigen::Vector3d& p_0 : points_0) p_0 += by_0;
  return points_0;
}

}  // namespace

void RecentEdges::add(std::vector<Eigen::Vector3d> edges_0) {
  scans_.push_back(std::move(edges_0));
  if (scans_.size() > kGap + 1) scans_.pop_front();
}

std::optional<double> RecentEdges::agreement() const {
  if (scans_.size() < 2) return std::nullopt;
  return edge_agreement(*(scans_.end() - 2), scans_.back());
}

bool RecentEdges::contradict(const Eigen::Vector3d& direction_0) const {
  if (scans_.size() <= kGap) return false;
  const std::vector<Eigen::Vector3d>& newest = scans_.back();
  const auto agreement = edge_agreement(scans_.front(), newest);
  if (!agreement || kTimesBetter * *agreement >= 1) return false;  // nothing agrees better than by 1 an edge
  EdgeGrid earlier;
  earlier.insert(scans_.front());
  const double enough =
      std::max(kLeastElsewhere, kTimesBetter * *agreement) * static_cast<double>(newest.size());
  for (double move_m = kFirstMove_m; move_m <= kMostMove_m; move_m += kMoveStep_m) {
    for (const double sign : {1., -1.}) {
      if (earlier.agreement(moved(newest, sign * move_m * direction_0)) > enough) return true;
    }
  }
  return false;
}

}  // namespace mapless
