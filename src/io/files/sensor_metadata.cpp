#include "io/files/sensor_metadata.hpp"

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "io/files/text.hpp"
#include "io/files/yaml_reader.hpp"
#include "lidar/vendor_models.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::inline v1 {
namespace {

// Of the first OS-1, whose metadata do not say it [mm].
constexpr double kFirstBeamOrigin_mm = 12.163;
// Of the lidar frame above the sensor frame, where the metadata do not say it [mm].
constexpr double kUsualHeight_mm = 36.18;

// The metadata of some firmwares group the keys; others have them at the top.
YamlMap map_with(const YamlMap& metadata, const std::string& group, const std::string& key) {
  return !metadata.has(key) && metadata.has(group) ? metadata.map(group) : metadata;
}

// "1024x10": columns and turns a second.
std::pair<int, double> columns_and_rate(const YamlMap& metadata) {
  const std::string mode = metadata.text("lidar_mode");
  const std::size_t x = mode.find('x');
  const long long columns = parse_integer(mode.substr(0, x)).value_or(0);
  const double rate = x == std::string::npos ? 0. : parse_double(mode.substr(x + 1)).value_or(0.);
  if (columns < 1 || columns > 1'000'000 || !(rate > 0))
    metadata.refuse("lidar_mode", "not columns x turns a second, as 1024x10");
  return {static_cast<int>(columns), rate};
}

struct HesaiRow {
  double elevation_deg, azimuth_deg;
};

std::vector<HesaiRow> hesai_rows(const std::filesystem::path& file) {
  const std::vector<std::string> lines = read_lines(file);
  std::vector<HesaiRow> rows;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    if (lines[i].empty()) continue;
    std::string row = lines[i];
    std::replace(row.begin(), row.end(), ',', ' ');
    const std::vector<std::string_view> cells = split_words(row);
    const auto channel = cells.size() == 3 ? parse_integer(cells[0]) : std::nullopt;
    const auto elevation = channel ? parse_double(cells[1]) : std::nullopt;
    const auto azimuth = channel ? parse_double(cells[2]) : std::nullopt;
    if (elevation && azimuth && *channel == static_cast<long long>(rows.size()) + 1) {
      rows.push_back({*elevation, *azimuth});
      continue;
    }
    throw InputError({fmt::format("{}:{}", file.string(), i + 1), "row", lines[i],
                      fmt::format("not channel {}, its elevation and its azimuth", rows.size() + 1),
                      "give the angle correction of the sensor"});
  }
  return rows;
}

}  // namespace

LidarModel read_ouster_metadata(const std::filesystem::path& file) {
  const YamlMap metadata(file);
  const YamlMap beams = map_with(metadata, "beam_intrinsics", "beam_altitude_angles");
  const std::vector<double> altitude = beams.numbers("beam_altitude_angles");
  const std::vector<double> azimuth = beams.numbers("beam_azimuth_angles", altitude.size());
  const YamlMap frames = map_with(metadata, "lidar_intrinsics", "lidar_to_sensor_transform");
  const double height_mm = frames.has("lidar_to_sensor_transform")
                               ? frames.numbers("lidar_to_sensor_transform", 16)[11]
                               : kUsualHeight_mm;
  const double origin_mm = beams.number_or("lidar_origin_to_beam_origin_mm", kFirstBeamOrigin_mm);
  LidarModel model = ouster_model(altitude, azimuth, 1e-3 * origin_mm, 1e-3 * height_mm);
  std::tie(model.columns, model.rotation_rate_hz) =
      columns_and_rate(map_with(metadata, "config_params", "lidar_mode"));
  model.name = file.stem().string();
  validate(model, file.string());
  return model;
}

LidarModel read_hesai_correction(const std::filesystem::path& file) {
  const std::vector<HesaiRow> rows = hesai_rows(file);
  std::vector<double> elevation, azimuth;
  for (const HesaiRow& row : rows) {
    elevation.push_back(row.elevation_deg);
    azimuth.push_back(row.azimuth_deg);
  }
  LidarModel model = hesai_model(elevation, azimuth);
  if (model.lasers.empty()) {
    throw InputError({file.string(), "rows", std::to_string(rows.size()),
                      "no spinning sensor of Hesai has such channels",
                      "describe the sensor in a sensor.yaml"});
  }
  model.name = file.stem().string();
  validate(model, file.string());
  return model;
}

}  // namespace mapless
