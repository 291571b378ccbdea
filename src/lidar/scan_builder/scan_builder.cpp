#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "core/parallel_parts.hpp"
#include "core/time_check.hpp"
#include "lidar/nearest_beam.hpp"
#include "lidar/recovery/ring_recovery.hpp"
#include "lidar/scan_builder/raw_points.hpp"
#include "lidar/scan_builder/sensor_recovery.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/lidar/scan_builder.hpp>

namespace mapless::inline v1 {
namespace {

// Median distance of the points from the beams of their lasers, in spacings between lasers. Points spread
// evenly between two beams have 0.25 to the nearer one.
constexpr double kLargestMisfitFound = 0.15;
// Rings the points come with are of a sensor whose elevations may differ from the nominal ones by a spacing.
constexpr double kLargestMisfitStated = 1.0;
// Drivers that send packets rather than turns put up to two and a bit into a scan.
constexpr int kMostTurns = 3;
// Points that all have one time, over more of a turn than this, have no times of their own.
constexpr double kLargestShareAtOnce = 0.1;
// Chosen: stamps are of the start, the end or the arrival of a scan, within seconds of its points. Another
// clock (since boot, another epoch) is minutes and more away.
constexpr std::int64_t kFarthestFromStamp_ns = 10'000'000'000;

// Rows for rings counted from 0, from the lowest or the highest laser: whichever fits the points better.
BeamAssignment stated_lasers(const RawPoints& points, const LidarModel& model, const std::string& source) {
  const auto count = static_cast<std::int64_t>(model.lasers.size());
  std::vector<std::int32_t> lasers(points.rings.size(), 0), reversed(points.rings.size());
  for_parts(lasers.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const bool inside = points.rings[i] >= 0 && points.rings[i] < count;
      if (!inside && is_usable(points.positions[i])) {
        throw InputError({source, fmt::format("point {} ring", i), std::to_string(points.rings[i]),
                          fmt::format("not one of the {} lasers of {}", count, model.name),
                          "name the sensor that measured the points"});
      }
      if (inside) lasers[i] = static_cast<std::int32_t>(points.rings[i]);
      reversed[i] = static_cast<std::int32_t>(count) - 1 - lasers[i];
    }
  });
  const double misfit = beam_misfit(points.positions, lasers, model);
  const double reversed_misfit = beam_misfit(points.positions, reversed, model);
  if (reversed_misfit < misfit) return {std::move(reversed), reversed_misfit};
  return {std::move(lasers), misfit};
}

void require_fit(double misfit, double largest, const LidarModel& model, const std::string& source) {
  if (misfit <= largest) return;
  throw InputError(
      {source, "sensor", model.name,
       fmt::format("half of the points lie more than {:.2f} laser spacings off its beams", misfit),
       "name the sensor that measured the points, or give its calibration file; points must be in the frame "
       "of the sensor, not of the world"});
}

// Moves each column, known but for whole turns, to the turn that the point's time gives, with column 0 at the
// earliest point, and gives the scan a model that starts there: scans may begin anywhere.
void unwind(LidarScan& scan, std::vector<LidarRecord>& records, const RawPoints& points,
            std::int64_t first_ns) {
  const auto model = std::make_shared<LidarModel>(*scan.model);
  const int turn = model->columns;
  std::size_t first = 0;
  while (!is_usable(points.positions[first]) || points.times_ns[first] != first_ns) ++first;
  const int first_column = records[first].column;
  model->start_azimuth_rad = model->hub_angle(first_column);
  std::vector<int> columns(count_parts(records.size()), scan.columns);
  for_parts(records.size(), [&](std::size_t part, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      LidarRecord& r = records[i];
      if (r.code != ReturnCode::hit) {
        r.column = 0;
        continue;
      }
      const double expected =
          static_cast<double>(r.time_ns) / static_cast<double>(scan.column_period.nanoseconds());
      const int column = r.column - first_column;
      const int turns = static_cast<int>(std::lround((expected - column) / turn));
      r.column = std::max(0, column + turns * turn);
      columns[part] = std::max(columns[part], r.column + 1);
    }
  });
  for (const int of_part : columns) scan.columns = std::max(scan.columns, of_part);
  scan.model = model;
}

// A driver without times fills the field with one value.
void require_own_times(const std::vector<LidarRecord>& records, const RawPoints& points, int columns,
                       const std::string& source) {
  int first = std::numeric_limits<int>::max(), last = -1;
  std::optional<std::int64_t> time_ns;
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (records[i].code != ReturnCode::hit) continue;
    if (points.times_ns[i] != time_ns.value_or(points.times_ns[i])) return;
    time_ns = points.times_ns[i];
    first = std::min(first, records[i].column);
    last = std::max(last, records[i].column);
  }
  if (!time_ns || last - first < kLargestShareAtOnce * columns) return;
  throw InputError({source, "time", fmt::format("{} ns", *time_ns),
                    fmt::format("all points have it, over {} columns of {}", last - first + 1, columns),
                    "leave the times out where the driver gives none: the azimuths give them"});
}

// Times that are not plainly of the epoch (RawPoints) count from the stamp, or on the clock of the stamps:
// whichever places the scan near its stamp.
void find_time_reference(RawPoints& points, Time stamp, const std::string& source) {
  const auto first_ns = points.first_time_ns;
  if (!first_ns || points.times_are_absolute || std::abs(*first_ns) <= kFarthestFromStamp_ns) return;
  const std::int64_t from_stamp_ns = *first_ns - stamp.nanoseconds();
  if (std::abs(from_stamp_ns) > kFarthestFromStamp_ns) {
    throw InputError({source, "time", fmt::format("{} ns", *first_ns),
                      fmt::format("neither since the scan's start nor on its clock: the scan starts at {} ns",
                                  stamp.nanoseconds()),
                      "give the start of the scan and the times of its points on one clock"});
  }
  points.times_are_absolute = true;
}

// The scan then starts with its earliest point.
void take_times(LidarScan& scan, std::vector<LidarRecord>& records, const RawPoints& points,
                std::int64_t first_ns, const std::string& source) {
  require_own_times(records, points, scan.columns, source);
  const std::int64_t longest_ns = kMostTurns * scan.columns * scan.column_period.nanoseconds();
  const auto take = [&](std::size_t i) {
    if (records[i].code != ReturnCode::hit) return;
    const std::int64_t since_first = points.times_ns[i] - first_ns;
    if (since_first > longest_ns || since_first > INT32_MAX) {
      throw InputError({source, fmt::format("point {} time", i), fmt::format("{} ns", points.times_ns[i]),
                        fmt::format("{} ns after the first point: more than three turns", since_first),
                        "name the unit that the times have (integers of a file are nanoseconds, floating "
                        "numbers seconds)"});
    }
    records[i].time_ns = static_cast<std::int32_t>(since_first);
  };
  for_parts(records.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) take(i);
  });
  scan.start = points.times_are_absolute ? Time::from_nanoseconds(first_ns)
                                         : scan.start + Duration::from_nanoseconds(first_ns);
  scan.time_source = Provenance::sensor;
}

// Of returns that share a cell. Both returns of a ray have its time; without times, a direction to much less
// than the step of any sensor.
bool are_of_one_ray(const LidarScan& scan, const LidarRecord& a, const LidarRecord& b) {
  constexpr double kSameDirection_rad = 1e-5;
  if (scan.time_source == Provenance::sensor) return a.time_ns == b.time_ns;
  const Eigen::Vector3d p = a.position_v.cast<double>(), q = b.position_v.cast<double>();
  return p.dot(q) > 0 && p.cross(q).norm() < kSameDirection_rad * p.norm() * q.norm();
}

// Of the returns of one ray the nearest is kept: farther ones (through leaves and glass, or the same return
// twice, as drivers publish both returns) would pass for rays of their own, and what is behind them for free
// space.
void keep_nearest_of_each_ray(const LidarScan& scan, std::vector<LidarRecord>& records) {
  const auto columns = static_cast<std::size_t>(scan.columns);
  std::vector<std::int32_t> last(scan.model->lasers.size() * columns, -1);  // hit of the cell
  std::vector<std::int32_t> before;                                         // the hit of its cell before it
  for (std::size_t i = 0; i < records.size(); ++i) {
    LidarRecord& r = records[i];
    if (r.code != ReturnCode::hit) continue;
    std::int32_t& of_cell =
        last[static_cast<std::size_t>(r.laser) * columns + static_cast<std::size_t>(r.column)];
    if (of_cell >= 0 && before.empty()) before.assign(records.size(), -1);
    for (std::int32_t j = of_cell; j >= 0; j = before[static_cast<std::size_t>(j)]) {
      LidarRecord& other = records[static_cast<std::size_t>(j)];
      if (other.code != ReturnCode::hit || !are_of_one_ray(scan, r, other)) continue;
      const bool nearer = r.position_v.squaredNorm() < other.position_v.squaredNorm();
      (nearer ? other : r).code = ReturnCode::absent;
    }
    if (!before.empty()) before[i] = of_cell;
    of_cell = static_cast<std::int32_t>(i);
  }
}

}  // namespace

struct ScanBuilder::State {
  explicit State(const LidarModel& m) : model(std::make_shared<const LidarModel>(m)) {
    validate(*model, "sensor");
    turn = Duration::from_seconds(1 / model->rotation_rate_hz);
  }

  [[nodiscard]] std::vector<std::int32_t> lasers_of(const RawPoints& points, LidarScan& scan,
                                                    const std::string& source) const;
  [[nodiscard]] std::vector<LidarRecord> records_of(const RawPoints& points, LidarScan& scan,
                                                    const std::string& source) const;

  std::shared_ptr<const LidarModel> model;
  std::optional<RecoveredSensor> recovered;
  Duration turn;
};

std::vector<std::int32_t> ScanBuilder::State::lasers_of(const RawPoints& points, LidarScan& scan,
                                                        const std::string& source) const {
  if (recovered) {
    std::vector<std::int32_t> lasers = lasers_by_rings(points, *recovered, source);
    require_fit(beam_misfit(points.positions, lasers, *model), kLargestMisfitStated, *model, source);
    const bool stated = recovered->rings_from == RingSource::field;
    scan.ring_source = stated ? Provenance::sensor : Provenance::recovered_from_order;
    return lasers;
  }
  const bool stated = !points.rings.empty();
  BeamAssignment found =
      stated ? stated_lasers(points, *model, source) : nearest_beams(points.positions, *model);
  require_fit(found.misfit, stated ? kLargestMisfitStated : kLargestMisfitFound, *model, source);
  scan.ring_source = stated ? Provenance::sensor : Provenance::recovered_from_angle;
  return std::move(found.lasers);
}

// Times by the column; where the points have times, take_times replaces them.
std::vector<LidarRecord> ScanBuilder::State::records_of(const RawPoints& points, LidarScan& scan,
                                                        const std::string& source) const {
  const std::vector<std::int32_t> lasers = lasers_of(points, scan, source);
  const std::vector<std::int32_t> columns =
      recover_columns(points.positions, lasers, *model, recovered ? recovered->layout.encoder_steps : 0);
  std::vector<LidarRecord> records(points.positions.size());
  for_parts(records.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Duration offset = model->lasers[static_cast<std::size_t>(lasers[i])].firing_offset;
      const auto time_ns =
          static_cast<std::int32_t>(columns[i] * scan.column_period.nanoseconds() + offset.nanoseconds());
      // Where a point without position was fired is not known: it has no cell.
      const ReturnCode code = is_usable(points.positions[i]) ? ReturnCode::hit : ReturnCode::absent;
      records[i] = {points.positions[i], lasers[i], columns[i], time_ns, code};
    }
  });
  scan.time_source = Provenance::recovered_from_angle;
  return records;
}

ScanBuilder::ScanBuilder(const LidarModel& model) : ScanBuilder(std::make_unique<State>(model)) {}
ScanBuilder::ScanBuilder(std::unique_ptr<State> state) : state_(std::move(state)) {}
ScanBuilder::~ScanBuilder() = default;
ScanBuilder::ScanBuilder(ScanBuilder&&) noexcept = default;
ScanBuilder& ScanBuilder::operator=(ScanBuilder&&) noexcept = default;

ScanBuilder ScanBuilder::recover(std::span<const PointFields> scans, std::span<const Time> stamps,
                                 const std::string& source) {
  std::vector<RawPoints> points;
  for (const PointFields& fields : scans) points.push_back(read_points(fields, source));
  if (points.empty()) {
    throw InputError({source, "scans", "0", "a sensor cannot be recovered from no scan", "give about eight"});
  }
  RecoveredSensor sensor = recover_sensor(std::move(points), stamps, source);
  auto state = std::make_unique<State>(sensor.model);
  state->recovered = std::move(sensor);
  return ScanBuilder(std::move(state));
}

void ScanBuilder::set_turn_duration(Duration turn) { state_->turn = turn; }

LidarScan ScanBuilder::build(const PointFields& fields, Time stamp, const std::string& source) const {
  require_time(source, "stamp", stamp);
  RawPoints points = read_points(fields, source);
  if (fields.time_reference == TimeReference::automatic) find_time_reference(points, stamp, source);
  LidarScan scan;
  scan.model = state_->model;
  scan.start = stamp;
  scan.columns = scan.model->columns;
  scan.column_period = Duration::from_nanoseconds(state_->turn.nanoseconds() / scan.columns);
  std::vector<LidarRecord> records = state_->records_of(points, scan, source);
  if (const auto first_ns = points.first_time_ns) {
    take_times(scan, records, points, *first_ns, source);
    unwind(scan, records, points, *first_ns);
  }
  keep_nearest_of_each_ray(scan, records);
  return organise(std::move(scan), records, source);
}

const std::shared_ptr<const LidarModel>& ScanBuilder::model() const { return state_->model; }

std::optional<ModelEstimate> ScanBuilder::estimate() const {
  return state_->recovered ? std::optional(state_->recovered->estimate) : std::nullopt;
}

std::vector<std::string> ScanBuilder::notes() const {
  return state_->recovered ? state_->recovered->notes : std::vector<std::string>();
}

}  // namespace mapless
