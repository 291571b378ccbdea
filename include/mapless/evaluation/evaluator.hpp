#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <mapless/evaluation/evaluation_report.hpp>
#include <mapless/io/object_truth.hpp>
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

}  // namespace mapless
