#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <mapless/evaluation/evaluation_report.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/object_tables.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

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

/// The labels of a result folder compared with the truth of its recording.
struct ResultEvaluation {
  std::size_t labelled_scans = 0;            ///< scans with a label file in the folder
  std::size_t scans_without_truth = 0;       ///< of these, the scans without true labels
  std::vector<std::size_t> scans;            ///< those that are evaluated: with both
  std::vector<PrecisionRecall> after_stage;  ///< by stage, over the evaluated scans that have a stage file
  EvaluationReport report;                   ///< of the final labels
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
