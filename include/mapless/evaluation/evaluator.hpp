#pragma once

/// @file
/// Room evaluation: how well a result agrees with the truth. In go true and estimated labels, objects and
/// poses; out come reports. It knows files and recordings, and nothing of how labels are made. A rate whose
/// denominator is 0 is absent, never 0 or 1.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <mapless/io/dataset.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

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

/// Points of one class and kind ("mover", "parked", "carrier") of objects.csv. FP: static points labelled
/// dynamic; FN: dynamic points labelled static.
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

/// Labels of one scan, true and predicted; every span has one entry per input record.
struct ScanLabels {
  std::size_t number = 0;                 ///< of the scan in the recording, from 0
  std::span<const std::uint32_t> truth;   ///< labels (io/labels.hpp)
  std::span<const std::uint32_t> result;  ///< labels to be evaluated
  std::span<const float> ranges_m;        ///< from the laser; NaN without a return
};

/// Range [m] of each input record from its laser; NaN without a return.
[[nodiscard]] std::vector<float> ranges_of(const LidarScan& scan);

/// Accumulates an EvaluationReport scan by scan, in constant memory.
class Evaluator {
 public:
  /// With a limit, points farther from their laser, and points without a return, do not count. Throws
  /// ParameterError for a limit that is not in (0, 1e6] m.
  explicit Evaluator(ObjectTruth objects, std::optional<double> max_range_m = {});

  /// Throws InputError if the spans differ in length.
  void add(const ScanLabels& scan);

  [[nodiscard]] EvaluationReport report() const;

 private:
  struct ClassTally {
    Counts points;
    Found objects, evident_movers;
  };
  struct ObjectInScan;

  void add_ranges(const std::vector<Counts>& by_step);
  void add_object(std::size_t scan, std::uint32_t id, const ObjectInScan& object);

  ObjectTruth truth_;
  std::optional<double> max_range_m_;
  EvaluationReport report_;  // by_class and by_kind are filled in at the end
  std::map<std::string, ClassTally> classes_;
  std::map<std::pair<std::string, std::string>, Counts> kinds_;
};

inline constexpr double kMinEvaluatedSpeed_mps = 1;       ///< velocities of slower objects are not evaluated
inline constexpr double kSmallVelocityError_mps = 0.3;    ///< bound of VelocityReport::small_error_share
inline constexpr double kConfidentVelocityStd_mps = 0.5;  ///< bound of VelocityReport::confident

/// Errors of the estimated velocities. A *mover* is a true object with a state in this scan. It is found if
/// at least half of its dynamic points are labelled dynamic, and is matched with the object of the result
/// that covers most of them (ties: the lowest number). The error is the length of the difference between the
/// estimated velocity and the true velocity of the body's origin in the middle of the scan.
struct VelocityReport {
  std::int64_t evaluated = 0;   ///< found movers, counted in every scan, faster than kMinEvaluatedSpeed_mps
  std::int64_t first_seen = 0;  ///< not evaluated: the object is new and has no velocity yet
  std::int64_t mixed = 0;       ///< not evaluated: most points of the matched object belong to others
  std::optional<double> rms_mps, median_mps;
  std::optional<double>
      small_error_share;  ///< share of the evaluated with an error below kSmallVelocityError_mps
  /// Root mean square over movers and axes of error / standard deviation: 1 if the standard deviations are
  /// consistent.
  std::optional<double> normalised_rms;
  /// The evaluated with all three standard deviations below kConfidentVelocityStd_mps.
  std::int64_t confident = 0;
  std::optional<double> confident_rms_mps;
  std::int64_t movers = 0;  ///< true objects with a state that were found in at least one scan, at any speed
  std::int64_t id_changes = 0;  ///< how often a mover was matched with another id than when last found
};

/// Accumulates a VelocityReport scan by scan.
class VelocityEvaluator {
 public:
  /// With a limit, points farther from their laser do not count. `rows` are those of the objects.csv of the
  /// result, `table` its path, for messages. Throws ParameterError as Evaluator does.
  VelocityEvaluator(const ObjectTruth& truth, std::vector<ObjectRow> rows, std::string table,
                    std::optional<double> max_range_m = {});

  /// `C_rt` rotates directions from the world frame of the truth (t) to that of the result (r). Throws
  /// InputError for spans of different length, and for a labelled object without a row.
  void add(const ScanLabels& scan, const Eigen::Matrix3d& C_rt);

  [[nodiscard]] VelocityReport report() const;

 private:
  struct Mover;
  [[nodiscard]] const ObjectRow& row_of(std::size_t scan, std::uint32_t number) const;
  void evaluate(std::size_t scan, std::uint32_t id, const Mover& mover,
                const std::vector<std::int64_t>& sizes, const Eigen::Matrix3d& C_rt);

  std::map<std::pair<std::size_t, std::uint32_t>, ObjectState> states_;  // by scan and object
  std::map<std::pair<std::size_t, std::uint32_t>, ObjectRow> rows_;      // by scan and number in its labels
  std::string table_;
  std::optional<double> max_range_m_;
  VelocityReport report_;
  std::vector<double> errors_;
  double normalised_sum_ = 0, confident_sum_ = 0;
  std::map<std::uint32_t, std::uint32_t> last_id_;  // of the result, by true object
};

// The cases that the paper names as open (section VI): points seen through a fence, points with only sky
// behind, and the delay with which a start or a stop is noticed.

/// Recall of the dynamic points that are hard to see. Neighbours of a point are cells of the same laser.
struct SightReport {
  /// Points seen through a gap (a fence, a hedge, railings): on either side, within kGapReach_deg, the same
  /// laser has a static return that is nearer by more than kGapDepth_m.
  Found through_gap;
  /// Points with only sky behind: on either side, the first cell of the laser that is not of the same true
  /// object has no return within range. Faulty and absent cells are skipped. Zero for recordings that do not
  /// distinguish ReturnCode::nothing from ReturnCode::faulty.
  Found before_sky;
};
/// Chosen: slats up to 0.17 m apart, seen from 10 m, hide the next point on either side.
inline constexpr double kGapReach_deg = 1;
/// Chosen: farther than the parts of one object lie in front of each other.
inline constexpr double kGapDepth_m = 0.5;

/// Accumulates a SightReport scan by scan.
class SightEvaluator {
 public:
  /// With a limit, points farther from their laser do not count. Throws ParameterError as Evaluator does.
  explicit SightEvaluator(std::optional<double> max_range_m = {});

  /// `labels` are those of `scan`. Throws InputError if their lengths differ.
  void add(const LidarScan& scan, const ScanLabels& labels);

  [[nodiscard]] const SightReport& report() const { return report_; }

 private:
  void add_row(const LidarScan& scan, const ScanLabels& labels, int row);

  std::optional<double> max_range_m_;
  SightReport report_;
};

/// Delays of one kind of event.
struct Delays {
  std::int64_t events = 0;
  std::int64_t never = 0;  ///< not noticed within 25 scans
  /// Smallest delay [scans] within which at least 50 % (median) or 90 % (p90) of all events are noticed.
  /// Absent if fewer events than that are noticed at all.
  std::optional<double> median_scans, p90_scans;
};

/// Delays between the start or stop of a true object and the labels that show it. Only scans in which the
/// object has points with a true label, and a true speed (object_states.csv), are counted; "next" and "last"
/// refer to these scans.
struct DelayReport {
  /// From the first scan above 0.2 m/s to the first one with half of the object's points labelled dynamic. A
  /// start: below 0.1 m/s in the scans six to two before, at most 0.2 m/s in the last; 0.5 m/s within the
  /// next 25, and at least 20 points in the first.
  Delays start;
  /// From the first scan below 0.1 m/s to the first one with less than a tenth of the object's points
  /// labelled dynamic. A stop: above 0.5 m/s within the last 12 scans, at most 0.1 m/s in the next ten, of
  /// which there are at least five, and at least 20 points in the first.
  Delays stop;
};

/// Accumulates a DelayReport scan by scan. Keeps a few numbers per object and scan.
class DelayEvaluator {
 public:
  /// With a limit, points farther from their laser do not count. Throws ParameterError as Evaluator does.
  explicit DelayEvaluator(const ObjectTruth& truth, std::optional<double> max_range_m = {});

  /// Scans by increasing number. Throws InputError if the spans differ in length.
  void add(const ScanLabels& scan);

  /// Absent if the recording has no object_states.csv.
  [[nodiscard]] std::optional<DelayReport> report() const;

 private:
  struct Sighting {
    std::size_t scan = 0;
    double speed_mps = 0;
    std::int64_t points = 0, called = 0;
  };
  using History = std::vector<Sighting>;  // of one object
  static bool starts(const History& history, std::size_t at);
  static bool stops(const History& history, std::size_t at);

  bool has_states_;
  std::map<std::pair<std::size_t, std::uint32_t>, double> speeds_mps_;  // by scan and object
  std::optional<double> max_range_m_;
  std::map<std::uint32_t, History> histories_;
};

/// The labels of a result folder compared with the truth of its recording.
struct ResultEvaluation {
  std::size_t labelled_scans = 0;            ///< scans with a label file in the folder
  std::size_t scans_without_truth = 0;       ///< of these, the scans without true labels
  std::vector<std::size_t> scans;            ///< those that are evaluated: with both
  std::vector<PrecisionRecall> after_stage;  ///< by stage, over the evaluated scans that have a stage file
  EvaluationReport report;                   ///< of the final labels
  SightReport sight;                         ///< of the final labels
  std::optional<DelayReport> delays;         ///< absent if the recording has no object_states.csv
  /// Of the tracked objects; absent if the recording has no object_states.csv, or the folder no summary.json,
  /// which marks a result of mapless detect.
  std::optional<VelocityReport> velocity;
};

struct EvaluationOptions {
  int stages = 0;                     ///< number of bits used in a stage file, 0 to 8
  std::optional<double> max_range_m;  ///< points farther from their laser do not count; above 0
  std::filesystem::path objects;      ///< folder of objects.csv and object_states.csv; empty: none
  std::function<void(std::size_t done, std::size_t of)> progress;  ///< called after every scan; may be empty
};

/// Evaluates every scan of `result` that has true labels in `dataset`. Throws ParameterError for options out
/// of bounds, InputError for files that do not fit the recording, and if no scan has both label and truth.
[[nodiscard]] ResultEvaluation evaluate_result(const Dataset& dataset, const ResultFolder& result,
                                               const EvaluationOptions& options);

}  // namespace mapless
