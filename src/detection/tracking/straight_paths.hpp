#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "detection/detection_pipeline.hpp"
#include <mapless/core/time.hpp>
#include <mapless/detection/detection.hpp>

namespace mapless::inline v1 {

/// Tells what moves by where it was: its places in the scans of the last second follow one velocity.
///
/// Of a walker far away, or a car on one laser of sixteen, a scan sees a few points, and few rays of other
/// scans passed there: too little evidence in any one scan. But the few points of each scan lie where one
/// velocity takes them. Edges, leaves and ground that are seen through now and then lie so by chance only;
/// how easily, paths of other velocities tell.
///
/// A spot is the centre of an object or of a faint cluster of one scan. For every small spot of the newest
/// scan each velocity is tried that leads to it from a spot two to five scans before. The best path meets
/// spots in n of N scans. p is the largest share of the scans that another path meets: in the opposite order,
/// in five other directions, with no velocity, or with half of it unless n is most of N. The path is no
/// chance if the number of velocities tried x P(n - 1 or more of N - 1, by p) is below kChance: the expected
/// number of such paths where nothing moves. (One of the n is the spot that the velocity comes from.)
///
/// Rails and kerbs beside a moving sensor keep pace with it: for a path of the sensor's own velocity the rays
/// along it have to tell that they pass through (ObjectEvidence::log_odds).
///
/// A faint cluster on a path becomes an object of its own; but where a body that moved in the scan before is
/// proposed again and reaches the cluster, it is a part of that.
class StraightPaths {
 public:
  /// Takes the next scan. Faint clusters on a straight path become objects of `proposed`, or parts of them.
  /// `movers`: what moved in the scan before. Returns for every object, by its number - 1, whether it is on a
  /// path.
  std::vector<bool> find(ObjectProposals& proposed, const std::vector<TrackedObject>& movers);

 private:
  struct Spot {
    Eigen::Vector3d centre_0;
    double reach_m = 0;   // of its centre from one scan to the next
    double log_odds = 0;  // ObjectEvidence::log_odds
    std::size_t points = 0;
    std::uint16_t object = 0;  // its number; 0: faint, which come last
  };
  struct Spots {  // of one scan
    Time start;
    std::vector<Spot> all;
    Eigen::ArrayX3d centres_0;              // of all
    std::vector<std::uint32_t> within;      // indices into `all`, for each cell those whose reach touches it
    std::vector<std::uint32_t> cell_begin;  // of each cell in `within`, and the end
  };
  struct Met {
    int scans = 0;
    double log_odds = 0;  // of the spots met
  };

  [[nodiscard]] static Spot spot_of(const ObjectProposals& proposed, std::span<const std::int32_t> returns,
                                    double log_odds);
  static void sort_into_cells(Spots& spots);
  [[nodiscard]] static const Spot* any_around(const Spots& spots, const Eigen::Vector3d& place_0);
  void tabulate_chances();
  [[nodiscard]] bool on_straight_path(const Spot& spot) const;
  [[nodiscard]] std::uint16_t body_of(const Spot& spot, const std::vector<Spot>& spots,
                                      const std::vector<TrackedObject>& movers) const;
  [[nodiscard]] std::vector<Eigen::Vector3d> velocities_to(const Spot& spot) const;
  [[nodiscard]] Met meet(const Spot& spot, const Eigen::Vector3d& velocity_0, int least) const;
  // `met`: scans that the path of the velocity itself meets.
  [[nodiscard]] int most_met_by_others(const Spot& spot, const Eigen::Vector3d& velocity_0, int met) const;
  /// P(met - 1 or more of all earlier scans but one, each by the share that `most` is of them).
  [[nodiscard]] double chance(int met, int most) const {
    return chances_[static_cast<std::size_t>(most) * (earlier_.size() + 1) + static_cast<std::size_t>(met)];
  }
  [[nodiscard]] int fewest_to_meet(int most, std::size_t velocities) const;
  [[nodiscard]] bool keeps_pace(const Eigen::Vector3d& velocity_0) const;
  [[nodiscard]] double seconds_since(const Spots& spots) const { return (now_ - spots.start).seconds(); }

  std::vector<double> chances_;  // see chance()
  std::deque<Spots> earlier_;    // newest first
  Time now_;
  Eigen::Vector3d sensor_velocity_0_ = Eigen::Vector3d::Zero();
};

}  // namespace mapless
