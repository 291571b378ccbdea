#include "io/files/numbered_files.hpp"

#include <algorithm>
#include <optional>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "io/files/text.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {

namespace fs = std::filesystem;

namespace {

// Nine digits fit any int.
constexpr std::size_t kMaxDigits = 9;

// The number a name consists of; nothing for names with any other character.
std::optional<int> whole_number(std::string_view name) {
  if (name.empty() || name.find_first_not_of("0123456789") != std::string_view::npos) return std::nullopt;
  name.remove_prefix(std::min(name.find_first_not_of('0'), name.size() - 1));
  if (name.size() > kMaxDigits) return std::nullopt;
  return static_cast<int>(*parse_integer(name));
}

// A pipe that nobody writes to is waited for without end.
bool may_never_end(const fs::file_status& status) {
  return fs::is_fifo(status) || fs::is_socket(status) || fs::is_character_file(status);
}

}  // namespace

std::map<int, fs::path> numbered_files(const fs::path& folder, const std::string& extension) {
  std::map<int, fs::path> files;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const fs::path& file = it->path();
    if (file.extension() != extension) continue;
    const std::optional<int> number = whole_number(file.stem().string());
    if (!number) continue;
    std::error_code unknown;  // a link to nothing: reading says so
    if (may_never_end(it->status(unknown)))
      throw InputError({file.string(), "", "", "is a pipe or a device, not a file", "give a file"});
    if (!files.emplace(*number, file).second) {
      throw InputError({file.string(), "number", std::to_string(*number), "two files have this number",
                        "keep one of them"});
    }
  }
  if (error)
    throw_read_error({folder.string(), "", "", error.message(), "give a folder that can be read"}, error);
  return files;
}

std::string missing_numbers(const std::map<int, fs::path>& files) {
  std::string text;
  std::optional<int> before;
  for (const auto& [number, file] : files) {
    if (before && number > *before + 1) {
      text += text.empty() ? "" : ", ";
      text += std::to_string(*before + 1);
      if (number > *before + 2) text += fmt::format(" to {}", number - 1);
    }
    before = number;
  }
  return text;
}

}  // namespace mapless
