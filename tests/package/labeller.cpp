#include "labeller.hpp"

#include <string>

#include <mapless/core/errors.hpp>
#include <mapless/detection/detector.hpp>
#include <mapless/lidar/lidar_model.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

using mapless::Detection;
using mapless::Duration;
using mapless::LidarRecord;
using mapless::LidarScan;
using mapless::Time;

namespace {

mapless::DetectorParameters parameters_with(double min_speed_mps) {
  if (min_speed_mps < 0) {
    throw mapless::ParameterError(
        {"Labeller", "min_speed_mps", std::to_string(min_speed_mps), "must not be below 0", ""});
  }
  mapless::DetectorParameters parameters;
  parameters.voting.min_speed_mps = min_speed_mps;
  return parameters;
}

std::vector<std::vector<bool>> moving_points(const std::vector<Detection>& detections) {
  std::vector<std::vector<bool>> all;
  for (const Detection& detection : detections) {
    std::vector<bool> moving(detection.scan->input_size);
    for (std::size_t i = 0; i < detection.object.size(); ++i) {
      moving[detection.scan->returns[i].input_index] = detection.dynamic(i);
    }
    all.push_back(std::move(moving));
  }
  return all;
}

}  // namespace

struct Labeller::State {
  std::shared_ptr<const mapless::LidarModel> model =
      std::make_shared<const mapless::LidarModel>(mapless::named_model("VLP-16"));
  mapless::StationaryTrajectory trajectory;
  mapless::Detector detector;
  int turns = 0;
};

Labeller::Labeller(double min_speed_mps)
    : state_(new State{.detector = mapless::Detector(parameters_with(min_speed_mps))}) {}
Labeller::~Labeller() = default;

int Labeller::lasers() const { return static_cast<int>(state_->model->lasers.size()); }
int Labeller::columns() const { return state_->model->columns; }

std::vector<std::vector<bool>> Labeller::add(const std::vector<double>& ranges) {
  const mapless::LidarModel& model = *state_->model;
  LidarScan scan;
  scan.model = state_->model;
  scan.column_period = Duration::from_seconds(1 / model.rotation_rate_hz / model.columns);
  scan.columns = model.columns;
  scan.start = Time::from_seconds(state_->turns / model.rotation_rate_hz);
  ++state_->turns;

  std::vector<LidarRecord> records;
  for (int laser = 0; laser < lasers(); ++laser) {
    for (int column = 0; column < columns(); ++column) {
      const double range = ranges.at(static_cast<std::size_t>(laser * columns() + column));
      const Eigen::Vector3d p_v = model.point_v(laser, column, range);
      const auto firing = model.lasers[static_cast<std::size_t>(laser)].firing_offset;
      const auto time = scan.column_time(column) + firing - scan.start;
      records.push_back({p_v.cast<float>(), laser, column, static_cast<std::int32_t>(time.nanoseconds()),
                         mapless::ReturnCode::hit});
    }
  }
  return moving_points(state_->detector.process(
      std::make_shared<const LidarScan>(mapless::organise(std::move(scan), records, "turn")),
      state_->trajectory));
}

std::vector<std::vector<bool>> Labeller::finish() { return moving_points(state_->detector.flush()); }
