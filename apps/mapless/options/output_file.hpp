#pragma once

#include <filesystem>

namespace mapless::app {

/// Throws ParameterError where writing `output` would replace a file of the input: any file of the folder
/// `recording` but a page (.html) or figures (.json), or any of the result `result`, which may be empty, but
/// such a file, a picture or a cloud of an earlier run. `recording` may be a file.
void require_not_input(const std::filesystem::path& output, const std::filesystem::path& recording,
                       const std::filesystem::path& result);

}  // namespace mapless::app
