#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>
#include <mapless/live/live_options.hpp>
#include <mapless/live/live_output.hpp>
#include <mapless/live/point_cloud2.hpp>

namespace mapless::inline v1 {

/// OnlineDetector for a sensor that runs: clouds as its driver publishes them, in, labelled clouds out.
///
///     LiveDetector live(options);
///     live.add_cloud(cloud, publisher);      // on the thread of the middleware, for every message
///
///     while (running) {                      // on a thread of its own
///       live.wait(Duration::from_seconds(0.1));
///       for (const LiveOutput& output : live.process()) publish(output);
///     }
///
/// What can happen on a robot is a line of the diagnostics and of the log, and never an exception: no cloud
/// for longer than max_gap_s, stamps that jump or run backwards, empty clouds, clouds of another layout or of
/// another rate, a second publisher, poses that are late or missing, more clouds than can be processed, and
/// measurements of the motion that are missing, on another clock or of a frame without a place.
/// Where the clouds before and after cannot belong together, detection begins anew; ids of objects are not
/// reused, and the own odometry goes on from its last pose.
///
/// process and reset are called from one thread, all others from any.
class LiveDetector {
 public:
  /// `now`: a clock that does not jump; empty: the steady clock of the computer. Throws ParameterError for a
  /// parameter out of bounds, InputError for a sensor that is none.
  explicit LiveDetector(const LiveOptions& options, std::function<Time()> now = {});
  ~LiveDetector();
  LiveDetector(const LiveDetector&) = delete;
  LiveDetector& operator=(const LiveDetector&) = delete;

  /// Takes a cloud that has just arrived; never waits. `publisher`: a number that differs between the
  /// publishers of the topic; 0: not known.
  void add_cloud(PointCloud2 cloud, std::uint64_t publisher = 0);
  /// Takes T_parent_child at `time`, which does not matter where it is static.
  void add_transform(const std::string& parent, const std::string& child, Time time,
                     const SE3& T_parent_child, bool is_static);
  /// Takes the angular velocity of `frame` about its axes [rad/s], of an inertial sensor, for the own
  /// odometry. Static transforms place the frame on the lidar.
  void add_angular_velocity(const std::string& frame, Time time, const Eigen::Vector3d& angular);
  /// Takes velocity [m/s] and angular velocity [rad/s] of `frame` in its axes, of wheels, for the own
  /// odometry. The speed of the lidar on this rigid body is used.
  void add_twist(const std::string& frame, Time time, const Eigen::Vector3d& linear,
                 const Eigen::Vector3d& angular);
  /// Waits until a cloud or, with given poses, a transform comes, at most `at_most`. process() is called
  /// either way: it gives up clouds that have waited too long.
  void wait(Duration at_most);

  /// Processes the oldest cloud that waits, if there is one, and returns the clouds that are labelled now, in
  /// the order of their arrival.
  [[nodiscard]] std::vector<LiveOutput> process();
  /// Labels what is held back, with what is known now, and begins anew. Clouds that wait are kept.
  [[nodiscard]] std::vector<LiveOutput> reset();

  [[nodiscard]] LiveDiagnostics diagnostics() const;
  /// What happened since the last call.
  [[nodiscard]] std::vector<LiveEvent> take_events();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mapless
