#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "detection/evidence/point_evidence.hpp"
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {

/// Shape of an object as the rays of the reference scans observed its place. Limits: object_evidence.cpp.
enum class Body : std::uint8_t {
  unclear,
  rigid,     ///< several rows, and part of its points was never seen through: it occluded its former place
  standing,  ///< scans before the recent ones saw a surface at part of its points: leaves, rails, edges
  line       ///< its points lie on a straight line: rails, kerbs, edges
};

/// Evidence of the rays about one object, of method "voting".
struct ObjectEvidence {
  float displacement_m = 0;  ///< estimate since the scans up to kRecentGap back
  int votes = 0;             ///< sum over its points, see ObjectEvidenceCollector
  Body body = Body::unclear;
  /// Logarithm of the likelihood of the rays past it and through it, as past a place that was empty before,
  /// relative to that as past a thing thinner than the distance of two lasers; 0: nothing is known.
  double log_odds = 0;
  Eigen::Vector3f line_0 = Eigen::Vector3f::Zero();  ///< unit vector along the straight line on
                                                     ///< which its points lie, frame 0; 0: on none
  int clutter = 0;  ///< EvidenceGrowthResult::faint within 3 m of its centre; counted by grow_evidence
};

/// The mean of these points of the scan [m], about LocalPoints::origin_0. At least one.
[[nodiscard]] Eigen::Vector3f centroid(const LocalPoints& points, std::span<const std::int32_t> returns);

/// Sums the evidence of the points of each object of one scan.
///
/// - Votes of a point count half if some scan saw a surface there: a porous object was there, a moving one
///   was not. Measured with full votes on 18 recordings of `mapless benchmark`: IoU -.006 (HDL-64E-S2) and
///   -.027 (VLP-16), false objects a scan +.4 and +.7.
/// - A point counts as the cosine of its beam's elevation: the firings of a beam that rises lie closer
///   together, and all that see one leaf err alike.
/// - The points of one row count at most `max_of_row` votes together: their errors are correlated, as one
///   laser's beam grazes an edge.
/// - Rails, kerbs and edges between two lasers are hit by neither: rays pass beside them in scan after scan,
///   and hardly ever through them. Past a place that was empty rays go at any distance.
/// - An object that moves on by a part of its length uncovers that part of its points. The displacement is
///   the share of points seen through recently, times twice the distance of the farthest point from the
///   centroid.
/// - The votes of surfaces that slide along themselves (TangentialSurfaces) do not count: rays observe such a
///   surface at the same place whether its object moves or not.
class ObjectEvidenceCollector {
 public:
  /// Keeps references. The votes of the returns `sliding` do not count.
  ObjectEvidenceCollector(const LidarScan& scan, const LocalPoints& points,
                          const std::vector<PointEvidence>& votes, int max_of_row,
                          std::span<const std::int32_t> sliding = {});

  /// The evidence of an object, given by the indices of its returns, in any order.
  [[nodiscard]] ObjectEvidence collect(std::span<const std::int32_t> object);

 private:
  [[nodiscard]] double displacement_m(std::span<const std::int32_t> object) const;
  struct RowTally {
    int points = 0;
    int all = 0;             // votes
    int uncontradicted = 0;  // of those, at points where no scan saw a surface
    int rays_through = 0, rays_beside = 0;
    float beside_m = 0;
  };
  // Rays through an object, and how many there would be if rays passed its place at any distance.
  struct RaysThrough {
    double seen = 0, expected = 0;
  };
  struct Tally {
    int rows;
    int votes;
    RaysThrough rays;
    bool surface_seen;  // at one of its points at least
  };
  [[nodiscard]] Tally tally(std::span<const std::int32_t> object);
  [[nodiscard]] Eigen::Vector3f line_0(std::span<const std::int32_t> object) const;
  [[nodiscard]] Body body(std::span<const std::int32_t> object, int rows, bool on_line) const;
  [[nodiscard]] RowTally& row_of(std::int32_t i) {
    return rows_[static_cast<std::size_t>(scan_.returns[static_cast<std::size_t>(i)].laser)];
  }
  [[nodiscard]] double weighted(const RowTally& row, double elevation_cosine) const;
  [[nodiscard]] double elevation_cosine(std::int32_t i) const;
  void add_rays(const RowTally& row, RaysThrough& rays) const;
  [[nodiscard]] static double log_odds_of_mover(const RaysThrough& rays);

  const LidarScan& scan_;
  const LocalPoints& points_;
  const std::vector<PointEvidence>& votes_;
  int max_of_row_;
  double alike_points_;         // neighbours in a row nearer to one another than two lasers
  std::vector<RowTally> rows_;  // all zero between calls
  std::vector<bool> slides_;    // by return
};

}  // namespace mapless
