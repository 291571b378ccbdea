#pragma once

#include <cstddef>
#include <vector>

#include "detection/witnesses.hpp"
#include <mapless/lidar/aligned_image.hpp>

namespace mapless {

/// Puts a scan's points to the witnesses, laser by laser, as few as will do.
///
/// A row is cut into spans between whose ends all points lie on a line. Where both ends stand, or have the
/// same votes, so have the points between. Else the one half-way is asked, and so on. Rows between two that
/// were asked before ask nothing of points that lie on the line between two of those that stand, or next to
/// one.
class RowVotes {
 public:
  RowVotes(const LidarScan& scan, const LocalPoints& points, const Witnesses& witnesses,
           const VotingParameters& parameters);

  /// The rows in the order they are to be asked in: those of one turn need only turns before it.
  [[nodiscard]] static std::vector<std::vector<int>> turns(int rows);
  /// Votes of the returns `begin` to `end` of `laser`. `apart` is how far off the rows above and below are
  /// that were asked before, 0 if none were.
  void vote(int laser, int apart, std::size_t begin, std::size_t end, std::vector<PointVotes>& votes);

 private:
  // Points of the row, numbered from its first: two that were asked, and those between that were not.
  struct Span {
    std::size_t left, right;
  };

  void load(std::size_t begin, std::size_t end);
  void cut(const Span& span);
  [[nodiscard]] std::size_t farthest_off(const Span& span) const;
  void settle(const Span& span);
  void question(std::size_t i);
  [[nodiscard]] bool known_from_beside(std::size_t i);
  [[nodiscard]] std::ptrdiff_t beside(std::size_t i, int row) const;

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  const Witnesses& witnesses_;
  float tolerance2_;
  AlignedImage image_;
  // Of one row:
  int below_ = -1, above_ = -1;     // rows that were asked before; -1: none
  std::size_t begin_ = 0;           // its first point
  std::vector<PointVotes>* votes_ = nullptr;
  std::vector<float> x_, y_, z_;    // of its points, and a few more zeros
  std::vector<std::size_t> questions_;
  std::vector<Span> open_, halves_;
  Witnesses::Hearing hearing_;
};

}  // namespace mapless
