#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "evaluation/scan_checks.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/evaluation/evaluator.hpp>
#include <mapless/evaluation/trajectory_evaluation.hpp>
#include <mapless/io/labels.hpp>

namespace mapless::inline v1 {

// The dynamic points of one true object in one scan.
struct VelocityEvaluator::Mover {
  std::int64_t points = 0, called = 0;
  std::map<std::uint32_t, std::int64_t> covered_by;  // points, by number of the result

  [[nodiscard]] bool found() const { return 2 * called >= points && !covered_by.empty(); }
  [[nodiscard]] std::pair<std::uint32_t, std::int64_t> most() const {
    return *std::max_element(covered_by.begin(), covered_by.end(),
                             [](const auto& a, const auto& b) { return a.second < b.second; });
  }
};

VelocityEvaluator::VelocityEvaluator(const ObjectTruth& truth, std::vector<ObjectRow> rows, std::string table,
                                     std::optional<double> max_range_m)
    : states_(truth.states), table_(std::move(table)), max_range_m_(max_range_m) {
  if (max_range_m_) require_range_limit("VelocityEvaluator", *max_range_m_);
  for (ObjectRow& row : rows) rows_.emplace(std::pair(row.scan, label_number(row.id)), std::move(row));
}

const ObjectRow& VelocityEvaluator::row_of(std::size_t scan, std::uint32_t number) const {
  const auto row = rows_.find({scan, number});
  if (row != rows_.end()) return row->second;
  throw InputError({table_, fmt::format("scan {}, object {} of its labels", scan, number), "",
                    "the table has no such row", "give labels and table of one run"});
}

void VelocityEvaluator::add(const ScanLabels& scan, const Eigen::Matrix3d& C_rt) {
  require_equal_lengths(scan.number, scan.truth.size(), scan.result.size(), scan.ranges_m.size());
  std::map<std::uint32_t, Mover> movers;
  std::vector<std::int64_t> sizes(std::size_t{1} << 16, 0);  // of the result's objects
  for (std::size_t i = 0; i < scan.truth.size(); ++i) {
    if (max_range_m_ && !(static_cast<double>(scan.ranges_m[i]) <= *max_range_m_)) continue;
    const bool called = motion_of_label(scan.result[i]) == MotionTruth::moving;
    const std::uint32_t number = called ? scan.result[i] >> 16 : 0;
    if (number != 0 && sizes[number]++ == 0) (void)row_of(scan.number, number);
    const std::uint32_t id = scan.truth[i] >> 16;
    if (id == 0 || motion_of_label(scan.truth[i]) != MotionTruth::moving) continue;
    Mover& mover = movers[id];
    ++mover.points;
    mover.called += called ? 1 : 0;
    if (number != 0) ++mover.covered_by[number];
  }
  for (const auto& [id, mover] : movers) {
    if (mover.found()) evaluate(scan.number, id, mover, sizes, C_rt);
  }
}

void VelocityEvaluator::evaluate(std::size_t scan, std::uint32_t id, const Mover& mover,
                                 const std::vector<std::int64_t>& sizes, const Eigen::Matrix3d& C_rt) {
  const auto state = states_.find({scan, id});
  if (state == states_.end()) return;
  const auto [number, covered] = mover.most();
  const ObjectRow& row = row_of(scan, number);
  const auto [last, is_new] = last_id_.try_emplace(id, row.id);
  if (std::exchange(last->second, row.id) != row.id) ++report_.id_changes;
  report_.movers += is_new ? 1 : 0;
  if (state->second.speed_mps <= kMinEvaluatedSpeed_mps) return;
  if (row.age < 2) {
    ++report_.first_seen;
  } else if (2 * covered <= sizes[number]) {
    ++report_.mixed;
  } else {
    const Eigen::Vector3d error = row.velocity_0 - C_rt * state->second.velocity_0;
    errors_.push_back(error.norm());
    if (row.velocity_std_0.maxCoeff() < kConfidentVelocityStd_mps) {
      ++report_.confident;
      confident_sum_ += error.squaredNorm();
    }
    normalised_sum_ += error.cwiseQuotient(row.velocity_std_0).squaredNorm() / 3;
  }
}

VelocityReport VelocityEvaluator::report() const {
  VelocityReport out = report_;
  out.evaluated = static_cast<std::int64_t>(errors_.size());
  if (errors_.empty()) return out;
  const auto count = static_cast<double>(errors_.size());
  double squares = 0;
  for (const double error : errors_) squares += error * error;
  const auto close =
      std::count_if(errors_.begin(), errors_.end(), [](double e) { return e < kSmallVelocityError_mps; });
  out.rms_mps = std::sqrt(squares / count);
  if (out.confident > 0)
    out.confident_rms_mps = std::sqrt(confident_sum_ / static_cast<double>(out.confident));
  out.median_mps = quantile(errors_, 0.5);
  out.small_error_share = static_cast<double>(close) / count;
  out.normalised_rms = std::sqrt(normalised_sum_ / count);
  return out;
}

}  // namespace mapless
