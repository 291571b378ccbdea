#include "trajectory/domain.hpp"

#include <fmt/format.h>

#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {

namespace {

// Seconds with all nine decimals.
std::string seconds_text(Time t) {
  constexpr std::uint64_t kNanosecondsPerSecond = 1'000'000'000;
  const std::int64_t ns = t.nanoseconds();
  // The magnitude of the most negative time does not fit the signed type.
  const std::uint64_t magnitude = ns < 0 ? -static_cast<std::uint64_t>(ns) : static_cast<std::uint64_t>(ns);
  return fmt::format("{}{}.{:09}", ns < 0 ? "-" : "", magnitude / kNanosecondsPerSecond,
                     magnitude % kNanosecondsPerSecond);
}

}  // namespace

void require_covered(Time t, Time begin, Time end, const std::string& source) {
  if (begin <= t && t <= end) return;
  throw TrajectoryDomainError(
      {source, "time", seconds_text(t) + " s",
       fmt::format("the trajectory covers {} s to {} s", seconds_text(begin), seconds_text(end)),
       "give a trajectory of the whole recording, choose fewer scans or allow more extrapolation"});
}

void IncreasingTimes::add(Time t) {
  if (count_ > 0 && t <= last_) {
    throw InputError({source_, fmt::format("time of {} {}", what_, count_), seconds_text(t) + " s",
                      fmt::format("not after the {} before it at {} s", what_, seconds_text(last_)),
                      fmt::format("give every {} once, in order of time", what_)});
  }
  last_ = t;
  ++count_;
}

void IncreasingTimes::finish() const {
  if (count_ >= 2) return;
  throw InputError({source_, what_ + "s", fmt::format("{}", count_), "a trajectory needs at least two",
                    fmt::format("give a {} before and after the recording", what_)});
}

}  // namespace mapless
