#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "detection/evidence/point_evidence.hpp"
#include "detection/segmentation/linked_neighbours.hpp"
#include "detection/segmentation/marked_returns.hpp"

namespace mapless::inline v1 {

/// All votes against that the three scans before and the later one can have: as many has what slides within
/// itself while it moves, and what stands has more.
inline constexpr int kSliding = -4;

/// Sides that slide within themselves: of a bus that goes by, both ends show that it moves, and its side is
/// where it was a moment ago. Such a side goes on from what moves over points that scans before saw a surface
/// at, none long ago, and ends of itself, in front of something farther. A wall or the ground beside
/// something that moves goes on into what stands: along rows, or as straight from row to row. And where it
/// goes straight on into what nobody has seen before, as under a fan that comes by, it is of what moves only
/// if it goes straight on from that, too: the ground is at an angle.
class TangentialSurfaces {
 public:
  /// Keeps references. The marks are on what moves.
  TangentialSurfaces(const LidarScan& scan, const LocalPoints& points, const LinkedNeighbours& neighbours,
                     const std::vector<PointVotes>& votes, const MarkedReturns& moving)
      : scan_(scan),
        points_(points.points),
        neighbours_(neighbours),
        votes_(votes),
        moving_(moving),
        reached_(votes.size(), 0) {}

  /// The sides of `thing`, points that move and are linked, which are not marked; empty where what goes on
  /// from it is not of it. Valid until the next call.
  [[nodiscard]] const std::vector<std::int32_t>& of(std::span<const std::int32_t> thing);

 private:
  void reach(std::int32_t from);
  [[nodiscard]] static bool slides(const PointVotes& votes);
  [[nodiscard]] bool end_of_themselves() const;

  // Rims of the sides: in front of something farther, where the surface goes on into what stands or straight
  // on into what is not known, and where what moves goes on, straight or not as far as can be told.
  struct Rims {
    int free = 0, held = 0, unknown = 0, straight = 0, bent = 0;
  };
  void look_along(std::int32_t i, Rims& rims) const;
  void look_beyond(std::int32_t i, LinkedNeighbours::Way way, int side, Rims& rims) const;
  [[nodiscard]] bool moves(std::int32_t i) const;
  [[nodiscard]] bool goes_straight_on(std::int32_t i, LinkedNeighbours::Way way, int side) const;
  [[nodiscard]] std::int32_t apart(std::int32_t i, LinkedNeighbours::Way way, int side) const;

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  const LinkedNeighbours& neighbours_;
  const std::vector<PointVotes>& votes_;
  const MarkedReturns& moving_;
  std::vector<std::uint8_t> reached_;  // of each return, by the thing at hand
  std::vector<std::int32_t> sides_;
};

}  // namespace mapless
