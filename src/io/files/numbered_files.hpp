#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace mapless::inline v1 {

/// Files of `folder` named NUMBER.extension, by number. Others are ignored. Throws InputError for a number
/// that occurs twice, or a folder that cannot be read.
[[nodiscard]] std::map<int, std::filesystem::path> numbered_files(const std::filesystem::path& folder,
                                                                  const std::string& extension);

/// "177 to 180, 190": runs of consecutive numbers missing between the first and the last key.
[[nodiscard]] std::string missing_numbers(const std::map<int, std::filesystem::path>& files);

}  // namespace mapless
