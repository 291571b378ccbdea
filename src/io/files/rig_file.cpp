#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include "io/files/yaml_reader.hpp"
#include <mapless/io/files.hpp>

namespace mapless::inline v1 {
namespace {

bool is_folder_name(const std::string& name) {
  return !name.empty() && name.front() != '.' && name.find_first_of("/\\\n") == std::string::npos;
}

RigSensor read_sensor(const YamlMap& yaml) {
  yaml.require_only({"name", "model", "position_m", "quaternion_xyzw", "clock_offset_s"});
  RigSensor sensor;
  sensor.name = yaml.text("name");
  if (!is_folder_name(sensor.name)) yaml.refuse("name", "not the name of a folder");
  if (yaml.has("model")) sensor.model = yaml.text("model");
  const std::vector<double> p = yaml.numbers("position_m", 3);
  const std::vector<double> q = yaml.numbers("quaternion_xyzw", 4);
  const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  if (std::abs(rotation.norm() - 1) > 1e-3) yaml.refuse("quaternion_xyzw", "not a unit quaternion x y z w");
  sensor.T_bv = SE3(rotation.normalized().toRotationMatrix(), {p[0], p[1], p[2]});
  sensor.clock_offset = Duration::from_seconds(yaml.number_or("clock_offset_s", 0));
  return sensor;
}

std::string quoted(const std::string& text) {
  YAML::Emitter emitter;
  emitter << YAML::DoubleQuoted << text;
  return emitter.c_str();
}

}  // namespace

bool is_rig(const std::filesystem::path& folder) {
  return std::filesystem::is_regular_file(folder / kRigFile);
}

std::vector<RigSensor> read_rig_yaml(const std::filesystem::path& file) {
  const YamlMap yaml(file);
  yaml.require_only({"sensors"});
  std::vector<RigSensor> sensors;
  std::set<std::string> names;
  for (const YamlMap& one : yaml.maps("sensors", "sensor")) {
    sensors.push_back(read_sensor(one));
    if (!names.insert(sensors.back().name).second) one.refuse("name", "not the only sensor of this name");
    if (sensors.size() == 1 && sensors.back().clock_offset != Duration())
      one.refuse("clock_offset_s", "not 0: the clock of the rig is that of its first sensor");
  }
  if (sensors.empty()) yaml.refuse("sensors", "no sensor in it");
  return sensors;
}

void write_rig_yaml(const std::filesystem::path& file, const std::vector<RigSensor>& sensors) {
  std::string text = "sensors:  # vehicle from sensor; the first one gives motion and clock of the rig\n";
  for (const RigSensor& sensor : sensors) {
    Eigen::Quaterniond q(sensor.T_bv.rotation());
    q.normalize();
    const Eigen::Vector3d& p = sensor.T_bv.translation();
    text += fmt::format("  - name: {}\n", quoted(sensor.name));
    if (!sensor.model.empty()) text += fmt::format("    model: {}\n", quoted(sensor.model));
    text += fmt::format("    position_m: [{}, {}, {}]\n    quaternion_xyzw: [{}, {}, {}, {}]\n", p.x(), p.y(),
                        p.z(), q.x(), q.y(), q.z(), q.w());
    text += fmt::format("    clock_offset_s: {}\n", sensor.clock_offset.seconds());
  }
  write_file_atomically(file, text);
}

}  // namespace mapless
