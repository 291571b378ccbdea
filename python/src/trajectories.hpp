#pragma once

#include <memory>
#include <vector>

#include <nanobind/nanobind.h>

#include <mapless/core/se3.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::python {

namespace nb = nanobind;

/// mapless.Trajectory.
struct TrajectoryHandle {
  std::shared_ptr<const Trajectory> trajectory;
};

/// A pose as a NumPy array of shape (4, 4).
[[nodiscard]] nb::object matrix_of(const SE3& pose);
/// The trajectory of an argument; null for None.
[[nodiscard]] std::shared_ptr<const Trajectory> trajectory_of(const TrajectoryHandle* argument);

void bind_trajectory(nb::module_& m);

}  // namespace mapless::python
