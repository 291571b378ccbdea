#pragma once

#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "detection/segmentation/evidence_growth.hpp"
#include "support/small_scan.hpp"

namespace mapless::test {

inline LocalPoints points_of(const LidarScan& scan) {
  LocalPoints points{Eigen::Vector3d::Zero(), {}};
  for (const LidarReturn& r : scan.returns) points.points.push_back(r.position_v);
  return points;
}

/// Every beam of the scan's sensor; its points stay where they are.
inline void raise_by_60_degrees(LidarScan& scan) {
  auto raised = std::make_shared<LidarModel>(*scan.model);
  for (Laser& laser : raised->lasers) laser.elevation_rad += std::numbers::pi / 3;
  scan.model = std::move(raised);
}

/// A scan of five lasers and 24 columns at 5 m, each return linked to all others of its window unless a test
/// changes that.
class EvidenceImage : public testing::Test {
 protected:
  EvidenceImage() {
    parameters_.link_m = 100;
    parameters_.seed_score = 8;
    parameters_.min_seeds = 3;
  }
  [[nodiscard]] std::size_t at(int laser, int column) const {
    return static_cast<std::size_t>(scan_.cell(laser, column));
  }
  void set(int laser, int column, int votes) {
    PointEvidence& v = votes_[at(laser, column)];
    v.past = static_cast<std::int16_t>(votes);
    v.seen_through = v.recently_free = votes > 0;
    v.surface_seen = votes < 0;
  }
  [[nodiscard]] std::vector<FilterVerdict> filter() const {
    return filter_evidence(scan_, points_, votes_, parameters_);
  }
  [[nodiscard]] EvidenceGrowthResult grow() const {
    std::vector<FilterVerdict> seeds;
    for (const PointEvidence& v : votes_)
      seeds.push_back(v.total() > 0 ? FilterVerdict::kept : FilterVerdict::not_evaluated);
    return grow_evidence(scan_, points_, votes_, seeds, parameters_);
  }
  /// Reached by growth alone: seen through by one scan, a surface in another.
  void see_through(int laser, int column) { votes_[at(laser, column)] = {1, -1, true, true, true}; }
  /// Seen through, but not recently.
  void make_old(int laser, int column) { votes_[at(laser, column)].recently_free = false; }

  LidarScan scan_ = small_scan({0, 0, 0, 0, 0}, 5);
  LocalPoints points_ = points_of(scan_);
  std::vector<PointEvidence> votes_ = std::vector<PointEvidence>(scan_.returns.size());
  VotingParameters parameters_;
};

}  // namespace mapless::test
