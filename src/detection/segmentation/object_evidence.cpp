#include "detection/segmentation/object_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Eigenvalues>

#include "geometry/plane_fit.hpp"

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

// Points lie on a line if their standard deviation along it is at least kLeastAlong_m, and that across it at
// most this share of it. Measured: with a share of .15, cars seen by two lasers are lines (IoU of a motorway
// -.02, VLP-16); a length of .15 m, or of 0, changes the mean IoU of no group by more than .0005.
constexpr double kLeastAlong_m = 0.1;
constexpr double kMostAcross = 0.1;

// Rays through a thin static thing, of those through a place where rays pass at any distance. Measured,
// VLP-16 past guard rails: .2 in the median, 1.6 through what moves (docs/notebook/detection.md, "Rays
// beside").
constexpr double kThroughThin = 0.3;
// Rays beside an object are farther aside than kSeenThroughWithin_m, in the mean by this at least.
constexpr double kLeastAside_m = 0.07;

// Firings between two lasers.
double laser_spacing_columns(const LidarScan& scan) {
  const std::vector<Laser>& lasers = scan.model->lasers;
  if (lasers.size() < 2) return 1;
  const double span_rad = lasers.back().elevation_rad - lasers.front().elevation_rad;
  const double spacing_rad = span_rad / static_cast<double>(lasers.size() - 1);
  return std::max(1.0, spacing_rad * scan.model->columns / (2 * std::numbers::pi));
}

}  // namespace

Eigen::Vector3f centroid(const LocalPoints& points, std::span<const std::int32_t> returns) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const std::int32_t i : returns) sum += points.points[static_cast<std::size_t>(i)];
  return sum / static_cast<float>(returns.size());
}

ObjectEvidenceCollector::ObjectEvidenceCollector(const LidarScan& scan, const LocalPoints& points,
                                                 const std::vector<PointEvidence>& votes, int max_of_row,
                                                 std::span<const std::int32_t> sliding)
    : scan_(scan),
      points_(points),
      votes_(votes),
      max_of_row_(max_of_row),
      alike_points_(laser_spacing_columns(scan)),
      rows_(static_cast<std::size_t>(scan.rows())),
      slides_(votes.size(), false) {
  for (const std::int32_t i : sliding) slides_[static_cast<std::size_t>(i)] = true;
}

ObjectEvidence ObjectEvidenceCollector::collect(std::span<const std::int32_t> object) {
  const Tally all = tally(object);
  const Eigen::Vector3f line = all.surface_seen ? line_0(object) : Eigen::Vector3f::Zero();
  return {static_cast<float>(displacement_m(object)), all.votes, body(object, all.rows, !line.isZero()),
          log_odds_of_mover(all.rays), line};
}

Eigen::Vector3f ObjectEvidenceCollector::line_0(std::span<const std::int32_t> object) const {
  if (object.size() < 3) return Eigen::Vector3f::Zero();
  const Eigen::Vector3f& near = points_.points[static_cast<std::size_t>(object.front())];
  Moments moments;
  for (const std::int32_t j : object)
    moments.add((points_.points[static_cast<std::size_t>(j)] - near).cast<double>());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(moments.covariance());
  const double along = axes.eigenvalues().z(), across = axes.eigenvalues().y();
  if (along < kLeastAlong_m * kLeastAlong_m || across > kMostAcross * kMostAcross * along)
    return Eigen::Vector3f::Zero();
  return axes.eigenvectors().col(2).cast<float>();
}

double ObjectEvidenceCollector::displacement_m(std::span<const std::int32_t> object) const {
  const Eigen::Vector3f centre = centroid(points_, object);
  std::size_t recent = 0;
  float radius2 = 0;
  for (const std::int32_t j : object) {
    recent += votes_[static_cast<std::size_t>(j)].recently_free ? 1 : 0;
    radius2 = std::max(radius2, (points_.points[static_cast<std::size_t>(j)] - centre).squaredNorm());
  }
  return 2 * std::sqrt(radius2) * static_cast<float>(recent) / static_cast<float>(object.size());
}

ObjectEvidenceCollector::Tally ObjectEvidenceCollector::tally(std::span<const std::int32_t> object) {
  bool surface_seen = false;
  for (const std::int32_t j : object) {
    const PointEvidence& v = votes_[static_cast<std::size_t>(j)];
    surface_seen = surface_seen || v.surface_seen;
    ++row_of(j).points;
    const int votes = slides_[static_cast<std::size_t>(j)] ? 0 : v.total();
    row_of(j).all += votes;
    if (!v.surface_seen) row_of(j).uncontradicted += votes;
    row_of(j).rays_through += v.rays_through;
    row_of(j).rays_beside += v.rays_beside;
    row_of(j).beside_m += v.beside_m;
  }
  int rows = 0;
  double sum = 0;
  RaysThrough rays;
  for (const std::int32_t j : object) {
    const RowTally row = std::exchange(row_of(j), {});
    if (row.points == 0) continue;
    ++rows;
    sum += weighted(row, elevation_cosine(j));
    add_rays(row, rays);
  }
  return {rows, static_cast<int>(std::lround(sum)), rays, surface_seen};
}

// Of rays that pass at any distance up to half of that between two lasers, with a mean `aside` of those
// beyond kSeenThroughWithin_m, w, there are w / (2 (aside - w)) within w for each beyond. Points nearer than
// two lasers have the rays of the same lasers beside them, and a sensor that hardly moves has the same rays
// in every scan: together they count once.
void ObjectEvidenceCollector::add_rays(const RowTally& row, RaysThrough& rays) const {
  const double points = row.points, all = row.rays_through + row.rays_beside;
  const double alike = std::min(points, alike_points_) * std::max(1.0, all / points);
  rays.seen += row.rays_through / alike;
  if (row.rays_beside == 0) return;
  const double aside_m = static_cast<double>(row.beside_m) / row.rays_beside;
  const double beyond_m = std::max(aside_m - static_cast<double>(kSeenThroughWithin_m), kLeastAside_m);
  rays.expected += row.rays_beside / alike * static_cast<double>(kSeenThroughWithin_m) / (2 * beyond_m);
}

// Of the rays, as those of a mover against those of a thin thing, both Poisson.
double ObjectEvidenceCollector::log_odds_of_mover(const RaysThrough& rays) {
  return -(1 - kThroughThin) * rays.expected - std::log(kThroughThin) * rays.seen;
}

Body ObjectEvidenceCollector::body(std::span<const std::int32_t> object, int rows, bool on_line) const {
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
  if (static_cast<double>(stood_before) > kStandingShare * count) return Body::standing;
  return on_line ? Body::line : Body::unclear;
}

double ObjectEvidenceCollector::elevation_cosine(std::int32_t i) const {
  const int laser = scan_.returns[static_cast<std::size_t>(i)].laser;
  return std::cos(scan_.model->lasers[static_cast<std::size_t>(laser)].elevation_rad);
}

double ObjectEvidenceCollector::weighted(const RowTally& row, double elevation_cosine) const {
  const double all = row.all * elevation_cosine;
  const double counted = (row.all + row.uncontradicted) * elevation_cosine / 2;
  return all > max_of_row_ ? counted * max_of_row_ / all : counted;
}

}  // namespace mapless
