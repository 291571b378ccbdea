#pragma once

#include <vector>

#include "detection/evidence/point_evidence.hpp"
#include "detection/segmentation/evidence_growth.hpp"

namespace mapless::test {

/// evidence_growth.hpp by exhaustive search over all pairs of points. Two points are linked if their distance
/// is at most link_m + range x max(link_per_m, link_spacings x widest angle to a neighbouring beam), for both
/// of them, and if they are within a window of lasers and columns of the aligned scan image.
class EvidenceGrowthOracle {
 public:
  EvidenceGrowthOracle(const LidarScan& scan, const LocalPoints& points, const VotingParameters& parameters)
      : scan_(scan), points_(points.points), parameters_(parameters) {}

  [[nodiscard]] std::vector<FilterVerdict> filter(const std::vector<PointEvidence>& votes) const;
  [[nodiscard]] EvidenceGrowthResult grow(const std::vector<PointEvidence>& votes,
                                          const std::vector<FilterVerdict>& seeds) const;

 private:
  void fill(const std::vector<PointEvidence>& votes, int min_votes, std::vector<char>& dynamic,
            EvidenceGrowthResult& result) const;
  /// Adds the surfaces that slide along themselves to every set of `dynamic` points.
  void add_surfaces(const std::vector<PointEvidence>& votes, std::vector<char>& dynamic,
                    EvidenceGrowthResult& result) const;
  [[nodiscard]] std::vector<char> surfaces_of(const std::vector<std::size_t>& object,
                                              const std::vector<PointEvidence>& votes,
                                              const std::vector<char>& dynamic) const;
  struct Rim {
    int free = 0;           // in front of something farther
    int static_points = 0;  // continuing into static points
    int moving = 0;         // continuing into dynamic points
  };
  [[nodiscard]] Rim rim_of(const std::vector<char>& surface, const std::vector<PointEvidence>& votes,
                           const std::vector<char>& dynamic) const;
  /// Numbers the sets of `dynamic` points and collects the evidence of each.
  void number(const std::vector<PointEvidence>& votes, const std::vector<char>& dynamic,
              EvidenceGrowthResult& result) const;
  /// Diameter about the centroid times the share of points seen through recently [m].
  [[nodiscard]] double displacement_m(const std::vector<PointEvidence>& votes,
                                      const std::vector<std::size_t>& object) const;
  [[nodiscard]] int weighted_votes(const std::vector<PointEvidence>& votes,
                                   const std::vector<std::size_t>& object) const;
  [[nodiscard]] Body body(const std::vector<PointEvidence>& votes,
                          const std::vector<std::size_t>& object) const;
  [[nodiscard]] bool on_line(const std::vector<PointEvidence>& votes,
                             const std::vector<std::size_t>& object) const;
  [[nodiscard]] bool linked(std::size_t i, std::size_t j, int rows, int columns) const;
  [[nodiscard]] double link_m(const LidarReturn& r) const;
  /// Columns of the aligned image, which wraps.
  [[nodiscard]] int columns_apart(const LidarReturn& a, const LidarReturn& b) const;
  [[nodiscard]] int image_column(const LidarReturn& r) const;
  /// Lowest index of the set of `chosen` points that each belongs to; meaningless for the others.
  [[nodiscard]] std::vector<std::size_t> sets(const std::vector<char>& chosen) const;

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  VotingParameters parameters_;
};

}  // namespace mapless::test
