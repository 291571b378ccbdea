#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace mapless::inline v1 {

/// Room evaluation: how well a result agrees with the truth. In go true and estimated labels, objects and
/// poses; out come reports. It knows files and recordings, and nothing of how labels are made. A rate whose
/// denominator is 0 is absent, never 0 or 1.

/// Confusion matrix of points; "positive" means dynamic.
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

/// Counts the points of one scan. `truth`: labels of the SemanticKITTI moving-object convention; points of
/// unknown truth (0, 1) do not count. `predicted_dynamic`: not 0 for points labelled dynamic. `counted`:
/// empty, or 0 for points that do not count (beyond a range limit). Throws InputError if the lengths differ.
[[nodiscard]] Counts count_points(std::span<const std::uint32_t> truth,
                                  std::span<const std::uint8_t> predicted_dynamic,
                                  std::span<const std::uint8_t> counted = {});

/// Precision and recall over scans, as in section V of the paper: *total* from the sums of TP, FP and FN,
/// *average* as the mean over the scans with a denominator above 0 (N_p scans for precision, N_r for recall).
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

/// Number of found items out of all.
struct Found {
  std::int64_t found = 0;
  std::int64_t of = 0;

  bool operator==(const Found&) const = default;
  [[nodiscard]] std::optional<double> share() const;  ///< found / of; absent for of = 0
};

/// Counts of the values in (above, up_to]; the first band includes 0, and up_to of the last band is infinite.
template <class What>
struct Band {
  double above = 0;
  double up_to = 0;
  What counts;
};

/// Points within a range limit from their laser (the paper plots recall over this limit).
struct RangeLimitReport {
  double limit_m = 0;
  PrecisionRecall points;
};

/// Points and objects of one class of the recording's objects.csv.
struct ClassReport {
  std::string object_class;  ///< kNoObject: object id 0; kUnlisted: an id missing in objects.csv
  Counts points;
  Found objects;                        ///< as EvaluationReport::objects
  std::optional<Found> evident_movers;  ///< as EvaluationReport::evident_movers
};
inline constexpr std::string_view kNoObject = "(no object)";
inline constexpr std::string_view kUnlisted = "(unlisted)";

/// Points of one class and kind ("mover", "parked") of objects.csv. FP: static points labelled dynamic; FN:
/// dynamic points labelled static.
struct KindReport {
  std::string object_class;  ///< as ClassReport::object_class
  std::string kind;          ///< empty for kNoObject and kUnlisted
  Counts points;
};

/// Objects of the result (numbers in the high 16 bits of its dynamic labels), counted in every scan.
struct FalseObjects {
  std::int64_t scans = 0;
  std::int64_t objects = 0;            ///< with at least one point of known truth
  std::int64_t false_ones = 0;         ///< more than half of their points of known truth are static
  std::int64_t unnumbered_points = 0;  ///< dynamic points without an object number

  /// false_ones / scans; absent without a scan, and if there are dynamic points but none has an object
  /// number.
  [[nodiscard]] std::optional<double> per_scan() const;
};

/// Agreement of labels with the truth. Dynamic and static as motion_of_label (io/labels.hpp) defines them.
/// Points of unknown truth (0, 1) do not count; a predicted label that is not dynamic counts as static.
/// Ranges are distances from the laser. A true *object* consists of the points of a scan with its id (not 0)
/// in the high 16 bits of their true label: its *visible points*, static or dynamic. An object with at least
/// one dynamic point counts, and is *found* if at least half of its dynamic points are labelled dynamic. Its
/// true speed is that of its body's origin in the middle of the scan (object_states.csv).
struct EvaluationReport {
  PrecisionRecall points;  ///< of all points that count

  std::vector<Band<Counts>> by_range;          ///< [m]; without points that have no return
  std::vector<RangeLimitReport> within_range;  ///< every 5 m
  std::vector<ClassReport> by_class;           ///< by name; empty without objects.csv
  std::vector<KindReport> by_kind;             ///< by name; empty without objects.csv

  /// Recall of dynamic points by their object's true speed [m/s]; empty without object_states.csv.
  std::vector<Band<Found>> by_speed;
  /// Recall of dynamic points by the number of visible points of their object; without points of no object.
  std::vector<Band<Found>> by_visible_points;

  Found objects;  ///< counted in every scan
  /// Evident movers: objects faster than kEvidentSpeed_mps with at least kEvidentPoints visible points, at a
  /// mean range of at most kEvidentRange_m. Absent without object_states.csv.
  std::optional<Found> evident_movers;
  FalseObjects false_objects;
};
/// Chosen: an evident mover shows enough points and displacement (0.05 m a scan) to be detected.
inline constexpr double kEvidentSpeed_mps = 0.5;
inline constexpr std::int64_t kEvidentPoints = 20;
inline constexpr double kEvidentRange_m = 50;

}  // namespace mapless
