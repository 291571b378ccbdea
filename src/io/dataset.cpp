#include <fmt/format.h>

#include "io/files/text.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {

std::size_t Dataset::checked(std::size_t k) const {
  if (k < size()) return k;
  throw ParameterError({format(), "scan", std::to_string(k),
                        fmt::format("the recording has {} scans", size()), "count scans from 0"});
}

void require_time_order(const Dataset& dataset, std::size_t first, std::size_t count) {
  for (std::size_t k = first + 1; k < first + count; ++k) {
    const Time before = dataset.scan_start(k - 1);
    const Time start = dataset.scan_start(k);
    if (start > before) continue;
    throw InputError({dataset.scan_file(k).string(), fmt::format("start of scan {}", k),
                      decimal_seconds(start) + " s",
                      fmt::format("not after that of scan {} ({} s)", k - 1, decimal_seconds(before)),
                      "correct the times of the recording, or choose scans with --first and --count"});
  }
}

}  // namespace mapless
