#include "io/formats/kitti/kitti_raw_dataset.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "io/files/numbered_files.hpp"
#include "io/files/text.hpp"
#include "io/formats/kitti/bare_cloud_dataset.hpp"
#include "io/formats/kitti/kitti_files.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;

// Times in a scan are 32-bit nanoseconds; a turn takes 50 to 200 ms.
constexpr double kLongestScan_s = 1;

// Every velodyne_points folder with data that `path` may mean.
std::vector<fs::path> velodyne_folders(const fs::path& path) {
  if (fs::is_directory(path / "velodyne_points" / "data")) return {path / "velodyne_points"};
  const fs::path normal = fs::absolute(path / "").lexically_normal().parent_path();
  if (normal.filename() == "velodyne_points" && fs::is_directory(path / "data")) return {path};
  std::vector<fs::path> folders;
  std::error_code error;
  for (fs::directory_iterator it(path, error), end; !error && it != end; it.increment(error)) {
    // What else lies here may be closed to us, as lost+found at the root of a disk is.
    std::error_code closed;
    if (fs::is_directory(it->path() / "velodyne_points" / "data", closed))
      folders.push_back(it->path() / "velodyne_points");
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

std::vector<std::string> read_timestamps(const fs::path& file, const std::map<int, fs::path>& clouds) {
  if (!fs::exists(file)) {
    throw InputError({file.string(), "", "", "missing: the start and end of every scan are needed",
                      "restore it from the original recording"});
  }
  std::vector<std::string> lines = read_lines(file);
  const auto needed = static_cast<std::size_t>(clouds.rbegin()->first) + 1;
  if (lines.size() < needed) {
    throw InputError({file.string(), "lines", std::to_string(lines.size()),
                      fmt::format("there are {} .bin files, the last of them {}, which needs {} lines",
                                  clouds.size(), clouds.rbegin()->second.filename().string(), needed),
                      "restore it from the original recording"});
  }
  return lines;
}

BareCloudScan make_scan(const fs::path& file, int number, const fs::path& start_file,
                        const std::string& start, const fs::path& end_file, const std::string& end) {
  BareCloudScan scan;
  scan.file = file;
  const std::string end_line = fmt::format("{}:{}", end_file.string(), number + 1);
  scan.start = parse_date_time(start, fmt::format("{}:{}", start_file.string(), number + 1));
  scan.end = parse_date_time(end, end_line);
  const double length_s = (scan.end - scan.start).seconds();
  if (length_s <= 0 || length_s > kLongestScan_s) {
    throw InputError({end_line, "time", end,
                      fmt::format("{:.6f} s after the start of the scan ({})", length_s, start),
                      fmt::format("a scan takes more than 0 and at most {} s", kLongestScan_s)});
  }
  return scan;
}

}  // namespace

bool looks_kitti_raw(const fs::path& path) { return !velodyne_folders(path).empty(); }

std::unique_ptr<Dataset> open_kitti_raw(const fs::path& path, const DatasetOptions& options) {
  const std::vector<fs::path> folders = velodyne_folders(path);
  if (folders.size() != 1) {
    throw InputError({path.string(), "drives", std::to_string(folders.size()),
                      "one folder velodyne_points/data was looked for", "give the folder of one drive"});
  }
  const fs::path& folder = folders.front();
  const std::map<int, fs::path> clouds = numbered_files(folder / "data", ".bin");
  if (clouds.empty()) {
    throw InputError(
        {(folder / "data").string(), "scans", "0", "no NNNNNNNNNN.bin files", "give a KITTI raw drive"});
  }
  const fs::path start_file = folder / "timestamps_start.txt";
  const fs::path end_file = folder / "timestamps_end.txt";
  const std::vector<std::string> starts = read_timestamps(start_file, clouds);
  const std::vector<std::string> ends = read_timestamps(end_file, clouds);

  BareCloudRecording recording;
  recording.format = "kitti-raw";
  recording.folder = folder;
  std::vector<int> numbers;
  for (const auto& [number, file] : clouds) {
    const auto line = static_cast<std::size_t>(number);
    recording.scans.push_back(make_scan(file, number, start_file, starts[line], end_file, ends[line]));
    numbers.push_back(number);
  }
  recording.notes.emplace_back(
      "times: of scans from timestamps_start.txt and timestamps_end.txt, of points from the "
      "azimuth (clockwise, seam at the rear)");
  if (const std::string gaps = missing_numbers(clouds); !gaps.empty()) {
    recording.notes.push_back("frames missing: " + gaps);
  }
  if (const auto spare = starts.size() - static_cast<std::size_t>(clouds.rbegin()->first) - 1; spare > 0) {
    recording.notes.push_back(fmt::format("timestamps without a scan after the last one: {}", spare));
  }
  find_label_files(recording, numbers, folder / ".." / "labels", options);
  return make_bare_cloud_dataset(std::move(recording), options);
}

}  // namespace mapless
