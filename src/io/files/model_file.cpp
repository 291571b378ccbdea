#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "io/files/sensor_metadata.hpp"
#include "io/files/yaml_reader.hpp"
#include "lidar/vendor_models.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::inline v1 {
namespace {

constexpr double kMaxFiringOffsetUs = 1e6;

Laser read_laser(const YamlMap& yaml) {
  yaml.require_only({"elevation_deg", "azimuth_offset_deg", "origin_m", "firing_offset_us"});
  Laser laser;
  laser.elevation_rad = yaml.degrees_as_radians("elevation_deg");
  laser.azimuth_offset_rad = yaml.degrees_as_radians("azimuth_offset_deg");
  const std::vector<double> origin = yaml.numbers("origin_m", 3);
  laser.origin_h_m = {origin[0], origin[1], origin[2]};
  const double firing_offset_us = yaml.number_or("firing_offset_us", 0);
  if (std::abs(firing_offset_us) > kMaxFiringOffsetUs) yaml.refuse("firing_offset_us", "more than a second");
  laser.firing_offset = Duration::from_seconds(1e-6 * firing_offset_us);
  return laser;
}

SpinDirection read_direction(const YamlMap& yaml) {
  const int direction = yaml.integer("direction");
  if (direction != -1 && direction != 1) {
    yaml.refuse("direction", "neither -1 (clockwise seen from above) nor 1 (counter-clockwise)");
  }
  return static_cast<SpinDirection>(direction);
}

std::string laser_text(const Laser& laser) {
  const Eigen::Vector3d& o = laser.origin_h_m;
  std::string text = fmt::format("  - {{elevation_deg: {}, azimuth_offset_deg: {}, origin_m: [{}, {}, {}]",
                                 degrees_text(laser.elevation_rad), degrees_text(laser.azimuth_offset_rad),
                                 o.x(), o.y(), o.z());
  const std::int64_t ns = laser.firing_offset.nanoseconds();
  if (ns != 0) text += fmt::format(", firing_offset_us: {:.3f}", static_cast<double>(ns) * 1e-3);
  return text + "}\n";
}

// Laser ids give the firing order; each occurs once.
std::size_t read_laser_id(const YamlMap& yaml, std::size_t position, std::vector<bool>& seen) {
  const int id = yaml.has("laser_id") ? yaml.integer("laser_id") : static_cast<int>(position);
  if (id < 0 || static_cast<std::size_t>(id) >= seen.size()) {
    yaml.refuse("laser_id", fmt::format("not from 0 to {}", seen.size() - 1));
  }
  const auto index = static_cast<std::size_t>(id);
  if (seen[index]) yaml.refuse("laser_id", "there twice");
  seen[index] = true;
  return index;
}

VelodyneCorrection read_correction(const YamlMap& yaml) {
  VelodyneCorrection correction;
  correction.vert_rad = yaml.number("vert_correction");
  correction.rot_rad = yaml.number("rot_correction");
  correction.vert_offset_m = yaml.number_or("vert_offset_correction", 0);
  correction.horiz_offset_m = yaml.number_or("horiz_offset_correction", 0);
  return correction;
}

constexpr std::size_t kLongestName = 200;  // it is in lines and tables of results

bool is_control(unsigned char c) { return c < 0x20 || c == 0x7F; }

bool equal_ignoring_case(const std::string& a, const std::string& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

// What is neither of the two is often another vendor's calibration.
bool is_velodyne_calibration(const std::string& file) try {
  return YamlMap(file).maps("lasers", "laser").front().has("vert_correction");
} catch (const InputError& error) {
  ErrorDetail detail = error.detail();
  detail.remedy =
      "give a calibration file of Velodyne's (YAML), Ouster's (JSON) or Hesai's (CSV), or a sensor.yaml";
  throw InputError(std::move(detail));
}

}  // namespace

LidarModel read_sensor_yaml(const std::filesystem::path& file) {
  const YamlMap yaml(file);
  yaml.require_only({"name", "rate_hz", "direction", "columns", "start_azimuth_deg", "min_range_m",
                     "max_range_m", "lasers"});
  LidarModel model;
  model.name = yaml.text("name");
  if (model.name.size() > kLongestName || std::any_of(model.name.begin(), model.name.end(), is_control))
    yaml.refuse("name", fmt::format("not a line of {} bytes at most", kLongestName));
  model.rotation_rate_hz = yaml.number("rate_hz");
  model.direction = read_direction(yaml);
  model.columns = yaml.integer("columns");
  model.start_azimuth_rad = yaml.degrees_as_radians("start_azimuth_deg");
  model.min_range_m = yaml.number("min_range_m");
  model.max_range_m = yaml.number("max_range_m");
  for (const YamlMap& laser : yaml.maps("lasers", "laser")) model.lasers.push_back(read_laser(laser));
  validate(model, file.string());
  return model;
}

void write_sensor_yaml(const std::filesystem::path& file, const LidarModel& model) {
  YAML::Emitter name;
  name << YAML::DoubleQuoted << model.name;
  std::string text = fmt::format(
      "name: {}\nrate_hz: {}\ndirection: {}  # -1 clockwise, 1 counter-clockwise, seen from +z\ncolumns: {}\n"
      "start_azimuth_deg: {}\nmin_range_m: {}\nmax_range_m: {}\nlasers:  # by increasing elevation\n",
      name.c_str(), model.rotation_rate_hz, static_cast<int>(model.direction), model.columns,
      degrees_text(model.start_azimuth_rad), model.min_range_m, model.max_range_m);
  for (const Laser& laser : model.lasers) text += laser_text(laser);
  write_file_atomically(file, text);
}

LidarModel read_velodyne_calibration(const std::filesystem::path& file) {
  const YamlMap yaml(file);
  const std::vector<YamlMap> lasers = yaml.maps("lasers", "laser");
  if (yaml.has("num_lasers") && yaml.integer("num_lasers") != static_cast<int>(lasers.size())) {
    yaml.refuse("num_lasers", fmt::format("but the file lists {} lasers", lasers.size()));
  }
  LidarModel model = velodyne_timing(lasers.size(), yaml.number_or("distance_resolution", 0));
  if (model.lasers.empty()) {
    throw InputError({file.string(), "lasers", std::to_string(lasers.size()),
                      "no Velodyne sensor has as many", "describe the sensor in a sensor.yaml"});
  }
  model.name = file.stem().string();
  std::vector<bool> seen(lasers.size(), false);
  for (std::size_t i = 0; i < lasers.size(); ++i) {
    Laser& laser = model.lasers[read_laser_id(lasers[i], i, seen)];
    const Duration firing_offset = laser.firing_offset;
    laser = velodyne_laser(read_correction(lasers[i]));
    laser.firing_offset = firing_offset;
  }
  model = assembled(std::move(model));
  validate(model, file.string());
  return model;
}

LidarModel model_from_name_or_file(const std::string& name_or_file) {
  for (const std::string& name : named_models()) {
    if (equal_ignoring_case(name, name_or_file)) return named_model(name);
  }
  if (!std::filesystem::is_regular_file(name_or_file)) {
    throw ParameterError(
        {"sensor", "name or file", name_or_file, "neither a named model nor a file",
         fmt::format("choose one of {}, or a calibration file", fmt::join(named_models(), ", "))});
  }
  const std::string suffix = std::filesystem::path(name_or_file).extension().string();
  if (equal_ignoring_case(suffix, ".json")) return read_ouster_metadata(name_or_file);
  if (equal_ignoring_case(suffix, ".csv")) return read_hesai_correction(name_or_file);
  return is_velodyne_calibration(name_or_file) ? read_velodyne_calibration(name_or_file)
                                               : read_sensor_yaml(name_or_file);
}

}  // namespace mapless
