#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace mapless::inline v1 {

/// Files of `folder` with names NUMBER + `extension` (".bin"), by number; other files are ignored. Throws
/// InputError for a number that occurs twice, a pipe or device, and a folder that cannot be read.
[[nodiscard]] std::map<int, std::filesystem::path> numbered_files(const std::filesystem::path& folder,
                                                                  const std::string& extension);

/// The numbers missing between the first and the last key, as text: "177 to 180, 190".
[[nodiscard]] std::string missing_numbers(const std::map<int, std::filesystem::path>& files);

}  // namespace mapless
