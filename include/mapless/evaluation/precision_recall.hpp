#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace mapless::inline v1 {

/// Points by truth and prediction, "positive" meaning dynamic. A rate whose denominator is 0 is absent, never
/// 0 or 1.
struct Counts {
  std::int64_t tp = 0;
  std::int64_t fp = 0;
  std::int64_t fn = 0;
  std::int64_t tn = 0;

  Counts& operator+=(const Counts& other);
  bool operator==(const Counts&) const = default;

  [[nodiscard]] std::int64_t points() const { return tp + fp + fn + tn; }
  [[nodiscard]] std::optional<double> precision() const;  ///< TP / (TP + FP)
  [[nodiscard]] std::optional<double> recall() const;     ///< TP / (TP + FN)
  [[nodiscard]] std::optional<double> f1() const;         ///< 2 TP / (2 TP + FP + FN)
  /// Intersection over union of the moving class, TP / (TP + FP + FN), as semantic-kitti-api counts it.
  [[nodiscard]] std::optional<double> iou() const;
};

/// Compares one scan, point by point. `truth` are labels of the SemanticKITTI moving-object convention;
/// points whose truth is unknown (0, 1) do not count. `predicted_dynamic` is not 0 where the point was called
/// dynamic. `counted`, if not empty, is 0 where a point does not count (beyond a range limit). All of one
/// length; throws InputError otherwise.
[[nodiscard]] Counts count_points(std::span<const std::uint32_t> truth,
                                  std::span<const std::uint8_t> predicted_dynamic,
                                  std::span<const std::uint8_t> counted = {});

/// Precision and recall over scans as the paper reports them (its section V): *total* from the sums of TP, FP
/// and FN, *average* as the mean over the scans whose own denominator is not 0 (N_p scans for precision, N_r
/// for recall).
class PrecisionRecall {
 public:
  void add(const Counts& scan);

  [[nodiscard]] const Counts& total() const { return total_; }
  [[nodiscard]] std::int64_t scans() const { return scans_; }
  [[nodiscard]] std::optional<double> average_precision() const;
  [[nodiscard]] std::optional<double> average_recall() const;
  [[nodiscard]] std::int64_t precision_scans() const { return precision_scans_; }  ///< N_p
  [[nodiscard]] std::int64_t recall_scans() const { return recall_scans_; }        ///< N_r

 private:
  Counts total_;
  std::int64_t scans_ = 0;
  std::int64_t precision_scans_ = 0;
  std::int64_t recall_scans_ = 0;
  double precision_sum_ = 0;
  double recall_sum_ = 0;
};

}  // namespace mapless
