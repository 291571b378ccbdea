#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "simulation/traffic/road_user.hpp"

namespace mapless::inline v1 {

/// True for pedestrians and dogs.
[[nodiscard]] bool on_foot(ObjectClass c);

/// The part of a vehicle's path inside a junction, in metres along the path.
struct Passage {
  double begin_m = 0;  ///< stop line, for the front of the vehicle
  double end_m = 0;
  std::size_t junction = 0;
  bool along_x = false;  ///< direction of entry: along x, else along y
  bool turns_left = false;
  std::vector<Eigen::Vector2d> line;  ///< the path inside the junction, one point per metre
};

/// The state of a road user during the simulation.
struct Agent {
  RoadUser user;
  double length_m = 4, half_width_m = 0.9;
  std::vector<double> speed_limit;  ///< at each metre of the path [m/s]
  std::vector<Passage> passages;    ///< of a vehicle, in order
  std::size_t next = 0;             ///< index of the current or next passage, or crossing on foot
  bool holds = false;               ///< has the right of way through that passage
  double waited_s = 0;              ///< at the stop line
  double s = 0, v = 0, a = 0;       ///< distance along the path [m], speed [m/s], acceleration [m/s^2]
  double aside_m = 0;               ///< lateral offset of a pedestrian, to the left of the path
  double aside_rate = 0;            ///< its rate of change [m/s]
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Vector2d heading = Eigen::Vector2d::UnitX();

  /// The current or next passage; null after the last.
  [[nodiscard]] const Passage* passage() const { return next < passages.size() ? &passages[next] : nullptr; }
  /// The current or next street crossing on foot; null after the last.
  [[nodiscard]] const StreetCrossing* crossing() const {
    return next < user.crossings.size() ? &user.crossings[next] : nullptr;
  }
  [[nodiscard]] bool is_on_road() const { return crossing() != nullptr && s > crossing()->from_m; }
  [[nodiscard]] double front_m() const { return s + length_m / 2; }
  [[nodiscard]] double limit_at(double at_m) const;
  /// Updates position, heading and the next passage or crossing from s.
  void settle();
};

[[nodiscard]] Agent make_agent(const RoadUser& user, const std::vector<Junction>& junctions);

/// Distance [m] from a point to the centre line of a vehicle, a segment as long as the vehicle.
[[nodiscard]] double distance_to(const Agent& other, const Eigen::Vector2d& p);

}  // namespace mapless
