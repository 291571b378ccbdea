#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <mapless/core/time.hpp>
#include <mapless/lidar/lidar_model.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

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
  stamp,     ///< the scan's stamp; times may be negative
  epoch,     ///< the epoch of the stamps (Unix for most recordings)
  automatic  ///< the epoch where the earliest is 1e15 ns (eleven days) or more, else the stamp
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

/// Turns points with, or without, ring and time into a LidarScan: the image of rays that the detector needs.
///
/// Laser of a point: its ring (numbers from 0, by increasing or decreasing elevation, whichever fits the
/// points); without rings, the laser whose cone passes nearest. Column: the nearest to the hub's angle, which
/// is the azimuth less the laser's own part (recover_firings); the time of the point tells the turn, so that
/// a scan may begin at any azimuth and be longer than a turn. Time: the point's own; without times, that of
/// the column. Labels come out in the order of the points: LidarReturn::input_index is the index here.
///
/// Immutable after construction; `build` may be called from several threads.
class ScanBuilder {
 public:
  /// For a known sensor. Throws InputError where the model cannot be one (validate).
  explicit ScanBuilder(const LidarModel& model);

  /// For an unknown sensor: estimates its lasers from scans of it , about eight from
  /// all over a recording. Rings from the field `ring`, else from the rows of an organised cloud, else from
  /// the order (ring after ring, as KITTI stores them). Spin from the times; without times, clockwise at the
  /// rate of the stamps. `stamps` has one element per scan of the recording, in time order, and may hold more
  /// than `scans`. Throws InputError naming `source` where the points do not lie on the beams of a spinning
  /// lidar.
  [[nodiscard]] static ScanBuilder recover(std::span<const PointFields> scans, std::span<const Time> stamps,
                                           const std::string& source);

  ~ScanBuilder();
  ScanBuilder(ScanBuilder&&) noexcept;
  ScanBuilder& operator=(ScanBuilder&&) noexcept;

  /// The duration of a turn, where it is known better than by the model's rotation rate: the median distance
  /// of the stamps of a recording.
  void set_turn_duration(Duration turn);

  /// `stamp`: start of the scan where points have no times or times since the stamp. With times, the scan
  /// starts at its earliest point. Throws InputError naming `source`, the field and its value: fields of
  /// different lengths, x, y or z missing, rings that are not integers or not of the sensor, times that are
  /// not finite, coarser than the scan, all equal, or more than three turns after the first, points that do
  /// not lie on the sensor's beams.
  [[nodiscard]] LidarScan build(const PointFields& points, Time stamp,
                                const std::string& source = "scan") const;

  [[nodiscard]] const std::shared_ptr<const LidarModel>& model() const;
  /// Quality of the estimate; absent for a known sensor.
  [[nodiscard]] std::optional<ModelEstimate> estimate() const;
  /// How the sensor was recovered, one line each; empty for a known sensor.
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  struct State;
  explicit ScanBuilder(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace mapless
