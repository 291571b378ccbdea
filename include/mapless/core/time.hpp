#pragma once

#include <compare>
#include <cstdint>

namespace mapless::inline v1 {

/// A span of time in whole nanoseconds. There is no conversion from bare numbers: 2.0 and 2 must say what
/// they are.
class Duration {
 public:
  constexpr Duration() = default;
  [[nodiscard]] static constexpr Duration from_nanoseconds(std::int64_t ns) { return Duration(ns); }
  /// Rounds to the nearest nanosecond; |s| must be below 9.2e9 (292 years).
  [[nodiscard]] static constexpr Duration from_seconds(double s) {
    return Duration(static_cast<std::int64_t>(s * 1e9 + (s < 0 ? -0.5 : 0.5)));
  }

  [[nodiscard]] constexpr std::int64_t nanoseconds() const { return ns_; }
  [[nodiscard]] constexpr double seconds() const { return static_cast<double>(ns_) * 1e-9; }

  constexpr auto operator<=>(const Duration&) const = default;
  constexpr Duration operator-() const { return Duration(-ns_); }
  constexpr Duration operator+(Duration other) const { return Duration(ns_ + other.ns_); }
  constexpr Duration operator-(Duration other) const { return Duration(ns_ - other.ns_); }
  /// Rounds to the nearest nanosecond.
  constexpr Duration operator*(double factor) const { return from_seconds(seconds() * factor); }

 private:
  explicit constexpr Duration(std::int64_t ns) : ns_(ns) {}
  std::int64_t ns_ = 0;
};

/// An instant in whole nanoseconds since the recording's own epoch (Unix for most recordings).
class Time {
 public:
  constexpr Time() = default;
  [[nodiscard]] static constexpr Time from_nanoseconds(std::int64_t ns) { return Time(ns); }
  /// Rounds to the nearest nanosecond. A double holds a Unix time only to about 0.2 microseconds.
  [[nodiscard]] static constexpr Time from_seconds(double s) {
    return Time(Duration::from_seconds(s).nanoseconds());
  }

  [[nodiscard]] constexpr std::int64_t nanoseconds() const { return ns_; }
  [[nodiscard]] constexpr double seconds() const { return static_cast<double>(ns_) * 1e-9; }

  constexpr auto operator<=>(const Time&) const = default;
  constexpr Time operator+(Duration d) const { return Time(ns_ + d.nanoseconds()); }
  constexpr Time operator-(Duration d) const { return Time(ns_ - d.nanoseconds()); }
  constexpr Duration operator-(Time other) const { return Duration::from_nanoseconds(ns_ - other.ns_); }

 private:
  explicit constexpr Time(std::int64_t ns) : ns_(ns) {}
  std::int64_t ns_ = 0;
};

}  // namespace mapless
