#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "detection/evidence/point_evidence.hpp"

namespace mapless::inline v1 {

/// What an object looks like to all the scans that were asked about its points.
enum class Body : std::uint8_t {
  unclear,
  rigid,  ///< of some rows, and no scan saw through a part of it, as it hides itself or where it was
  porous  ///< nearly all of it was seen through by one scan and a surface to another: leaves, rails,
          ///< edges
};

/// What rays tell of the whole of an object, of method "voting".
struct ObjectEvidence {
  float displacement_m = 0;  ///< about how far it went since the scans of a moment ago
  int votes = 0;  ///< of its points (PointVotes::total): half where a surface was seen, of one row at
                  ///< most VotingParameters::min_evidence
  Body body = Body::unclear;
};

/// Sums up what rays say of the points of whole objects of one scan.
///
/// Points of one row err alike, as one laser's beam grazes an edge: together they count no more than
/// `most_of_row` votes. And a point at which some scan saw a surface counts half: what moves was not there
/// then, what flickers was.
class ObjectEvidenceCollector {
 public:
  /// Keeps references.
  ObjectEvidenceCollector(const LidarScan& scan, const LocalPoints& points,
                          const std::vector<PointVotes>& votes, int most_of_row);

  /// `object`: its returns, in any order.
  [[nodiscard]] ObjectEvidence of(std::span<const std::int32_t> object);

 private:
  [[nodiscard]] double displacement_m(std::span<const std::int32_t> object) const;
  struct RowTally {
    int points = 0;
    int all = 0, unseen = 0;  // of those all, where no scan saw a surface
  };
  struct Tally {
    int rows;
    int votes;
  };
  [[nodiscard]] Tally tally(std::span<const std::int32_t> object);
  [[nodiscard]] Body body(std::span<const std::int32_t> object, int rows) const;
  [[nodiscard]] RowTally& row_of(std::int32_t i) {
    return rows_[static_cast<std::size_t>(scan_.returns[static_cast<std::size_t>(i)].laser)];
  }
  [[nodiscard]] double weighed(const RowTally& row) const;

  const LidarScan& scan_;
  const LocalPoints& points_;
  const std::vector<PointVotes>& votes_;
  int most_of_row_;
  std::vector<RowTally> rows_;  // 0 between calls
};

}  // namespace mapless
