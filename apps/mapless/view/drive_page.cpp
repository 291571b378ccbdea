#include "view/drive_page.hpp"

#include <cmath>
#include <mutex>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "reports/base64.hpp"
#include "reports/json.hpp"
#include "reports/method_of_result.hpp"
#include "view/scan_block.hpp"
#include <mapless/detection/detection.hpp>

namespace mapless::app {
namespace {

// viewer/src/drive.ts refuses another version.
constexpr int kPageVersion = 2;
constexpr std::string_view kDriveMark = "<!--mapless:drive-->", kScansMark = "<!--mapless:scans-->";

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

struct EncodedScan {
  Json header;
  std::string element;
};

std::string data_element(std::string_view what, std::size_t k, const std::string& bytes) {
  return fmt::format("<script type=\"text/plain\" id=\"{}-{}\">{}</script>\n", what, k, base64(bytes));
}

EncodedScan encode(const LabelledDrive& drive, std::size_t k, const SE3& T_page_world,
                   const OptionalPlanes& planes) {
  const LabelledCloud cloud = drive.read(k);
  const ScanBlock block = encode_scan(cloud, T_page_world.rotation(), planes);
  Json objects = Json::array();
  for (const ObjectRow& row : drive.objects(k)) objects.push_back(object_json(row, T_page_world));
  const SE3 T_page_v = T_page_world * cloud.T_0v;
  Eigen::Quaterniond q(T_page_v.rotation());
  q.normalize();
  EncodedScan out;
  out.header = {{"number", k},
                {"time_ns", std::to_string(cloud.scan->start.nanoseconds())},
                {"duration_s", rounded((cloud.scan->end() - cloud.scan->start).seconds(), 1e-6)},
                {"columns", cloud.scan->columns},
                {"points", block.points},
                {"step_m", block.step_m},
                {"origin", vector_json(T_page_world * cloud.points.origin_0, 1e-4)},
                {"position", vector_json(T_page_v.translation(), 1e-4)},
                {"quaternion",
                 {rounded(q.x(), 1e-7), rounded(q.y(), 1e-7), rounded(q.z(), 1e-7), rounded(q.w(), 1e-7)}},
                {"dynamic", block.dynamic},
                {"hits", block.hits},
                {"false", block.false_positives},
                {"missed", block.missed},
                {"objects", std::move(objects)}};
  out.element = data_element("scan", k, block.bytes);
  return out;
}

// Scans are read and compressed by all threads, and stay in their order.
std::vector<EncodedScan> encode_all(const LabelledDrive& drive, const std::vector<std::size_t>& scans,
                                    const SE3& T_page_world, const OptionalPlanes& planes,
                                    const std::function<void(std::size_t, std::size_t)>& progress) {
  std::vector<EncodedScan> out(scans.size());
  std::mutex printing;
  std::size_t done = 0;
  tbb::parallel_for(std::size_t{0}, scans.size(), [&](std::size_t i) {
    out[i] = encode(drive, scans[i], T_page_world, planes);
    const std::lock_guard<std::mutex> lock(printing);
    if (progress) progress(++done, scans.size());
  });
  return out;
}

// A script element ends at the first "</", and "<!--" begins a comment: neither is in JSON without "<".
std::string json_for_script(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string out;
  out.reserve(text.size());
  for (const char c : text) c == '<' ? out += "\\u003c" : out += c;
  return out;
}

Json header_of(const LabelledDrive& drive, const PageTitle& title, const OptionalPlanes& planes,
               bool with_truth) {
  const LidarModel& model = *drive.dataset().model();
  Json stages = Json::array();
  if (planes.stages && drive.result()) {
    for (const std::string_view name : stage_names_of(*drive.result())) stages.push_back(std::string(name));
  }
  return {{"version", kPageVersion},
          {"program", "mapless " MAPLESS_VERSION},
          {"recording", title.recording},
          {"result", title.result},
          {"format", drive.dataset().format()},
          {"sensor", model.name},
          {"lasers", model.lasers.size()},
          {"columns", model.columns},
          {"truth", with_truth},
          {"poses", drive.has_poses()},
          {"probability", planes.probability},
          {"stages", std::move(stages)}};
}

}  // namespace

std::string drive_page(const LabelledDrive& drive, const std::vector<std::size_t>& scans,
                       const PageTitle& title, const ExplainedDrive& explained,
                       const std::function<void(std::size_t, std::size_t)>& progress) {
  const LabelledCloud first = drive.read(scans.front());
  const SE3 T_page_world = first.T_0v.inverse();
  const OptionalPlanes planes{first.stages.has_value(), first.probability.has_value()};
  const bool with_truth = first.truth.has_value();
  const std::vector<EncodedScan> encoded = encode_all(drive, scans, T_page_world, planes, progress);

  Json header = header_of(drive, title, planes, with_truth);
  header["scans"] = Json::array();
  for (const EncodedScan& scan : encoded) header["scans"].push_back(scan.header);
  if (!explained.blocks.empty()) header["explanations"] = explained.header;

  const std::string_view page = page_template();
  const std::size_t drive_at = page.find(kDriveMark), scans_at = page.find(kScansMark);
  // The first scan comes before the program, which draws it while the browser still reads the others.
  std::string out(page.substr(0, drive_at));
  out += "<script type=\"application/json\" id=\"drive\">" + json_for_script(header) + "</script>\n";
  out += encoded.front().element;
  out += page.substr(drive_at + kDriveMark.size(), scans_at - drive_at - kDriveMark.size());
  for (std::size_t i = 1; i < encoded.size(); ++i) out += encoded[i].element;
  for (const std::size_t k : scans) {
    const auto block = explained.blocks.find(k);
    if (block != explained.blocks.end()) out += data_element("explain", k, block->second);
  }
  out += page.substr(scans_at + kScansMark.size());
  return out;
}

}  // namespace mapless::app
