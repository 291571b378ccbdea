#include <nanobind/nanobind.h>

#include "command.hpp"
#include "detector.hpp"
#include "recordings.hpp"
#include "trajectories.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::python {
namespace {

// The last one registered is tried first: the base comes before what derives from it.
void bind_errors(nb::module_& m) {
  const nb::exception<Error> base(m, "Error", PyExc_ValueError);
  nb::exception<InputError>(m, "InputError", base.ptr());
  nb::exception<ParameterError>(m, "ParameterError", base.ptr());
  nb::exception<TrajectoryDomainError>(m, "TrajectoryDomainError", base.ptr());
  nb::exception<OutputError>(m, "OutputError", base.ptr());
}

}  // namespace
}  // namespace mapless::python

NB_MODULE(_core, m) {
  m.doc() = "The C++ library of mapless, for the package mapless alone.";
  m.def("version", [] { return MAPLESS_VERSION; });
  mapless::python::bind_errors(m);
  mapless::python::bind_trajectory(m);
  mapless::python::bind_recordings(m);
  mapless::python::bind_detector(m);
  mapless::python::bind_command(m);
}
