#pragma once

#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>
#include <mapless/geometry/compensated_scan.hpp>
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

/// The still points of the labelled clouds in the world frame, one point per voxel, for a service that writes
/// them to static_map_file; where that is empty, nothing is kept. The own odometry that begins anew does not
/// know where it is in the world before (LiveOutput::world_number): the map then begins anew, too. At most
/// static_map_max_voxels voxels are kept, of 72 bytes each; points of further voxels are left out.
///
/// add and clear are called from one thread, save_aside from one.
class StaticMap {
 public:
  explicit StaticMap(const LiveOptions& options);

  /// Adds the still points of a cloud. Clouds without a known motion, or whose body is not known, are not
  /// added.
  void add(const LiveOutput& output);
  /// Forgets all points.
  void clear();

  /// As std_srvs/Trigger has it: `message` is one line, what was written or why nothing was.
  struct Answer {
    bool success = false;
    std::string message;
  };
  /// Writes a cloud to a file or throws, as write_cloud_file does.
  using Write = std::function<void(const std::string& file, const ExportCloud& cloud)>;
  /// Writes the map; it is kept, and can be written again.
  [[nodiscard]] Answer save(const Write& write) const;
  /// Does so on a thread of its own, which then calls `reply`: clouds do not wait for the disk. Refuses where
  /// that thread still writes. The destructor waits for it.
  void save_aside(Write write, std::function<void(const Answer&)> reply);

 private:
  const std::string file_;
  const double voxel_m_;
  const std::size_t max_voxels_;
  mutable std::mutex mutex_;  // of the members up to the empty line
  std::optional<VoxelMap> map_;
  std::uint32_t world_number_ = 0;
  std::size_t clouds_ = 0, left_out_ = 0, restarts_ = 0;

  std::future<void> saving_;
};

}  // namespace mapless
