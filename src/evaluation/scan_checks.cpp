#include "evaluation/scan_checks.hpp"

#include <limits>
#include <string>

#include <fmt/format.h>

#include "core/argument_checks.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

constexpr double kMaxRange_m = 1e6;  // as of a LidarModel

void require_length(std::size_t scan, std::size_t points, const char* what, std::size_t found) {
  if (found == points) return;
  throw InputError({fmt::format("scan {}", scan), what, std::to_string(found),
                    fmt::format("truth has {} points", points),
                    "compare results and truth of the same scan"});
}

}  // namespace

void require_range_limit(std::string_view function, double max_range_m) {
  require_between(function, "max_range_m", max_range_m, std::numeric_limits<double>::min(), kMaxRange_m);
}

void require_equal_lengths(std::size_t scan, std::size_t points, std::size_t results, std::size_t ranges) {
  require_length(scan, points, "result", results);
  require_length(scan, points, "ranges", ranges);
}

}  // namespace mapless
