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

/// One scan of truth and result, an entry per input record each.
struct JudgedScan {
  std::size_t number = 0;  ///< in the recording, from 0
  std::span<const std::uint32_t> truth;
  std::span<const std::uint32_t> result;
  std::span<const float> ranges_m;  ///< of the return from its laser; NaN without one
};

/// The range of each input record, NaN without a return.
[[nodiscard]] std::vector<float> ranges_of(const LidarScan& scan);

/// Adds up an EvaluationReport scan by scan, in constant memory.
class Evaluator {
 public:
  /// With a limit, points farther than that from their laser, and those without a return, count nowhere.
  explicit Evaluator(ObjectTruth objects, std::optional<double> max_range_m = {});

  /// Throws InputError where the spans differ in length.
  void add(const JudgedScan& scan);

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

inline constexpr double kMovingSpeed = 1;      ///< true speed beyond which a velocity is judged [m/s]
inline constexpr double kCloseVelocity = 0.3;  ///< an error below this is a small one [m/s]
inline constexpr double kSureVelocity =
    0.5;  ///< a velocity with standard deviations below this is sure [m/s]

/// How right the velocities of the movers found are. A mover is a true object in a scan with a state, found
/// where at least half of its dynamic points are called dynamic; the object of the result that covers most of
/// these (ties to the lowest number) stands for it. The error is the length of the difference between that
/// object's velocity and the true one of the body's origin in the middle of the scan.
struct VelocityReport {
  std::int64_t judged = 0;      ///< movers in scans, of a true speed above kMovingSpeed
  std::int64_t first_seen = 0;  ///< not judged: the object is new, its velocity not yet measured
  std::int64_t mixed = 0;       ///< not judged: most points of the object are not this mover's
  std::optional<double> rms_mps, median_mps;
  std::optional<double> close_share;  ///< of those judged, with an error below kCloseVelocity
  /// Root of the mean over movers and axes of (error / standard deviation)^2: 1 where these are honest.
  std::optional<double> normalised_rms;
  std::int64_t sure = 0;  ///< of those judged, with all three standard deviations below kSureVelocity
  std::optional<double> sure_rms_mps;
  std::int64_t movers = 0;      ///< true objects with a state that were found in some scan, at any speed
  std::int64_t id_changes = 0;  ///< how often another id stood for one than when it was found before
};

/// Adds up a VelocityReport scan by scan.
class VelocityEvaluator {
 public:
  /// With a limit, points farther than that from their laser count nowhere. `table`: the objects.csv of the
  /// result, for messages.
  VelocityEvaluator(const ObjectTruth& truth, std::vector<ObjectRow> rows, std::string table,
                    std::optional<double> max_range_m = {});

  /// `C_rt` turns directions of the true world to the result's. Throws InputError for a labelled object that
  /// has no row.
  void add(const JudgedScan& scan, const Eigen::Matrix3d& C_rt);

  [[nodiscard]] VelocityReport report() const;

 private:
  struct Mover;
  [[nodiscard]] const ObjectRow& row_of(std::size_t scan, std::uint32_t number) const;
  void judge(std::size_t scan, std::uint32_t id, const Mover& mover, const std::vector<std::int64_t>& sizes,
             const Eigen::Matrix3d& C_rt);

  std::map<std::pair<std::size_t, std::uint32_t>, ObjectState> states_;  // by scan and object
  std::map<std::pair<std::size_t, std::uint32_t>, ObjectRow> rows_;      // by scan and number in its labels
  std::string table_;
  std::optional<double> max_range_m_;
  VelocityReport report_;
  std::vector<double> errors_;
  double normalised_sum_ = 0, sure_sum_ = 0;
  std::map<std::uint32_t, std::uint32_t> last_id_;  // of the result, by true object
};

/// How well the labels of a result folder agree with the truth of its recording.
struct ResultEvaluation {
  std::size_t labelled_scans = 0;            ///< scans of the folder
  std::size_t scans_without_truth = 0;       ///< of these, the ones that cannot count
  std::vector<std::size_t> scans;            ///< those that count: label and truth are both there
  std::vector<PrecisionRecall> after_stage;  ///< by stage; over the scans of `scans` that have a stage file
  EvaluationReport report;                   ///< of the final labels
  /// Of the objects followed over time; absent where the recording has no object_states.csv, or the folder is
  /// no result of mapless detect (it has no summary.json).
  std::optional<VelocityReport> velocity;
};

struct EvaluationOptions {
  int stages = 0;                     ///< bits used in a stage file
  std::optional<double> max_range_m;  ///< points farther from their laser do not count
  std::filesystem::path objects;      ///< folder of objects.csv and object_states.csv; empty: there are none
  std::function<void(std::size_t done, std::size_t of)> progress;
};

/// Throws InputError for files that do not fit the recording, or where no scan has both label and truth.
[[nodiscard]] ResultEvaluation evaluate_result(const Dataset& dataset, const ResultFolder& result,
                                               const EvaluationOptions& options);

}  // namespace mapless
