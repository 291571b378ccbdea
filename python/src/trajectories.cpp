#include "trajectories.hpp"

#include <cstdint>
#include <utility>

#include <Eigen/Core>
#include <nanobind/ndarray.h>

#include "arrays.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::python {
namespace {

using Stamps = nb::ndarray<nb::ro, const std::int64_t, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Poses = nb::ndarray<nb::ro, const double, nb::shape<-1, 4, 4>, nb::c_contig, nb::device::cpu>;
using RowMajorPose = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

// `poses`: world from sensor.
TrajectoryHandle sampled(const Stamps& stamps_ns, const Poses& poses, double max_extrapolation_s) {
  if (stamps_ns.shape(0) != poses.shape(0)) {
    throw ParameterError({"Trajectory", "poses", std::to_string(poses.shape(0)),
                          "not as many as stamps_ns has: " + std::to_string(stamps_ns.shape(0)),
                          "give one pose per stamp"});
  }
  std::vector<TimedPose> timed;
  for (std::size_t i = 0; i < stamps_ns.shape(0); ++i) {
    const Eigen::Matrix4d T = Eigen::Map<const RowMajorPose>(poses.data() + 16 * i);
    const SE3 T_0v(T.topLeftCorner<3, 3>(), T.topRightCorner<3, 1>());
    timed.push_back({Time::from_nanoseconds(stamps_ns(i)), T_0v.inverse()});
  }
  return {std::make_shared<SampledTrajectory>(std::move(timed), Duration::from_seconds(max_extrapolation_s),
                                              "Trajectory")};
}

}  // namespace

nb::object matrix_of(const SE3& pose) {
  std::vector<double> numbers(16);
  Eigen::Map<RowMajorPose>(numbers.data()) = pose.matrix();
  return owned_array(std::move(numbers), {4, 4});
}

std::shared_ptr<const Trajectory> trajectory_of(const TrajectoryHandle* argument) {
  return argument == nullptr ? nullptr : argument->trajectory;
}

void bind_trajectory(nb::module_& m) {
  nb::class_<TrajectoryHandle>(
      m, "Trajectory",
      "Poses of the sensor as a continuous function of time. Made from poses at given times, with constant\n"
      "velocity between two of them.")
      .def(
          "__init__",
          [](TrajectoryHandle* self, const Stamps& stamps_ns, const Poses& poses,
             double max_extrapolation_s) {
            new (self) TrajectoryHandle(sampled(stamps_ns, poses, max_extrapolation_s));
          },
          nb::arg("stamps_ns"), nb::arg("poses"), nb::arg("max_extrapolation_s") = 0.0,
          "stamps_ns: (M,) int64, increasing, M >= 2, the clock of the scans' stamps.\n"
          "poses: (M, 4, 4) float64, world from sensor.\n"
          "max_extrapolation_s: how far the first and last velocity extend beyond the ends.")
      .def_prop_ro("begin_ns", [](const TrajectoryHandle& t) { return t.trajectory->begin().nanoseconds(); })
      .def_prop_ro("end_ns", [](const TrajectoryHandle& t) { return t.trajectory->end().nanoseconds(); })
      .def(
          "pose_at",
          [](const TrajectoryHandle& t, std::int64_t stamp_ns) {
            return matrix_of(t.trajectory->at(Time::from_nanoseconds(stamp_ns)).T_v0.inverse());
          },
          nb::arg("stamp_ns"),
          nb::sig("def pose_at(self, stamp_ns: int) -> numpy.typing.NDArray[numpy.float64]"),
          "World from sensor at an instant: (4, 4). Raises TrajectoryDomainError outside [begin_ns, "
          "end_ns].");
}

}  // namespace mapless::python
