#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

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
