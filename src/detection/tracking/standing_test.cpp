#include "detection/tracking/standing_test.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "detection/evidence/point_evidence.hpp"
#include "detection/freespace/packed_points.hpp"

namespace mapless::inline v1 {
namespace {

// Most points of an object that are tested, for the time it takes: a share of 160 is known to 4 %.
constexpr std::size_t kMaxTestedPoints = 160;

// A velocity that explains this much less does not explain the rays. Measured: .03 and .07 change no mean
// IoU of a sensor by more than .004 (docs/notebook/detection.md, "Standing or moving").
constexpr double kStandsBetter = 0.05;
// Standing explains at least this share of the rays. Not all: glass, edges, and poses that err by a
// hundredth of the path leave a quarter of the rays past parked cars unexplained.
constexpr double kStandingExplains = 0.7;
// This share where the velocity is known worse than kKnown_mps: the long side of a car alongside slides along
// itself, and a wrong velocity explains it no better than standing.
constexpr double kExplainsAlone = 0.8, kKnown_mps = 1;
// Least share of the points that the rays of a scan observe.
constexpr double kObserved = 0.25;

// An older scan has to show that the object is static: the nearest in which an object of this speed would be
// off by its tolerance. The rays of nearer scans end on the surface of a slow walker, too. Measured: without
// it, people at 0.4 to 0.6 m/s are lost, up to .06 IoU of a recording.
constexpr double kShownSpeed_mps = 0.3;
constexpr double kMostOfThem = 0.5;      // least share of the observed points on a surface
constexpr double kObservedBefore = 0.3;  // least share of the points that its rays observe

// The rays of the next scan and of two before it fix the velocity of a surface of which they reach most
// points again, to this standard deviation. Measured: .1 to .2 m/s and a share of .95 give the same within
// .005; with .85, slow walkers stop on 16 beams.
constexpr double kSlowStd_mps = 0.1;
constexpr int kBesideGap = 2;
constexpr double kReachAgain = 0.9, kObservedBeside = 0.5;
// Rays that end farther off are of something else. Chosen: 1.5 m/s over two scans.
constexpr float kSameSurface_m = 0.3F;
// From more than this nothing stops within the 0.45 s over which tracks are registered: 5 m/s^2 is hard
// braking. So what is faster slides along itself where its surface seems to stand.
constexpr double kStopsFrom_mps = 2.25;

// 1, 2 and 4 scans before: those between add hardly any evidence.
bool is_recent(int gap) {
  return gap > 0 && gap <= kRecentGap && std::has_single_bit(static_cast<unsigned>(gap));
}

double share(int part, std::size_t all) { return static_cast<double>(part) / static_cast<double>(all); }

}  // namespace

// Up to kMaxTestedPoints of an object, and how far from a surface a ray may end.
struct StandingTest::Sample {
  std::vector<std::size_t> returns;
  std::vector<Eigen::Vector3f> points;
  std::vector<float> columns;
  double tolerance_m = 0;
};

template <class Take>
void StandingTest::observe(const Reference& reference, const Sample& sample,
                           const Eigen::Vector3d& velocity_0, Take&& take) {
  const Eigen::Vector3f back = (reference.before_s * velocity_0).cast<float>();
  PackedPoints points;
  points.reserve(sample.points.size());
  for (std::size_t k = 0; k < sample.points.size(); ++k)
    points.add(sample.points[k] - back, sample.columns[k]);
  points.observe(reference.probe, take);
}

StandingTest::StandingTest(const LidarScan& scan, const LocalPoints& points,
                           std::span<const ReferenceRays> references, const VotingParameters& parameters)
    : scan_(scan),
      points_(points.points),
      normals_(scan, points.points),
      min_speed_mps_(parameters.min_speed_mps) {
  int next = 0;
  for (const ReferenceRays& r : references) {
    if (r.gap < 0 && (next == 0 || r.gap > next)) next = r.gap;
  }
  for (const ReferenceRays& r : references) {
    const Reference reference{FreespaceProbe(*r.rays, points.origin_0, parameters), r.gap,
                              (scan.start - r.rays->start()).seconds()};
    if (r.gap == next || is_recent(r.gap)) recent_.push_back(reference);
    if (r.gap >= kRecentGap) earlier_.push_back(reference);
  }
}

bool StandingTest::stands(std::span<const std::int32_t> object, const Eigen::Vector3d& velocity_0,
                          double std_mps) const {
  if (recent_.empty() || object.empty()) return false;
  Sample sample;
  const std::size_t stride = (object.size() + kMaxTestedPoints - 1) / kMaxTestedPoints;
  for (std::size_t k = 0; k < object.size(); k += stride) {
    const auto i = static_cast<std::size_t>(object[k]);
    sample.returns.push_back(i);
    sample.points.push_back(points_[i]);
    sample.columns.push_back(static_cast<float>(scan_.returns[i].column));
  }
  const LidarReturn& middle = scan_.returns[static_cast<std::size_t>(object[object.size() / 2])];
  sample.tolerance_m = static_cast<double>(recent_.front().probe.tolerance_m(middle.laser, middle.range_m));

  Eigen::Vector3d velocity = velocity_0;
  if (velocity_0.norm() < kStopsFrom_mps) {
    if (const auto measured = measured_by_rays(sample)) {
      velocity = measured->velocity_0;
      if (velocity.norm() < min_speed_mps_) return true;
    }
  }
  if (!seen_standing_before(sample)) return false;
  const Tally standing = recent_rays(sample, Eigen::Vector3d::Zero());
  if (standing.all() == 0 || share(standing.all(), sample.points.size() * recent_.size()) < kObserved)
    return false;
  const double explained = share(standing.surface, static_cast<std::size_t>(standing.all()));
  if (explained < (std_mps > kKnown_mps ? kExplainsAlone : kStandingExplains)) return false;
  const Tally moving = recent_rays(sample, velocity);
  return explained >=
         kStandsBetter + share(moving.surface, static_cast<std::size_t>(std::max(moving.all(), 1)));
}

std::optional<SlowMotion> StandingTest::measured_by_rays(const Sample& sample) const {
  std::vector<PlaneOffset> offsets;
  int beside = 0;  // scans
  for (const Reference& reference : recent_) {
    if (std::abs(reference.gap) > kBesideGap) continue;
    Tally tally;
    observe(reference, sample, Eigen::Vector3d::Zero(),
            [&](std::size_t k, const FreespaceProbe::Answer& answer) {
              tally.add(answer.verdict);
              if (!(std::abs(answer.short_by_m) < kSameSurface_m) || answer.laser < 0) return;
              const Eigen::Vector3d normal = normals_.of(sample.returns[k]);
              const Eigen::Vector3f end = reference.probe.endpoint(answer.laser, answer.column);
              offsets.push_back(
                  {normal, normal.dot((end - sample.points[k]).cast<double>()), reference.before_s});
            });
    if (std::abs(reference.gap) != 1) continue;
    if (share(tally.all(), sample.points.size()) < kObservedBeside) return std::nullopt;
    if (tally.surface < kReachAgain * tally.all()) return std::nullopt;
    ++beside;
  }
  if (beside < 2) return std::nullopt;
  const SlowMotion motion = slow_motion(offsets);
  return motion.std_mps < kSlowStd_mps ? std::optional(motion) : std::nullopt;
}

bool StandingTest::seen_standing_before(const Sample& sample) const {
  const auto shows = std::find_if(earlier_.begin(), earlier_.end(), [&](const Reference& r) {
    return kShownSpeed_mps * r.before_s >= sample.tolerance_m;
  });
  if (shows == earlier_.end()) return false;
  Tally tally;
  observe(*shows, sample, Eigen::Vector3d::Zero(),
          [&](std::size_t, const FreespaceProbe::Answer& answer) { tally.add(answer.verdict); });
  return share(tally.all(), sample.points.size()) >= kObservedBefore &&
         tally.surface >= kMostOfThem * (tally.surface + tally.through);
}

StandingTest::Tally StandingTest::recent_rays(const Sample& sample, const Eigen::Vector3d& velocity_0) const {
  Tally tally;
  for (const Reference& reference : recent_) {
    observe(reference, sample, velocity_0,
            [&](std::size_t, const FreespaceProbe::Answer& answer) { tally.add(answer.verdict); });
  }
  return tally;
}

}  // namespace mapless
