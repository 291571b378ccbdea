#pragma once

#include <cstddef>
#include <vector>

#include "detection/witnesses.hpp"
#include <mapless/lidar/aligned_image.hpp>

namespace mapless {

/// Puts a scan's points to the witnesses, laser by laser, as few as will do.
///
/// A row is cut into spans between whose ends all points lie on a line. Where both ends stand, or both move,
/// so do the points between, and have the votes of the nearer. Else the one half-way is asked, and so on.
/// A row between two that were asked before does not ask about points on the line between two of those that
/// stand.
class RowVotes {
 public:
  RowVotes(const LidarScan& scan, const LocalPoints& points, const Witnesses& witnesses);

  /// Votes of the returns `begin` to `end` of `laser`. Where it is `between`, the rows below and above were
  /// asked before.
  void vote(int laser, bool between, std::size_t begin, std::size_t end, std::vector<PointVotes>& votes);

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
  // A row that was asked before, and how far along it what lies in the same direction is.
  struct Beside {
    int row = -1;  // -1: none
    int columns_on = 0;
  };
  [[nodiscard]] Beside row_beside(int laser, int row) const;
  [[nodiscard]] std::ptrdiff_t beside(std::size_t i, const Beside& other) const;

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  const Witnesses& witnesses_;
  AlignedImage image_;
  // Of one row:
  Beside below_, above_;
  std::size_t begin_ = 0;  // its first point
  std::vector<PointVotes>* votes_ = nullptr;
  std::vector<float> x_, y_, z_;  // of its points, and a few more zeros
  std::vector<std::size_t> questions_;
  std::vector<Span> open_, halves_;
  Witnesses::Hearing hearing_;
};

}  // namespace mapless
