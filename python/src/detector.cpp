#include "detector.hpp"

#include <mutex>

#include <Eigen/Core>
#include <nanobind/ndarray.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "arrays.hpp"
#include "cloud_sources.hpp"
#include "live_detector.hpp"
#include "recordings.hpp"
#include "trajectories.hpp"

namespace mapless::python {
namespace {

// A detector that refuses a second call while one is running, which the GIL does not keep out.
struct DetectorHandle {
  LiveDetector live;
  std::mutex in_use;

  template <class... Arguments>
  explicit DetectorHandle(const Arguments&... arguments) : live(arguments...) {}

  template <class Call>
  auto call(Call&& run) {
    const std::unique_lock lock(in_use, std::try_to_lock);
    if (!lock) throw std::runtime_error("the detector is in use on another thread; make one call at a time");
    const nb::gil_scoped_release released;
    return run(live);
  }
};

template <class Number>
nb::object view(nb::handle owner, const std::vector<Number>& numbers) {
  return nb::ndarray<nb::numpy, const Number>(numbers.data(), {numbers.size()}, owner).cast();
}

nb::object array_of(const Eigen::Vector3d& v) {
  return owned_array(std::vector<double>(v.data(), v.data() + 3));
}

void bind_object(nb::module_& m) {
  constexpr const char* kVector = "numpy.typing.NDArray[numpy.float64]";
  const auto signature = [&](const char* name) {
    return std::string("def ") + name + "(self, /) -> " + kVector;
  };
  auto object = nb::class_<TrackedObject>(
      m, "MovingObject", "A moving object in one scan, in the world frame of the trajectory.");
  object.def_ro("id", &TrackedObject::id, "1, 2, ...: kept over scans, never used again")
      .def_prop_ro(
          "stamp_ns", [](const TrackedObject& o) { return o.time.nanoseconds(); },
          "mean instant of its points, at which centre and velocity hold")
      .def_ro("points", &TrackedObject::points, "number of its points")
      .def_ro("age", &TrackedObject::age, "scans since its track began");
  const auto vector = [&](const char* name, const Eigen::Vector3d TrackedObject::*member, const char* help) {
    object.def_prop_ro(
        name, [member](const TrackedObject& o) { return array_of(o.*member); }, help,
        nb::for_getter(nb::sig(signature(name).c_str())));
  };
  vector("centre", &TrackedObject::centre_0, "centre of the box of its points [m], (3,)");
  vector("extent", &TrackedObject::extent_0, "sides of that box along the axes of the world [m], (3,)");
  vector("velocity", &TrackedObject::velocity_0, "[m/s], (3,)");
  object.def_prop_ro(
      "velocity_covariance",
      [](const TrackedObject& o) {
        const auto& c = o.velocity_covariance_0;  // symmetric: the order of storage does not matter
        return owned_array(std::vector<double>(c.data(), c.data() + 9), {3, 3});
      },
      "[m^2/s^2], (3, 3)", nb::for_getter(nb::sig(signature("velocity_covariance").c_str())));
}

void bind_found(nb::module_& m) {
  nb::class_<FoundScan>(m, "LabelledScan",
                        "The labels of one scan: one number per point that was pushed, in its order. Rows\n"
                        "without a return (NaN) have label 0 and do not move. Keeps its own memory.")
      .def_ro("scan", &FoundScan::scan, "number of the scan among those pushed, from 0")
      .def_ro("stamp_ns", &FoundScan::stamp_ns, "instant of its first ray")
      .def_prop_ro(
          "label", [](nb::handle self) { return view(self, nb::cast<FoundScan&>(self).label); },
          "(N,) uint32: 251 moving, 9 static, 0 no return; the high 16 bits number the object",
          nb::for_getter(nb::sig("def label(self, /) -> numpy.typing.NDArray[numpy.uint32]")))
      .def_prop_ro(
          "object", [](nb::handle self) { return view(self, nb::cast<FoundScan&>(self).object); },
          "(N,) uint32: id of the moving object that the point belongs to; 0: none",
          nb::for_getter(nb::sig("def object(self, /) -> numpy.typing.NDArray[numpy.uint32]")))
      .def_prop_ro(
          "stages", [](nb::handle self) { return view(self, nb::cast<FoundScan&>(self).stages); },
          "(N,) uint8: bit s is 1 where the point was dynamic after stage s of the method",
          nb::for_getter(nb::sig("def stages(self, /) -> numpy.typing.NDArray[numpy.uint8]")))
      .def_prop_ro(
          "probability", [](nb::handle self) { return view(self, nb::cast<FoundScan&>(self).probability); },
          "(N,) float32: probability that the point moves; NaN where it is not known: without a return, "
          "where\n"
          "the motion is lost, and with the published method",
          nb::for_getter(nb::sig("def probability(self, /) -> numpy.typing.NDArray[numpy.float32]")))
      .def_prop_ro(
          "moving",
          [](const FoundScan& f) {
            std::vector<std::uint8_t> moving(f.object.size());
            for (std::size_t i = 0; i < moving.size(); ++i) moving[i] = f.object[i] != 0 ? 1 : 0;
            return owned_array(std::move(moving)).attr("view")("bool");
          },
          "(N,) bool", nb::for_getter(nb::sig("def moving(self, /) -> numpy.typing.NDArray[numpy.bool_]")))
      .def_ro("objects", &FoundScan::objects, "the moving objects of the scan", nb::rv_policy::copy)
      .def_prop_ro(
          "pose", [](const FoundScan& f) { return matrix_of(f.T_0v); },
          "world from sensor at stamp_ns, (4, 4)",
          nb::for_getter(nb::sig("def pose(self, /) -> numpy.typing.NDArray[numpy.float64]")))
      .def_prop_ro(
          "trajectory", [](const FoundScan& f) { return TrajectoryHandle{f.trajectory}; },
          "the motion of the sensor, during the scan too")
      .def_prop_ro(
          "motion_state", [](const FoundScan& f) { return std::string(name_of(f.motion_state)); },
          "how far the motion can be relied on: good, degenerate (a direction is uncertain), or lost (no "
          "motion;\n"
          "every label is 0)",
          nb::for_getter(
              nb::sig("def motion_state(self, /) -> typing.Literal['good', 'degenerate', 'lost']")))
      .def_ro("trouble", &FoundScan::trouble, "what limits the estimate of the motion; empty: nothing");
}

}  // namespace

void bind_detector(nb::module_& m) {
  bind_object(m);
  bind_found(m);
  nb::class_<DetectorHandle>(m, "Detector")
      .def(nb::init<std::string, std::optional<double>, std::string, std::map<std::string, std::string>>(),
           nb::arg("sensor"), nb::arg("rotation_rate_hz").none(), nb::arg("profile"), nb::arg("settings"))
      .def_prop_ro("keeps_clouds", [](const DetectorHandle& d) { return d.live.keeps_clouds(); })
      .def_prop_ro("latency", [](const DetectorHandle& d) { return d.live.latency(); })
      .def_prop_ro("sensor", [](const DetectorHandle& d) { return d.live.sensor(); })
      .def_prop_ro("notes", [](const DetectorHandle& d) { return d.live.notes(); })
      .def_prop_ro("odometry_trouble", [](const DetectorHandle& d) { return d.live.odometry_trouble(); })
      .def(
          "push_cloud",
          [](DetectorHandle& d, const nb::tuple& fields, const TrajectoryHandle* given) {
            Cloud cloud = cloud_of(fields);
            return d.call([&](LiveDetector& live) { return live.push(cloud, trajectory_of(given)); });
          },
          nb::arg("fields"), nb::arg("trajectory").none(),
          nb::sig("def push_cloud(self, fields: tuple[object, ...], trajectory: Trajectory | None) -> "
                  "list[LabelledScan]"))
      .def(
          "push_scan",
          [](DetectorHandle& d, const ScanHandle& scan, const TrajectoryHandle* given) {
            return d.call([&](LiveDetector& live) { return live.push(scan.scan, trajectory_of(given)); });
          },
          nb::arg("scan"), nb::arg("trajectory").none())
      .def(
          "add_measurement",
          [](DetectorHandle& d, const nb::tuple& measurement) {
            const MotionMeasurement measured = measurement_of(measurement);
            d.call([&](LiveDetector& live) { live.add_measurement(measured); });
          },
          nb::arg("measurement"),
          nb::sig("def add_measurement(self, measurement: tuple[object, ...]) -> None"))
      .def("take_doubts",
           [](DetectorHandle& d) { return d.call([](LiveDetector& live) { return live.take_doubts(); }); })
      .def("flush",
           [](DetectorHandle& d) { return d.call([](LiveDetector& live) { return live.flush(); }); });
}

}  // namespace mapless::python
