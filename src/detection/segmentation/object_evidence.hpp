#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "detection/evidence/point_evidence.hpp"
#include "detection/published/region_growth.hpp"

namespace mapless::inline v1 {

/// Sums up what rays say of the points of whole objects of one scan.
///
/// Points of one row err alike, as one laser's beam grazes an edge: together they count no more than
/// `most_of_row` votes. And a point at which some scan saw a surface counts half: what moves was not there
/// then, what flickers was.
class EvidenceOfObjects {
 public:
  /// Keeps references.
  EvidenceOfObjects(const LidarScan& scan, const LocalPoints& points, const std::vector<PointVotes>& votes,
                    int most_of_row);

  /// `object`: its returns, in any order.
  [[nodiscard]] ObjectEvidence of(std::span<const std::int32_t> object);

 private:
  [[nodiscard]] double advance_m(std::span<const std::int32_t> object) const;
  struct RowVotes {
    int points = 0;
    int all = 0, unseen = 0;  // of those all, where no scan saw a surface
  };
  struct Tally {
    int rows;
    int votes;
  };
  [[nodiscard]] Tally tally(std::span<const std::int32_t> object);
  [[nodiscard]] Body body(std::span<const std::int32_t> object, int rows) const;
  [[nodiscard]] RowVotes& row_of(std::int32_t i) {
    return rows_[static_cast<std::size_t>(scan_.returns[static_cast<std::size_t>(i)].laser)];
  }
  [[nodiscard]] double weighed(const RowVotes& row) const;

  const LidarScan& scan_;
  const LocalPoints& points_;
  const std::vector<PointVotes>& votes_;
  int most_of_row_;
  std::vector<RowVotes> rows_;  // 0 between calls
};

}  // namespace mapless
