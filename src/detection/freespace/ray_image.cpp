#include "detection/freespace/ray_image.hpp"

#include <algorithm>
#include <limits>

#include "detection/dynamic_returns.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

// A vector of the sensor frame in the hub frame.
Vector3d in_hub(const BeamFan::Turn& turn, const Vector3d& v) {
  return {turn.cosine * v.x() + turn.sine * v.y(), turn.cosine * v.y() - turn.sine * v.x(), v.z()};
}

float range_of_cell(const LidarScan& scan, std::int32_t cell) {
  switch (code_of_cell(cell)) {
    case ReturnCode::hit:
      return scan.returns[static_cast<std::size_t>(cell)].range_m;
    case ReturnCode::nothing:
      return static_cast<float>(scan.model->max_range_m);
    case ReturnCode::faulty:
    case ReturnCode::absent:
      break;
  }
  return kNone;
}

}  // namespace

RayImage::RayImage(const CompensatedScan& scan, const RayImage* before, const std::vector<bool>& open)
    : model_(scan.scan->model),
      fan_(before != nullptr && before->model_ == model_ ? before->fan_
                                                         : std::make_shared<const BeamFan>(*model_)),
      start_(scan.scan->start) {
  if (!scan.column_T_0v.empty()) origin_0_ = scan.column_T_0v.front().translation();
  poses_.resize(scan.column_states.size());
  const double period_s = scan.scan->column_period.seconds();
  for (std::size_t c = 0; c < poses_.size(); ++c) {
    const TrajectoryState& state = scan.column_states[c];
    const BeamFan::Turn turn =
        c < fan_->turns.size() ? fan_->turns[c] : BeamFan::turn_at(*model_, static_cast<int>(c));
    Pose& pose = poses_[c];
    pose.T_h0.setZero();
    for (int axis = 0; axis < 3; ++axis)
      pose.T_h0.col(axis).head<3>() = in_hub(turn, state.T_v0.rotation().col(axis)).cast<float>();
    pose.T_h0.topRightCorner<3, 1>() = in_hub(turn, state.T_v0 * origin_0_).cast<float>();
    pose.linear << (in_hub(turn, state.varpi.head<3>()) * period_s).cast<float>(), 0;
    pose.angular << (in_hub(turn, state.varpi.tail<3>()) * period_s).cast<float>(), 0;
  }
  const auto rows = static_cast<std::size_t>(scan.scan->rows());
  const auto columns = poses_.size();
  ranges_m_.assign(rows * (columns + kBeside) + kBeside, kNone);
  for (std::size_t l = 0; l < rows; ++l) {
    std::transform(scan.scan->cells.begin() + static_cast<std::ptrdiff_t>(l * columns),
                   scan.scan->cells.begin() + static_cast<std::ptrdiff_t>((l + 1) * columns),
                   ranges_m_.begin() + static_cast<std::ptrdiff_t>(l * (columns + kBeside) + kBeside),
                   [&](std::int32_t cell) { return range_of_cell(*scan.scan, cell); });
  }
  const auto max_range_m = static_cast<float>(model_->max_range_m);
  for (std::size_t cell = 0; cell < open.size(); ++cell) {
    if (open[cell]) ranges_m_[cell + (cell / columns + 1) * kBeside] = max_range_m;
  }
}

void RayImage::mark_dynamic(const LidarScan& scan, const std::vector<std::uint16_t>& object) {
  dynamic_.assign(model_->lasers.size() * poses_.size(), false);
  for_each_dynamic(object, [&](std::size_t i) {
    const LidarReturn& r = scan.returns[i];
    dynamic_[static_cast<std::size_t>(r.laser) * poses_.size() + static_cast<std::size_t>(r.column)] = true;
  });
}

}  // namespace mapless
