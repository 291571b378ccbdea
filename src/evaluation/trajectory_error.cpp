#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

#include "core/argument_checks.hpp"
#include <mapless/evaluation/trajectory_evaluation.hpp>

namespace mapless::inline v1 {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
// Segments as in the KITTI devkit: 100 to 800 m from every tenth pose; shorter ones for short drives.
constexpr double kLongUnit = 100;  // [m]
constexpr std::array kShortUnits = {50.0, 20.0, 10.0, 5.0, 2.0, 1.0};
constexpr int kLengths = 8;
constexpr std::size_t kStartEvery = 10;

double angle_deg(const SE3& T) { return so3_log(T.rotation()).norm() * kDegrees; }

// E = (E_1^-1 E_2)^-1 (T_1^-1 T_2).
SE3 error_between(const PosePair& first, const PosePair& second) {
  const SE3 estimated = first.T_0v_estimated.inverse() * second.T_0v_estimated;
  return estimated.inverse() * (first.T_0v_true.inverse() * second.T_0v_true);
}

std::optional<PoseErrors> figures_of_poses(const std::vector<SE3>& errors) {
  if (errors.empty()) return std::nullopt;
  std::vector<double> translations, rotations;
  for (const SE3& E : errors) {
    translations.push_back(E.translation().norm());
    rotations.push_back(angle_deg(E));
  }
  return PoseErrors{*figures_of(translations), *figures_of(rotations)};
}

// Distance along the true poses up to each of them.
std::vector<double> ways(std::span<const PosePair> pairs) {
  std::vector<double> out;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double step =
        i == 0 ? 0 : (pairs[i].T_0v_true.translation() - pairs[i - 1].T_0v_true.translation()).norm();
    out.push_back(i == 0 ? 0 : out.back() + step);
  }
  return out;
}

// 0 for a drive too short for any segment.
double segment_unit(double way) {
  if (way >= 2 * kLongUnit) return kLongUnit;
  for (const double unit : kShortUnits) {
    if (way >= 2 * unit) return unit;
  }
  return 0;
}

DriftOfLength drift_of(std::span<const PosePair> pairs, const std::vector<double>& way, double length,
                       std::size_t start_every) {
  DriftOfLength out;
  out.length_m = length;
  for (std::size_t first = 0; first < pairs.size(); first += start_every) {
    const auto last = std::upper_bound(way.begin(), way.end(), way[first] + length);
    if (last == way.end()) break;
    const SE3 E = error_between(pairs[first], pairs[static_cast<std::size_t>(last - way.begin())]);
    out.translation_percent += 100 * E.translation().norm() / length;
    out.rotation_deg_per_100m += 100 * angle_deg(E) / length;
    ++out.segments;
  }
  if (out.segments == 0) return out;
  out.translation_percent /= static_cast<double>(out.segments);
  out.rotation_deg_per_100m /= static_cast<double>(out.segments);
  return out;
}

}  // namespace

std::optional<ErrorFigures> figures_of(const std::vector<double>& errors) {
  if (errors.empty()) return std::nullopt;
  ErrorFigures out;
  out.count = errors.size();
  double sum = 0, squares = 0;
  for (const double e : errors) {
    sum += e;
    squares += e * e;
  }
  out.mean = sum / static_cast<double>(errors.size());
  out.rmse = std::sqrt(squares / static_cast<double>(errors.size()));
  out.median = *quantile(errors, 0.5);
  out.p95 = *quantile(errors, 0.95);
  out.max = *std::max_element(errors.begin(), errors.end());
  return out;
}

double path_length_m(std::span<const PosePair> pairs) { return pairs.empty() ? 0 : ways(pairs).back(); }

std::optional<Drift> drift(std::span<const PosePair> pairs) {
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    require_between("drift", "pairs[i].scan", static_cast<double>(pairs[i].scan),
                    static_cast<double>(pairs[i - 1].scan + 1), std::numeric_limits<double>::max());
  }
  if (pairs.empty()) return std::nullopt;
  const std::vector<double> way = ways(pairs);
  const double unit = segment_unit(way.back());
  if (unit == 0) return std::nullopt;
  Drift out;
  for (int i = 1; i <= kLengths; ++i) {
    const DriftOfLength of = drift_of(pairs, way, i * unit, unit == kLongUnit ? kStartEvery : 1);
    if (of.segments == 0) break;
    const auto weight = static_cast<double>(of.segments);
    out.translation_percent += weight * of.translation_percent;
    out.rotation_deg_per_100m += weight * of.rotation_deg_per_100m;
    out.segments += of.segments;
    out.by_length.push_back(of);
  }
  if (out.segments == 0) return std::nullopt;
  out.translation_percent /= static_cast<double>(out.segments);
  out.rotation_deg_per_100m /= static_cast<double>(out.segments);
  return out;
}

std::optional<ErrorFigures> absolute_error_aligned(std::span<const PosePair> pairs) {
  if (pairs.size() < 3) return std::nullopt;
  Eigen::Matrix3Xd truth(3, static_cast<Eigen::Index>(pairs.size()));
  Eigen::Matrix3Xd estimate(3, truth.cols());
  for (Eigen::Index i = 0; i < truth.cols(); ++i) {
    truth.col(i) = pairs[static_cast<std::size_t>(i)].T_0v_true.translation();
    estimate.col(i) = pairs[static_cast<std::size_t>(i)].T_0v_estimated.translation();
  }
  const Eigen::Matrix4d T = Eigen::umeyama(estimate, truth, false);
  const SE3 T_true_estimated(T.topLeftCorner<3, 3>(), T.topRightCorner<3, 1>());
  std::vector<double> errors;
  for (const PosePair& p : pairs) {
    const Eigen::Vector3d moved = T_true_estimated * p.T_0v_estimated.translation();
    errors.push_back((moved - p.T_0v_true.translation()).norm());
  }
  return figures_of(errors);
}

std::optional<PoseErrors> absolute_error_from_first(std::span<const PosePair> pairs) {
  if (pairs.size() < 2) return std::nullopt;
  std::vector<SE3> errors;
  for (const PosePair& p : pairs) errors.push_back(error_between(pairs.front(), p));
  return figures_of_poses(errors);
}

std::optional<PoseErrors> relative_error_per_scan(std::span<const PosePair> pairs, std::size_t first_scan) {
  std::vector<SE3> errors;
  for (std::size_t i = 0; i + 1 < pairs.size(); ++i) {
    if (pairs[i].scan < first_scan || pairs[i + 1].scan != pairs[i].scan + 1) continue;
    errors.push_back(error_between(pairs[i], pairs[i + 1]));
  }
  return figures_of_poses(errors);
}

}  // namespace mapless
