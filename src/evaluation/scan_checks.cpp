#include "evaluation/scan_checks.hpp"

#include <limits>
#include <string>

#include <fmt/format.h>

#include "core/argument_checks.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

constexpr double kMaxRange_m = 1e6;  // as of a LidarModel

void require_length(const LabelledScan& scan, const char* what, std::size_t found) {
  if (found == scan.truth.size()) return;
  throw InputError({fmt::format("scan {}", scan.number), what, std::to_string(found),
                    fmt::format("truth has {} points", scan.truth.size()),
                    "compare results and truth of the same scan"});
}

}  // namespace

void require_range_limit(std::string_view function, double max_range_m) {
  require_between(function, "max_range_m", max_range_m, std::numeric_limits<double>::min(), kMaxRange_m);
}

void require_equal_lengths(const LabelledScan& scan) {
  require_length(scan, "result", scan.result.size());
  require_length(scan, "ranges", scan.ranges_m.size());
}

}  // namespace mapless
