#include "io/formats/mdlidar/pose_reading.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

namespace mapless::inline v1 {
namespace {

// Twice the median that range noise of 0.05 m gives by itself, the largest of the paper's evaluation: 0.67
// sqrt(2) 0.05 m.
constexpr double kMaxStaticDisplacement_m = 0.1;

constexpr std::array<std::string_view, 2> kDirectionTexts = {"world from sensor", "sensor from world"};
constexpr std::array<std::string_view, 2> kInstantTexts = {
    "position_p at the start of the frame, position at its end",
    "position at the start of the frame, position_p before it"};

std::string_view text(PoseDirection direction) {
  return kDirectionTexts.at(static_cast<std::size_t>(direction));
}
std::string_view text(FramePoseInstant instant) {
  return kInstantTexts.at(static_cast<std::size_t>(instant));
}

PoseDirection other(PoseDirection direction) {
  return direction == PoseDirection::world_from_sensor ? PoseDirection::sensor_from_world
                                                       : PoseDirection::world_from_sensor;
}
FramePoseInstant other(FramePoseInstant instant) {
  return instant == FramePoseInstant::end ? FramePoseInstant::start : FramePoseInstant::end;
}

class PoseReadingFinder {
 public:
  PoseReadingFinder(const std::vector<MdlidarFrameSummary>& frames, std::string source,
                    const ScanReader& read)
      : frames_(frames), source_(std::move(source)), read_(read) {
    for (const MdlidarFrameSummary& frame : frames) scans_.push_back({frame.start, frame.end});
  }

  // Decides one member of the reading between its present value and the other one.
  template <class Meaning>
  void decide(Meaning PoseReading::*member, std::string_view name, std::string_view option) {
    PoseReading alternative = reading_;
    alternative.*member = other(reading_.*member);
    const SampledTrajectory a = trajectory_of(frames_, reading_, source_);
    const SampledTrajectory b = trajectory_of(frames_, alternative, source_);
    const TrajectoryComparison compared = compare_trajectories(a, b, scans_, read_);
    if (compared.same()) {
      note(
          fmt::format("the {} of the poses does not matter: between scans, points move by at most {:.3f} m "
                      "more or less if it is \"{}\" or \"{}\"",
                      name, compared.difference_m, text(reading_.*member), text(alternative.*member)));
      return;
    }
    if (!compared.measured()) {
      note(
          fmt::format("the {} of the poses cannot be found, as only {} points of the compared "
                      "scans depend on it (by at most {:.3f} m); read as \"{}\"; {} gives it",
                      name, compared.points, compared.difference_m, text(reading_.*member), option));
      return;
    }
    double chosen_m = compared.displacement_a_m, other_m = compared.displacement_b_m;
    if (other_m < chosen_m) {
      std::swap(reading_, alternative);
      std::swap(chosen_m, other_m);
    }
    note(
        fmt::format("the {} of the poses is \"{}\": static points move by {:.3f} m between scans; as "
                    "\"{}\" by {}{:.3f} m (medians of {} points)",
                    name, text(reading_.*member), chosen_m, text(alternative.*member),
                    other_m < kMaxDisplacement_m ? "" : "at least ", other_m, compared.points));
  }

  template <class Meaning>
  void give(Meaning PoseReading::*member, Meaning value, std::string_view name, std::string_view option) {
    reading_.*member = value;
    note(fmt::format("the {} of the poses is \"{}\" ({})", name, text(value), option));
  }

  // The trajectory under the reading, with a refusal unless static points keep their place. A reading that
  // the user gave in full is not checked.
  [[nodiscard]] PoseReadingChoice choice(bool given) const {
    PoseReadingChoice choice;
    choice.reading = reading_;
    choice.notes = notes_;
    choice.trajectory = std::make_shared<const SampledTrajectory>(trajectory_of(frames_, reading_, source_));
    if (given) return choice;
    const StaticDisplacement moved = measure_static_displacement(*choice.trajectory, scans_, read_);
    if (moved.measured()) {
      choice.notes.push_back(fmt::format(
          "trajectory: read so, static points move by {:.3f} m between scans (median of {} points)",
          moved.median_m, moved.points));
    }
    if (moved.measured() && moved.median_m > kMaxStaticDisplacement_m) {
      choice.refusal = ErrorDetail{
          source_, "state", fmt::format("{}, {}", text(reading_.direction), text(reading_.instant)),
          fmt::format("static points move by {:.3f} m between scans under the best reading of the poses; at "
                      "most {:.3f} m is accepted",
                      moved.median_m, kMaxStaticDisplacement_m),
          "give other poses with --trajectory FILE (mapless odometry makes them), or the meaning of these "
          "with --own-pose-direction and --own-pose-instant"};
    }
    return choice;
  }

 private:
  void note(const std::string& text) { notes_.push_back("trajectory: " + text); }

  const std::vector<MdlidarFrameSummary>& frames_;
  std::string source_;
  const ScanReader& read_;
  std::vector<ScanInterval> scans_;
  PoseReading reading_;
  std::vector<std::string> notes_;
};

}  // namespace

SampledTrajectory trajectory_of(const std::vector<MdlidarFrameSummary>& frames, const PoseReading& reading,
                                const std::string& source) {
  std::vector<TimedPose> poses;
  const auto add = [&](Time time, const SE3& pose) {
    poses.push_back({time, reading.direction == PoseDirection::world_from_sensor ? pose.inverse() : pose});
  };
  Duration longest;
  for (const MdlidarFrameSummary& frame : frames) {
    longest = std::max(longest, frame.end - frame.start);
    if (reading.instant == FramePoseInstant::start) {
      // A trajectory needs two poses: of a single frame, position_p is taken to be one frame earlier.
      if (frames.size() == 1) add(frame.start - longest, frame.pose_p);
      add(frame.start, frame.pose);
    } else {
      // Frames that follow each other share a pose.
      if (poses.empty() || frame.start > poses.back().time) add(frame.start, frame.pose_p);
      add(frame.end, frame.pose);
    }
  }
  // A scan ends one column after the end of its frame, and the last pose may be that of its start.
  return {std::move(poses), longest + longest, source};
}

PoseReadingChoice choose_pose_reading(const std::vector<MdlidarFrameSummary>& frames,
                                      std::optional<PoseDirection> direction,
                                      std::optional<FramePoseInstant> instant, const std::string& source,
                                      const ScanReader& read) {
  constexpr std::string_view kDirection = "direction", kInstant = "instant";
  constexpr std::string_view kDirectionOption = "--own-pose-direction", kInstantOption = "--own-pose-instant";
  PoseReadingFinder finder(frames, source, read);
  if (direction) finder.give(&PoseReading::direction, *direction, kDirection, kDirectionOption);
  if (instant) finder.give(&PoseReading::instant, *instant, kInstant, kInstantOption);
  if (!direction) finder.decide(&PoseReading::direction, kDirection, kDirectionOption);
  if (!instant) finder.decide(&PoseReading::instant, kInstant, kInstantOption);
  return finder.choice(direction && instant);
}

}  // namespace mapless
