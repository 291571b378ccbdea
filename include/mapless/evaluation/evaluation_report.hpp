#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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

/// How many of some were found: a share whose denominator is 0 is absent.
struct Found {
  std::int64_t found = 0;
  std::int64_t of = 0;

  bool operator==(const Found&) const = default;
  [[nodiscard]] std::optional<double> share() const;
};

/// What lies in (above, up_to], in the first band at 0 too; up_to of the last band is infinite.
template <class What>
struct InBand {
  double above = 0;
  double up_to = 0;
  What counts;
};

/// Points no farther from their laser than a limit: the paper's plot of recall over a range limit.
struct WithinRange {
  double limit_m = 0;
  PrecisionRecall points;
};

/// Points and objects of one class of the recording's objects.csv.
struct OfClass {
  std::string object_class;  ///< kNoObject: object id 0. kUnlisted: an id that objects.csv does not have
  Counts points;
  Found objects;                        ///< as EvaluationReport::objects
  std::optional<Found> evident_movers;  ///< as EvaluationReport::evident_movers
};
inline constexpr std::string_view kNoObject = "(no object)";
inline constexpr std::string_view kUnlisted = "(unlisted)";

/// Where the errors are: points of one class and kind ("mover", "parked") of objects.csv. FP are its points
/// called dynamic while they stand still, FN those that were missed.
struct OfKind {
  std::string object_class;  ///< as OfClass::object_class
  std::string kind;          ///< empty for kNoObject and kUnlisted
  Counts points;
};

/// Objects of the result: the numbers in the high 16 bits of its dynamic labels, each counted in every scan
/// it is in.
struct FalseObjects {
  std::int64_t scans = 0;
  std::int64_t objects = 0;     ///< with at least one point of known truth
  std::int64_t false_ones = 0;  ///< of these, those of whose points of known truth more than half are static
  std::int64_t unnumbered_points = 0;  ///< dynamic points of no object

  /// Absent without a scan, and where points are called dynamic but none belongs to an object.
  [[nodiscard]] std::optional<double> per_scan() const;
};

/// How well labels agree with the truth. "Dynamic" and "static" are of motion_of_label (io/labels.hpp);
/// points whose truth is unknown (0, 1) count nowhere, a predicted label that is not dynamic counts as
/// static.
///
/// Ranges are those of the return, from its own laser. An *object* is all points of a scan whose true label
/// has its id (not 0) in the high 16 bits; its *visible points* are these, static or dynamic. An object in a
/// scan counts where at least one of its points is dynamic, and is *found* where at least half of its dynamic
/// points are called dynamic. Its true speed is that of object_states.csv: of its body's origin in the middle
/// of the scan.
struct EvaluationReport {
  PrecisionRecall points;  ///< of all points that count, total and average over scans

  std::vector<InBand<Counts>> by_range;   ///< [m]; points without a return are in no band
  std::vector<WithinRange> within_range;  ///< every 5 m
  std::vector<OfClass> by_class;          ///< by name; empty without objects.csv
  std::vector<OfKind> by_kind;            ///< by name; empty without objects.csv

  /// Recall of dynamic points by their object's true speed [m/s]; empty without object_states.csv.
  std::vector<InBand<Found>> by_speed;
  /// Recall of dynamic points by the number of visible points of their object; points of no object in no
  /// band.
  std::vector<InBand<Found>> by_visible_points;

  Found objects;  ///< objects in scans
  /// The same among those faster than kEvidentSpeed with kEvidentPoints visible points or more, whose mean
  /// range is at most kEvidentRange; absent without object_states.csv.
  std::optional<Found> evident_movers;
  FalseObjects false_objects;
};
inline constexpr double kEvidentSpeed = 0.5;  ///< [m/s]
inline constexpr std::int64_t kEvidentPoints = 20;
inline constexpr double kEvidentRange = 50;  ///< [m]

}  // namespace mapless
