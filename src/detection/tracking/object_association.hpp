#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "detection/tracking/object_snapshot.hpp"

namespace mapless::inline v1 {

/// Where a known object is expected in the next scan: its last points, moved there.
struct PredictedObject {
  std::vector<Eigen::Vector3d> points_0;  ///< thinned: each stands for `weight` points
  double weight = 1;
  Eigen::AlignedBox3d box;
  double uncertainty_m = 0;  ///< standard deviation of the place
  double hidden_m = 0;       ///< half of what was once seen of it and is not now
};

/// `view` moved by `displacement_0`, every point the same way: the next scan comes to an object about as far
/// into its turn as the last one did, so that both are smeared alike. `out`, whatever it was, keeps its
/// memory.
void expect(const ObjectSnapshot& view, const Eigen::Vector3d& displacement_0, double uncertainty_m,
            PredictedObject& out);

/// For each seen object, which known one it is, if any, and which one most of it came from.
struct Association {
  std::vector<std::optional<std::size_t>> known;   ///< by seen object; no known one twice
  std::vector<std::optional<std::size_t>> parent;  ///< of the unassociated: a known one it overlaps
};

/// The pair with the most points in common is associated first, then the next, ties to the lowest indices;
/// where nothing overlaps, the nearest middles within what the uncertainty allows.
[[nodiscard]] Association associate(std::span<const PredictedObject> known,
                                    std::span<const PredictedObject> seen);

}  // namespace mapless
