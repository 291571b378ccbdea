#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/argument_checks.hpp"
#include "core/parallel_parts.hpp"
#include "core/time_check.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {
namespace {

// Nearer points lie inside the sensor: drivers store "no return" as 0 0 0. The blind zone of every named
// model is at least 0.3 m.
constexpr float kMinRange_m = 0.01f;
// No spinning lidar measures as far. Points in millimetres do from 10 m on, and damaged bytes.
constexpr float kFarthestPoint_m = 10'000.0f;
// More columns than validate() allows a model would not fit memory.
constexpr int kMaxColumns = 1'000'000;
// Bounds of a record's time, in turns before and after the start of the scan. A laser may fire before the
// instant of its column, and the hub may turn slower than its nominal rate. A time beyond was read in another
// unit or from another field.
constexpr std::int64_t kMaxTurnsBefore = 1, kMaxTurnsAfter = 2;

[[noreturn]] void refuse(const std::string& source, std::size_t record, const char* field, std::int64_t value,
                         std::int64_t first, std::int64_t last) {
  throw InputError({source, fmt::format("record {} {}", record, field), std::to_string(value),
                    fmt::format("not from {} to {}", first, last),
                    "the sensor's description does not fit this scan"});
}

[[noreturn]] void refuse_far(const std::string& source, std::size_t record, const LidarRecord& r) {
  throw InputError({source, fmt::format("record {} range", record),
                    fmt::format("{:g} m", r.position_v.cast<double>().norm()),
                    fmt::format("farther than {:g} m, which no spinning lidar measures", kFarthestPoint_m),
                    "give points in metres; if they are, the file is damaged"});
}

void require_in(std::int64_t value, std::int64_t first, std::int64_t last, const char* field,
                std::size_t record, const std::string& source) {
  if (value < first || value > last) refuse(source, record, field, value, first, last);
}

void validate_records(const LidarScan& scan, const std::vector<LidarRecord>& records,
                      const std::string& source) {
  const std::int64_t turn_ns = scan.column_period.nanoseconds() * scan.columns;
  for_parts(records.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const LidarRecord& r = records[i];
      require_in(r.laser, 0, scan.rows() - 1, "laser", i, source);
      require_in(r.column, 0, scan.columns - 1, "column", i, source);
      if (r.code != ReturnCode::hit) continue;
      require_in(r.time_ns, -kMaxTurnsBefore * turn_ns, kMaxTurnsAfter * turn_ns, "time [ns]", i, source);
    }
  });
}

// Origin of each laser's beam in the sensor frame at the instant of a column.
class BeamOrigins {
 public:
  explicit BeamOrigins(const LidarScan& scan) : model_(*scan.model) {
    for (int c = 0; c < scan.columns; ++c) {
      const double angle = model_.hub_angle(c);
      cos_sin_.emplace_back(std::cos(angle), std::sin(angle));
    }
  }
  [[nodiscard]] Eigen::Vector3f at(std::int32_t laser, std::int32_t column) const {
    const Eigen::Vector3d& o = model_.lasers[static_cast<std::size_t>(laser)].origin_h_m;
    const Eigen::Vector2d& cs = cos_sin_[static_cast<std::size_t>(column)];
    return Eigen::Vector3d(cs.x() * o.x() - cs.y() * o.y(), cs.y() * o.x() + cs.x() * o.y(), o.z())
        .cast<float>();
  }

 private:
  const LidarModel& model_;
  std::vector<Eigen::Vector2d> cos_sin_;
};

std::size_t cell_of(const LidarScan& scan, const LidarRecord& r) {
  return static_cast<std::size_t>(r.laser) * static_cast<std::size_t>(scan.columns) +
         static_cast<std::size_t>(r.column);
}

// The range of every record that is a return; kNoRange of the others, whose codes go into their cells. Of
// several codes the weakest claim is kept: faulty, then nothing within range.
constexpr float kNoRange = -1;
std::vector<float> usable_ranges(LidarScan& scan, const std::vector<LidarRecord>& records,
                                 const std::string& source) {
  const BeamOrigins origins(scan);
  std::vector<float> ranges(records.size(), kNoRange);
  for_parts(records.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const LidarRecord& r = records[i];
      if (r.code != ReturnCode::hit) continue;
      const float range_m = (r.position_v - origins.at(r.laser, r.column)).norm();
      if (r.position_v.allFinite() && range_m > kFarthestPoint_m) refuse_far(source, i, r);
      if (std::isfinite(range_m) && range_m >= kMinRange_m) ranges[i] = range_m;
    }
  });
  for (std::size_t i = 0; i < records.size(); ++i) {
    const LidarRecord& r = records[i];
    if (ranges[i] != kNoRange || r.code == ReturnCode::absent)
      continue;  // a cell is absent unless it is more
    const ReturnCode code = r.code == ReturnCode::hit ? ReturnCode::faulty : r.code;
    std::int32_t& cell = scan.cells[cell_of(scan, r)];
    cell = std::max(cell, empty_cell(code));
  }
  return ranges;
}

// Counting sort by cell: linear in the number of returns, and stable.
void place(LidarScan& scan, const std::vector<LidarRecord>& records, const std::vector<float>& ranges) {
  std::vector<std::uint32_t> next(scan.cells.size() + 1, 0);
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (ranges[i] != kNoRange) ++next[cell_of(scan, records[i]) + 1];
  }
  for (std::size_t c = 1; c < next.size(); ++c) next[c] += next[c - 1];
  scan.returns.resize(next.back());
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (ranges[i] == kNoRange) continue;
    const LidarRecord& r = records[i];
    const std::size_t cell = cell_of(scan, r);
    const std::uint32_t at = next[cell]++;
    scan.returns[at] = {r.position_v, ranges[i], r.time_ns, r.column, r.laser, static_cast<std::uint32_t>(i)};
    const std::int32_t shown = scan.cells[cell];
    if (shown < 0 || ranges[i] < scan.returns[static_cast<std::size_t>(shown)].range_m) {
      scan.cells[cell] = static_cast<std::int32_t>(at);
    }
  }
}

}  // namespace

LidarScan organise(LidarScan scan, const std::vector<LidarRecord>& records, const std::string& source) {
  require_given("organise", "scan.model", scan.model.get());
  validate(*scan.model, source);
  if (scan.columns <= 0 || scan.columns > kMaxColumns || scan.column_period.nanoseconds() <= 0) {
    throw InputError({source, "columns x period",
                      fmt::format("{} x {} ns", scan.columns, scan.column_period.nanoseconds()),
                      fmt::format("not 1 to {} columns of a positive period", kMaxColumns),
                      "correct the times of the recording"});
  }
  require_time(source, "start", scan.start);
  validate_records(scan, records, source);
  scan.input_size = records.size();
  scan.cells.assign(static_cast<std::size_t>(scan.rows()) * static_cast<std::size_t>(scan.columns),
                    empty_cell(ReturnCode::absent));
  place(scan, records, usable_ranges(scan, records, source));
  return scan;
}

}  // namespace mapless
