#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <optional>
#include <system_error>

#include <fmt/format.h>
#include <unistd.h>

#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;

// As LabelAlignment: labels of these very scans have none misplaced, those of others 5 % and more.
constexpr double kMostMisplaced = 0.01;

std::string scan_name(std::size_t scan, const char* extension) {
  return fmt::format("{:06}{}", scan, extension);
}

std::optional<std::size_t> scan_of_name(const fs::path& file, const char* extension) {
  if (file.extension() != extension) return std::nullopt;
  const std::string stem = file.stem().string();
  std::size_t scan = 0;
  const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), scan);
  if (error != std::errc() || end != stem.data() + stem.size()) return std::nullopt;
  // Only the name we would write ourselves: 7.label and 000007.label must not be one scan.
  return file.filename() == scan_name(scan, extension) ? std::optional(scan) : std::nullopt;
}

[[noreturn]] void refuse(const fs::path& path, const std::string& problem, const std::string& remedy) {
  throw OutputError({path.string(), "output folder", "", problem, remedy});
}

void check(const fs::path& path, const std::error_code& error, const char* what) {
  if (!error) return;
  throw_write_error({path.string(), "output folder", "", fmt::format("cannot {}: {}", what, error.message()),
                     "choose a folder you may write to"},
                    error);
}

bool begins_with(const fs::path& file, std::string_view text) {
  std::ifstream stream(file, std::ios::binary);
  std::string begin(text.size(), '\0');
  stream.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return stream && begin == text;
}

// A run that was killed before its first file may have left its lock and a part of its summary.
bool is_empty_folder(const fs::path& path) {
  const std::string partial_summary = fmt::format(".summary.json{}", kPartialMark);
  std::error_code error;
  bool empty = true;
  for (fs::directory_iterator it(path, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    empty = empty && (name == kLockFile || name.starts_with(partial_summary));
  }
  check(path, error, "look into it");
  return empty;
}

// An earlier result is left as it is where not all of it can be replaced.
void require_writable(const fs::path& folder) {
  if (!fs::is_directory(folder) || access(folder.c_str(), W_OK | X_OK) == 0) return;
  refuse(folder, std::string("cannot be written into: ") + std::strerror(errno),
         "choose a folder you may write to");
}

void remove_scan_files(const fs::path& folder, const char* extension) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) return;
  std::vector<fs::path> files;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (scan_of_name(it->path(), extension)) files.push_back(it->path());
  }
  check(folder, error, "list it");
  for (const fs::path& file : files) {
    fs::remove(file, error);
    check(file, error, "remove it");
  }
}

}  // namespace

fs::path ResultFolder::label_file(std::size_t scan) const { return labels() / scan_name(scan, ".label"); }
fs::path ResultFolder::stage_file(std::size_t scan) const { return stages() / scan_name(scan, ".stages"); }
fs::path ResultFolder::probability_file(std::size_t scan) const {
  return probabilities() / scan_name(scan, ".f32");
}

void ResultFolder::require_free(bool overwrite, std::string_view summary_begin) const {
  std::error_code error;
  const fs::file_status status = fs::status(path_, error);
  if (status.type() == fs::file_type::not_found) return;
  check(path_, error, "look at it");
  if (!fs::is_directory(status)) refuse(path_, "is there and not a folder", "choose another name");
  if (is_empty_folder(path_)) return;
  if (!overwrite)
    refuse(path_, "exists already", "choose another folder, or give --overwrite to replace its result");
  if (!begins_with(summary(), summary_begin)) {
    refuse(path_, "is neither empty nor the result of an earlier run: nothing in it is overwritten",
           "choose another folder");
  }
}

void ResultFolder::create(bool overwrite, std::string_view summary_text) const {
  require_free(overwrite);
  std::error_code error;
  fs::create_directories(path_, error);
  check(path_, error, "make it");
  // The new summary replaces the old one before files are removed: if the run is killed here, the folder is
  // still recognised as a result, and as an incomplete one.
  for (const fs::path& folder : {path_, labels(), stages(), probabilities()}) require_writable(folder);
  write_file_atomically(summary(), summary_text);
  remove_partial_files();
  remove_scan_files(labels(), ".label");
  remove_scan_files(stages(), ".stages");
  remove_scan_files(probabilities(), ".f32");
  if (fs::is_empty(probabilities(), error)) fs::remove(probabilities(), error);
  remove_tables();
  for (const fs::path& folder : {labels(), stages()}) {
    fs::create_directories(folder, error);
    check(folder, error, "make it");
  }
}

void ResultFolder::create_for_odometry(bool overwrite, std::string_view summary_text) const {
  require_free(overwrite, kOdometrySummaryBegin);
  std::error_code error;
  fs::create_directories(path_, error);
  check(path_, error, "make it");
  require_writable(path_);
  write_file_atomically(summary(), summary_text);
  remove_partial_files();
  remove_tables();
}

void ResultFolder::remove_tables() const {
  std::error_code error;
  for (const fs::path& file : {objects(), kitti_poses(), trajectory(), poses(), config()}) {
    fs::remove(file, error);
    check(file, error, "remove it");
  }
}

void ResultFolder::create_probabilities() const {
  std::error_code error;
  fs::create_directories(probabilities(), error);
  check(probabilities(), error, "make it");
}

void ResultFolder::remove_partial_files() const {
  std::error_code error;
  for (const fs::path& folder : {path_, labels(), stages(), probabilities()}) {
    if (!fs::is_directory(folder, error)) continue;
    std::vector<fs::path> files;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
      const std::string name = it->path().filename().string();
      if (name.starts_with('.') && name.find(kPartialMark) != std::string::npos) files.push_back(it->path());
    }
    check(folder, error, "list it");
    for (const fs::path& file : files) {
      fs::remove(file, error);
      check(file, error, "remove it");
    }
  }
}

std::vector<std::size_t> ResultFolder::labelled_scans() const {
  std::error_code error;
  std::vector<std::size_t> scans;
  for (fs::directory_iterator it(labels(), error), end; !error && it != end; it.increment(error)) {
    if (const auto scan = scan_of_name(it->path(), ".label")) scans.push_back(*scan);
  }
  if (error) {
    throw_read_error(
        {path_.string(), "labels", "", "cannot list the folder of label files: " + error.message(),
         "give a folder written by mapless detect, or one with labels/NNNNNN.label"},
        error);
  }
  std::sort(scans.begin(), scans.end());
  return scans;
}

void write_stage_file(const fs::path& file, const std::vector<std::uint8_t>& masks) {
  write_file_atomically(file, std::string(masks.begin(), masks.end()));
}

std::vector<std::uint8_t> read_stage_file(const fs::path& file, std::size_t expected_count) {
  const std::string bytes = read_whole_file(file);
  if (bytes.size() != expected_count) {
    throw InputError({file.string(), "length", fmt::format("{} bytes", bytes.size()),
                      fmt::format("must be {}, one per record of the scan", expected_count),
                      "run mapless detect again on this recording"});
  }
  return {bytes.begin(), bytes.end()};
}

void write_probability_file(const fs::path& file, const std::vector<float>& probabilities) {
  std::string bytes(probabilities.size() * sizeof(float), '\0');
  if (!probabilities.empty()) std::memcpy(bytes.data(), probabilities.data(), bytes.size());
  write_file_atomically(file, bytes);
}

std::vector<float> read_probability_file(const fs::path& file, std::size_t expected_count) {
  const std::string bytes = read_whole_file(file);
  if (bytes.size() != expected_count * sizeof(float)) {
    throw InputError({file.string(), "length", fmt::format("{} bytes", bytes.size()),
                      fmt::format("must be 4 x {}, a float32 per record of the scan", expected_count),
                      "run mapless detect --probability again on this recording"});
  }
  std::vector<float> probabilities(expected_count);
  if (expected_count > 0) std::memcpy(probabilities.data(), bytes.data(), bytes.size());
  const auto wrong = std::find_if(probabilities.begin(), probabilities.end(),
                                  [](float p) { return p < 0 || p > 1; });  // NaN: not known
  if (wrong != probabilities.end()) {
    throw InputError({file.string(), fmt::format("record {}", wrong - probabilities.begin()),
                      fmt::format("{}", *wrong), "is no probability: not from 0 to 1",
                      "run mapless detect --probability again on this recording"});
  }
  return probabilities;
}

void require_labels_of(const LidarScan& scan, const std::vector<std::uint32_t>& labels,
                       const fs::path& file) {
  const auto is_unknown = [](std::uint32_t label) { return label == kLabelUnknown; };
  if (std::all_of(labels.begin(), labels.end(), is_unknown)) return;
  std::vector<bool> has_return(labels.size(), false);
  for (const LidarReturn& r : scan.returns) has_return.at(r.input_index) = true;
  std::size_t misplaced = 0;
  for (std::size_t i = 0; i < labels.size(); ++i) misplaced += has_return[i] == is_unknown(labels[i]) ? 1 : 0;
  if (static_cast<double>(misplaced) <= kMostMisplaced * static_cast<double>(labels.size())) return;
  throw InputError(
      {file.string(), "labels", fmt::format("{} of {}", misplaced, labels.size()),
       "are at records without a return, or missing where there is one: they are of another scan",
       "give the recording this result was made from, with the same --sensor"});
}

std::vector<std::uint32_t> read_labels_of(const ResultFolder& result, std::size_t k, const LidarScan& scan) {
  const fs::path file = result.label_file(k);
  std::vector<std::uint32_t> labels = read_label_file(file, scan.input_size);
  // Labels of other programs need not leave out records without a return.
  if (fs::exists(result.summary())) require_labels_of(scan, labels, file);
  return labels;
}

}  // namespace mapless
