#include "options/scan_range.hpp"

#include <charconv>
#include <limits>
#include <string_view>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/option_checks.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::app {
namespace {

[[noreturn]] void refuse(const std::string& range) {
  throw ParameterError({"--scans", "", range, "is not a range of scan numbers",
                        "give A:B, A: or :B with whole numbers, A not above B"});
}

std::size_t end_of_range(const std::string& range, std::string_view text, std::size_t otherwise) {
  if (text.empty()) return otherwise;
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) refuse(range);
  return value;
}

}  // namespace

std::vector<std::size_t> ScanRange::of(const std::vector<std::size_t>& scans) const {
  std::size_t first = 0, last = std::numeric_limits<std::size_t>::max();
  if (!range.empty()) {
    const std::string_view text = range;
    const std::size_t colon = text.find(':');
    if (colon == std::string_view::npos) refuse(range);
    first = end_of_range(range, text.substr(0, colon), first);
    last = end_of_range(range, text.substr(colon + 1), last);
    if (first > last) refuse(range);
  }
  std::vector<std::size_t> chosen;
  std::size_t within = 0;
  for (const std::size_t k : scans) {
    if (k < first || k > last) continue;
    if (within++ % every == 0) chosen.push_back(k);
  }
  if (chosen.empty()) {
    throw ParameterError({"--scans", "", range, "there is no labelled scan in this range",
                          scans.empty()
                              ? "give a result with labels"
                              : fmt::format("labelled are scans {} to {}", scans.front(), scans.back())});
  }
  return chosen;
}

void add_scan_range_options(CLI::App& verb, ScanRange& range) {
  verb.add_option("--scans", range.range,
                  "scans A:B, both included; A: and :B too. Default: all labelled scans")
      ->check(not_empty());
  verb.add_option("--every", range.every, "only every Nth of these scans")
      ->check(whole_number(1))
      ->capture_default_str();
}

}  // namespace mapless::app
