#pragma once

#include <mapless/detection/detection.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::app {

/// What the stages of a result are called, by the method in its config.yaml; those of the default method if
/// there is none. Only that line of the file is read: other versions have other keys.
[[nodiscard]] const StageNames& stage_names_of(const ResultFolder& result);

}  // namespace mapless::app
