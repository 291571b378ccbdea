#include "rig/rig_run.hpp"

#include <algorithm>
#include <deque>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "run/folder_lock.hpp"
#include "run/given_motion.hpp"
#include "run/result_tables.hpp"
#include "run/run_summary.hpp"
#include "run/scan_poses.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/progress.hpp"
#include "terminal/stderr.hpp"
#include "trust/input_check.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/lidar/self_check.hpp>

namespace mapless::app {
namespace {

// One sensor of the rig: its recording, and its result as far as it is written.
struct Member {
  Member(const RigSensor& sensor, std::unique_ptr<Dataset> recording, const RigRunOptions& options,
         const TrajectorySource& motion)
      : offset(sensor.clock_offset),
        result(options.output / sensor.name),
        lock(result.path(), std::string(kProgramName)),
        dataset(std::move(recording)),
        summary(*dataset, (options.recording / sensor.name).string(), motion, options.profile, 0,
                dataset->size()) {
    result.require_free(options.overwrite);
    require_time_order(*dataset, 0, dataset->size());
  }

  [[nodiscard]] bool finished() const { return next == dataset->size(); }
  [[nodiscard]] Time next_start() const { return dataset->scan_start(next) + offset; }

  Duration offset;
  ResultFolder result;
  FolderLock lock;
  std::unique_ptr<Dataset> dataset;
  RunSummary summary;
  ScanWatch watch;
  std::size_t next = 0;                               // scan to be read
  std::optional<ResultTables> tables;                 // once the folder is made
  std::shared_ptr<const Trajectory> last_trajectory;  // of the last scan with one
  Time last_end;
};

class RigRun {
 public:
  RigRun(const RigRunOptions& options, std::vector<RigSensor> sensors)
      : options_(options),
        lock_(options.output, std::string(kProgramName)),
        detector_(sensors, options.detector) {
    for (const RigSensor& sensor : sensors) {
      auto recording = open_dataset(options.recording / sensor.name, {{}, sensor.model, {}, {}, {}});
      if (members_.empty()) motion_ = motion_of(*recording);
      members_.push_back(std::make_unique<Member>(sensor, std::move(recording), options, motion_));
    }
    for (const auto& member : members_) scans_ += member->dataset->size();
    for (std::size_t k = 0; k < members_.size(); ++k) {
      const Dataset& dataset = *members_[k]->dataset;
      members_[k]->summary.set_input_doubts(said_doubts(dataset, given_to(k), {0, dataset.size(), 0}));
    }
  }

  // False where it was interrupted.
  bool run() {
    try {
      while (Member* const member = earliest()) {
        if (InterruptGuard::requested()) break;
        push(*member);
      }
      write(detector_.flush());
    } catch (const std::exception& error) {
      finish(error.what());
      throw;
    }
    const bool complete =
        std::all_of(members_.begin(), members_.end(), [](const auto& member) { return member->finished(); });
    finish(complete ? "" : "interrupted");
    return complete;
  }

  [[nodiscard]] bool estimates_motion() const { return motion_.trajectory == nullptr; }

  // Says the doubts; returns the exit code.
  [[nodiscard]] int report() const {
    bool trusted = true;
    for (std::size_t k = 0; k < members_.size(); ++k) {
      const Member& member = *members_[k];
      fmt::print("{}:\n{}", detector_.sensors()[k].name, member.summary.lines());
      for (const std::string& doubt : member.summary.doubts()) {
        say("mapless: {}: {}\n", detector_.sensors()[k].name, doubt);
        trusted = false;
      }
    }
    fmt::print("result in {}\n", options_.output.string());
    return trusted ? kSuccess : kNotTrusted;
  }

 private:
  // Of the first sensor.
  [[nodiscard]] TrajectorySource motion_of(const Dataset& dataset) const {
    return options_.odometry ? motion_by_odometry(dataset, 0) : given_motion(dataset, options_.trajectory, 0);
  }

  // The given motion of a sensor; null: none is given, or its clock is another.
  [[nodiscard]] std::shared_ptr<const Trajectory> given_to(std::size_t sensor) const {
    const std::vector<RigSensor>& sensors = detector_.sensors();
    if (!motion_.trajectory || sensors[sensor].clock_offset != Duration()) return nullptr;
    return std::make_shared<const MountedTrajectory>(motion_.trajectory,
                                                     sensors[sensor].T_bv.inverse() * sensors.front().T_bv);
  }

  // The sensor whose next scan starts first; null: all are read.
  [[nodiscard]] Member* earliest() const {
    Member* first = nullptr;
    for (const auto& member : members_) {
      if (!member->finished() && (first == nullptr || member->next_start() < first->next_start()))
        first = member.get();
    }
    return first;
  }

  void push(Member& member) {
    const auto scan = std::make_shared<const LidarScan>(member.dataset->read(member.next));
    if (member.next == 0) member.summary.set_input(*scan, scan->compensated_to.has_value());
    member.watch.add(*scan, member.next++);
    write(detector_.push(number_of(member), scan, motion_.trajectory));
  }

  [[nodiscard]] std::size_t number_of(const Member& member) const {
    const auto same = [&](const auto& one) { return one.get() == &member; };
    return static_cast<std::size_t>(std::find_if(members_.begin(), members_.end(), same) - members_.begin());
  }

  void write(const std::vector<RigScan>& scans) {
    for (const RigScan& scan : scans) write(*members_[scan.sensor], scan.sensor == 0, scan.labelled);
  }

  void write(Member& member, bool is_first, const LabelledScan& labelled) {
    if (!member.tables) {
      member.result.create(options_.overwrite, member.summary.text());
      if (options_.probability) member.result.create_probabilities();
      write_file_atomically(member.result.config(), options_.configuration);
      member.tables.emplace(member.result, TableChoice{true, is_first && !motion_.trajectory},
                            GrowingFile::Start::anew);
    }
    const LidarScan& scan = labelled.scan();
    const std::size_t k = labelled.detection.sequence_number;
    if (labelled.trajectory) {
      const auto poses = scan_poses(*labelled.trajectory, scan.start, scan.end(), kPosesPerScan);
      write_files(member.result, k, files_of(labelled, k, poses, options_.probability), *member.tables);
      member.last_trajectory = labelled.trajectory;
      member.last_end = scan.end();
    } else {  // without labels, objects and poses
      write_stage_file(member.result.stage_file(k), stage_masks_of(labelled.detection));
      if (options_.probability)
        write_probability_file(member.result.probability_file(k), labelled.probability_by_input());
      write_label_file(member.result.label_file(k), labels_of(labelled.detection));
    }
    member.summary.add(labelled.detection);
    progress_.update(++written_, scans_);
  }

  // `reason`: why the run stopped; empty: it is complete.
  void finish(const std::string& reason) {
    progress_.clear();
    for (const auto& member : members_) {
      if (!member->tables) continue;
      if (member->last_trajectory) member->tables->finish(*member->last_trajectory, member->last_end);
      reason.empty() ? member->summary.set_complete() : member->summary.set_stopped(reason);
    }
    for (const auto& member : members_) {
      if (!member->tables) continue;
      if (!motion_.trajectory) member->summary.set_odometry(detector_.odometry_report());
      member->summary.set_scan_doubts(member->watch.lines());
      write_file_atomically(member->result.summary(), member->summary.text());
    }
  }

  const RigRunOptions& options_;
  FolderLock lock_;  // outlives those of the sensors, which are in this folder
  RigDetector detector_;
  TrajectorySource motion_;  // of the first sensor
  std::vector<std::unique_ptr<Member>> members_;
  std::size_t scans_ = 0, written_ = 0;
  Progress progress_{"scans"};
};

}  // namespace

int detect_rig(const RigRunOptions& options) {
  const std::vector<RigSensor> sensors = read_rig_yaml(options.recording / kRigFile);
  RigRun run(options, sensors);
  say("mapless: rig of {} sensors; trajectory: {} {}\n", sensors.size(),
      run.estimates_motion() ? "estimated by lidar odometry of" : "of", sensors.front().name);
  const InterruptGuard interrupt;
  if (!run.run()) {
    say("mapless: interrupted; the results are valid up to their last scans, summary.json says incomplete\n");
    return InterruptGuard::exit_code();
  }
  return run.report();
}

}  // namespace mapless::app
