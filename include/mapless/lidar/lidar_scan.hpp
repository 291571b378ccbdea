#pragma once

/// @file
/// Room lidar: the sensor (LidarModel) and what it measured in one turn (LidarScan). In go records of points
/// with laser, column and time, or bare points whose rings and times are recovered; out comes a LidarScan. A
/// LidarScan is made by organise() or build_scan() and not changed afterwards: the other rooms rely on its
/// sorted returns and its cells.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/time.hpp>
#include <mapless/lidar/lidar_model.hpp>

namespace mapless::inline v1 {

/// Outcome of one firing of one laser. The first three values are the codes of the native format.
enum class ReturnCode : std::uint8_t {
  hit = 0,
  faulty = 1,   ///< no return for an unknown reason: no evidence of free space
  nothing = 2,  ///< no return, as no surface lies within the maximum range
  absent = 3,   ///< the recording has no record of this firing (bare clouds store hits only)
};

/// Where the times or the rings of a scan come from.
enum class Provenance : std::uint8_t {
  none,
  sensor,                ///< a value per point in the recording, or the timestamps of the packets
  recovered_from_angle,  ///< from azimuth or elevation of the point
  recovered_from_order,  ///< from the position of the point in the file
};

/// One hit, as the sensor measured it.
struct LidarReturn {
  Eigen::Vector3f position_v;  ///< [m] in the sensor frame at the instant of firing
  float range_m;               ///< distance from the origin of its laser
  std::int32_t time_ns;        ///< since LidarScan::start
  std::int32_t column;
  std::int32_t laser;
  std::uint32_t input_index;  ///< number of its record in the input, from 0
};

/// One turn of the sensor as an image: rows are lasers by increasing elevation, columns consecutive firings.
/// Columns wrap in azimuth, rows do not. Every usable record of the input is a return. Two returns may share
/// a cell where columns had to be recovered; the cell then holds the index of the nearer.
struct LidarScan {
  std::shared_ptr<const LidarModel> model;
  Time start;                  ///< of column 0
  Duration column_period;      ///< between consecutive columns
  int columns = 0;             ///< of this scan; column c has the hub angle model->hub_angle(c)
  std::size_t input_size = 0;  ///< number of records in the input, hits or not: the length of a label file
  Provenance time_source = Provenance::none;
  Provenance ring_source = Provenance::none;
  std::optional<Time>
      compensated_to;  ///< set if another system has already moved every position_v to this instant

  std::vector<LidarReturn> returns;  ///< by laser, then column, then input index
  std::vector<std::int32_t> cells;   ///< rows x columns, row-major: index into returns, or a negative code

  [[nodiscard]] int rows() const { return static_cast<int>(model->lasers.size()); }
  [[nodiscard]] Time column_time(int column) const {
    return start + Duration::from_nanoseconds(column * column_period.nanoseconds());
  }
  [[nodiscard]] Time end() const { return column_time(columns); }
  [[nodiscard]] Time time_of(const LidarReturn& r) const {
    return start + Duration::from_nanoseconds(r.time_ns);
  }
  [[nodiscard]] std::int32_t cell(int row, int column) const {
    return cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                 static_cast<std::size_t>(column)];
  }
};

/// A cell without a return holds the negative of its ReturnCode; a cell >= 0 is an index into
/// LidarScan::returns.
[[nodiscard]] constexpr std::int32_t empty_cell(ReturnCode code) { return -static_cast<std::int32_t>(code); }
[[nodiscard]] constexpr ReturnCode code_of_cell(std::int32_t cell) {
  return cell >= 0 ? ReturnCode::hit : static_cast<ReturnCode>(-cell);
}

/// One record of a recording, before organise() assigns it to a cell.
struct LidarRecord {
  Eigen::Vector3f position_v;  ///< [m]; not finite: no return
  std::int32_t laser;          ///< row of the image; 0 has the lowest elevation
  std::int32_t column;
  std::int32_t time_ns;  ///< since the scan's start
  ReturnCode code;
};

/// Sorts the records into the image: record i becomes input index i. `scan` has every member set but returns,
/// cells and input_size. A record with code hit whose position is not finite, or less than 1 cm from its
/// laser, counts as faulty. A cell without a record is absent. Throws ParameterError for a scan without
/// model, InputError naming `source` for an invalid model (validate), a scan of no columns or no duration,
/// a start beyond Time::kLargestOutside_ns, a laser, column or time out of range, and a point beyond 10 km.
[[nodiscard]] LidarScan organise(LidarScan scan, const std::vector<LidarRecord>& records,
                                 const std::string& source);

enum class NumberType : std::uint8_t {
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64
};

/// One number per point in memory that the caller owns: an array, or a field of interleaved points. The
/// numbers need not be aligned.
struct NumberSpan {
  const void* first = nullptr;
  NumberType type = NumberType::float32;
  std::size_t size = 0;          ///< how many numbers
  std::size_t stride_bytes = 0;  ///< from one number to the next

  NumberSpan() = default;
  NumberSpan(const void* first_number, NumberType type_of_numbers, std::size_t count,
             std::size_t stride_in_bytes)
      : first(first_number), type(type_of_numbers), size(count), stride_bytes(stride_in_bytes) {}
  NumberSpan(std::span<const float> numbers)
      : NumberSpan(numbers.data(), NumberType::float32, numbers.size(), sizeof(float)) {}
  NumberSpan(std::span<const double> numbers)
      : NumberSpan(numbers.data(), NumberType::float64, numbers.size(), sizeof(double)) {}
  NumberSpan(std::span<const std::uint16_t> numbers)
      : NumberSpan(numbers.data(), NumberType::uint16, numbers.size(), sizeof(std::uint16_t)) {}
  NumberSpan(std::span<const std::uint32_t> numbers)
      : NumberSpan(numbers.data(), NumberType::uint32, numbers.size(), sizeof(std::uint32_t)) {}
  NumberSpan(std::span<const std::int64_t> numbers)
      : NumberSpan(numbers.data(), NumberType::int64, numbers.size(), sizeof(std::int64_t)) {}

  [[nodiscard]] bool empty() const { return size == 0; }
};

enum class TimeUnit : std::uint8_t { seconds, milliseconds, microseconds, nanoseconds };

/// What the times of the points are counted from.
enum class TimeReference : std::uint8_t {
  stamp,  ///< the scan's stamp; times may be negative
  epoch,  ///< the epoch of the stamps (Unix for most recordings)
  /// the epoch where the earliest is 1e15 ns (eleven days) or more; else the stamp where the earliest is
  /// within 10 s of 0; else the clock of the stamps, where it is within 10 s of the stamp (InputError where
  /// it is not)
  automatic
};

/// The points of one scan, as a driver or a file has them: one turn of a spinning lidar, or a little more or
/// less, in any order. All fields that are not empty have the same length.
struct PointFields {
  /// [m] in the sensor frame at the instant each point was measured: not motion-compensated. Points with a
  /// coordinate that is not finite, or within 1 cm of the spin axis, are records without a return: they keep
  /// their place in the input and get no label.
  NumberSpan x, y, z;
  /// Number of the laser of each point, integer. Empty: recovered from elevation or order.
  NumberSpan ring;
  /// Instant of each point. Empty: recovered from azimuth.
  NumberSpan time;
  TimeUnit time_unit = TimeUnit::seconds;
  TimeReference time_reference = TimeReference::stamp;
  /// Rows of an organised cloud, one per laser; 1: not organised.
  std::size_t rows = 1;
};

}  // namespace mapless
