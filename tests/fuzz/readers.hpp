#pragma once

/// @file
/// The readers of files from outside, one by one, for fuzzing (libfuzzer.cpp, `make fuzz`) and for the replay
/// of kept and damaged files (tests/io/damaged_files_test.cpp). A reader has a right recording or table
/// around the one file that is given any bytes. What it must do with them: read them, or throw a typed error.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace mapless::fuzz {

struct Reader {
  std::string_view name;                               ///< of its folder in tests/fuzz/corpus
  std::string_view file;                               ///< the file under test, in the folder
  std::string_view dictionary;                         ///< in tests/fuzz/dictionaries
  void (*write)(const std::filesystem::path& folder);  ///< all files, right; the folder is empty
  void (*read)(const std::filesystem::path& folder);   ///< throws what the reader throws
};

[[nodiscard]] const std::vector<Reader>& readers();

/// Gives the reader's file `bytes`, and reads. The message of the library's Error that refuses them; empty
/// where they are accepted. Any other exception gets out.
std::string refusal(const Reader& reader, const std::filesystem::path& folder, std::string_view bytes);

}  // namespace mapless::fuzz
