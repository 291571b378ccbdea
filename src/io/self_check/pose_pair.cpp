#include "io/self_check/pose_pair.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "core/half_turns.hpp"

namespace mapless::inline v1 {
namespace {

constexpr std::size_t kSample = 900;
// Farther surfaces are others.
constexpr double kReach_m = 1.5;
// Normals of one surface are alike: within 45 degrees.
constexpr double kAlike = 0.7;
constexpr std::size_t kFewestMatches = 30;

// Three standard deviations of the difference of two ranges with noise of 0.035 m, two of 0.05 m.
constexpr float kEqual_m = 0.15F;

// Two motions differ at a point by this much along its normal.
constexpr double kTells_m = 0.3;
// Neighbours of a motion: from twice kTells_m on, the shortest that tells points whose normals are within 60
// degrees of it; negative: beyond it, seen from the other account.
constexpr double kLeastApart_m = 0.6;
constexpr std::array kBeside_m = {-4 * kLeastApart_m, -2 * kLeastApart_m, -kLeastApart_m, kLeastApart_m,
                                  2 * kLeastApart_m};
constexpr std::size_t kSectors = 16;  // of a turn
// Nothing but chance: share of the points that are on a surface under one account alone. A vehicle beside
// the sensor leaves 0 of 130 to 190 points to the other half turn, poses that are too fast 4 % and more.
constexpr double kOneSided = 0.02;
// On a surface: three standard deviations of the difference of two ranges with noise of 0.02 m.
constexpr double kOnSurface_m = 0.08;

struct Stage {
  double reach_m, scale_m;  // of matches, of the robust loss
  int steps;
};
// From coarse to fine. The first finds a motion that is metres off.
constexpr std::array<Stage, 3> kStages = {{{3.0, 0.5, 6}, {1.5, 0.2, 5}, {0.8, 0.1, 5}}};
// Prior of a step: the part of the motion that no surface shows stays [1/m^2, 1/rad^2].
constexpr double kDamping = 1e-3;

// World from sensor at the instants of ScanPoses; of a compensated scan, at that of its points.
std::vector<Time> instants(const LidarScan& scan) {
  std::vector<Time> out;
  const std::int64_t length = (scan.end() - scan.start).nanoseconds();
  for (int i = 0; i < ScanPoses::kInstants; ++i) {
    const Time t = scan.start + Duration::from_nanoseconds(length * i / (ScanPoses::kInstants - 1));
    out.push_back(scan.compensated_to.value_or(t));
  }
  return out;
}

ScanPoses poses_of(const LidarScan& scan, const Vector6d& velocity, Time since) {
  ScanPoses poses;
  for (const Time t : instants(scan)) poses.T_0v.push_back(SE3::exp((t - since).seconds() * velocity));
  return poses;
}

// How much better the second is than the first, each by which points are on surfaces (McNemar 1947).
double preference(const std::vector<bool>& here, const std::vector<bool>& there) {
  double here_alone = 0, there_alone = 0;
  for (std::size_t i = 0; i < here.size(); ++i) {
    if (here[i] != there[i]) (here[i] ? here_alone : there_alone) += 1;
  }
  return (there_alone - here_alone) / std::sqrt(here_alone + there_alone + 1);
}

}  // namespace

std::optional<ScanPoses> poses_of(const LidarScan& scan, const Motion& motion) {
  ScanPoses poses;
  for (const Time t : instants(scan)) {
    const auto T_0v = motion(t);
    if (!T_0v) return std::nullopt;
    poses.T_0v.push_back(*T_0v);
  }
  return poses;
}

PosePair::PosePair(const LidarScan& first, const LidarScan& second)
    : first_scan_(first),
      second_scan_(second),
      first_(first),
      second_(second),
      sample_(second_.sample(kSample)) {}

PosePair::Comparison PosePair::compare(const Surfel& s, const ScanPoses& first, const ScanPoses& second,
                                       double reach_m) const {
  const SE3& T_second = second.at(s.fraction);
  const Eigen::Vector3d p_0 = T_second * s.position_v;
  const SurfelImage::Sight sight = first_.look(p_0, first, reach_m);
  if (!sight.surfel) return {std::nullopt, sight.free};
  const Surfel& near = *sight.surfel;
  const SE3& T_first = first.at(near.fraction);
  const Eigen::Vector3d normal_0 = T_first.rotation() * near.normal_v;
  if (std::abs(normal_0.dot(T_second.rotation() * s.normal_v)) < kAlike) return {};
  const double apart_s = (second_scan_.start - first_scan_.start).seconds();
  const auto since = [](const LidarScan& scan, double fraction, double duration_s) {
    return scan.compensated_to ? (*scan.compensated_to - scan.start).seconds() : fraction * duration_s;
  };
  return {
      Match{T_first * near.position_v, p_0, normal_0, since(first_scan_, near.fraction, first_.duration_s()),
            apart_s + since(second_scan_, s.fraction, second_.duration_s())},
      false};
}

double PosePair::blur_m(const ScanPoses& first, const ScanPoses& second) const {
  double sum = 0, count = 0;
  for (const Surfel& s : sample_) {
    const Comparison c = compare(s, first, second, kReach_m);
    if (!c.match && !c.free) continue;
    ++count;
    sum += c.match ? std::min(kCap_m, std::abs(c.match->normal_0.dot(c.match->second_0 - c.match->first_0)))
                   : kCap_m;
  }
  return count < static_cast<double>(kFewestMatches) ? kCap_m : sum / count;
}

std::optional<double> PosePair::blur_m(const Motion& motion) const {
  const auto first = poses_of(first_scan_, motion), second = poses_of(second_scan_, motion);
  if (!first || !second) return std::nullopt;
  return blur_m(*first, *second);
}

double PosePair::blur_m(const Vector6d& velocity) const {
  return blur_m(poses_of(first_scan_, velocity, first_scan_.start),
                poses_of(second_scan_, velocity, first_scan_.start));
}

std::vector<bool> PosePair::on_surfaces(const Poses& poses) const {
  std::vector<bool> out;
  for (const Surfel& s : sample_) {
    const auto m = compare(s, poses.first, poses.second, kReach_m).match;
    out.push_back(m && std::abs(m->normal_0.dot(m->second_0 - m->first_0)) < kOnSurface_m);
  }
  return out;
}

// The poses of a sensor that moves by `velocity` more, in the world, from the start of the first scan on.
PosePair::Poses PosePair::beside(const Poses& poses, const Vector6d& velocity) const {
  const auto moved = [&](const LidarScan& scan, const ScanPoses& of) {
    ScanPoses out;
    const std::vector<Time> times = instants(scan);
    for (std::size_t i = 0; i < times.size(); ++i)
      out.T_0v.push_back(SE3::exp((times[i] - first_scan_.start).seconds() * velocity) * of.T_0v[i]);
    return out;
  };
  return {moved(first_scan_, poses.first), moved(second_scan_, poses.second)};
}

// How far a point of the second scan lies from where the other account has it, along its normal.
double PosePair::moved_m(const Surfel& s, const Poses& poses, const Poses& other) {
  const SE3 &T = poses.second.at(s.fraction), &T_other = other.second.at(s.fraction);
  return std::abs((T.rotation() * s.normal_v).dot(T_other * s.position_v - T * s.position_v));
}

// `towards_other`: the velocity that leads to the other account, `apart_m` away.
double PosePair::peak(const Poses& poses, const Vector6d& towards_other, double apart_m) const {
  const std::vector<bool> here = on_surfaces(poses);
  std::vector<double> peaks;
  for (const double shift_m : kBeside_m) {
    if (shift_m > 0.5 * apart_m) continue;
    const Poses other = beside(poses, (shift_m / apart_m) * towards_other);
    const std::vector<bool> there = on_surfaces(other);
    double here_alone = 0, there_alone = 0;
    for (std::size_t i = 0; i < sample_.size(); ++i) {
      const Surfel& s = sample_[i];
      if (here[i] == there[i] || moved_m(s, poses, other) < kTells_m) continue;
      (here[i] ? here_alone : there_alone) += 1;
    }
    peaks.push_back((here_alone - there_alone) / std::sqrt(here_alone + there_alone + 1));
  }
  const auto middle = peaks.begin() + static_cast<std::ptrdiff_t>(peaks.size() / 2);
  std::nth_element(peaks.begin(), middle, peaks.end());
  return *middle;
}

std::optional<PosePair::Accounts> PosePair::accounts(const Motion& said, const Vector6d& found) const {
  const auto T_start = said(first_scan_.start);
  const auto first = poses_of(first_scan_, said), second = poses_of(second_scan_, said);
  if (!T_start || !first || !second) return std::nullopt;
  Accounts out{
      {*first, *second},
      {poses_of(first_scan_, found, first_scan_.start), poses_of(second_scan_, found, first_scan_.start)},
      {},
      0};
  for (ScanPoses* poses : {&out.said.first, &out.said.second}) {
    for (SE3& T : poses->T_0v) T = T_start->inverse() * T;
  }
  const SE3 &T_said = out.said.second.T_0v.front(), &T_found = out.found.second.T_0v.front();
  std::vector<double> apart_m;
  for (const Surfel& s : sample_) apart_m.push_back((T_found * s.position_v - T_said * s.position_v).norm());
  if (apart_m.empty()) return std::nullopt;
  const auto middle = apart_m.begin() + static_cast<std::ptrdiff_t>(apart_m.size() / 2);
  std::nth_element(apart_m.begin(), middle, apart_m.end());
  out.apart_m = *middle;
  const double apart_s = (second_scan_.start - first_scan_.start).seconds();
  out.towards_found = (T_found * T_said.inverse()).log() / apart_s;
  return out;
}

std::optional<PosePair::Peaks> PosePair::peaks(const Motion& said, const Vector6d& found) const {
  const auto both = accounts(said, found);
  if (!both || both->apart_m < kLeastApart_m) return std::nullopt;
  return Peaks{peak(both->said, both->towards_found, both->apart_m),
               peak(both->found, -both->towards_found, both->apart_m)};
}

std::optional<PosePair::Flank> PosePair::flank(const Motion& said, const Vector6d& found) const {
  const auto both = accounts(said, found);
  if (!both) return std::nullopt;
  const std::vector<bool> said_on = on_surfaces(both->said);
  const auto better = [&](const Poses& poses) { return preference(said_on, on_surfaces(poses)); };
  return Flank{both->apart_m, better(both->found), better(beside(both->said, 0.5 * both->towards_found))};
}

std::vector<double> PosePair::preferences(const Motion& said, const std::vector<Motion>& others) const {
  std::vector<double> out(others.size(), 0);
  const auto first = poses_of(first_scan_, said), second = poses_of(second_scan_, said);
  if (!first || !second) return out;
  const std::vector<bool> said_on = on_surfaces({*first, *second});
  for (std::size_t i = 0; i < others.size(); ++i) {
    const auto other_first = poses_of(first_scan_, others[i]),
               other_second = poses_of(second_scan_, others[i]);
    if (other_first && other_second) out[i] = preference(said_on, on_surfaces({*other_first, *other_second}));
  }
  return out;
}

bool PosePair::one_sided(const Motion& said, const Vector6d& found) const {
  const auto both = accounts(said, found);
  if (!both) return false;
  const std::vector<bool> here = on_surfaces(both->said), there = on_surfaces(both->found);
  std::array<double, kSectors> alone{};
  for (std::size_t i = 0; i < here.size(); ++i) {
    const Surfel& s = sample_[i];
    if (here[i] || !there[i] || moved_m(s, both->said, both->found) < kTells_m) continue;
    const Eigen::Vector3d& p = s.position_v;
    const double turn = std::atan2(p.y(), p.x()) / (2 * std::numbers::pi) + 0.5;
    alone[static_cast<std::size_t>(turn * kSectors) % kSectors] += 1;
  }
  const std::array<double, kSectors> halves = half_turns(alone);
  return *std::min_element(halves.begin(), halves.end()) < kOneSided * (halves[0] + halves[kSectors / 2]);
}

std::optional<double> PosePair::equal_share() const {
  if (first_scan_.cells.size() != second_scan_.cells.size()) return std::nullopt;
  double equal = 0, both = 0;
  for (std::size_t i = 0; i < first_scan_.cells.size(); ++i) {
    const std::int32_t a = first_scan_.cells[i], b = second_scan_.cells[i];
    if (a < 0 || b < 0) continue;
    const float difference_m = first_scan_.returns[static_cast<std::size_t>(a)].range_m -
                               second_scan_.returns[static_cast<std::size_t>(b)].range_m;
    ++both;
    if (std::abs(difference_m) < kEqual_m) ++equal;
  }
  if (both == 0) return std::nullopt;
  return equal / both;
}

std::optional<Vector6d> PosePair::mean_velocity(const Motion& motion) const {
  const auto first = motion(first_scan_.start), second = motion(second_scan_.start);
  if (!first || !second) return std::nullopt;
  return Vector6d((first->inverse() * *second).log() / (second_scan_.start - first_scan_.start).seconds());
}

// A Gauss-Newton step: point to plane, both scans moving.
bool PosePair::step(Vector6d& velocity, double reach_m, double scale_m) const {
  const ScanPoses first = poses_of(first_scan_, velocity, first_scan_.start),
                  second = poses_of(second_scan_, velocity, first_scan_.start);
  Matrix6d information = kDamping * Matrix6d::Identity();
  Vector6d gradient = Vector6d::Zero();
  std::size_t matches = 0;
  for (const Surfel& s : sample_) {
    const auto m = compare(s, first, second, reach_m).match;
    if (!m) continue;
    ++matches;
    const double distance = m->normal_0.dot(m->second_0 - m->first_0);
    const double weight = 1 / (1 + (distance / scale_m) * (distance / scale_m));
    Vector6d row;
    row << m->normal_0 * (m->second_s - m->first_s),
        m->second_s * m->second_0.cross(m->normal_0) - m->first_s * m->first_0.cross(m->normal_0);
    information += weight * row * row.transpose();
    gradient += weight * distance * row;
  }
  if (matches < kFewestMatches) return false;
  velocity -= information.ldlt().solve(gradient);
  return velocity.allFinite();
}

Vector6d PosePair::registered(Vector6d velocity) const {
  for (const Stage& stage : kStages) {
    for (int i = 0; i < stage.steps; ++i) {
      Vector6d next = velocity;
      if (!step(next, stage.reach_m, stage.scale_m)) return velocity;
      velocity = next;
    }
  }
  return velocity;
}

}  // namespace mapless
