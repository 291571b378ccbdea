#pragma once

#include <memory>

#include <nanobind/nanobind.h>

#include <mapless/io/dataset.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::python {

namespace nb = nanobind;

/// mapless._core.Recording.
struct RecordingHandle {
  std::shared_ptr<const Dataset> dataset;
};

/// mapless._core.MeasuredScan: a scan as the C++ readers give it.
struct ScanHandle {
  std::shared_ptr<const LidarScan> scan;
};

void bind_recordings(nb::module_& m);

}  // namespace mapless::python
