#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "detection/evidence/point_evidence.hpp"
#include "detection/segmentation/linked_neighbours.hpp"
#include "detection/segmentation/marked_returns.hpp"

namespace mapless::inline v1 {

/// Most votes against a point of the three scans before and the later one, one each: a surface that slides
/// along itself has no more while it moves, a static one has, from older scans.
inline constexpr int kTangentialVotes = -4;

/// Surfaces of a moving object that slide along themselves (the aperture problem): the side of a passing bus
/// is observed at the same place in consecutive scans, while both ends show that the bus moves.
///
/// Candidates are the unlabelled points linked to the object that have at least kTangentialVotes votes.
/// Points that no earlier scan observed are among them. Their rim decides: along it they continue into points
/// of the object, continue into static points, or end freely, in front of something farther. A square of as
/// many points has four sides. The candidates belong to the object if it takes one of them and they end
/// freely at more than kPerStatic times as many places as they continue into static points, or if it takes
/// two and the same holds of the places where they continue into it. The ground beside an object continues
/// into static points, and where it is unknown touches the object at few.
class TangentialSurfaces {
 public:
  /// Keeps references. `moving` marks the points labelled so far.
  TangentialSurfaces(const LidarScan& scan, const LinkedNeighbours& neighbours,
                     const std::vector<PointEvidence>& votes, const MarkedReturns& moving)
      : scan_(scan), neighbours_(neighbours), votes_(votes), moving_(moving), reached_(votes.size(), 0) {}

  /// The tangential surfaces of an object, given by the indices of its returns; empty where they do not
  /// belong to it. Valid until the next call.
  [[nodiscard]] const std::vector<std::int32_t>& of(std::span<const std::int32_t> object);

 private:
  void reach(std::int32_t from);
  [[nodiscard]] bool belongs_to_object() const;

  // At how many places the candidates end or continue.
  struct Rim {
    int free = 0;           // in front of something farther
    int static_points = 0;  // into static points
    int moving = 0;         // into labelled points
  };
  void count_beside(std::int32_t i, LinkedNeighbours::Axis axis, int side, Rim& rim) const;
  [[nodiscard]] bool moves(std::int32_t i) const;

  const LidarScan& scan_;
  const LinkedNeighbours& neighbours_;
  const std::vector<PointEvidence>& votes_;
  const MarkedReturns& moving_;
  std::vector<std::uint8_t> reached_;  // by return, from the object at work
  std::vector<std::int32_t> surface_;
};

}  // namespace mapless
