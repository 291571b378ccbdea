#include "view/labelled_drive.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include <mapless/core/errors.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::app {
namespace {

namespace fs = std::filesystem;

// Poses of a result reach from the first to the last labelled scan; a scan whose columns go on a little
// beyond is placed at constant velocity.
constexpr double kMaxExtrapolation_s = 0.2;

std::vector<std::size_t> all_scans(const Dataset& dataset) {
  if (!dataset.read_labels(0)) {
    throw ParameterError(
        {"OUT", "", "", "not given, and the recording has no labels", "give a result of mapless detect"});
  }
  std::vector<std::size_t> scans(dataset.size());
  std::iota(scans.begin(), scans.end(), std::size_t{0});
  return scans;
}

std::shared_ptr<const Trajectory> trajectory_of(const Dataset& dataset,
                                                const std::optional<ResultFolder>& result) {
  if (result && fs::exists(result->trajectory())) {
    TrajectoryFileOptions options;
    options.max_extrapolation = Duration::from_seconds(kMaxExtrapolation_s);
    return std::make_shared<SampledTrajectory>(read_trajectory_file(result->trajectory(), options));
  }
  return dataset.trajectory();
}

// A cloud that another system has compensated: all its points are in the sensor frame of one instant.
LocalPoints place_compensated(const LidarScan& scan, const Trajectory& trajectory) {
  const SE3 T_0c = trajectory.at(*scan.compensated_to).T_v0.inverse();
  LocalPoints out{trajectory.at(scan.start).T_v0.inverse().translation(), {}};
  out.points.reserve(scan.returns.size());
  for (const LidarReturn& r : scan.returns) {
    out.points.push_back((T_0c * r.position_v.cast<double>() - out.origin_0).cast<float>());
  }
  return out;
}

}  // namespace

LabelledDrive::LabelledDrive(const Dataset& dataset, const fs::path& result) : dataset_(dataset) {
  if (result.empty()) {
    scans_ = all_scans(dataset);
  } else {
    result_.emplace(result);
    scans_ = result_->labelled_scans();
    if (!scans_.empty() && scans_.back() >= dataset.size()) {
      throw InputError({result_->label_file(scans_.back()).string(), "", "",
                        "is of a scan that the recording does not have",
                        "give the recording from which this result was made"});
    }
    if (fs::exists(result_->objects())) {
      for (ObjectRow& row : read_object_table(result_->objects())) objects_[row.scan].push_back(row);
    }
  }
  place();
}

LabelledDrive::LabelledDrive(const Dataset& dataset, std::map<std::size_t, std::vector<std::uint32_t>> labels,
                             const std::vector<ObjectRow>& objects)
    : dataset_(dataset), given_(std::move(labels)) {
  for (const auto& [k, of_scan] : given_) scans_.push_back(k);
  for (const ObjectRow& row : objects) objects_[row.scan].push_back(row);
  place();
}

void LabelledDrive::place() {
  trajectory_ = trajectory_of(dataset_, result_);
  has_poses_ = trajectory_ != nullptr;
  if (!has_poses_) trajectory_ = std::make_shared<StationaryTrajectory>();
}

LabelledCloud LabelledDrive::read(std::size_t k) const {
  LabelledCloud out;
  out.number = k;
  out.scan = std::make_shared<const LidarScan>(dataset_.read(k));
  out.truth = dataset_.read_labels(k);
  if (result_) {
    out.labels = read_labels_of(*result_, k, *out.scan);
    if (fs::exists(result_->stage_file(k)))
      out.stages = read_stage_file(result_->stage_file(k), out.scan->input_size);
    if (fs::exists(result_->probability_file(k)))
      out.probability = read_probability_file(result_->probability_file(k), out.scan->input_size);
  } else if (given_.contains(k)) {
    out.labels = given_.at(k);
  } else if (out.truth) {
    out.labels = *std::exchange(out.truth, std::nullopt);
  } else {
    throw InputError({dataset_.scan_file(k).string(), "", "", "has no true labels",
                      "give a result of mapless detect, or leave the scan out with --scans"});
  }
  out.T_0v = trajectory_->at(out.scan->start).T_v0.inverse();
  out.points = out.scan->compensated_to ? place_compensated(*out.scan, *trajectory_)
                                        : compensate_locally(out.scan, *trajectory_).second;
  return out;
}

SE3 LabelledDrive::start_pose(std::size_t scan) const {
  return trajectory_->at(dataset_.scan_start(scan)).T_v0.inverse();
}

const std::vector<ObjectRow>& LabelledDrive::objects(std::size_t scan) const {
  static const std::vector<ObjectRow> none;
  const auto found = objects_.find(scan);
  return found == objects_.end() ? none : found->second;
}

}  // namespace mapless::app
