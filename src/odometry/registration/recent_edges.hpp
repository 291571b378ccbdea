#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace mapless::inline v1 {

/// The edges of the last scans (select_edges), in the world along the estimated motion. Where planes hardly
/// fix a direction, the map repeats the motion that made it, right or wrong: the lines of a laser on a wall
/// fall on those of the scan before. Edges do not.
class RecentEdges {
 public:
  /// The edges of a scan are compared with those of this many scans before. Chosen: a speed wrong by 1 m/s
  /// moves them by .4 m, the reach of an edge, at 10 Hz.
  static constexpr std::size_t kGap = 4;

  /// Adds the next scan.
  void add(std::vector<Eigen::Vector3d> edges_0);
  void clear() { scans_.clear(); }
  [[nodiscard]] bool empty() const { return scans_.empty(); }

  /// edge_agreement() of the newest scan with the one before. None without both, or with few edges.
  [[nodiscard]] std::optional<double> agreement() const;
  /// Whether the newest scan, moved along `direction_0` (of unit length), agrees far better with the scan
  /// kGap before than where it is. False without both, or with few edges.
  [[nodiscard]] bool contradict(const Eigen::Vector3d& direction_0) const;

 private:
  std::deque<std::vector<Eigen::Vector3d>> scans_;  // at most kGap + 1
};

}  // namespace mapless
