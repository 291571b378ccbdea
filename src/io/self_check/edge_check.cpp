#include "io/self_check/edge_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <iterator>
#include <optional>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "io/self_check/pose_mistakes.hpp"
#include "odometry/keypoints/edges.hpp"
#include "odometry/map/edge_grid.hpp"
#include <mapless/odometry/parameters.hpp>

namespace mapless::inline v1 {
namespace {

// Of the second scan, for speed; peaks grow with the square root of the number of edges.
constexpr std::size_t kMostEdges = 2000;
constexpr double kStep_m = EdgeGrid::kReach_m / 2;
// Moved by so many steps, an edge agrees with others than itself.
constexpr std::array<std::size_t, 3> kBeside = {3, 4, 5};
constexpr int kFewestSteps = kBeside.front(), kMostBeside = kBeside.back(), kSteps = 30;  // from 0.6 to 6 m
// Along the way as far as to a sensor at rest, and 2 m beyond. At rest there are edges that go with the
// sensor: where the ground leaves its range, and at the end of a wall behind a pillar.
constexpr int kBeyondRest = 10;
constexpr int kMostSteps = 80;
// Edges contradict the poses where they agree so little under them, and so much elsewhere; above kAgree they
// support them. Where they rise by more than kMovingBeside on one side, things that move are on the other
// one. Measured (docs/notebook/self_check.md, "Edges"): 90 right recordings have 3.6 and more (median 18),
// wrong poses from -16 on; of 629 below 2, all but 11 have less than 20 on the one side. People who walk on
// ahead in a bare aisle left right poses -4 and 1.7, on the one side 81 and 57. Above kSure they outvote a
// registration that stands out: poses 1.5 times too fast in a town reach 7.
constexpr double kAgreeNot = 2, kElsewhere = 5, kAgree = 5, kSure = 10, kMovingBeside = 20;
// Fewer agreeing edges, as a part of all, may agree by chance: a pole with another one. As in RecentEdges.
constexpr double kLeastElsewhere = 0.2;
// Poses that move by less have no direction: that of the sensor's x axis stands for it.
constexpr double kNoWay_m = 0.02;
// Edges that stay this near to their place in the sensor frame go with the sensor: the own vehicle. Chosen:
// the distance of two firings on it, and noise. Only poses that move by kTold_m tell it from the world.
constexpr double kStays_m = 0.1, kTold_m = kFewestSteps * kStep_m;

std::vector<ScanPoint> thinned(const std::vector<ScanPoint>& all) {
  std::vector<ScanPoint> out;
  const std::size_t stride = all.size() / kMostEdges + 1;
  for (std::size_t i = 0; i < all.size(); i += stride) out.push_back(all[i]);
  return out;
}

// Of `edges` those that are elsewhere in the sensor frame than all `others`.
std::vector<ScanPoint> without_carried_along(const std::vector<ScanPoint>& edges,
                                             const std::vector<ScanPoint>& others) {
  std::vector<Eigen::Vector3d> positions_v;
  for (const ScanPoint& o : others) positions_v.push_back(o.position_v.cast<double>());
  EdgeGrid grid;
  grid.insert(positions_v);
  std::vector<ScanPoint> out;
  std::copy_if(edges.begin(), edges.end(), std::back_inserter(out), [&](const ScanPoint& e) {
    const Eigen::Vector3d p_v = e.position_v.cast<double>();
    const Eigen::Vector3d* nearest = grid.nearest(p_v);
    return !nearest || (*nearest - p_v).norm() > kStays_m;
  });
  return out;
}

std::vector<Eigen::Vector3d> in_world(const LidarScan& scan, const std::vector<ScanPoint>& edges,
                                      const ScanPoses& poses) {
  const auto duration_ns = static_cast<double>((scan.end() - scan.start).nanoseconds());
  std::vector<Eigen::Vector3d> out;
  for (const ScanPoint& e : edges)
    out.push_back(poses.at(e.time_ns / duration_ns) * e.position_v.cast<double>());
  return out;
}

// The first is the way.
Eigen::Matrix3d axes(const SE3& from, const Eigen::Vector3d& way_0) {
  const Eigen::Vector3d along =
      way_0.norm() < kNoWay_m ? Eigen::Vector3d(from.rotation().col(0)) : way_0.normalized();
  const Eigen::Vector3d across = along.unitOrthogonal();
  Eigen::Matrix3d out;
  out << along, across, along.cross(across);
  return out;
}

// How far the agreement at `i` rises above those beside it: above their mean, and above those of the lower
// side alone. On the other side may be the peak of things that move.
struct Peak {
  double above_both = 0, above_lower = 0;
};
Peak peak_at(const std::vector<double>& agreements, std::size_t i) {
  double before = 0, behind = 0;
  for (const std::size_t steps : kBeside) {
    before += agreements[i - steps] / kBeside.size();
    behind += agreements[i + steps] / kBeside.size();
  }
  const auto above = [&](double beside) { return (agreements[i] - beside) / std::sqrt(beside + 1); };
  return {above(0.5 * (before + behind)), above(std::min(before, behind))};
}

// The edges of two scans in the world.
struct Edges {
  EdgeGrid first;
  std::vector<Eigen::Vector3d> second_0;
  Eigen::Vector3d way_0;   // between the two
  Eigen::Matrix3d axes_0;  // along which the second is moved

  // Where the second scan is moved by -steps to steps times kStep_m.
  [[nodiscard]] std::vector<double> agreements(int axis, int steps) const {
    std::vector<double> out;
    for (int step = -steps; step <= steps; ++step) {
      std::vector<Eigen::Vector3d> moved_0 = second_0;
      for (Eigen::Vector3d& p_0 : moved_0) p_0 += step * kStep_m * axes_0.col(axis);
      out.push_back(first.agreement(moved_0));
    }
    return out;
  }
  [[nodiscard]] Peak peak() const { return peak_at(agreements(0, kMostBeside), kMostBeside); }
  [[nodiscard]] double highest_elsewhere() const {
    const int to_rest = static_cast<int>(std::lround(std::min(way_0.norm() / kStep_m, 1e3)));
    double out = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const int steps = axis == 0 ? std::clamp(to_rest + kBeyondRest, kSteps, kMostSteps) : kSteps;
      const std::vector<double> all = agreements(axis, steps + kMostBeside);
      for (int step = -steps; step <= steps; ++step) {
        const bool rest = axis == 0 && std::abs(step + to_rest) < kFewestSteps;
        const auto i = static_cast<std::size_t>(steps + kMostBeside + step);
        const bool few = all[i] < kLeastElsewhere * static_cast<double>(second_0.size());
        if (std::abs(step) < kFewestSteps || rest || few) continue;
        out = std::max(out, peak_at(all, i).above_both);
      }
    }
    return out;
  }
};

// The edges at some places. They tell the motion where planes do not: along roads, and in tunnels.
class PoseEdges {
 public:
  explicit PoseEdges(const std::vector<std::shared_ptr<const Place>>& places);

  // How much better the edges of two scans agree (EdgeGrid::agreement) than where those of the second are
  // moved along the way by 0.6 to 1 m, in standard deviations of chance, as if each agreeing edge were one
  // event; the lower one of the two pairs of a place, the mean of the places. None where all places have few
  // edges, or `motion` does not cover them.
  [[nodiscard]] std::optional<Peak> peak(const Motion& motion) const;
  // The highest such peak with the second scan moved by 0.6 to 6 m along the way or across it, and along it
  // beyond where the sensor would be at rest, at most 16 m, but for rest itself; of the pair where it is
  // higher, the mean of the places.
  [[nodiscard]] double highest_elsewhere(const Motion& motion) const;

 private:
  struct Pair {
    Pair(const LidarScan& first_scan, const std::vector<ScanPoint>& edges_of_first,
         const LidarScan& second_scan);
    const LidarScan &first, &second;
    std::array<std::vector<ScanPoint>, 2> all, moved;  // of each scan; without those that go with the sensor
  };
  [[nodiscard]] static std::optional<Edges> under(const Pair& pair, const Motion& motion);

  std::vector<std::array<Pair, 2>> pairs_;  // of each place
};

PoseEdges::Pair::Pair(const LidarScan& first_scan, const std::vector<ScanPoint>& edges_of_first,
                      const LidarScan& second_scan)
    : first(first_scan), second(second_scan) {
  const std::vector<ScanPoint> edges = select_edges(second, OdometryParameters());
  all = {edges_of_first, thinned(edges)};
  moved = {without_carried_along(edges_of_first, edges),
           thinned(without_carried_along(edges, edges_of_first))};
}

PoseEdges::PoseEdges(const std::vector<std::shared_ptr<const Place>>& places) {
  for (const auto& place : places) {
    const std::vector<ScanPoint> first = select_edges(place->first, OdometryParameters());
    pairs_.push_back({Pair(place->first, first, place->next), Pair(place->first, first, place->last)});
  }
}

std::optional<Edges> PoseEdges::under(const Pair& pair, const Motion& motion) {
  const auto first = poses_of(pair.first, motion), second = poses_of(pair.second, motion);
  if (!first || !second) return std::nullopt;
  Edges out;
  out.way_0 = second->T_0v.front().translation() - first->T_0v.front().translation();
  const auto& [of_first, of_second] = out.way_0.norm() < kTold_m ? pair.all : pair.moved;
  if (std::min(of_first.size(), of_second.size()) < kMinEdges) return std::nullopt;
  out.first.insert(in_world(pair.first, of_first, *first));
  out.second_0 = in_world(pair.second, of_second, *second);
  out.axes_0 = axes(first->T_0v.front(), out.way_0);
  return out;
}

std::optional<Peak> PoseEdges::peak(const Motion& motion) const {
  Peak sum;
  double count = 0;
  for (const auto& [next, last] : pairs_) {
    const auto by_next = under(next, motion), by_last = under(last, motion);
    if (!by_next || !by_last) continue;
    const Peak a = by_next->peak(), b = by_last->peak();
    sum.above_both += std::min(a.above_both, b.above_both);
    sum.above_lower += std::min(a.above_lower, b.above_lower);
    ++count;
  }
  if (count == 0) return std::nullopt;
  return Peak{sum.above_both / count, sum.above_lower / count};
}

double PoseEdges::highest_elsewhere(const Motion& motion) const {
  double sum = 0, count = 0;
  for (const auto& [next, last] : pairs_) {
    const auto by_next = under(next, motion), by_last = under(last, motion);
    if (!by_next || !by_last) continue;
    sum += std::max(by_next->highest_elsewhere(), by_last->highest_elsewhere());
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

// The mistake under which the edges agree best.
std::string likely_mistake(const PoseEdges& edges, const std::shared_ptr<const Trajectory>& given) {
  std::string best = kOtherMistake;
  double most = kAgree;
  for (const PoseMistake& mistake : pose_mistakes(given)) {
    const double peak = edges.peak(mistake.motion).value_or(Peak{}).above_both;
    if (peak <= most) continue;
    most = peak;
    best = fmt::format("{}: by {:.1f} so", mistake.text, peak);
  }
  return best;
}

}  // namespace

EdgeFinding check_edges(const std::vector<std::shared_ptr<const Place>>& places,
                        const std::shared_ptr<const Trajectory>& given) {
  const PoseEdges edges(places);
  const Motion said = motion_of(given);
  const auto peak = edges.peak(said);
  if (!peak) return {};
  EdgeFinding out{peak->above_both > kAgree, peak->above_both > kSure,
                  fmt::format("edges agree by {:.1f} standard deviations", peak->above_both), ""};
  if (peak->above_both > kAgreeNot || peak->above_lower > kMovingBeside) return out;
  const double elsewhere = edges.highest_elsewhere(said);
  if (elsewhere < kElsewhere) return out;
  out.problem = fmt::format(
      "the edges of poles, trees and buildings agree under the poses by {:.1f} standard deviations, and by "
      "{:.1f} elsewhere: {}",
      peak->above_both, elsewhere, likely_mistake(edges, given));
  return out;
}

}  // namespace mapless
