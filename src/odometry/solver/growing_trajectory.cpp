#include "odometry/solver/growing_trajectory.hpp"

#include <algorithm>
#include <string>

#include "trajectory/domain.hpp"
#include "trajectory/knot_states.hpp"

namespace mapless::inline v1 {
namespace {

// The name in messages of TrajectoryDomainError.
const std::string& source() {
  static const std::string name = "lidar odometry";
  return name;
}

GrowingTrajectory::Chunk chunk_of(std::span<const TrajectoryKnot> knots) {
  return std::make_shared<const std::vector<TrajectoryKnot>>(knots.begin(), knots.end());
}

class TrajectorySnapshot final : public Trajectory {
 public:
  explicit TrajectorySnapshot(std::vector<GrowingTrajectory::Chunk> chunks) : chunks_(std::move(chunks)) {}

  [[nodiscard]] Time begin() const override {
    return chunks_.empty() ? Time::from_nanoseconds(1) : chunks_.front()->front().time;
  }
  [[nodiscard]] Time end() const override { return chunks_.empty() ? Time() : chunks_.back()->back().time; }

  [[nodiscard]] TrajectoryState at(Time t) const override {
    require_covered(t, begin(), end(), source());
    return state_between(*chunks_[number_of(t)], t, source());
  }

  void sample(Time first, Duration period, std::span<TrajectoryState> states) const override {
    const auto instant = [&](std::size_t i) {
      return first + Duration::from_nanoseconds(static_cast<std::int64_t>(i) * period.nanoseconds());
    };
    for (std::size_t i = 0; i < states.size();) {
      require_covered(instant(i), begin(), end(), source());
      const std::size_t number = number_of(instant(i));
      std::size_t next = i + 1;
      while (next < states.size() && number_of(instant(next)) == number) ++next;
      sample_between(*chunks_[number], instant(i), period, source(), states.subspan(i, next - i));
      i = next;
    }
  }

 private:
  // The last chunk that begins at `t` or before it.
  [[nodiscard]] std::size_t number_of(Time t) const {
    const auto next = std::upper_bound(
        chunks_.begin() + 1, chunks_.end(), t,
        [](Time time, const GrowingTrajectory::Chunk& chunk) { return time < chunk->front().time; });
    return static_cast<std::size_t>(next - chunks_.begin()) - 1;
  }

  std::vector<GrowingTrajectory::Chunk> chunks_;
};

}  // namespace

void GrowingTrajectory::update(std::span<const TrajectoryKnot> knots, std::size_t final_knots) {
  for (std::size_t first = chunks_.size() * kKnots; first + kKnots < final_knots; first += kKnots)
    chunks_.push_back(chunk_of(knots.subspan(first, kKnots + 1)));
}

std::size_t GrowingTrajectory::forget_before(Time t) {
  const auto first_kept = std::find_if(chunks_.begin(), chunks_.end(),
                                       [&](const Chunk& chunk) { return chunk->back().time > t; });
  const auto dropped = static_cast<std::size_t>(first_kept - chunks_.begin());
  chunks_.erase(chunks_.begin(), first_kept);
  return dropped * kKnots;
}

std::shared_ptr<const Trajectory> GrowingTrajectory::snapshot(std::span<const TrajectoryKnot> knots) const {
  std::vector<Chunk> chunks = chunks_;
  const auto rest = knots.subspan(std::min(chunks_.size() * kKnots, knots.size()));
  if (rest.size() > 1) chunks.push_back(chunk_of(rest));
  return std::make_shared<const TrajectorySnapshot>(std::move(chunks));
}

}  // namespace mapless
