#pragma once

#include <nanobind/nanobind.h>

namespace mapless::python {

/// mapless._core.run_command, set_reader and parameter_table.
void bind_command(nanobind::module_& m);

}  // namespace mapless::python
