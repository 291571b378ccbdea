#include "run/run_summary.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>
#include <sys/resource.h>

#include "reports/json.hpp"
#include "run/lost_motion.hpp"
#include <mapless/evaluation/trajectory_evaluation.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::app {
namespace {

struct TimingRow {
  std::string_view name;
  double (*seconds)(const StageSeconds&);
};

constexpr std::array<TimingRow, kTimings> kTimingRows = {{
    {"compensation", [](const StageSeconds& s) { return s.compensation; }},
    {"neighbours", [](const StageSeconds& s) { return s.neighbours; }},
    {"normals", [](const StageSeconds& s) { return s.normals; }},
    {"comparison", [](const StageSeconds& s) { return s.comparison; }},
    {"backward", [](const StageSeconds& s) { return s.backward; }},
    {"forward", [](const StageSeconds& s) { return s.forward; }},
    {"evidence", [](const StageSeconds& s) { return s.evidence; }},
    {"filter", [](const StageSeconds& s) { return s.filter; }},
    {"region_growth", [](const StageSeconds& s) { return s.region_growth; }},
    {"tracking", [](const StageSeconds& s) { return s.tracking; }},
    {"total", [](const StageSeconds& s) { return s.total(); }},
}};

std::vector<double> milliseconds(const std::vector<StageSeconds>& scans, const TimingRow& row) {
  std::vector<double> out(scans.size());
  std::transform(scans.begin(), scans.end(), out.begin(),
                 [&](const StageSeconds& s) { return row.seconds(s) * 1e3; });
  return out;
}

Json number_or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json quantiles_json(const DurationHistogram& durations) {
  const auto ms = [&](double q) {
    const auto seconds = durations.quantile(q);
    return seconds ? Json(1e3 * *seconds) : Json(nullptr);
  };
  return {{"median_ms", ms(0.5)}, {"p95_ms", ms(0.95)}, {"p99_ms", ms(0.99)}};
}

Json quantiles_json(const std::vector<double>& ms) {
  return {{"median_ms", number_or_null(quantile(ms, 0.5))},
          {"p95_ms", number_or_null(quantile(ms, 0.95))},
          {"p99_ms", number_or_null(quantile(ms, 0.99))}};
}

double peak_memory_mb() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

}  // namespace

std::string provenance_text(Provenance provenance) {
  switch (provenance) {
    case Provenance::none:
      return "none";
    case Provenance::sensor:
      return "in the recording";
    case Provenance::recovered_from_angle:
      return "recovered from the angles of the points";
    case Provenance::recovered_from_order:
      return "recovered from the order of the points";
  }
  return "none";
}

RunSummary::RunSummary(const Dataset& dataset, std::string recording, const TrajectorySource& trajectory,
                       std::string profile, std::size_t first_scan, std::size_t selected_scans)
    : recording_(std::move(recording)),
      format_(dataset.format()),
      sensor_(dataset.model()->name),
      profile_(std::move(profile)),
      trajectory_(trajectory.conventions),
      notes_(dataset.notes()),
      first_scan_(first_scan),
      selected_scans_(selected_scans) {}

void RunSummary::set_input(const LidarScan& scan, bool was_compensated) {
  times_ = provenance_text(scan.time_source);
  rings_ = provenance_text(scan.ring_source);
  motion_compensation_ =
      was_compensated ? "in the recording; undone before detection" : "none in the recording";
}

void RunSummary::add(const Detection& detection) {
  records_ += detection.scan->input_size;
  points_ += detection.object.size();
  const auto dynamic = static_cast<std::size_t>(std::count_if(
      detection.object.begin(), detection.object.end(), [](std::uint16_t object) { return object != 0; }));
  dynamic_points_ += dynamic;
  if (detection.motion_known) moving_share_.add(first_scan_ + scans_, detection);
  objects_ += static_cast<std::size_t>(detection.objects);
  for (const TrackedObject& object : detection.tracked) count_id(object.id);
  for (std::size_t row = 0; row < kTimingRows.size(); ++row)
    durations_[row].add(kTimingRows[row].seconds(detection.seconds));
  ++scans_;
}

void RunSummary::count_id(std::uint32_t id) {
  if (id >= seen_ids_.size()) seen_ids_.resize(id + 1);
  if (!seen_ids_[id]) ++ids_;
  seen_ids_[id] = true;
}

Json timing_json(const std::vector<StageSeconds>& scans) {
  Json rows = Json::object();
  for (const TimingRow& row : kTimingRows) {
    rows[std::string(row.name)] = quantiles_json(milliseconds(scans, row));
  }
  return rows;
}

namespace {

Json odometry_json(const OdometryReport& r) {
  Json out = {{"scans", r.scans()}};
  for (const MotionState state : {MotionState::good, MotionState::degenerate, MotionState::lost})
    out[std::string(name_of(state))] = r.count(state);
  out["restarts"] = r.restarts();
  out["gaps"] = r.gaps();
  return out;
}

}  // namespace

std::vector<std::string> further_doubts(const std::vector<std::string>& said,
                                        const std::vector<std::string>& found) {
  std::vector<std::string> further;
  for (const std::string& line : found) {
    const std::string about = line.substr(0, line.find(':') + 1);  // "doubtful beams:"
    if (std::none_of(said.begin(), said.end(),
                     [&](const std::string& one) { return one.starts_with(about); }))
      further.push_back(line);
  }
  return further;
}

void RunSummary::set_scan_doubts(const std::vector<std::string>& lines) {
  scan_doubts_ = further_doubts(input_doubts_, lines);
}

std::vector<std::string> RunSummary::doubts() const {
  std::vector<std::string> out = input_doubts_;
  out.insert(out.end(), scan_doubts_.begin(), scan_doubts_.end());
  if (std::string line = moving_share_.trouble(); !line.empty()) out.push_back(std::move(line));
  if (std::string line = odometry_ ? motion_doubt(*odometry_) : ""; !line.empty())
    out.push_back(std::move(line));
  return out;
}

Json RunSummary::json() const {
  Json trajectory = Json::object();
  for (const auto& [name, value] : trajectory_) trajectory[name] = value;
  Json timing = Json::object();
  for (std::size_t row = 0; row < kTimingRows.size(); ++row)
    timing[std::string(kTimingRows[row].name)] = quantiles_json(durations_[row]);
  Json out = {{"program", kProgramName},
              {"version", MAPLESS_VERSION},
              {"complete", complete_},
              {"doubts", doubts()},
              {"recording", recording_},
              {"recording_digest", recording_digest_},
              {"format", format_},
              {"sensor", sensor_},
              {"first_scan", first_scan_},
              {"selected_scans", selected_scans_},
              {"scans", scans_},
              {"records", records_},
              {"points", points_},
              {"dynamic_points", dynamic_points_},
              {"objects", objects_},
              {"objects_over_time", ids_},
              {"profile", profile_},
              {"probability", probability_},
              {"times", times_},
              {"rings", rings_},
              {"motion_compensation", motion_compensation_},
              {"trajectory", trajectory},
              {"notes", notes_},
              {"timing", timing},
              {"peak_memory_mb", peak_memory_mb()}};
  if (input_output_) out["input_output"] = to_json(*input_output_);
  if (real_time_) out["real_time"] = to_json(*real_time_);
  if (odometry_) out["odometry"] = odometry_json(*odometry_);
  if (resumed_after_) out["resumed_after"] = *resumed_after_;
  if (!stopped_.empty()) out["stopped"] = stopped_;
  return out;
}

std::string RunSummary::lines() const {
  const auto ms = [&](double q) { return 1e3 * durations_.back().quantile(q).value_or(0); };
  const std::string text = fmt::format(
      "{} scans, {} points, {} of them dynamic, {} objects (counted scan by scan; {} over time)\n"
      "{:.1f} ms per scan (median), {:.1f} ms (95 %), peak memory {:.0f} MB\n",
      scans_, points_, dynamic_points_, objects_, ids_, ms(0.5), ms(0.95), peak_memory_mb());
  return real_time_ ? text + text_of(*real_time_) : text;
}

}  // namespace mapless::app
