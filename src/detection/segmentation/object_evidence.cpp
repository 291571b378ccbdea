#include "detection/segmentation/object_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mapless::inline v1 {
namespace {

// A solid body has so many rows, and so many points and such a share of them that no scan saw through. One
// row or two, or every point seen through, is what edges and leaves look like.
constexpr int kSolidRows = 3;
constexpr std::size_t kSolidPoints = 4;
constexpr double kSolidShare = 0.2;

constexpr double kFlickeringShare = 0.7;

}  // namespace

ObjectEvidenceCollector::ObjectEvidenceCollector(const LidarScan& scan, const LocalPoints& points,
                                                 const std::vector<PointVotes>& votes, int most_of_row)
    : scan_(scan),
      points_(points),
      votes_(votes),
      most_of_row_(most_of_row),
      rows_(static_cast<std::size_t>(scan.rows())) {}

ObjectEvidence ObjectEvidenceCollector::of(std::span<const std::int32_t> object) {
  const Tally all = tally(object);
  return {static_cast<float>(displacement_m(object)), all.votes, body(object, all.rows)};
}

// What goes on by a part of its length uncovers such a part of its points.
double ObjectEvidenceCollector::displacement_m(std::span<const std::int32_t> object) const {
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();
  std::size_t recent = 0;
  for (const std::int32_t j : object) {
    centre += points_.points[static_cast<std::size_t>(j)];
    recent += votes_[static_cast<std::size_t>(j)].recently ? 1 : 0;
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
    const PointVotes& v = votes_[static_cast<std::size_t>(j)];
    ++row_of(j).points;
    row_of(j).all += v.total();
    if (!v.surface_seen) row_of(j).unseen += v.total();
  }
  int rows = 0;
  double sum = 0;
  for (const std::int32_t j : object) {
    const RowTally row = std::exchange(row_of(j), {});
    rows += row.points > 0 ? 1 : 0;
    sum += weighed(row);
  }
  return {rows, static_cast<int>(std::lround(sum))};
}

Body ObjectEvidenceCollector::body(std::span<const std::int32_t> object, int rows) const {
  std::size_t whole = 0, flickering = 0;
  for (const std::int32_t j : object) {
    const PointVotes& v = votes_[static_cast<std::size_t>(j)];
    whole += v.seen_through ? 0 : 1;
    flickering += v.seen_through && v.surface_seen ? 1 : 0;
  }
  const auto count = static_cast<double>(object.size());
  if (rows >= kSolidRows && whole >= kSolidPoints && static_cast<double>(whole) >= kSolidShare * count)
    return Body::rigid;
  return static_cast<double>(flickering) > kFlickeringShare * count ? Body::porous : Body::unclear;
}

double ObjectEvidenceCollector::weighed(const RowTally& row) const {
  const double counted = (row.all + row.unseen) / 2.0;
  return row.all > most_of_row_ ? counted * most_of_row_ / row.all : counted;
}

}  // namespace mapless
