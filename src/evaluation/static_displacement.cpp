#include "evaluation/static_displacement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/argument_checks.hpp"

namespace mapless::inline v1 {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

double azimuth(const Eigen::Vector3d& p) { return std::atan2(p.y(), p.x()); }

std::size_t nearest_column(double column, std::size_t columns) {
  return static_cast<std::size_t>(std::clamp(std::round(column), 0.0, static_cast<double>(columns - 1)));
}

// Column of the reference scan at which the laser that measured p_v in column `column` of the query points
// towards p_0 again: a fixed-point iteration. Each round multiplies the error by the ratio of the angular
// rates of sensor and hub.
std::size_t column_again(const LidarModel& model, const Eigen::Vector3d& p_v, std::size_t column,
                         const Eigen::Vector3d& p_0, const std::vector<SE3>& T_v0_reference) {
  constexpr int kRounds = 3;  // a ratio of 0.06 (200 deg/s at 10 Hz) leaves less than a column
  std::size_t again = nearest_column(static_cast<double>(column), T_v0_reference.size());
  for (int i = 0; i < kRounds; ++i) {
    const double turned = std::remainder(azimuth(T_v0_reference[again] * p_0) - azimuth(p_v), kTurn);
    again = nearest_column(static_cast<double>(column) + model.sign() * turned / kTurn * model.columns,
                           T_v0_reference.size());
  }
  return again;
}

}  // namespace

ScanPoses poses_of(const LidarScan& scan, const Trajectory& truth, const Trajectory& estimate) {
  ScanPoses out;
  for (int c = 0; c < scan.columns; ++c) {
    const Time t = scan.column_time(c);
    out.T_v0_true.push_back(truth.at(t).T_v0);
    out.T_0v_true.push_back(out.T_v0_true.back().inverse());
    out.T_0v_estimated.push_back(estimate.at(t).T_v0.inverse());
  }
  return out;
}

std::vector<double> static_displacements(const LidarScan& query, const ScanPoses& at_query,
                                         const ScanPoses& at_reference, std::size_t stride) {
  require_between("static_displacements", "stride", static_cast<double>(stride), 1,
                  std::numeric_limits<double>::max());
  const auto period_ns = static_cast<double>(query.column_period.nanoseconds());
  std::vector<double> out;
  for (std::size_t i = 0; i < query.returns.size(); i += stride) {
    const LidarReturn& r = query.returns[i];
    const Eigen::Vector3d p_v = r.position_v.cast<double>();
    const std::size_t q = nearest_column(r.time_ns / period_ns, at_query.T_0v_true.size());
    const Eigen::Vector3d p_0 = at_query.T_0v_true[q] * p_v;
    const std::size_t c = column_again(*query.model, p_v, q, p_0, at_reference.T_v0_true);
    const Eigen::Vector3d seen_before = at_reference.T_0v_estimated[c] * (at_reference.T_v0_true[c] * p_0);
    out.push_back((at_query.T_0v_estimated[q] * p_v - seen_before).norm());
  }
  return out;
}

}  // namespace mapless
