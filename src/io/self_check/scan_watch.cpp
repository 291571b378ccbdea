#include <cstdint>
#include <cstring>

#include <fmt/format.h>

#include "io/self_check/beam_check.hpp"
#include "io/self_check/range_check.hpp"
#include "io/self_check/scan_checks.hpp"
#include "io/self_check/time_check.hpp"
#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {
namespace {

// What is wrong for half a second is seen, at a third of the cost.
constexpr std::size_t kEvery = 3;

// FNV-1a, over the bits of all ranges with the beams they belong to.
std::uint64_t hash_of(const LidarScan& scan) {
  std::uint64_t hash = 14695981039346656037U;
  const auto mix = [&](std::uint32_t word) { hash = (hash ^ word) * 1099511628211U; };
  for (const LidarReturn& r : scan.returns) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &r.range_m, sizeof bits);
    mix(bits);
    mix(static_cast<std::uint32_t>(r.column));
  }
  return hash;
}

}  // namespace

struct ScanWatch::State {
  Findings beams{"beams"}, ranges{"ranges"}, times{"times"};
  std::vector<std::size_t> repeated;  // scans that are the one before them
  std::size_t scans = 0;
  std::uint64_t last_hash = 0;
};

ScanWatch::ScanWatch() : state_(std::make_unique<State>()) {}
ScanWatch::~ScanWatch() = default;

void ScanWatch::add(const LidarScan& scan, std::size_t k) {
  State& s = *state_;
  const std::uint64_t hash = hash_of(scan);
  if (s.scans > 0 && scan.returns.size() >= kFewestSamples && hash == s.last_hash) s.repeated.push_back(k);
  s.last_hash = hash;
  if (s.scans++ % kEvery != 0) return;
  const auto keep_wrong = [k](Findings& findings, const ScanFinding& found) {
    if (found.trust == Trust::wrong) findings.add(found, k);
  };
  keep_wrong(s.beams, check_beams(scan, nullptr));
  keep_wrong(s.ranges, check_ranges(scan));
  keep_wrong(s.times, check_point_times(scan));
}

std::vector<std::string> ScanWatch::lines() const {
  const State& s = *state_;
  std::vector<std::string> out;
  for (const auto& [name, findings] :
       {std::pair("beams", &s.beams), std::pair("ranges", &s.ranges), std::pair("times", &s.times)}) {
    if (const std::string line = findings->line(); !line.empty())
      out.push_back(fmt::format("doubtful {}: {}", name, line));
  }
  // A simulated sensor at rest, without noise, sees the same in every scan; a driver that stalls, in some.
  if (!s.repeated.empty() && 2 * s.repeated.size() < s.scans) {
    const std::string others =
        s.repeated.size() > 1 ? fmt::format(" (and {} others)", s.repeated.size() - 1) : "";
    out.push_back(fmt::format("doubtful scans: scan {}{}: the same points as the scan before it, to the bit",
                              s.repeated.front(), others));
  }
  return out;
}

}  // namespace mapless
