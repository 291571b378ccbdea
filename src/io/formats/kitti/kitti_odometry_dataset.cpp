#include "io/formats/kitti/kitti_odometry_dataset.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "io/files/numbered_files.hpp"
#include "io/files/text.hpp"
#include "io/formats/kitti/bare_cloud_dataset.hpp"
#include "io/formats/kitti/kitti_calibration.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;

// Duration of a turn of a recording of one scan: that of an HDL-64E at 10 Hz.
constexpr double kUsualTurn_s = 0.1;
// Longer periods between scans are gaps of the recording, not turns.
constexpr double kLongestTurn_s = 1;

std::vector<Time> read_times(const fs::path& file, const std::map<int, fs::path>& clouds) {
  if (!fs::exists(file)) {
    throw InputError({file.string(), "", "", "missing: the time of every scan is needed",
                      "restore it from the original recording"});
  }
  const std::vector<std::string> lines = read_lines(file);
  std::vector<Time> times;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::optional<Time> time = parse_decimal_seconds(lines[i]);
    if (!time) {
      throw InputError({fmt::format("{}:{}", file.string(), i + 1), "time", lines[i], "not a time in seconds",
                        "restore the line from the original recording"});
    }
    times.push_back(*time);
  }
  const auto needed = static_cast<std::size_t>(clouds.rbegin()->first) + 1;
  if (times.size() < needed) {
    throw InputError({file.string(), "lines", std::to_string(times.size()),
                      fmt::format("there are {} .bin files, the last of them {}, which needs {} lines",
                                  clouds.size(), clouds.rbegin()->second.filename().string(), needed),
                      "restore it from the original recording"});
  }
  return times;
}

Duration median_period(const std::vector<Time>& times, const fs::path& file) {
  if (times.size() < 2) return Duration::from_seconds(kUsualTurn_s);
  std::vector<Duration> periods;
  for (std::size_t i = 1; i < times.size(); ++i) periods.push_back(times[i] - times[i - 1]);
  const auto middle = periods.begin() + static_cast<std::ptrdiff_t>(periods.size() / 2);
  std::nth_element(periods.begin(), middle, periods.end());
  if (middle->seconds() <= 0 || middle->seconds() > kLongestTurn_s) {
    throw InputError({file.string(), "median step", fmt::format("{} s", middle->seconds()),
                      fmt::format("a turn takes more than 0 and at most {} s", kLongestTurn_s),
                      "restore it from the original recording"});
  }
  return *middle;
}

std::optional<fs::path> poses_file(const fs::path& sequence) {
  if (fs::exists(sequence / "poses.txt")) return sequence / "poses.txt";
  const fs::path normal = fs::absolute(sequence / "").lexically_normal().parent_path();
  const fs::path beside =
      normal.parent_path().parent_path() / "poses" / (normal.filename().string() + ".txt");
  if (fs::exists(beside)) return beside;
  return std::nullopt;
}

// Poses come one per line of times.txt, and have no times of their own.
void require_increasing(const std::vector<Time>& times, const fs::path& file) {
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (times[i] > times[i - 1]) continue;
    throw InputError({fmt::format("{}:{}", file.string(), i + 1), "time", decimal_seconds(times[i]) + " s",
                      fmt::format("not after the line before ({} s)", decimal_seconds(times[i - 1])),
                      "restore the line from the original recording"});
  }
}

void add_trajectory(const fs::path& sequence, const std::vector<Time>& times, Duration turn,
                    BareCloudRecording& recording) {
  const std::optional<fs::path> poses = poses_file(sequence);
  if (!poses || times.size() < 2) {
    recording.notes.emplace_back("trajectory: none (no poses.txt, nor ../../poses/NN.txt)");
    return;
  }
  require_increasing(times, sequence / "times.txt");
  TrajectoryFileOptions options;
  options.T_file_sensor = read_kitti_calibration(sequence / "calib.txt");
  options.row_times = times;
  options.max_extrapolation = turn;
  recording.trajectory = std::make_shared<const SampledTrajectory>(read_trajectory_file(*poses, options));
  recording.notes.push_back(
      fmt::format("trajectory: {}, of camera 0, taken to the sensor with Tr of calib.txt", poses->string()));
}

}  // namespace

bool looks_kitti_odometry(const fs::path& path) {
  const fs::path folder = path / "velodyne";
  return fs::is_directory(folder) && !numbered_files(folder, ".bin").empty();
}

std::unique_ptr<Dataset> open_kitti_odometry(const fs::path& path, const DatasetOptions& options) {
  if (!fs::is_directory(path / "velodyne")) {
    throw InputError({path.string(), "folder", "velodyne", "missing", "give a folder sequences/NN"});
  }
  const std::map<int, fs::path> clouds = numbered_files(path / "velodyne", ".bin");
  if (clouds.empty()) {
    throw InputError(
        {(path / "velodyne").string(), "scans", "0", "no NNNNNN.bin files", "give a folder sequences/NN"});
  }
  const std::vector<Time> times = read_times(path / "times.txt", clouds);
  const Duration turn = median_period(times, path / "times.txt");

  BareCloudRecording recording;
  recording.format = "kitti";
  recording.folder = path;
  std::vector<int> numbers;
  for (const auto& [number, file] : clouds) {
    const Time middle = times[static_cast<std::size_t>(number)];
    const Time start = middle - Duration::from_nanoseconds(turn.nanoseconds() / 2);
    recording.scans.push_back({file, start, start + turn, middle, std::nullopt});
    numbers.push_back(number);
  }
  recording.notes.push_back(fmt::format(
      "times: mid-scan from times.txt, a turn of {:.6f} s around each; of points from the azimuth",
      turn.seconds()));
  recording.notes.emplace_back(
      "compensated already, to mid-scan; the vertical angles are as published (+0.205 degrees is known to "
      "fit better)");
  if (const std::string gaps = missing_numbers(clouds); !gaps.empty()) {
    recording.notes.push_back("frames missing: " + gaps);
  }
  add_trajectory(path, times, turn, recording);
  find_label_files(recording, numbers, path / "labels", options);
  return make_bare_cloud_dataset(std::move(recording), options);
}

}  // namespace mapless
