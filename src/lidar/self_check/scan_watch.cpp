#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "lidar/self_check/beam_check.hpp"
#include "lidar/self_check/range_check.hpp"
#include "lidar/self_check/scan_checks.hpp"
#include "lidar/self_check/time_check.hpp"
#include <mapless/lidar/self_check.hpp>

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

// Two scans are compared in every so-many-th column; a beam is the same where its ranges differ by less than
// three standard deviations of the difference of two ranges with noise of 0.025 m.
constexpr int kColumnStep = 8;
constexpr float kSame_m = 0.1F;
// Two scans are exchanged where both are more like the scan after next than the next, by this share of the
// beams, and where this stands out from the rest of the recording by so many standard deviations: the posts
// of a motorway bring a scan onto the next but one, again and again. Measured, the most in 66 right
// recordings: .014, on motorways .047 to .1; two scans exchanged: from .02 (on foot) to .15.
constexpr double kExchanged = 0.06, kOrderStandsOut = 4;
constexpr std::size_t kFewestUsual = 8;

// Ranges of a scan, of each laser in every kColumnStep-th column; NaN without a return.
std::vector<float> thinned(const LidarScan& scan) {
  std::vector<float> out;
  out.reserve(scan.cells.size() / static_cast<std::size_t>(kColumnStep) +
              static_cast<std::size_t>(scan.rows()));
  for (int row = 0; row < scan.rows(); ++row) {
    for (int column = 0; column < scan.columns; column += kColumnStep) {
      const std::int32_t cell = scan.cell(row, column);
      out.push_back(cell < 0 ? std::numeric_limits<float>::quiet_NaN()
                             : scan.returns[static_cast<std::size_t>(cell)].range_m);
    }
  }
  return out;
}

// Share of the beams with a return in both that have the same range.
double alike(const std::vector<float>& a, const std::vector<float>& b) {
  if (a.size() != b.size()) return 0;
  std::size_t same = 0, both = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const float difference_m = std::abs(a[i] - b[i]);
    both += difference_m >= 0 ? 1 : 0;  // not NaN
    same += difference_m < kSame_m ? 1 : 0;
  }
  return both >= kFewestSamples ? static_cast<double>(same) / static_cast<double>(both) : 0;
}

// Finds neighbouring scans p q r s of which q and r are exchanged: p and r, q and r, q and s are one scan
// apart then, p and q, r and s two.
class OrderWatch {
 public:
  void add(const LidarScan& scan, std::size_t k) {
    std::vector<float> image = thinned(scan);
    const double r_s = scans_ > 0 ? alike(last_, image) : 0, q_s = scans_ > 1 ? alike(second_, image) : 0;
    const double gain = std::min(p_r_ - p_q_, q_s - r_s);
    if (scans_ > 2 && gain > kExchanged && 2 * q_r_ > p_q_ + r_s) candidates_.emplace_back(k - 2, gain);
    if (scans_ > 2 && gain <= kExchanged) add_usual(gain);
    second_ = std::exchange(last_, std::move(image));
    p_q_ = std::exchange(q_r_, r_s);
    p_r_ = q_s;
    ++scans_;
  }
  // The first of each pair.
  [[nodiscard]] std::vector<std::size_t> exchanged() const {
    std::vector<std::size_t> out;
    if (usual_ < kFewestUsual) return out;
    const double limit = mean_ + kOrderStandsOut * std::sqrt(squares_ / static_cast<double>(usual_));
    for (const auto& [k, gain] : candidates_)
      if (gain > limit) out.push_back(k);
    return out;
  }

 private:
  // Running mean and sum of squares about it (Welford 1962).
  void add_usual(double gain) {
    const double difference = gain - mean_;
    mean_ += difference / static_cast<double>(++usual_);
    squares_ += difference * (gain - mean_);
  }

  std::size_t scans_ = 0;
  std::vector<float> last_, second_;    // r and q when s comes
  double p_q_ = 0, q_r_ = 0, p_r_ = 0;  // how alike they are
  std::vector<std::pair<std::size_t, double>> candidates_;
  std::size_t usual_ = 0;
  double mean_ = 0, squares_ = 0;
};

// A column is filled where this share of the lasers has a return: the ground, or a wall.
constexpr int kFilledShare = 4;
// Share of the columns filled in the scans before and after a scan that have no return in it. Of those, at
// least kFewestColumns.
constexpr double kLostShare = 0.05;
constexpr std::size_t kFewestColumns = 100;
// Something dark, or nearer than the least range, that passes the sensor gives no return either. It hides one
// stretch of columns, at most kWidestBlind of the turn, and another in the scan before or after, of at least
// 1 / kBlindShare of its columns. Chosen: in four recordings of random places it hid .05 to .37 of the turn.
constexpr double kWidestBlind = 0.4;
constexpr std::size_t kBlindShare = 20;

// Empty columns of one scan.
struct EmptyColumns {
  std::size_t columns = 0, stretches = 0;
};

// Of the columns that are empty in `here` and filled in the others. Stretches wrap at the seam; gaps of a
// hundredth of a turn are none.
EmptyColumns empty_columns(const std::vector<int>& here, const std::vector<bool>& elsewhere) {
  EmptyColumns out;
  const std::size_t widest_gap = here.size() / 100;
  std::size_t gap = widest_gap + 1, first = 0, last = 0;
  for (std::size_t c = 0; c < here.size(); ++c, ++gap) {
    if (here[c] > 0 || !elsewhere[c]) continue;
    if (out.columns++ == 0) first = c;
    if (gap > widest_gap) ++out.stretches;
    last = c;
    gap = 0;
  }
  if (out.stretches > 1 && first + here.size() - last <= widest_gap) --out.stretches;
  return out;
}

// Finds columns without a return in one scan between two scans that have some there.
class ColumnWatch {
 public:
  // What it finds of the scan before.
  [[nodiscard]] ScanFinding add(const LidarScan& scan) {
    std::vector<int> filling(static_cast<std::size_t>(scan.columns), 0);
    for (const LidarReturn& r : scan.returns) ++filling[static_cast<std::size_t>(r.column)];
    const bool comparable = before_.size() == filling.size() && last_.size() == filling.size();
    ScanFinding found;
    if (comparable) found = compare(filling, scan.rows());
    before_ = std::exchange(last_, std::move(filling));
    return found;
  }

 private:
  [[nodiscard]] ScanFinding compare(const std::vector<int>& after, int rows) const {
    std::vector<bool> filled(after.size()), filled_here(after.size());
    for (std::size_t c = 0; c < after.size(); ++c) {
      filled[c] = kFilledShare * std::min(before_[c], after[c]) >= rows;
      filled_here[c] = kFilledShare * last_[c] >= rows;
    }
    const auto all = static_cast<std::size_t>(std::count(filled.begin(), filled.end(), true));
    const EmptyColumns lost = empty_columns(last_, filled);
    ScanFinding found;
    found.size = static_cast<double>(lost.columns) / static_cast<double>(std::max(all, kFewestColumns));
    if (found.size < kLostShare) return found;
    const auto also_hidden_in = [&](const std::vector<int>& other) {
      const EmptyColumns there = empty_columns(other, filled_here);
      return there.stretches == 1 && kBlindShare * there.columns >= lost.columns;
    };
    const double turns = static_cast<double>(lost.columns) / static_cast<double>(after.size());
    if (lost.stretches == 1 && turns <= kWidestBlind && (also_hidden_in(before_) || also_hidden_in(after)))
      return found;
    found.trust = Trust::wrong;
    found.problem = fmt::format(
        "{} columns have no return, of {} that have in the scan before it and in the one after it: lost "
        "packets?",
        lost.columns, all);
    return found;
  }

  std::vector<int> before_, last_;  // returns of each column
};

}  // namespace

struct ScanWatch::State {
  OrderWatch order;
  ColumnWatch columns;
  Findings beams{"beams"}, ranges{"ranges"}, times{"times"}, lost{"columns"};
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
  s.order.add(scan, k);
  const auto keep_wrong = [k](Findings& findings, const ScanFinding& found) {
    if (found.trust == Trust::wrong) findings.add(found, k);
  };
  if (const ScanFinding found = s.columns.add(scan); found.trust == Trust::wrong) s.lost.add(found, k - 1);
  if (s.scans++ % kEvery != 0) return;
  keep_wrong(s.beams, check_beams(scan, {}));
  keep_wrong(s.ranges, check_ranges(scan));
  keep_wrong(s.times, check_point_times(scan));
}

std::vector<std::string> ScanWatch::take_lines() {
  std::vector<std::string> out = lines();
  if (!out.empty()) *state_ = State();
  return out;
}

std::vector<std::string> ScanWatch::lines() const {
  const State& s = *state_;
  std::vector<std::string> out;
  for (const auto& [name, findings] : {std::pair("beams", &s.beams), std::pair("ranges", &s.ranges),
                                       std::pair("times", &s.times), std::pair("columns", &s.lost)}) {
    if (const std::string line = findings->line(); !line.empty())
      out.push_back(fmt::format("doubtful {}: {}", name, line));
  }
  if (const auto pairs = s.order.exchanged(); !pairs.empty()) {
    const std::string others =
        pairs.size() > 1 ? fmt::format(" (and {} other places)", pairs.size() - 1) : "";
    out.push_back(fmt::format(
        "doubtful order: scans {} and {}{} look exchanged: the scan before them is more like the second, the "
        "scan after them like the first",
        pairs.front(), pairs.front() + 1, others));
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
