#pragma once

#include <memory>
#include <span>
#include <vector>

#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Makes immutable trajectories over knots that grow in number. Knots that never change again are copied
/// once, into chunks that all snapshots share. A snapshot costs a copy of the knots after the last full chunk
/// and one pointer per chunk, so that its cost hardly grows with the length of the drive.
class GrowingTrajectory {
 public:
  /// Knots per chunk. Chosen: a snapshot copies at most this many knots and those not final yet (200 bytes
  /// each, 50 kB together), and an hour of driving at 10 Hz has 140 chunks.
  static constexpr std::size_t kKnots = 256;

  /// Copies the knots of every chunk that is full by now. `knots` is the whole trajectory, without those that
  /// forget_before() has dropped. The first `final_knots` never change again.
  void update(std::span<const TrajectoryKnot> knots, std::size_t final_knots);

  /// The trajectory over `knots`, which begin with those given to update(). It shares nothing with `knots`
  /// and never changes. Its domain is empty for less than two knots.
  [[nodiscard]] std::shared_ptr<const Trajectory> snapshot(std::span<const TrajectoryKnot> knots) const;

  /// Drops the chunks that end at `t` or before it. Returns the number of knots dropped: the caller drops as
  /// many from the front of its own. Snapshots made before keep them.
  std::size_t forget_before(Time t);

  /// Consecutive chunks share a knot: the last one of the first chunk is the first one of the second.
  using Chunk = std::shared_ptr<const std::vector<TrajectoryKnot>>;

 private:
  std::vector<Chunk> chunks_;
};

}  // namespace mapless
