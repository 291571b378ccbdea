#include "detection/segmentation/object_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mapless::inline v1 {
namespace {

// A rigid body has at least this many rows, and this many points and share of its points that no scan saw
// through. Edges and leaves have one row or two, or are seen through at every point.
constexpr int kRigidRows = 3;
constexpr std::size_t kRigidPoints = 4;
constexpr double kRigidShare = 0.2;

// Share of points that stood before, above which the object did. Not zero: where one thing leaves, another
// may come. Measured: .05 and .2 change no mean IoU of a sensor by more than .001.
constexpr double kStandingShare = 0.1;

}  // namespace

ObjectEvidenceCollector::ObjectEvidenceCollector(const LidarScan& scan, const LocalPoints& points,
                                                 const std::vector<PointEvidence>& votes, int max_of_row)
    : scan_(scan),
      points_(points),
      votes_(votes),
      max_of_row_(max_of_row),
      rows_(static_cast<std::size_t>(scan.rows())) {}

ObjectEvidence ObjectEvidenceCollector::collect(std::span<const std::int32_t> object) {
  const Tally all = tally(object);
  return {static_cast<float>(displacement_m(object)), all.votes, body(object, all.rows)};
}

double ObjectEvidenceCollector::displacement_m(std::span<const std::int32_t> object) const {
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();
  std::size_t recent = 0;
  for (const std::int32_t j : object) {
    centre += points_.points[static_cast<std::size_t>(j)];
    recent += votes_[static_cast<std::size_t>(j)].recently_free ? 1 : 0;
  }
  const auto count = static_cast<float>(object.size());
  centre /= count;
  float radius2 = 0;
  for (const std::int32_t j : object) {
    radius2 = std::max(radius2, (points_.points[static_cast<std::size_t>(j)] - centre).squaredNorm());
  }
  return 2 * std::sqrt(radius2) * static_cast<float>(recent) / count;
}

ObjectEvidenceCollector::Tally ObjectEvidenceCollector::tally(std::span<const std::int32_t> object) {
  for (const std::int32_t j : object) {
    const PointEvidence& v = votes_[static_cast<std::size_t>(j)];
    ++row_of(j).points;
    row_of(j).all += v.total();
    if (!v.surface_seen) row_of(j).uncontradicted += v.total();
  }
  int rows = 0;
  double sum = 0;
  for (const std::int32_t j : object) {
    const RowTally row = std::exchange(row_of(j), {});
    rows += row.points > 0 ? 1 : 0;
    sum += weighted(row);
  }
  return {rows, static_cast<int>(std::lround(sum))};
}

Body ObjectEvidenceCollector::body(std::span<const std::int32_t> object, int rows) const {
  std::size_t not_seen_through = 0, stood_before = 0;
  for (const std::int32_t j : object) {
    const PointEvidence& v = votes_[static_cast<std::size_t>(j)];
    not_seen_through += v.seen_through ? 0 : 1;
    stood_before += v.stood_before ? 1 : 0;
  }
  const auto count = static_cast<double>(object.size());
  if (rows >= kRigidRows && not_seen_through >= kRigidPoints &&
      static_cast<double>(not_seen_through) >= kRigidShare * count)
    return Body::rigid;
  return static_cast<double>(stood_before) > kStandingShare * count ? Body::standing : Body::unclear;
}

double ObjectEvidenceCollector::weighted(const RowTally& row) const {
  const double counted = (row.all + row.uncontradicted) / 2.0;
  return row.all > max_of_row_ ? counted * max_of_row_ / row.all : counted;
}

}  // namespace mapless
