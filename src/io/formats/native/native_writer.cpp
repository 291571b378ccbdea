#include "io/formats/native/native_writer.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "io/files/text.hpp"
#include "io/formats/pcd/pcd.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kNoRecord = std::numeric_limits<std::size_t>::max();

void make_folder(const fs::path& folder) {
  std::error_code error;
  if (!fs::create_directories(folder, error) && !error) error = std::make_error_code(std::errc::file_exists);
  if (error) {
    throw_write_error({folder.string(), "", "", "cannot be made: " + error.message(), "choose a new folder"},
                      error);
  }
}

// Which record each cell holds, in file order.
std::vector<std::size_t> records_by_cell(const LidarModel& model, const std::vector<LidarRecord>& records,
                                         const std::string& source) {
  const auto columns = static_cast<std::size_t>(model.columns);
  std::vector<std::size_t> by_cell(model.lasers.size() * columns, kNoRecord);
  for (std::size_t i = 0; i < records.size(); ++i) {
    const LidarRecord& r = records[i];
    const auto refuse = [&](const std::string& problem) {
      throw InputError({source, fmt::format("record {}", i),
                        fmt::format("laser {}, column {}", r.laser, r.column), problem,
                        "give each firing of the model once"});
    };
    const bool inside = r.laser >= 0 && r.column >= 0 && r.column < model.columns &&
                        static_cast<std::size_t>(r.laser) < model.lasers.size();
    if (!inside) refuse("not a cell of the scan");
    std::size_t& cell =
        by_cell[static_cast<std::size_t>(r.laser) * columns + static_cast<std::size_t>(r.column)];
    if (cell != kNoRecord) refuse("a cell that is taken");
    cell = i;
  }
  return by_cell;
}

template <class T>
void put(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

void put_record(std::string& bytes, const LidarRecord& r) {
  const ReturnCode code = r.code == ReturnCode::absent ? ReturnCode::faulty : r.code;
  const Eigen::Vector3f nan = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  for (const float coordinate : code == ReturnCode::hit ? r.position_v : nan) put(bytes, coordinate);
  put(bytes, r.time_ns);
  put(bytes, static_cast<std::uint8_t>(code));
}

std::uint8_t in_255ths(float intensity) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(intensity, 0.0F, 1.0F)));
}

void require_one_each(const fs::path& file, const char* what, std::size_t found, std::size_t records) {
  if (found == 0 || found == records) return;
  throw InputError({file.string(), what, std::to_string(found),
                    fmt::format("not one for each of {} records", records), "give all of them, or none"});
}

// A laser may fire before its column's instant, and before the scan's start then.
char type_of_times(const std::vector<LidarRecord>& records) {
  const bool negative =
      std::any_of(records.begin(), records.end(), [](const LidarRecord& r) { return r.time_ns < 0; });
  return negative ? 'I' : 'U';
}

PcdCloud organised_cloud(const LidarModel& model, char time_type, bool with_intensity) {
  PcdCloud cloud;
  cloud.width = static_cast<std::size_t>(model.columns);
  cloud.height = model.lasers.size();
  for (const char* name : {"x", "y", "z"}) cloud.add_field(name, 'F', 4);
  cloud.add_field("t", time_type, 4);
  cloud.add_field("code", 'U', 1);
  if (with_intensity) cloud.add_field("intensity", 'U', 1);
  return cloud;
}

}  // namespace

NativeWriter::NativeWriter(fs::path folder, LidarModel model)
    : folder_(std::move(folder)), model_(std::move(model)) {
  validate(model_, folder_.string());
  make_folder(folder_);
  make_folder(folder_ / "scans");
  write_sensor_yaml(folder_ / "sensor.yaml", model_);
}

void NativeWriter::add_scan(Time start, const std::vector<LidarRecord>& records,
                            const std::vector<std::uint32_t>& labels, const std::vector<float>& intensities) {
  const std::string name = fmt::format("{:06}", starts_.size());
  const fs::path file = folder_ / "scans" / (name + ".pcd");
  if (!starts_.empty() && start <= starts_.back()) {
    throw InputError(
        {file.string(), "start", decimal_seconds(start), "not after the scan before", "sort the scans"});
  }
  require_one_each(file, "labels", labels.size(), records.size());
  require_one_each(file, "intensities", intensities.size(), records.size());
  const std::vector<std::size_t> by_cell = records_by_cell(model_, records, file.string());
  PcdCloud cloud = organised_cloud(model_, type_of_times(records), !intensities.empty());
  std::vector<std::uint32_t> cell_labels;
  for (const std::size_t i : by_cell) {
    put_record(cloud.bytes, i == kNoRecord ? LidarRecord{{}, 0, 0, 0, ReturnCode::faulty} : records[i]);
    if (!intensities.empty()) put(cloud.bytes, i == kNoRecord ? std::uint8_t{0} : in_255ths(intensities[i]));
    if (!labels.empty()) cell_labels.push_back(i == kNoRecord ? kLabelUnknown : labels[i]);
  }
  // The scan last: where its labels find no room, the recording ends with the one before.
  if (!labels.empty()) {
    if (!fs::exists(folder_ / "labels")) make_folder(folder_ / "labels");
    write_label_file(folder_ / "labels" / (name + ".label"), cell_labels);
  }
  write_pcd(file, cloud);
  starts_.push_back(start);
}

void NativeWriter::finish(const std::vector<TimedPose>& trajectory) {
  if (!trajectory.empty()) write_tum_trajectory(folder_ / "trajectory.txt", trajectory);
  std::string times;
  for (const Time start : starts_) times += decimal_seconds(start) + "\n";
  write_file_atomically(folder_ / "times.txt", times);
}

}  // namespace mapless
