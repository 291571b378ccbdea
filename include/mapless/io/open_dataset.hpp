#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {

/// Opens a recording. Throws InputError naming the folder and what was looked for where no format, or more
/// than one, fits.
[[nodiscard]] std::unique_ptr<Dataset> open_dataset(const std::filesystem::path& path,
                                                    const DatasetOptions& options = {});

/// The formats open_dataset knows.
[[nodiscard]] const std::vector<std::string>& dataset_formats();

}  // namespace mapless
