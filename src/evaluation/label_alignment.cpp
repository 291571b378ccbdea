#include "evaluation/label_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>

#include <fmt/format.h>

#include <mapless/core/errors.hpp>
#include <mapless/io/labels.hpp>

namespace mapless::inline v1 {
namespace {

// mapless detect labels the records with a return and no others: a result of these very scans has no
// misplaced label. Other scans of one place have returns and gaps in 5 % of the rays exchanged, and more.
constexpr double kMostMisplaced = 0.01;
// True labels of other programs may mark records that this one takes for faulty. Labels of another scan are
// where it has no return as often as any place of a scan: a tenth of a town's rays and more.
constexpr double kMostMovingNowhere = 0.05;
constexpr std::size_t kFewestMoving = 100;

}  // namespace

void LabelAlignment::add(const ScanLabels& scan) {
  const auto has_return = [&scan](std::size_t i) { return !std::isnan(scan.ranges_m[i]); };
  for (std::size_t i = 0; i < scan.truth.size(); ++i) {
    if (motion_of_label(scan.truth[i]) != MotionTruth::moving) continue;
    ++moving_;
    if (!has_return(i)) ++moving_nowhere_;
  }
  const auto is_unknown = [](std::uint32_t label) { return label == kLabelUnknown; };
  // All unknown: the odometry has lost the motion.
  if (std::all_of(scan.result.begin(), scan.result.end(), is_unknown)) return;
  records_ += scan.result.size();
  for (std::size_t i = 0; i < scan.result.size(); ++i) {
    if (has_return(i) == is_unknown(scan.result[i])) ++misplaced_;
  }
}

void LabelAlignment::require(const ResultFolder& result) const {
  const bool own = std::filesystem::exists(result.summary());
  if (own && static_cast<double>(misplaced_) > kMostMisplaced * static_cast<double>(records_)) {
    throw InputError({result.labels().string(), "labels", fmt::format("{} of {}", misplaced_, records_),
                      "are at records without a return, or missing where there is one: the result is of "
                      "another recording",
                      "give the recording this result was made from, with the same --sensor"});
  }
  if (moving_ >= kFewestMoving &&
      static_cast<double>(moving_nowhere_) > kMostMovingNowhere * static_cast<double>(moving_)) {
    throw InputError({"true labels", "moving points", fmt::format("{} of {}", moving_nowhere_, moving_),
                      "are records without a return: these labels are of another recording",
                      "give those of this recording (--labels)"});
  }
}

}  // namespace mapless
