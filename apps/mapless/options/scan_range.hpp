#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <CLI/App.hpp>

namespace mapless::app {

/// Which scans of a result a verb shows: --scans A:B and --every N.
struct ScanRange {
  std::string range;  ///< "A:B", both ends included; either may be left out
  std::size_t every = 1;

  /// Those of `scans` (numbers, increasing) within the range, every Nth of them from its first on. Throws
  /// ParameterError for a range that is not one, and if no scan lies in it.
  [[nodiscard]] std::vector<std::size_t> of(const std::vector<std::size_t>& scans) const;
};

/// Adds --scans and --every.
void add_scan_range_options(CLI::App& verb, ScanRange& range);

}  // namespace mapless::app
