#pragma once

#include <string>

#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// Throws TrajectoryDomainError naming `source` and the three times unless begin <= t <= end.
void require_covered(Time t, Time begin, Time end, const std::string& source);

/// Throws InputError naming `source` unless time i comes before time i + 1, and there are at least two.
/// `what` is what they are times of: "pose" or "knot".
class IncreasingTimes {
 public:
  IncreasingTimes(std::string source, std::string what)
      : source_(std::move(source)), what_(std::move(what)) {}
  void add(Time t);
  void finish() const;

 private:
  std::string source_;
  std::string what_;
  std::size_t count_ = 0;
  Time last_;
};

}  // namespace mapless
