#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "detection/evidence/evidence_collector.hpp"
#include "lidar/aligned_image.hpp"

namespace mapless::inline v1 {

/// Puts a scan's points to the witnesses, a few lasers at a time, as few points as will do.
///
/// A row is cut into spans between whose ends all points lie on a line. Where both ends stand, or both move,
/// so do the points between, and have the votes of the nearer. Else the one half-way is asked, and so on.
/// A row between two that were asked before does not ask about points on the line between two of those that
/// stand.
class RowVotes {
 public:
  RowVotes(const LidarScan& scan, const LocalPoints& points, const Witnesses& witnesses);

  /// A laser's returns.
  struct Row {
    std::size_t begin, end;
  };
  /// Votes of rows, asked together. Where they are `between`, the rows below and above each were asked
  /// before.
  void vote(std::span<const Row> rows, bool between, std::vector<PointVotes>& votes);

 private:
  // Returns of one row: two that were asked, and those between that were not.
  struct Span {
    std::size_t left, right;
  };

  void begin(const Row& row);
  void load(const Row& row);
  void cut(const Span& span);
  [[nodiscard]] std::size_t farthest_off(const Span& span) const;
  void settle(const Span& span);
  void question(std::size_t i);
  [[nodiscard]] bool known_from_beside(std::size_t i);
  [[nodiscard]] std::ptrdiff_t beside(const LidarReturn& r, int row) const;

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  const Witnesses& witnesses_;
  AlignedImage image_;
  bool between_ = false;
  std::vector<PointVotes>* votes_ = nullptr;
  // A thread keeps it from one scan to the next: nothing is allocated once it is large enough.
  struct Room {
    std::vector<float> x, y, z;  // of the row that is cut: all its points, and a few more zeros
    std::vector<std::size_t> questions;
    std::vector<Span> open, halves;
    Witnesses::Hearing hearing;
  };
  Room* room_ = nullptr;   // while `vote` is at work
  std::size_t first_ = 0;  // point of the row that is cut
};

}  // namespace mapless
