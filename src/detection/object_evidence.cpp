#include "detection/object_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mapless {

EvidenceOfObjects::EvidenceOfObjects(const LidarScan& scan, const LocalPoints& points,
                                     const std::vector<PointVotes>& votes, int most_of_row)
    : scan_(scan),
      points_(points),
      votes_(votes),
      most_of_row_(most_of_row),
      rows_(static_cast<std::size_t>(scan.rows())) {}

ObjectEvidence EvidenceOfObjects::of(std::span<const std::int32_t> object) {
  return {static_cast<float>(advance_m(object)), votes(object)};
}

// What goes on by a part of its length uncovers such a part of its points.
double EvidenceOfObjects::advance_m(std::span<const std::int32_t> object) const {
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

int EvidenceOfObjects::votes(std::span<const std::int32_t> object) {
  for (const std::int32_t j : object) {
    const PointVotes& v = votes_[static_cast<std::size_t>(j)];
    row_of(j).all += v.total();
    if (!v.surface_seen) row_of(j).unseen += v.total();
  }
  double sum = 0;
  for (const std::int32_t j : object) sum += weighed(std::exchange(row_of(j), {}));
  return static_cast<int>(std::lround(sum));
}

double EvidenceOfObjects::weighed(const RowVotes& row) const {
  const double counted = (row.all + row.unseen) / 2.0;
  return row.all > most_of_row_ ? counted * most_of_row_ / row.all : counted;
}

}  // namespace mapless
