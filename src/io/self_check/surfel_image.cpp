#include "io/self_check/surfel_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace mapless::inline v1 {
namespace {

// Neighbours of which a normal is made are about this far apart within a row: 1.5 degrees are 0.5 m at 20 m,
// ten times the noise.
constexpr double kAcross_rad = 1.5 * std::numbers::pi / 180;
// A neighbour is on the same surface where its range differs by less than this share of the distance between
// the rays over it; steeper surfaces are seen under 10 degrees and less.
constexpr double kSteepest = 5.7;
constexpr double kNoise_m = 0.1;
// The middle point is on the plane of its neighbours to this.
constexpr double kFlat_m = 0.1;
constexpr double kNearestSurfel_m = 2;  // nearer returns are of the vehicle itself
// Bins of the directions of normals: by the largest component and the signs of the two others.
constexpr std::size_t kBins = 12;
// Candidates per point of the sample: enough for every bin that has any.
constexpr std::size_t kCandidates = 8;
// The neighbourhood searched for a surfel, in rows and columns.
constexpr int kRowsAround = 1, kColumnsAround = 3;

std::size_t bin_of(const Eigen::Vector3d& n) {
  Eigen::Index largest = 0;
  n.cwiseAbs().maxCoeff(&largest);
  const double sign = n[largest] < 0 ? -1 : 1;
  const auto second = sign * n[(largest + 1) % 3] < 0 ? 1U : 0U,
             third = sign * n[(largest + 2) % 3] < 0 ? 1U : 0U;
  return static_cast<std::size_t>(largest) * 4 + 2 * second + third;
}

bool on_one_surface(const LidarReturn& a, const LidarReturn& b) {
  const double range = std::min(a.range_m, b.range_m);
  const double apart = (a.position_v.normalized() - b.position_v.normalized()).norm() * range;
  return std::abs(a.range_m - b.range_m) < kNoise_m + kSteepest * apart;
}

}  // namespace

const SE3& ScanPoses::at(double fraction) const {
  const auto i = std::lround(std::clamp(fraction, 0.0, 1.0) * (kInstants - 1));
  return T_0v[static_cast<std::size_t>(i)];
}

SurfelImage::SurfelImage(const LidarScan& scan)
    : scan_(scan), image_(scan), duration_s_((scan.end() - scan.start).seconds()) {
  const double column_rad = 2 * std::numbers::pi / scan.model->columns;
  across_ = std::max(1, static_cast<int>(std::lround(kAcross_rad / column_rad)));
}

double SurfelImage::fraction(const LidarReturn& r) const { return 1e-9 * r.time_ns / duration_s_; }

const LidarReturn* SurfelImage::at(int row, int aligned) const {
  if (row < 0 || row >= scan_.rows()) return nullptr;
  const std::int32_t cell = scan_.cell(row, image_.scan_column(row, aligned));
  return cell < 0 ? nullptr : &scan_.returns[static_cast<std::size_t>(cell)];
}

std::optional<Surfel> SurfelImage::surfel_at(const LidarReturn& r) const {
  const int aligned = image_.aligned_column(r.laser, r.column);
  const std::array<const LidarReturn*, 4> around = {at(r.laser, aligned - across_),
                                                    at(r.laser, aligned + across_), at(r.laser - 1, aligned),
                                                    at(r.laser + 1, aligned)};
  const auto usable = [&](const LidarReturn* n) { return n != nullptr && on_one_surface(r, *n); };
  const auto position = [](const LidarReturn* n) { return n->position_v.cast<double>().eval(); };
  // Of one pair both are needed, of the other one is enough.
  const LidarReturn* up = usable(around[3]) ? around[3] : nullptr;
  const LidarReturn* down = usable(around[2]) ? around[2] : nullptr;
  if (!usable(around[0]) || !usable(around[1]) || (up == nullptr && down == nullptr)) return std::nullopt;
  const Eigen::Vector3d p = r.position_v.cast<double>();
  const Eigen::Vector3d along_row = position(around[1]) - position(around[0]);
  const Eigen::Vector3d along_column =
      (up != nullptr ? position(up) : p) - (down != nullptr ? position(down) : p);
  Eigen::Vector3d normal = along_row.cross(along_column);
  const double length = normal.norm();
  if (!(length > 0)) return std::nullopt;
  normal /= length;
  for (const LidarReturn* n : {around[0], around[1], up, down}) {
    if (n != nullptr && std::abs(normal.dot(position(n) - p)) > kFlat_m) return std::nullopt;
  }
  return Surfel{p, normal, fraction(r)};
}

std::vector<Surfel> SurfelImage::sample(std::size_t most) const {
  std::array<std::vector<Surfel>, kBins> bins;
  const std::size_t step = 1 + scan_.returns.size() / (kCandidates * most);
  for (std::size_t i = 0; i < scan_.returns.size(); i += step) {
    const LidarReturn& r = scan_.returns[i];
    if (r.range_m < kNearestSurfel_m) continue;
    if (const auto surfel = surfel_at(r)) bins[bin_of(surfel->normal_v)].push_back(*surfel);
  }
  std::vector<Surfel> out;
  const std::size_t share = most / kBins;
  for (const std::vector<Surfel>& bin : bins) {
    const std::size_t kept = std::min(share, bin.size());
    for (std::size_t i = 0; i < kept; ++i) out.push_back(bin[i * bin.size() / kept]);
  }
  return out;
}

int SurfelImage::nearest_row(double elevation_rad) const {
  const auto& lasers = scan_.model->lasers;
  const auto above = std::lower_bound(lasers.begin(), lasers.end(), elevation_rad,
                                      [](const Laser& l, double e) { return l.elevation_rad < e; });
  if (above == lasers.end()) return scan_.rows() - 1;
  const auto row = static_cast<int>(above - lasers.begin());
  if (row > 0 && elevation_rad - (above - 1)->elevation_rad < above->elevation_rad - elevation_rad)
    return row - 1;
  return row;
}

SurfelImage::Sight SurfelImage::look(const Eigen::Vector3d& p_0, const ScanPoses& poses,
                                     double reach_m) const {
  const LidarModel& model = *scan_.model;
  // The column tells the pose, and the pose the column: two rounds are enough for a turn of a few degrees
  // within a scan.
  double turned = 0.5;  // share of the scan
  Eigen::Vector3d p_v = Eigen::Vector3d::Zero();
  double column = 0;
  for (int round = 0; round < 2; ++round) {
    const SE3& T_0v = poses.at(turned);
    p_v = T_0v.rotation().transpose() * (p_0 - T_0v.translation());
    const double angle = (std::atan2(p_v.y(), p_v.x()) - model.start_azimuth_rad) * model.sign();
    column = angle / (2 * std::numbers::pi) * model.columns;
    column -= std::floor(column / model.columns) * model.columns;
    turned = column / scan_.columns;
  }
  const int row = nearest_row(std::atan2(p_v.z(), p_v.head<2>().norm()));
  const int middle = std::min(static_cast<int>(column), scan_.columns - 1);
  const LidarReturn* best = nullptr;
  double best_m = reach_m;
  bool beyond = true, seen = false;
  const double range_m = p_v.norm();
  for (int r = row - kRowsAround; r <= row + kRowsAround; ++r) {
    for (int c = middle - kColumnsAround; c <= middle + kColumnsAround; ++c) {
      const LidarReturn* candidate = at(r, c);
      if (candidate == nullptr) continue;
      seen = true;
      beyond = beyond && candidate->range_m > range_m + reach_m;
      const double distance_m = (candidate->position_v.cast<double>() - p_v).norm();
      if (distance_m >= best_m) continue;
      best_m = distance_m;
      best = candidate;
    }
  }
  return {best == nullptr ? std::nullopt : surfel_at(*best), seen && beyond};
}

}  // namespace mapless
