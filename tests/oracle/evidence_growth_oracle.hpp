#pragma once

#include <vector>

#include "detection/evidence/point_evidence.hpp"
#include "detection/segmentation/evidence_growth.hpp"

namespace mapless::test {

/// evidence_growth.hpp by going over all pairs of points. Two points belong together where they are no
/// farther apart than link_m + range x max(link_per_m, link_spacings x the widest angle between neighbouring
/// beams) of either, and no more than so many lasers and columns of the aligned scan image.
class EvidenceGrowthOracle {
 public:
  EvidenceGrowthOracle(const LidarScan& scan, const LocalPoints& points, const VotingParameters& parameters)
      : scan_(scan), points_(points.points), parameters_(parameters) {}

  [[nodiscard]] std::vector<BoxVerdict> filter(const std::vector<PointVotes>& votes) const;
  [[nodiscard]] EvidenceGrowthResult grow(const std::vector<PointVotes>& votes,
                                          const std::vector<BoxVerdict>& seeds) const;

 private:
  void fill(const std::vector<PointVotes>& votes, int least, std::vector<char>& dynamic,
            EvidenceGrowthResult& result) const;
  /// Adds the sides of every set of `dynamic` points: all that hangs together with it and slides.
  void slide(const std::vector<PointVotes>& votes, std::vector<char>& dynamic,
             EvidenceGrowthResult& result) const;
  [[nodiscard]] std::vector<char> sides_of(const std::vector<std::size_t>& thing,
                                           const std::vector<PointVotes>& votes,
                                           const std::vector<char>& dynamic) const;
  struct Ends {
    int free = 0, held = 0;  // in front of something farther; going on into what stands
  };
  [[nodiscard]] Ends ends_of(const std::vector<char>& sides, const std::vector<PointVotes>& votes) const;
  /// Numbers the sets of `dynamic` points, and takes down the evidence of each.
  void number(const std::vector<PointVotes>& votes, const std::vector<char>& dynamic,
              EvidenceGrowthResult& result) const;
  /// Diameter about the centroid, times the share of points seen through lately [m].
  [[nodiscard]] double displacement_m(const std::vector<PointVotes>& votes,
                                      const std::vector<std::size_t>& object) const;
  [[nodiscard]] int weighed_votes(const std::vector<PointVotes>& votes,
                                  const std::vector<std::size_t>& object) const;
  [[nodiscard]] Body body(const std::vector<PointVotes>& votes, const std::vector<std::size_t>& object) const;
  [[nodiscard]] bool linked(std::size_t i, std::size_t j, int rows, int columns) const;
  [[nodiscard]] double link_m(const LidarReturn& r) const;
  [[nodiscard]] int image_column(const LidarReturn& r) const;
  /// Lowest index of the set of `chosen` points that each belongs to; meaningless for the others.
  [[nodiscard]] std::vector<std::size_t> sets(const std::vector<char>& chosen) const;

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  VotingParameters parameters_;
};

}  // namespace mapless::test
