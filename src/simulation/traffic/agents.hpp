#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "simulation/traffic/road_user.hpp"

namespace mapless::inline v1 {

/// Whether he goes on foot or paws.
[[nodiscard]] bool on_foot(ObjectClass c);

/// A vehicle's way through a junction, by distance along its path.
struct Passage {
  double begin_m = 0;  ///< where its front waits
  double end_m = 0;
  std::size_t junction = 0;
  bool along_x = false;  ///< as it comes in
  bool turns_left = false;
  std::vector<Eigen::Vector2d> line;  ///< its way, a point each metre
};

/// A road user under way.
struct Agent {
  RoadUser user;
  double length_m = 4, half_width_m = 0.9;
  std::vector<double> speed_limit;  ///< of each metre of the path
  std::vector<Passage> passages;    ///< of a vehicle
  std::size_t next = 0;             ///< the passage, or the crossing on foot, that is ahead or under way
  bool holds = false;               ///< the right of way through that passage
  double waited_s = 0;              ///< at its line
  double s = 0, v = 0, a = 0;
  double aside_m = 0;  ///< of the path, to the left: how a walker gets past another
  double aside_rate = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Vector2d heading = Eigen::Vector2d::UnitX();

  /// The passage ahead or under way; null beyond the last.
  [[nodiscard]] const Passage* passage() const { return next < passages.size() ? &passages[next] : nullptr; }
  /// The street crossed on foot next or now; null beyond the last.
  [[nodiscard]] const StreetCrossing* crossing() const {
    return next < user.crossings.size() ? &user.crossings[next] : nullptr;
  }
  [[nodiscard]] bool is_on_road() const { return crossing() != nullptr && s > crossing()->from_m; }
  [[nodiscard]] double front_m() const { return s + length_m / 2; }
  [[nodiscard]] double limit_at(double at_m) const;
  /// Follows s: position, heading, what has been passed.
  void settle();
};

[[nodiscard]] Agent make_agent(const RoadUser& user, const std::vector<Junction>& junctions);

/// From a point to a vehicle's middle line.
[[nodiscard]] double distance_to(const Agent& other, const Eigen::Vector2d& p);

}  // namespace mapless
