#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include <Eigen/Geometry>

#include <mapless/io/object_truth.hpp>
#include <mapless/simulation/scene.hpp>
#include <mapless/simulation/simulated_sensor.hpp>

namespace mapless::inline v1 {

/// Where the movers of a scene are, and how fast, for those a scan shows.
class ObjectStates {
 public:
  explicit ObjectStates(const Scene& scene);

  /// At `t`, of the movers that have a return in the scan, by object id.
  [[nodiscard]] std::map<std::uint32_t, ObjectState> of_seen(const SimulatedScan& scan, Time t) const;

 private:
  /// In the world frame that is told. The velocity is taken over 0.4 ms.
  [[nodiscard]] ObjectState state(const Mover& mover, Time t) const;

  std::vector<Mover> movers_;
  std::vector<Eigen::AlignedBox3d> shape_boxes_;
  SE3 T_w0_;
};

}  // namespace mapless
