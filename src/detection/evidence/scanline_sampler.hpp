#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "detection/evidence/evidence_collector.hpp"
#include "lidar/aligned_image.hpp"

namespace mapless::inline v1 {

/// Chooses which points of a scan an EvidenceCollector is queried about, a few rows at a time, and gives the
/// others the evidence of a neighbour.
///
/// A row is cut into spans whose points all lie near the line between the span's ends. If both ends are
/// static, or both dynamic, the points between get the evidence of the nearer end; otherwise the middle point
/// is queried, and so on. A row between two rows that were sampled before skips points on the line between
/// two neighbours that are firmly static.
class ScanlineSampler {
 public:
  /// Keeps references.
  ScanlineSampler(const LidarScan& scan, const LocalPoints& points, const EvidenceCollector& collector);

  /// Returns of one laser, [begin, end).
  struct Row {
    std::size_t begin, end;
  };
  /// Enters the evidence of all points of `rows` (one element of `evidence` per return of the scan).
  /// `between`: the rows below and above each were sampled before.
  void sample(std::span<const Row> rows, bool between, std::vector<PointEvidence>& evidence);

 private:
  // Two returns of one row that were queried, and those between that were not.
  struct Span {
    std::size_t left, right;
  };

  void begin(const Row& row);
  void load(const Row& row);
  void cut(const Span& span);
  [[nodiscard]] std::size_t farthest_off(const Span& span) const;
  void settle(const Span& span);
  void query(std::size_t i);
  void take(std::size_t from, std::size_t to);
  [[nodiscard]] bool take_from_rows_beside(std::size_t i);
  [[nodiscard]] std::ptrdiff_t in_row(const LidarReturn& r, int row) const;

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  const EvidenceCollector& collector_;
  AlignedImage image_;
  bool between_ = false;
  std::vector<PointEvidence>* evidence_ = nullptr;
  // A thread keeps it from one scan to the next: nothing is allocated once it is large enough.
  struct Workspace {
    std::vector<float> x, y, z;  // of the row that is cut: all its points, and four more zeros
    std::vector<std::size_t> queries;
    std::vector<Span> open, halves;
    EvidenceCollector::Workspace collector;
  };
  Workspace* work_ = nullptr;  // during `sample`
  std::size_t first_ = 0;      // point of the row that is cut
};

}  // namespace mapless
