#include "io/self_check/motion_check.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "io/self_check/pose_mistakes.hpp"
#include "io/self_check/pose_pair.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

// A motion is better where the sum over the places is beyond chance by so many standard deviations, and half
// of the places by kBetterAtHalf.
constexpr double kBetter = 4, kBetterAtHalf = 2;
// Vehicles that move along, and the rows of points themselves, which move with the sensor and lie on each
// other where it rests, speak for less motion: as much for this share of it.
constexpr double kMuchLess = 0.6;
// A true scale is a peak: as far beyond it the world is no sharper than under the poses. But where rows of
// points wander over a curved ground, ever less motion looks ever sharper.
constexpr double kShorter = 0.91, kLonger = 1.1;
constexpr double kBeyondShorter = 0.82, kBeyondLonger = 1.21;
// Distance between two scans that tells positions a tenth too long: 0.4 m of 4 m, and 0.08 m, which is the
// tolerance of a surface (PosePair), of the least.
constexpr double kFar_m = 4, kLeastFar_m = 0.8;
constexpr double kLongest_s = 4;
// Time between two scans that tells poses that are late, by the change of the velocity.
constexpr double kChanging_s = 1;
// Least displacement of points at kArm_m by poses that are 0.1 s late.
constexpr double kArm_m = 10, kLeastShift_m = 0.04, kShift_s = 0.1;

using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;  // numbers of scans

// Other motions, each with what it says of the recording, and where to look. A motion without a text is not
// believed: the others must be better than it is.
struct Question {
  std::string name;
  std::string what;  // that is varied
  Pairs pairs;
  std::vector<Motion> motions;
  std::vector<std::string> texts;
};

Motion scaled(const Motion& said, double factor) {
  return [said, factor](Time t) -> std::optional<SE3> {
    const auto T = said(t);
    return T ? std::optional(SE3(T->rotation(), factor * T->translation())) : std::nullopt;
  };
}

Motion later(const Motion& said, double seconds) {
  return [said, seconds](Time t) { return said(t + Duration::from_seconds(seconds)); };
}

double distance_m(const Motion& said, Time a, Time b) {
  const auto from = said(a), to = said(b);
  return from && to ? (from->inverse() * *to).translation().norm() : 0;
}

// How far points at kArm_m are displaced between two scans where the poses are late.
double displacement_m(const Motion& said, Time a, Time b) {
  const Motion late = later(said, kShift_s);
  const auto from = said(a), to = said(b), late_from = late(a), late_to = late(b);
  if (!from || !to || !late_from || !late_to) return 0;
  const Vector6d change = ((from->inverse() * *to).inverse() * (late_from->inverse() * *late_to)).log();
  return change.head<3>().norm() + kArm_m * change.tail<3>().norm();
}

// Pairs spread over the recording, each so far apart that the scale shows.
Pairs far_pairs(const Dataset& dataset, const Motion& said, std::size_t first, std::size_t last,
                std::size_t places) {
  Pairs out;
  for (std::size_t i = 0; i < places; ++i) {
    const std::size_t k = first + i * (last - first) / places;
    const Time start = dataset.scan_start(k);
    std::size_t m = k + 1;
    while (m < last && (dataset.scan_start(m) - start).seconds() < kLongest_s &&
           distance_m(said, start, dataset.scan_start(m)) < kFar_m)
      ++m;
    if (m <= last && distance_m(said, start, dataset.scan_start(m)) > kLeastFar_m) out.emplace_back(k, m);
  }
  return out;
}

// Pairs where the velocity changes most.
Pairs changing_pairs(const Dataset& dataset, const Motion& said, std::size_t first, std::size_t last,
                     std::size_t places) {
  std::vector<std::pair<double, std::pair<std::size_t, std::size_t>>> sizes;
  for (std::size_t k = first, m = first; k <= last; ++k) {
    while (m < last && (dataset.scan_start(m) - dataset.scan_start(k)).seconds() < kChanging_s) ++m;
    const double size = displacement_m(said, dataset.scan_start(k), dataset.scan_start(m));
    if (size > kLeastShift_m) sizes.emplace_back(size, std::pair(k, m));
  }
  std::sort(sizes.rbegin(), sizes.rend());
  Pairs out;
  for (const auto& [size, pair] : sizes) {
    if (out.size() == places) break;
    const bool near = std::any_of(out.begin(), out.end(), [pair = pair](const auto& other) {
      return pair.first < other.second && other.first < pair.second;
    });
    if (!near) out.push_back(pair);
  }
  return out;
}

// How much better each alternative is, at each place.
std::vector<std::vector<double>> preferences(const Dataset& dataset, const Motion& said, const Question& of) {
  std::vector<std::vector<double>> out(of.motions.size());
  for (const auto& [k, m] : of.pairs) {
    try {
      const LidarScan first = dataset.read(k), second = dataset.read(m);
      const std::vector<double> at_place = PosePair(first, second).preferences(said, of.motions);
      for (std::size_t i = 0; i < out.size(); ++i) out[i].push_back(at_place[i]);
    } catch (const InputError&) {  // the run says so when it reaches the scan
    }
  }
  return out;
}

// Half of the values are at least this.
double at_half(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Answer {
  std::size_t best = 0;  // of the motions
  double size = 0, beyond_rivals = 0;
};

// The motion that is better than the poses, and by most.
Answer answer_of(const Question& of, const std::vector<std::vector<double>>& found) {
  Answer out;
  double rival = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double sum = std::accumulate(found[i].begin(), found[i].end(), 0.0);
    const double size = sum / std::sqrt(static_cast<double>(found[i].size()));
    if (of.texts[i].empty()) {
      rival = std::max(rival, size);
    } else if (at_half(found[i]) > kBetterAtHalf && size > out.size) {
      out = {i, size, 0};
    }
  }
  out.beyond_rivals = out.size - rival;
  return out;
}

CheckResult result_of(const Dataset& dataset, const Motion& said, const Question& of) {
  CheckResult out{
      of.name, Trust::unknown, "not checked: no poses, too little motion, or it hardly changes", "", "", ""};
  if (of.pairs.size() < 2) return out;
  const std::vector<std::vector<double>> found = preferences(dataset, said, of);
  const std::size_t places = found.front().size();
  if (places < 2) return out;
  const Answer answer = answer_of(of, found);
  out.trust = answer.beyond_rivals > kBetter ? Trust::doubtful : Trust::right;
  out.measured = fmt::format("at {} places, the static world is no sharper with another {}", places, of.what);
  if (out.trust == Trust::right) return out;
  out.measured = fmt::format("at {} places, the static world is sharper if {}, by {:.1f} standard deviations",
                             places, of.texts[answer.best], answer.size);
  out.where = dataset.scan_file(of.pairs.front().first).string();
  out.problem = out.measured;
  out.remedy = "correct the poses, or leave them out (--odometry)";
  return out;
}

Question scale_question(const Motion& said, Pairs pairs) {
  Question out{"pose scale", "scale of the poses", std::move(pairs), {}, {}};
  for (const double factor : {kMuchLess, kBeyondShorter, kBeyondLonger}) {
    out.motions.push_back(scaled(said, factor));
    out.texts.emplace_back();
  }
  for (const double factor : {kShorter, kLonger}) {
    out.motions.push_back(scaled(said, factor));
    out.texts.push_back(
        fmt::format("positions are multiplied by {:.2f}, or points by {:.2f} (yards?)", factor, 1 / factor));
  }
  return out;
}

Question times_question(const Motion& said, Pairs pairs) {
  Question out{"pose times", "time of the poses", std::move(pairs), {}, {}};
  for (const double seconds : {-0.2, -0.1, -0.05, 0.05, 0.1, 0.2}) {
    out.motions.push_back(later(said, seconds));
    out.texts.push_back(fmt::format("the times of the poses are {:.2f} s too {}", std::abs(seconds),
                                    seconds > 0 ? "late" : "early"));
  }
  return out;
}

}  // namespace

std::vector<CheckResult> check_motion(const Dataset& dataset, const std::shared_ptr<const Trajectory>& given,
                                      std::size_t first, std::size_t count, std::size_t places) {
  const Motion said = given ? motion_of(given) : Motion();
  Pairs far, changing;
  if (given && count > 1) {
    const std::size_t last = first + count - 1;
    far = far_pairs(dataset, said, first, last, places);
    changing = changing_pairs(dataset, said, first, last, places);
  }
  return {result_of(dataset, said, scale_question(said, std::move(far))),
          result_of(dataset, said, times_question(said, std::move(changing)))};
}

}  // namespace mapless
