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
/// Candidates are the unlabelled points linked to the object that have at least kTangentialVotes votes and
/// that an earlier scan observed. They belong to the object if they end freely, in front of something
/// farther, at more than kFreePerStatic times as many places as they continue into static points. A wall or
/// the ground beside an object continues into static points, along a row or straight across rows. Where they
/// continue straight into points that no scan observed before, as under the fan of a tilted sensor, they
/// count as static unless they continue as straight into the moving points: the side of a car does, the
/// ground beneath it meets the car at an angle.
class TangentialSurfaces {
 public:
  /// Keeps references. `moving` marks the points labelled so far.
  TangentialSurfaces(const LidarScan& scan, const LocalPoints& points, const LinkedNeighbours& neighbours,
                     const std::vector<PointEvidence>& votes, const MarkedReturns& moving)
      : scan_(scan),
        points_(points.points),
        neighbours_(neighbours),
        votes_(votes),
        moving_(moving),
        reached_(votes.size(), 0) {}

  /// The tangential surfaces of an object, given by the indices of its returns; empty where they do not
  /// belong to it. Valid until the next call.
  [[nodiscard]] const std::vector<std::int32_t>& of(std::span<const std::int32_t> object);

 private:
  void reach(std::int32_t from);
  [[nodiscard]] static bool is_candidate(const PointEvidence& votes);
  [[nodiscard]] bool ends_freely() const;

  // Counts of how the candidates end or continue.
  struct Rims {
    int free = 0;                    // in front of something farther
    int static_points = 0;           // into static points
    int unobserved = 0;              // straight into points that no scan observed before
    int straight = 0, at_angle = 0;  // into moving points; at an angle also where the direction is unknown
  };
  void count_along_row(std::int32_t i, Rims& rims) const;
  void count_beyond(std::int32_t i, LinkedNeighbours::Axis axis, int side, Rims& rims) const;
  [[nodiscard]] bool moves(std::int32_t i) const;
  [[nodiscard]] bool continues_straight(std::int32_t i, LinkedNeighbours::Axis axis, int side) const;
  [[nodiscard]] std::int32_t distant(std::int32_t i, LinkedNeighbours::Axis axis, int side) const;

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  const LinkedNeighbours& neighbours_;
  const std::vector<PointEvidence>& votes_;
  const MarkedReturns& moving_;
  std::vector<std::uint8_t> reached_;  // by return, from the object at work
  std::vector<std::int32_t> surface_;
};

}  // namespace mapless
