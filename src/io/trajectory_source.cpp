#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <string_view>

#include <fmt/format.h>

#include "io/formats/kitti/kitti_calibration.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::inline v1 {
namespace {

constexpr std::array<std::string_view, 2> kDirectionNames = {"world_from_sensor", "sensor_from_world"};
constexpr std::array<std::string_view, 2> kFrameNames = {"sensor", "camera"};
constexpr std::array<std::string_view, 3> kInstantNames = {"start", "middle", "end"};

template <std::size_t N, class Enum>
std::string name_of(const std::array<std::string_view, N>& names, Enum value) {
  return std::string(names.at(static_cast<std::size_t>(value)));
}

// True for KITTI rows: 12 numbers without a time in the first row.
bool has_one_row_per_scan(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::size_t count = 0;
    for (std::string word; words >> word;) ++count;
    if (count > 0) return count == 12;
  }
  return false;
}

Time instant_of_scan(const Dataset& dataset, std::size_t k, PoseInstant instant) {
  const Time start = dataset.scan_start(k);
  const Duration length = dataset.scan_end(k) - start;
  switch (instant) {
    case PoseInstant::start:
      return start;
    case PoseInstant::middle:
      return start + Duration::from_nanoseconds(length.nanoseconds() / 2);
    case PoseInstant::end:
      return start + length;
  }
  return start;
}

std::vector<Time> instants_of_scans(const Dataset& dataset, PoseInstant instant) {
  std::vector<Time> times(dataset.size());
  for (std::size_t k = 0; k < times.size(); ++k) times[k] = instant_of_scan(dataset, k, instant);
  return times;
}

// How far the recording reaches beyond the first and the last of `times`.
Duration reach_beyond(const Dataset& dataset, const std::vector<Time>& times) {
  if (times.empty()) return {};
  return std::max(times.front() - dataset.scan_start(0), dataset.scan_end(dataset.size() - 1) - times.back());
}

SE3 file_from_sensor(const TrajectoryRequest& request) {
  if (request.frame == PoseFrame::sensor) return {};
  if (request.calibration.empty()) {
    throw InputError({request.file.string(), "--pose-frame", "camera", "needs the camera's calibration",
                      "give --calib FILE (KITTI's calib.txt or calib_velo_to_cam.txt)"});
  }
  return read_kitti_calibration(request.calibration);
}

TrajectoryFileOptions file_options(const Dataset& dataset, const TrajectoryRequest& request, bool per_scan) {
  if (request.max_extrapolation_s &&
      !(std::isfinite(*request.max_extrapolation_s) && *request.max_extrapolation_s >= 0)) {
    throw ParameterError({"--max-extrapolation-s", "", fmt::format("{}", *request.max_extrapolation_s),
                          "must be a number of seconds, at least 0", "give 0 to forbid any"});
  }
  TrajectoryFileOptions options;
  options.direction = request.direction;
  options.T_file_sensor = file_from_sensor(request);
  options.row_times = instants_of_scans(dataset, request.instant);
  if (request.max_extrapolation_s) {
    options.max_extrapolation = Duration::from_seconds(*request.max_extrapolation_s);
  } else if (per_scan) {
    options.max_extrapolation = reach_beyond(dataset, options.row_times);
  }
  return options;
}

TrajectorySource open_file(const Dataset& dataset, const TrajectoryRequest& request) {
  const std::string text = read_whole_file(request.file);
  const bool per_scan = has_one_row_per_scan(text);
  const TrajectoryFileOptions options = file_options(dataset, request, per_scan);
  TrajectorySource source;
  source.trajectory = std::make_shared<SampledTrajectory>(parse_trajectory(text, request.file, options));
  source.conventions = {
      {"source", request.file.string()},
      {"direction", name_of(kDirectionNames, request.direction)},
      {"frame", name_of(kFrameNames, request.frame)},
      {"times", per_scan ? name_of(kInstantNames, request.instant) + " of each scan" : "in the file"},
      {"max_extrapolation_s", fmt::format("{:.6f}", options.max_extrapolation.seconds())}};
  if (request.frame == PoseFrame::camera) {
    source.conventions.emplace_back("calibration", request.calibration.string());
  }
  return source;
}

std::string span_text(Time begin, Time end) {
  return fmt::format("[{:.6f}, {:.6f}] s", begin.seconds(), end.seconds());
}

}  // namespace

SampledTrajectory read_trajectory(const Dataset& dataset, const TrajectoryRequest& request) {
  const std::string text = read_whole_file(request.file);
  return parse_trajectory(text, request.file, file_options(dataset, request, has_one_row_per_scan(text)));
}

TrajectorySource open_trajectory(const Dataset& dataset, const TrajectoryRequest& request) {
  if (request.stationary) {
    return {std::make_shared<StationaryTrajectory>(), {{"source", "stationary sensor"}}};
  }
  if (!request.file.empty()) return open_file(dataset, request);
  if (auto own = dataset.trajectory()) return {std::move(own), {{"source", "recording"}}};
  throw InputError(
      {dataset.size() > 0 ? dataset.scan_file(0).parent_path().string() : "recording", "trajectory", "",
       "the recording comes without one",
       "give --trajectory FILE (TUM or KITTI poses), or --stationary for a sensor that does not move"});
}

void require_coverage(const Dataset& dataset, const Trajectory& trajectory, std::size_t first,
                      std::size_t count) {
  const int columns = std::max(1, dataset.model()->columns);
  for (std::size_t k = first; k < first + count; ++k) {
    const Time start = dataset.scan_start(k);
    const Time end = dataset.scan_end(k);
    // The end of a scan is one column period after its last column, the last instant that is evaluated.
    const Time last_column = end - Duration::from_nanoseconds((end - start).nanoseconds() / columns);
    if (start >= trajectory.begin() && last_column <= trajectory.end()) continue;
    throw TrajectoryDomainError(
        {dataset.scan_file(k).string(), fmt::format("scan {}", k), span_text(start, end),
         "the trajectory covers " + span_text(trajectory.begin(), trajectory.end()),
         "give a trajectory of the whole recording, or choose scans with --first and --count, or "
         "allow more with --max-extrapolation-s"});
  }
}

}  // namespace mapless
