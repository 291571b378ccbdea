#include "run/earlier_run.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <sstream>

#include <fmt/format.h>

#include "reports/digest.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace {

namespace fs = std::filesystem;

// What must be the same for the same bytes; the first that differs is named.
constexpr std::array kSame = {"version", "format",     "sensor",           "first_scan", "selected_scans",
                              "profile", "trajectory", "recording_digest", "probability"};
constexpr std::array kSameOdometry = {"version",      "format",         "sensor",          "selected_scans",
                                      "pose_instant", "poses_per_scan", "recording_digest"};

[[noreturn]] void refuse(const fs::path& file, const std::string& what, const std::string& before,
                         const std::string& now) {
  throw ParameterError({"--resume", what, now, fmt::format("{} has {}", file.string(), before),
                        "give the options and the recording of that run, or --overwrite to start anew"});
}

void require_same_configuration(const fs::path& file, const std::string& now) {
  const std::string before = read_whole_file(file);
  if (before == now) return;
  std::istringstream lines_before(before), lines_now(now);
  std::string group, line_before, line_now;
  while (std::getline(lines_before, line_before) && std::getline(lines_now, line_now)) {
    if (line_before != line_now) break;
    if (!line_now.empty() && line_now.front() != ' ' && line_now.front() != '#') group = line_now + " ";
  }
  const auto trimmed = [](const std::string& line) {
    const std::string text = line.substr(0, line.find(" #"));
    return text.substr(std::min(text.find_first_not_of(' '), text.size()));
  };
  const std::string in_group = line_now.starts_with(' ') ? group : "";
  refuse(file, "parameters", trimmed(line_before), in_group + trimmed(line_now));
}

std::size_t finished_scans(const ResultFolder& result, std::size_t first, std::size_t count,
                           bool probability) {
  std::size_t finished = 0;
  const auto is_there = [&](std::size_t k) {
    return fs::exists(result.label_file(k)) && fs::exists(result.stage_file(k)) &&
           (!probability || fs::exists(result.probability_file(k)));
  };
  while (finished < count && is_there(first + finished)) ++finished;
  return finished;
}

Json parsed(const fs::path& file) {
  Json json = Json::parse(read_whole_file(file), nullptr, false);
  if (json.is_object()) return json;
  throw InputError({file.string(), "content", "", "is not JSON", "start anew with --overwrite"});
}

// The summary of the earlier run, which agrees with `wanted` in `keys`.
Json agreeing_summary(const fs::path& file, const Json& wanted, std::span<const char* const> keys) {
  Json before = parsed(file);
  for (const char* key : keys) {
    const Json value = before.value(key, Json());
    if (value != wanted[key]) refuse(file, key, value.dump(), wanted[key].dump());
  }
  return before;
}

EarlierRun found_run(const Json& before, std::size_t finished, std::size_t selected) {
  EarlierRun out;
  out.finished = finished;
  out.complete = before.value("complete", false) && finished == selected;
  for (const Json& line : before.value("doubts", Json::array())) {
    if (line.is_string()) out.doubts.push_back(line);
  }
  return out;
}

// Whole rows beneath the line of names; at most `most`.
std::size_t rows_in(const fs::path& table, std::size_t most) {
  if (!fs::exists(table)) return 0;
  const std::string text = read_whole_file(table);
  const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  return std::min(most, lines > 0 ? lines - 1 : 0);
}

}  // namespace

std::optional<EarlierRun> earlier_run(const ResultFolder& result, const RunSummary& now,
                                      const std::string& configuration) {
  result.require_free(true);
  if (!fs::exists(result.summary())) return std::nullopt;
  const Json wanted = now.json();
  const Json before = agreeing_summary(result.summary(), wanted, kSame);
  const std::size_t finished =
      finished_scans(result, wanted["first_scan"], wanted["selected_scans"], wanted["probability"]);
  if (finished == 0) return std::nullopt;
  require_same_configuration(result.config(), configuration);
  return found_run(before, finished, wanted["selected_scans"]);
}

std::optional<EarlierRun> earlier_odometry(const ResultFolder& result, const Json& now,
                                           const std::string& configuration) {
  result.require_free(true, kOdometrySummaryBegin);
  if (!fs::exists(result.summary())) return std::nullopt;
  const Json before = agreeing_summary(result.summary(), now, kSameOdometry);
  const std::size_t finished = rows_in(result.poses(), now["selected_scans"]);
  if (finished == 0) return std::nullopt;
  require_same_configuration(result.config(), configuration);
  return found_run(before, finished, now["selected_scans"]);
}

std::string recording_digest(const Dataset& dataset, const Trajectory* given,
                             std::span<const MotionMeasurement> measured, std::size_t first,
                             std::size_t count) {
  Digest digest;
  for (const MotionMeasurement& one : measured) {
    digest.add(one.time.nanoseconds());
    digest.add(one.quantity);
    for (Eigen::Index i = 0; i < one.value.size(); ++i) digest.add(one.value[i]);
    digest.add(one.sigma.value_or(0.0));
  }
  for (std::size_t k = first; k < first + count; ++k) {
    const Time start = dataset.scan_start(k);
    digest.add(start.nanoseconds());
    std::error_code error;
    const std::uintmax_t size = fs::file_size(dataset.scan_file(k), error);
    if (!error) digest.add(size);
    if (given == nullptr) continue;
    const Eigen::Matrix4d T_v0 = given->at(start).T_v0.matrix();
    for (Eigen::Index i = 0; i < T_v0.size(); ++i) digest.add(T_v0.data()[i]);
  }
  return digest.text();
}

}  // namespace mapless::app
