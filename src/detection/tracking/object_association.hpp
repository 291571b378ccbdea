#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "detection/tracking/object_snapshot.hpp"

namespace mapless::inline v1 {

/// An object at its predicted position in the next scan.
struct PredictedObject {
  std::vector<Eigen::Vector3d> points_0;  ///< thinned: each represents `weight` points
  double weight = 1;
  Eigen::AlignedBox3d box;
  double uncertainty_m = 0;  ///< standard deviation of the position
  double hidden_m = 0;       ///< half of the extent that was seen before and is not now
};

/// Sets `out` to `snapshot` moved by `displacement_0`; its memory is kept. Every point is moved alike, as the
/// sensor reaches an object at about the same part of every turn, so that both scans are distorted alike.
void predict(const ObjectSnapshot& snapshot, const Eigen::Vector3d& displacement_0, double uncertainty_m,
             PredictedObject& out);

struct Association {
  std::vector<std::optional<std::size_t>> known;   ///< by seen object: the track it continues; none twice
  std::vector<std::optional<std::size_t>> parent;  ///< by seen object without one: a track that it overlaps
};

/// Associates tracks (`known`, predicted) with the objects of a scan (`seen`), one to one: pairs by the
/// number of points they share, most first, ties to the lowest indices; then those left by the distance of
/// their centres, within what uncertainty and hidden extent allow.
[[nodiscard]] Association associate(std::span<const PredictedObject> known,
                                    std::span<const PredictedObject> seen);

}  // namespace mapless
