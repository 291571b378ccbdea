#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "detection/freespace/object_sight.hpp"
#include <mapless/core/time.hpp>
#include <mapless/detection/detection.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// A point of an object with what its neighbourhood looks like.
struct SurfaceSample {
  Eigen::Vector3d p_0;
  double t_s = 0;                                      ///< after ObjectSnapshot::time
  Eigen::Vector3d normal_0 = Eigen::Vector3d::Zero();  ///< of the plane of its neighbours; 0 for none

  [[nodiscard]] bool is_plane() const { return !normal_0.isZero(0); }
};

/// Where an object ends in the scan image and the next ray goes on behind it. `across_0` is perpendicular to
/// the ray; the end lies within `std_m` of p_0 along it.
struct EdgeSample {
  Eigen::Vector3d p_0;
  double t_s = 0;
  Eigen::Vector3d across_0;
  double std_m = 0;
};

/// Which way the next ray lies in the image: a column before, after, a row below, above.
inline constexpr std::size_t kImageSides = 4;

/// One object of one scan, in the world.
struct ObjectSnapshot {
  std::uint16_t number = 0;               ///< in Detection::object
  Time time;                              ///< mean instant of its points
  std::vector<Eigen::Vector3d> points_0;  ///< all, each where it was at its own instant
  std::vector<double> t_s;                ///< their instants, after `time`
  Eigen::Vector3d mean_0 = Eigen::Vector3d::Zero();
  Eigen::AlignedBox3d seen_box;        ///< about points_0
  std::vector<SurfaceSample> surface;  ///< at most kMostSurfaceSamples
  std::vector<EdgeSample> edges;       ///< at most kMostEdgeSamples, those of a side together
  std::array<std::size_t, kImageSides + 1> edges_begin{};  ///< of each side among them, and the end
  double edge_share = 0;                                   ///< of its outline in the image
  double patch_m = 0;                                      ///< radius of the neighbourhoods
  std::optional<SightLines> sight;                         ///< of its scan, about `time`

  /// Those of one side: edges of different sides never meet.
  [[nodiscard]] std::span<const EdgeSample> edges_of(std::size_t side) const {
    return {edges.begin() + static_cast<std::ptrdiff_t>(edges_begin[side]),
            edges_begin[side + 1] - edges_begin[side]};
  }
  /// The box about its points, moved with `velocity_0` to `time`.
  [[nodiscard]] Eigen::AlignedBox3d box(const Eigen::Vector3d& velocity_0) const;
};

inline constexpr std::size_t kMostSurfaceSamples = 160;
inline constexpr std::size_t kMostEdgeSamples = 96;

/// The objects of a detection, by number. Throws TrajectoryDomainError.
[[nodiscard]] std::vector<ObjectSnapshot> take_snapshots(const Detection& detection,
                                                         const Trajectory& trajectory);

}  // namespace mapless
