#pragma once

#include <nanobind/nanobind.h>

namespace mapless::python {

/// mapless._core.Detector, LabelledScan and MovingObject.
void bind_detector(nanobind::module_& m);

}  // namespace mapless::python
