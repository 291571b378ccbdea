#include "view/drive_encoder.hpp"

#include <cmath>
#include <string_view>
#include <utility>

#include <Eigen/Geometry>

#include "reports/method_of_result.hpp"
#include <mapless/detection/detection.hpp>

namespace mapless::app {
namespace {

// viewer/src/drive.ts refuses another version.
constexpr int kPageVersion = 2;

double rounded(double value, double unit) { return std::round(value / unit) * unit; }

Json vector_json(const Eigen::Vector3d& v, double unit) {
  return {rounded(v.x(), unit), rounded(v.y(), unit), rounded(v.z(), unit)};
}

Json object_json(const ObjectRow& row, const SE3& T_page_world) {
  const Eigen::Matrix3d& R = T_page_world.rotation();
  // Along the page's axes, of a covariance whose cross terms the table does not have.
  const Eigen::Vector3d std_page = (R.cwiseAbs2() * row.velocity_std_0.cwiseAbs2()).cwiseSqrt();
  return {{"id", row.id},
          {"number", label_number(row.id)},
          {"points", row.points},
          {"centre", vector_json(T_page_world * row.centre_0, 1e-3)},
          {"velocity", vector_json(R * row.velocity_0, 1e-3)},
          {"std", vector_json(std_page, 1e-3)},
          {"age", row.age}};
}

}  // namespace

DriveEncoder::DriveEncoder(const LabelledDrive& drive, std::vector<std::size_t> scans)
    : drive_(drive), scans_(std::move(scans)) {
  const LabelledCloud first = drive.read(scans_.front());
  T_page_world_ = first.T_0v.inverse();
  planes_ = {first.stages.has_value(), first.probability.has_value()};
  with_truth_ = first.truth.has_value();
}

Json DriveEncoder::header(const PageTitle& title) const {
  const LidarModel& model = *drive_.dataset().model();
  Json stages = Json::array();
  if (planes_.stages && drive_.result()) {
    for (const std::string_view name : stage_names_of(*drive_.result())) stages.push_back(std::string(name));
  }
  return {{"version", kPageVersion},
          {"program", "mapless " MAPLESS_VERSION},
          {"recording", title.recording},
          {"result", title.result},
          {"format", drive_.dataset().format()},
          {"sensor", model.name},
          {"lasers", model.lasers.size()},
          {"columns", model.columns},
          {"truth", with_truth_},
          {"poses", drive_.has_poses()},
          {"probability", planes_.probability},
          {"stages", std::move(stages)}};
}

Json DriveEncoder::placed(std::size_t scan, Time start, Time end, const SE3& T_0v) const {
  Json objects = Json::array();
  for (const ObjectRow& row : drive_.objects(scan)) objects.push_back(object_json(row, T_page_world_));
  const SE3 T_page_v = T_page_world_ * T_0v;
  Eigen::Quaterniond q(T_page_v.rotation());
  q.normalize();
  return {{"number", scan},
          {"time_ns", std::to_string(start.nanoseconds())},
          {"duration_s", rounded((end - start).seconds(), 1e-6)},
          {"position", vector_json(T_page_v.translation(), 1e-4)},
          {"quaternion",
           {rounded(q.x(), 1e-7), rounded(q.y(), 1e-7), rounded(q.z(), 1e-7), rounded(q.w(), 1e-7)}},
          {"objects", std::move(objects)}};
}

Json DriveEncoder::outline(std::size_t scan) const {
  const Dataset& dataset = drive_.dataset();
  return placed(scan, dataset.scan_start(scan), dataset.scan_end(scan), drive_.start_pose(scan));
}

DriveEncoder::EncodedScan DriveEncoder::encode(std::size_t scan) const {
  const LabelledCloud cloud = drive_.read(scan);
  ScanBlock block = encode_scan(cloud, T_page_world_.rotation(), planes_);
  EncodedScan out{placed(scan, cloud.scan->start, cloud.scan->end(), cloud.T_0v), std::move(block.bytes)};
  out.header.update({{"columns", cloud.scan->columns},
                     {"points", block.points},
                     {"step_m", block.step_m},
                     {"origin", vector_json(T_page_world_ * cloud.points.origin_0, 1e-4)},
                     {"dynamic", block.dynamic},
                     {"hits", block.hits},
                     {"false", block.false_positives},
                     {"missed", block.missed}});
  return out;
}

}  // namespace mapless::app
