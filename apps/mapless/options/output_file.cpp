#include "options/output_file.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include <mapless/core/errors.hpp>

namespace mapless::app {
namespace {

namespace fs = std::filesystem;

// No reader reads files with these endings, but for summary.json.
constexpr std::array<std::string_view, 2> kOfNoRecording = {".html", ".json"};
constexpr std::array<std::string_view, 6> kOfNoResult = {".html", ".json", ".png", ".pcd", ".ply", ".las"};

template <std::size_t n>
bool ends_with_one_of(const fs::path& file, const std::array<std::string_view, n>& endings) {
  return file.filename() != "summary.json" &&
         std::find(endings.begin(), endings.end(), file.extension().string()) != endings.end();
}

bool lies_within(const fs::path& file, const fs::path& folder) {
  std::error_code error;
  if (folder.empty() || !fs::exists(folder, error)) return false;
  const fs::path inner = fs::weakly_canonical(file, error), outer = fs::weakly_canonical(folder, error);
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

}  // namespace

void require_not_input(const fs::path& output, const fs::path& recording, const fs::path& result) {
  std::error_code error;
  if (!fs::is_regular_file(output, error)) return;
  const bool of_recording = lies_within(output, recording) && !ends_with_one_of(output, kOfNoRecording);
  const bool of_result = lies_within(output, result) && !ends_with_one_of(output, kOfNoResult);
  if (!of_recording && !of_result) return;
  throw ParameterError({"output", "", output.string(),
                        of_recording ? "is a file of the recording" : "is a file of the result",
                        "choose another file"});
}

}  // namespace mapless::app
