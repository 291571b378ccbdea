#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include <Eigen/Geometry>

#include <mapless/io/labels.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless::inline v1 {

/// True positions and velocities of the movers of a scene.
class ObjectStates {
 public:
  explicit ObjectStates(const Scene& scene);

  /// States at time `t` of the movers with at least one return in the scan, by object id.
  [[nodiscard]] std::map<std::uint32_t, ObjectState> of_visible(const SimulatedScan& scan, Time t) const;

 private:
  /// In the world frame w of the recording.
  [[nodiscard]] ObjectState state(const Mover& mover, Time t) const;

  std::vector<Mover> movers_;
  std::vector<Eigen::AlignedBox3d> shape_boxes_;
  SE3 T_w0_;
};

}  // namespace mapless
