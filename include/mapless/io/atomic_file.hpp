#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace mapless::inline v1 {

/// Writes `bytes` to a file beside `file` and renames it over, so that a reader sees the old file or the
/// whole new one. A symbolic link is kept and its target replaced; what is no plain file (a folder, a device)
/// is refused. Throws OutputError (with the system's reason) and leaves nothing behind where that fails.
void write_file_atomically(const std::filesystem::path& file, std::string_view bytes);

/// Appends to a file that is there. Throws OutputError (with the system's reason) and leaves the file as it
/// was where that fails.
void append_to_file(const std::filesystem::path& file, std::string_view bytes);

/// The whole file, at most 1 GiB; of a pipe or device at most 64 MiB. Throws InputError with the reason.
[[nodiscard]] std::string read_whole_file(const std::filesystem::path& file);

}  // namespace mapless
