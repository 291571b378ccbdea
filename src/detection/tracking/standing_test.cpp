#include "detection/tracking/standing_test.hpp"

#include <algorithm>
#include <bit>

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

// 1, 2 and 4 scans before: those between add hardly any evidence.
bool is_recent(int gap) {
  return gap > 0 && gap <= kRecentGap && std::has_single_bit(static_cast<unsigned>(gap));
}

double share(int part, std::size_t all) { return static_cast<double>(part) / static_cast<double>(all); }

}  // namespace

// Up to kMaxTestedPoints of an object, and how far from a surface a ray may end.
struct StandingTest::Sample {
  std::vector<Eigen::Vector3f> points;
  std::vector<float> columns;
  double tolerance_m = 0;
};

StandingTest::StandingTest(const LidarScan& scan, const LocalPoints& points,
                           std::span<const ReferenceRays> references, const VotingParameters& parameters)
    : scan_(scan), points_(points.points) {
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
    sample.points.push_back(points_[i]);
    sample.columns.push_back(static_cast<float>(scan_.returns[i].column));
  }
  const LidarReturn& middle = scan_.returns[static_cast<std::size_t>(object[object.size() / 2])];
  sample.tolerance_m = static_cast<double>(recent_.front().probe.tolerance_m(middle.laser, middle.range_m));

  if (!seen_standing_before(sample)) return false;
  const Tally standing = recent_rays(sample, Eigen::Vector3d::Zero());
  if (standing.all() == 0 || share(standing.all(), sample.points.size() * recent_.size()) < kObserved)
    return false;
  const double explained = share(standing.surface, static_cast<std::size_t>(standing.all()));
  if (explained < (std_mps > kKnown_mps ? kExplainsAlone : kStandingExplains)) return false;
  const Tally moving = recent_rays(sample, velocity_0);
  return explained >=
         kStandsBetter + share(moving.surface, static_cast<std::size_t>(std::max(moving.all(), 1)));
}

bool StandingTest::seen_standing_before(const Sample& sample) const {
  const auto shows = std::find_if(earlier_.begin(), earlier_.end(), [&](const Reference& r) {
    return kShownSpeed_mps * r.before_s >= sample.tolerance_m;
  });
  if (shows == earlier_.end()) return false;
  Tally tally;
  observe(*shows, sample, Eigen::Vector3d::Zero(), tally);
  return share(tally.all(), sample.points.size()) >= kObservedBefore &&
         tally.surface >= kMostOfThem * (tally.surface + tally.through);
}

StandingTest::Tally StandingTest::recent_rays(const Sample& sample, const Eigen::Vector3d& velocity_0) const {
  Tally tally;
  for (const Reference& reference : recent_) observe(reference, sample, velocity_0, tally);
  return tally;
}

void StandingTest::observe(const Reference& reference, const Sample& sample,
                           const Eigen::Vector3d& velocity_0, Tally& tally) {
  const Eigen::Vector3f back = (reference.before_s * velocity_0).cast<float>();
  PackedPoints points;
  points.reserve(sample.points.size());
  for (std::size_t k = 0; k < sample.points.size(); ++k)
    points.add(sample.points[k] - back, sample.columns[k]);
  points.observe(reference.probe, [&](std::size_t, const FreespaceProbe::Answer& answer) {
    if (answer.verdict == FreespaceVerdict::border) ++tally.surface;
    if (answer.verdict == FreespaceVerdict::inside) ++tally.through;
    if (answer.verdict == FreespaceVerdict::outside) ++tally.hidden;
  });
}

}  // namespace mapless
