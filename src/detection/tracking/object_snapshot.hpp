#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "detection/freespace/ray_image.hpp"
#include <mapless/core/time.hpp>
#include <mapless/detection/detection.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// A point of an object with the normal of its neighbourhood.
struct SurfaceSample {
  Eigen::Vector3d p_0;
  double t_s = 0;                                      ///< relative to ObjectSnapshot::time [s]
  Eigen::Vector3d normal_0 = Eigen::Vector3d::Zero();  ///< of the plane of its neighbours; 0 for none

  [[nodiscard]] bool is_plane() const { return !normal_0.isZero(0); }
};

/// A silhouette edge: the next ray passes the object and goes on well behind it. `across_0` is a unit vector
/// perpendicular to the ray, towards that ray; along it the edge lies within `std_m` (one sigma) of p_0.
struct EdgeSample {
  Eigen::Vector3d p_0;
  double t_s = 0;  ///< relative to ObjectSnapshot::time [s]
  Eigen::Vector3d across_0;
  double std_m = 0;
};

/// The four sides on which a silhouette edge can lie in the scan image: column before, column after, row
/// below, above.
inline constexpr std::size_t kImageSides = 4;

/// One object of one scan, in the world frame 0.
struct ObjectSnapshot {
  std::uint16_t number = 0;               ///< in Detection::object
  Time time;                              ///< mean instant of its points
  std::vector<Eigen::Vector3d> points_0;  ///< all, each at its own instant [m]
  std::vector<double> t_s;                ///< these instants, relative to `time` [s]
  Eigen::Vector3d mean_0 = Eigen::Vector3d::Zero();
  Eigen::AlignedBox3d seen_box;                            ///< of points_0
  std::vector<SurfaceSample> surface;                      ///< at most kMaxSurfaceSamples
  std::vector<EdgeSample> edges;                           ///< at most kMaxEdgeSamples, ordered by side
  std::array<std::size_t, kImageSides + 1> edges_begin{};  ///< first of each side among them, and the end
  double patch_m = 0;                    ///< radius of the neighbourhoods of the surface samples
  std::shared_ptr<const RayImage> rays;  ///< of its scan; null once released

  /// The edges of one side; only edges of the same side correspond.
  [[nodiscard]] std::span<const EdgeSample> edges_of(std::size_t side) const {
    return {edges.begin() + static_cast<std::ptrdiff_t>(edges_begin[side]),
            edges_begin[side + 1] - edges_begin[side]};
  }
  /// The box of its points, each moved with `velocity_0` [m/s] to `time`; sides along the axes of the world.
  [[nodiscard]] Eigen::AlignedBox3d box(const Eigen::Vector3d& velocity_0) const;
};

/// Chosen for the time that registration takes: a car at 10 m has some 2500 points on an HDL-64E (0.18 by
/// 0.42 degrees), which are thinned evenly.
inline constexpr std::size_t kMaxSurfaceSamples = 160;
inline constexpr std::size_t kMaxEdgeSamples = 96;

/// One snapshot for each object of a detection, by number. `trajectory` is of the sensor, `rays` of the
/// detection's scan. Throws TrajectoryDomainError.
[[nodiscard]] std::vector<ObjectSnapshot> take_snapshots(const Detection& detection,
                                                         const Trajectory& trajectory,
                                                         const std::shared_ptr<const RayImage>& rays);

}  // namespace mapless
