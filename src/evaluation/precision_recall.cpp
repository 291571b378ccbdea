#include <string>

#include <mapless/core/errors.hpp>
#include <mapless/evaluation/evaluator.hpp>
#include <mapless/io/labels.hpp>

namespace mapless::inline v1 {
namespace {

std::optional<double> ratio(std::int64_t numerator, std::int64_t denominator) {
  if (denominator == 0) return std::nullopt;
  return static_cast<double>(numerator) / static_cast<double>(denominator);
}

void require_length(const char* what, std::size_t found, std::size_t expected) {
  if (found == expected) return;
  throw InputError({"evaluation", what, std::to_string(found),
                    "truth has " + std::to_string(expected) + " points",
                    "compare results and truth of the same scan"});
}

}  // namespace

Counts& Counts::operator+=(const Counts& other) {
  tp += other.tp;
  fp += other.fp;
  fn += other.fn;
  tn += other.tn;
  return *this;
}

std::optional<double> Counts::precision() const { return ratio(tp, tp + fp); }
std::optional<double> Counts::recall() const { return ratio(tp, tp + fn); }
std::optional<double> Counts::f1() const { return ratio(2 * tp, 2 * tp + fp + fn); }
std::optional<double> Counts::iou() const { return ratio(tp, tp + fp + fn); }

Counts count_points(std::span<const std::uint32_t> truth, std::span<const std::uint8_t> predicted_dynamic,
                    std::span<const std::uint8_t> counted) {
  require_length("predictions", predicted_dynamic.size(), truth.size());
  if (!counted.empty()) require_length("mask", counted.size(), truth.size());
  Counts counts;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!counted.empty() && counted[i] == 0) continue;
    const bool dynamic = predicted_dynamic[i] != 0;
    switch (motion_of_label(truth[i])) {
      case MotionTruth::unknown:
        break;
      case MotionTruth::still:
        ++(dynamic ? counts.fp : counts.tn);
        break;
      case MotionTruth::moving:
        ++(dynamic ? counts.tp : counts.fn);
        break;
    }
  }
  return counts;
}

void PrecisionRecall::add(const Counts& scan) {
  total_ += scan;
  ++scans_;
  if (const auto precision = scan.precision()) {
    precision_sum_ += *precision;
    ++precision_scans_;
  }
  if (const auto recall = scan.recall()) {
    recall_sum_ += *recall;
    ++recall_scans_;
  }
}

std::optional<double> PrecisionRecall::average_precision() const {
  if (precision_scans_ == 0) return std::nullopt;
  return precision_sum_ / static_cast<double>(precision_scans_);
}

std::optional<double> PrecisionRecall::average_recall() const {
  if (recall_scans_ == 0) return std::nullopt;
  return recall_sum_ / static_cast<double>(recall_scans_);
}

}  // namespace mapless
