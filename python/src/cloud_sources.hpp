#pragma once

#include <memory>
#include <vector>

#include <nanobind/nanobind.h>

#include <mapless/io/dataset.hpp>

namespace mapless::python {

namespace nb = nanobind;

/// What a Python exception says, as an InputError.
[[noreturn]] void rethrow_as_input_error(nb::python_error& error);

/// One cloud of Python: the tuple that mapless._fields.Fields.as_tuple makes. Keeps its arrays.
[[nodiscard]] Cloud cloud_of(nb::handle fields);

/// A mapless.Measurement of Python: stamp [ns], angular velocity [rad/s] or None, speed [m/s].
[[nodiscard]] MotionMeasurement measurement_of(nb::handle measurement);
/// List of such tuples; angular velocities and speeds alone.
[[nodiscard]] nb::object measurements_of(const std::vector<MotionMeasurement>& measurements);

/// The recording that a mapless.CloudSource of Python reads. Any thread may use and destroy it.
[[nodiscard]] std::shared_ptr<const CloudSource> cloud_source_of(nb::object source);

}  // namespace mapless::python
