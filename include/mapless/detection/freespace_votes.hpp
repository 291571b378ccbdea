#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <mapless/detection/parameters.hpp>
#include <mapless/detection/ray_image.hpp>

namespace mapless {

/// A scan's points about an origin near them, so that single precision holds them to a fraction of a
/// millimetre wherever in the world they are.
struct LocalPoints {
  Eigen::Vector3d origin_0;             ///< where the sensor was at the scan's start
  std::vector<Eigen::Vector3f> points;  ///< one per return, minus origin_0 [m]
};
[[nodiscard]] LocalPoints local_points(const CompensatedScan& scan);

/// What other scans say of one point: each that saw through its place votes +1, each that saw a surface there
/// -1; those that could not look there do not vote.
struct PointVotes {
  std::int8_t earlier = 0;    ///< sum over the earlier scans
  std::int8_t later = 0;      ///< of the later scan
  bool seen_through = false;  ///< some scan did
  bool surface_seen = false;  ///< some scan did

  [[nodiscard]] int total() const { return earlier + later; }
};

/// Puts every point of a scan to the `earlier` scans and the `later` one (null: none). One element per
/// return. Point by point this is the freespace check of paper step 3; the comparison of step 2 is its
/// border answer.
[[nodiscard]] std::vector<PointVotes> collect_votes(const LidarScan& scan, const LocalPoints& points,
                                                    const std::vector<const RayImage*>& earlier,
                                                    const RayImage* later,
                                                    const VotingParameters& parameters);

}  // namespace mapless
