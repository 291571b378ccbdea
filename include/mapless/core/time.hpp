#pragma once

#include <chrono>
#include <compare>
#include <cstdint>
#include <utility>

namespace mapless::inline v1 {

namespace detail {
/// Throws ParameterError: `seconds` is NaN or beyond what an int64 of nanoseconds holds.
[[noreturn]] void refuse_seconds(double seconds);
}  // namespace detail

/// A span of time in whole nanoseconds. There is no conversion from bare numbers: the unit of 2.0 and of 2 is
/// named where a Duration is made.
class Duration {
 public:
  /// Largest magnitude from_seconds accepts: an int64 of nanoseconds holds 9.223e9 s (292 years).
  static constexpr double kMaxSeconds = 9.2e9;

  constexpr Duration() = default;
  [[nodiscard]] static constexpr Duration from_nanoseconds(std::int64_t ns) { return Duration(ns); }
  /// Rounds to the nearest nanosecond. Throws ParameterError for NaN and beyond kMaxSeconds.
  [[nodiscard]] static constexpr Duration from_seconds(double s) {
    if (!(s >= -kMaxSeconds && s <= kMaxSeconds)) detail::refuse_seconds(s);
    return Duration(static_cast<std::int64_t>(s * 1e9 + (s < 0 ? -0.5 : 0.5)));
  }

  [[nodiscard]] constexpr std::int64_t nanoseconds() const { return ns_; }
  [[nodiscard]] constexpr double seconds() const { return static_cast<double>(ns_) * 1e-9; }

  constexpr auto operator<=>(const Duration&) const = default;
  constexpr Duration operator-() const { return Duration(-ns_); }
  constexpr Duration operator+(Duration other) const { return Duration(ns_ + other.ns_); }
  constexpr Duration operator-(Duration other) const { return Duration(ns_ - other.ns_); }
  /// Rounds to the nearest nanosecond. Throws as from_seconds does.
  constexpr Duration operator*(double factor) const { return from_seconds(seconds() * factor); }

 private:
  explicit constexpr Duration(std::int64_t ns) : ns_(ns) {}
  std::int64_t ns_ = 0;
};

/// An instant, in whole nanoseconds since the recording's own epoch (Unix time for most recordings).
class Time {
 public:
  constexpr Time() = default;
  [[nodiscard]] static constexpr Time from_nanoseconds(std::int64_t ns) { return Time(ns); }
  /// Rounds to the nearest nanosecond. A double resolves a Unix time to about 0.2 microseconds only. Throws
  /// ParameterError for NaN and beyond Duration::kMaxSeconds.
  [[nodiscard]] static constexpr Time from_seconds(double s) {
    return Time(Duration::from_seconds(s).nanoseconds());
  }

  /// Times from outside are at most this far from 0 (126 years, [ns]): the difference of any two fits an
  /// int64.
  static constexpr std::int64_t kLargestOutside_ns = 4'000'000'000'000'000'000;

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

/// Adds the time from its construction to its destruction to `seconds` (steady clock).
class WallTime {
 public:
  explicit WallTime(double& seconds) : seconds_(seconds) {}
  ~WallTime() {
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  WallTime(const WallTime&) = delete;
  WallTime& operator=(const WallTime&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Runs `step`, adds its duration to `seconds` and returns its result.
template <class Step>
decltype(auto) timed(double& seconds, Step&& step) {
  const WallTime wall(seconds);
  return std::forward<Step>(step)();
}

}  // namespace mapless
