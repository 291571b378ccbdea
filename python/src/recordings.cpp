#include "recordings.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "arrays.hpp"
#include "cloud_sources.hpp"
#include "trajectories.hpp"
#include <mapless/io/dataset.hpp>

namespace mapless::python {
namespace {

// NaN for records without a return.
nb::object points_of(const ScanHandle& handle) {
  const LidarScan& scan = *handle.scan;
  std::vector<float> points(3 * scan.input_size, std::numeric_limits<float>::quiet_NaN());
  for (const LidarReturn& r : scan.returns) {
    for (int axis = 0; axis < 3; ++axis)
      points[3 * r.input_index + static_cast<std::size_t>(axis)] = r.position_v[axis];
  }
  return owned_array(std::move(points), {scan.input_size, 3});
}

// Since the start of the scan; NaN for records without a return.
nb::object times_of(const ScanHandle& handle) {
  const LidarScan& scan = *handle.scan;
  std::vector<double> times(scan.input_size, std::numeric_limits<double>::quiet_NaN());
  for (const LidarReturn& r : scan.returns) times[r.input_index] = 1e-9 * r.time_ns;
  return owned_array(std::move(times));
}

// 0 for records without a return.
nb::object rings_of(const ScanHandle& handle) {
  const LidarScan& scan = *handle.scan;
  std::vector<std::uint16_t> rings(scan.input_size, 0);
  for (const LidarReturn& r : scan.returns) rings[r.input_index] = static_cast<std::uint16_t>(r.laser);
  return owned_array(std::move(rings));
}

std::optional<TrajectoryHandle> trajectory_of_recording(const RecordingHandle& r) {
  auto trajectory = r.dataset->trajectory();
  if (!trajectory) return std::nullopt;
  return TrajectoryHandle{std::move(trajectory)};
}

RecordingHandle open_folder(const std::string& path, const std::string& format, const std::string& sensor) {
  DatasetOptions options;
  options.format = format;
  options.sensor = sensor;
  const nb::gil_scoped_release released;
  return {open_dataset(path, options)};
}

RecordingHandle recording_of(const nb::object& source, const std::string& sensor) {
  auto clouds = cloud_source_of(source);
  const nb::gil_scoped_release released;
  return {make_cloud_dataset(std::move(clouds), sensor)};
}

ScanHandle read_scan(const RecordingHandle& r, std::size_t k) {
  const nb::gil_scoped_release released;
  return {std::make_shared<const LidarScan>(r.dataset->read(k))};
}

void bind_scan(nb::module_& m) {
  nb::class_<ScanHandle>(m, "MeasuredScan",
                         "A scan with the columns and empty rays that its recording holds.")
      .def("__len__", [](const ScanHandle& s) { return s.scan->input_size; })
      .def_prop_ro("stamp_ns", [](const ScanHandle& s) { return s.scan->start.nanoseconds(); })
      .def("points", points_of, nb::sig("def points(self) -> numpy.typing.NDArray[numpy.float32]"))
      .def("time_s", times_of, nb::sig("def time_s(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def("ring", rings_of, nb::sig("def ring(self) -> numpy.typing.NDArray[numpy.uint16]"));
}

}  // namespace

void bind_recordings(nb::module_& m) {
  bind_scan(m);
  nb::class_<RecordingHandle>(m, "Recording", "A recording opened by the C++ library.")
      .def("__len__", [](const RecordingHandle& r) { return r.dataset->size(); })
      .def_prop_ro("format", [](const RecordingHandle& r) { return r.dataset->format(); })
      .def_prop_ro("sensor", [](const RecordingHandle& r) { return r.dataset->model()->name; })
      .def_prop_ro("notes", [](const RecordingHandle& r) { return r.dataset->notes(); })
      .def_prop_ro("trajectory", trajectory_of_recording)
      .def_prop_ro(
          "measurements", [](const RecordingHandle& r) { return measurements_of(r.dataset->measurements()); },
          nb::for_getter(nb::sig("def measurements(self) -> list[tuple[int, tuple[float, float, float] | "
                                 "None, float]]")))
      .def(
          "start_ns",
          [](const RecordingHandle& r, std::size_t k) { return r.dataset->scan_start(k).nanoseconds(); },
          nb::arg("k"))
      .def(
          "labels",
          [](const RecordingHandle& r, std::size_t k) -> nb::object {
            auto labels = r.dataset->read_labels(k);
            return labels ? owned_array(std::move(*labels)) : nb::none();
          },
          nb::arg("k"), nb::sig("def labels(self, k: int) -> numpy.typing.NDArray[numpy.uint32] | None"))
      .def("read", read_scan, nb::arg("k"));
  m.def("open_folder", open_folder, nb::arg("path"), nb::arg("format") = "", nb::arg("sensor") = "");
  m.def(
      "recognised_formats", [](const std::string& path) { return recognised_formats(path); }, nb::arg("path"),
      "Names of the formats of the C++ library whose files the folder holds, found by their names alone.");
  m.def("recording_of", recording_of, nb::arg("source"), nb::arg("sensor") = "",
        "A recording that Python reads: `source` has the members of mapless.CloudSource.");
}

}  // namespace mapless::python
