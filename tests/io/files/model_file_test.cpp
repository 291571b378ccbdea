#include <cmath>
#include <map>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "io/files/sensor_metadata.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kSensor = R"(name: two beams
rate_hz: 10
direction: -1
columns: 360
start_azimuth_deg: 180
min_range_m: 0.5
max_range_m: 100
lasers:
  - {elevation_deg: -10, azimuth_offset_deg: 1.5, origin_m: [0.01, -0.02, 0.2]}
  - {elevation_deg: 3, azimuth_offset_deg: 0, origin_m: [0, 0, 0.1], firing_offset_us: 2.304}
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string refusal(const std::string& text, LidarModel (*read)(const std::filesystem::path&)) {
  const test::TemporaryFolder folder;
  write_file_atomically(folder / "s.yaml", text);
  try {
    (void)read(folder / "s.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

void expect_equal(const LidarModel& a, const LidarModel& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.rotation_rate_hz, b.rotation_rate_hz);
  EXPECT_EQ(a.direction, b.direction);
  EXPECT_EQ(a.columns, b.columns);
  EXPECT_EQ(a.start_azimuth_rad, b.start_azimuth_rad);
  EXPECT_EQ(a.min_range_m, b.min_range_m);
  EXPECT_EQ(a.max_range_m, b.max_range_m);
  ASSERT_EQ(a.lasers.size(), b.lasers.size());
  for (std::size_t i = 0; i < a.lasers.size(); ++i) {
    EXPECT_EQ(a.lasers[i].elevation_rad, b.lasers[i].elevation_rad) << i;
    EXPECT_EQ(a.lasers[i].azimuth_offset_rad, b.lasers[i].azimuth_offset_rad) << i;
    EXPECT_EQ(a.lasers[i].origin_h_m, b.lasers[i].origin_h_m) << i;
    EXPECT_EQ(a.lasers[i].firing_offset, b.lasers[i].firing_offset) << i;
  }
}

TEST(SensorYaml, IsReadAsWritten) {
  const test::TemporaryFolder folder;
  write_file_atomically(folder / "sensor.yaml", kSensor);
  const LidarModel model = read_sensor_yaml(folder / "sensor.yaml");
  EXPECT_EQ(model.name, "two beams");
  EXPECT_EQ(model.direction, SpinDirection::clockwise);
  EXPECT_EQ(model.columns, 360);
  EXPECT_EQ(model.start_azimuth_rad, std::numbers::pi);
  ASSERT_EQ(model.lasers.size(), 2u);
  EXPECT_NEAR(model.lasers[0].elevation_rad, -std::numbers::pi / 18, 1e-16);
  EXPECT_EQ(model.lasers[0].origin_h_m, Eigen::Vector3d(0.01, -0.02, 0.2));
  EXPECT_EQ(model.lasers[0].firing_offset, Duration());
  EXPECT_EQ(model.lasers[1].firing_offset.nanoseconds(), 2304);
}

TEST(SensorYaml, EveryNamedModelReadsBackToTheLastDigit) {
  const test::TemporaryFolder folder;
  for (const std::string& name : named_models()) {
    SCOPED_TRACE(name);
    LidarModel model = named_model(name);
    model.name += " \"quoted: #\\";
    model.rotation_rate_hz = 1.0 / 3;
    model.direction = SpinDirection::counter_clockwise;
    write_sensor_yaml(folder / "sensor.yaml", model);
    expect_equal(read_sensor_yaml(folder / "sensor.yaml"), model);
  }
}

TEST(SensorYaml, BadFilesNameFileLineKeyAndValue) {
  const auto broken = [](const std::string& from, const std::string& to) {
    return refusal(replaced(kSensor, from, to), read_sensor_yaml);
  };
  EXPECT_EQ(refusal(kSensor, read_sensor_yaml), "accepted");
  EXPECT_THAT(broken("two beams", std::string(201, 'a')), HasSubstr("not a line of 200 bytes"));
  EXPECT_THAT(broken("two beams", "\"a\\nb\""), HasSubstr("name = "));
  EXPECT_THAT(broken("rate_hz: 10", "rate_hz: ten"),
              AllOf(HasSubstr("s.yaml:2"), HasSubstr("rate_hz = ten")));
  EXPECT_THAT(broken("rate_hz: 10", "rate_hz: .nan"), HasSubstr("rate_hz = .nan"));
  EXPECT_THAT(broken("rate_hz: 10", "rate_hz: nan"), HasSubstr("rate_hz = nan: not finite"));
  EXPECT_THAT(broken("rate_hz: 10", "rate_hz: [10]"), HasSubstr("rate_hz: not a single value"));
  EXPECT_THAT(broken("rate_hz: 10\n", ""), HasSubstr("rate_hz: missing"));
  EXPECT_THAT(broken("rate_hz: 10", "rate_hz: 0"), HasSubstr("rate_hz = 0"));
  EXPECT_THAT(broken("rate_hz", "rate"), AllOf(HasSubstr("s.yaml:2: rate"), HasSubstr("unknown key")));
  EXPECT_THAT(broken("direction: -1", "rate_hz: 20\ndirection: -1"),
              AllOf(HasSubstr("s.yaml:3: rate_hz"), HasSubstr("there twice")));
  EXPECT_THAT(broken("direction: -1", "direction: 0"), HasSubstr("direction = 0"));
  EXPECT_THAT(broken("columns: 360", "columns: 36.5"), HasSubstr("columns = 36.5"));
  EXPECT_THAT(broken("columns: 360", "columns: 99999999999999999999"), HasSubstr("not an integer"));
  // A thousand million columns, or a turn without duration, are refused before memory is allocated.
  EXPECT_THAT(broken("columns: 360", "columns: 1000000000"), HasSubstr("columns = 1000000000: more than"));
  EXPECT_THAT(broken("rate_hz: 10", "rate_hz: 1e-300"), HasSubstr("rate_hz = 1e-300: not from"));
  EXPECT_THAT(broken("rate_hz: 10", "rate_hz: 1e300"), HasSubstr("rate_hz = 1e+300: not from"));
  EXPECT_THAT(broken("[0, 0, 0.1]", "[0, 1e30, 0.1]"), HasSubstr("laser 1 origin = 1e+30 m: more than"));
  EXPECT_THAT(broken("elevation_deg: -10", "elevation_deg: 10"), HasSubstr("increasing elevation"));
  EXPECT_THAT(broken("elevation_deg: 3", "elevation_deg: x"),
              AllOf(HasSubstr("s.yaml:10"), HasSubstr("laser 1 elevation_deg = x")));
  EXPECT_THAT(broken("[0, 0, 0.1]", "[0, 0]"), HasSubstr("laser 1 origin_m: not a list of 3 numbers"));
  EXPECT_THAT(broken("[0, 0, 0.1]", "[0, 0, inf]"), HasSubstr("laser 1 origin_m"));
  EXPECT_THAT(broken("firing_offset_us: 2.304", "firing_offset_us: 1e300"),
              HasSubstr("firing_offset_us = 1e300"));
  EXPECT_THAT(broken("firing_offset_us", "fire"), HasSubstr("laser 1 fire: unknown key"));
  EXPECT_THAT(broken("rate_hz: 10", "rate_hz: [10"), HasSubstr("not YAML"));
  EXPECT_THAT(refusal("", read_sensor_yaml), HasSubstr("s.yaml"));
  EXPECT_THAT(refusal("lasers", read_sensor_yaml), HasSubstr("not a list of keys"));
  EXPECT_THAT(
      refusal(std::string(kSensor, std::string(kSensor).find("lasers:")) + "lasers: []", read_sensor_yaml),
      HasSubstr("lasers: not a list with anything in it"));
}

// The position velodyne_driver gives a distance, in its own steps and frame (x forward, y left).
Eigen::Vector3d velodyne_driver_point(const YAML::Node& laser, double rotation, double distance) {
  const auto value = [&laser](const char* key) { return laser[key] ? laser[key].as<double>() : 0.0; };
  const double vert = value("vert_correction"), angle = rotation - value("rot_correction");
  const double horiz_offset = value("horiz_offset_correction"), vert_offset = value("vert_offset_correction");
  const double xy = distance * std::cos(vert) - vert_offset * std::sin(vert);
  const double x = xy * std::sin(angle) - horiz_offset * std::cos(angle);
  const double y = xy * std::cos(angle) + horiz_offset * std::sin(angle);
  return {y, -x, distance * std::sin(vert) + vert_offset * std::cos(vert)};
}

void expect_rays_of_the_formula(const std::filesystem::path& file) {
  const LidarModel model = read_velodyne_calibration(file);
  std::multimap<double, YAML::Node> by_elevation;
  for (const YAML::Node& laser : YAML::LoadFile(file.string())["lasers"]) {
    by_elevation.emplace(laser["vert_correction"].as<double>(), laser);
  }
  ASSERT_EQ(model.lasers.size(), by_elevation.size());
  int row = 0;
  for (const auto& [elevation, laser] : by_elevation) {
    const double turned =
        2 * std::numbers::pi * 10 * model.lasers[static_cast<std::size_t>(row)].firing_offset.seconds();
    for (const double column : {0.0, 17.0, 500.25, 1700.0}) {
      const double rotation = 2 * std::numbers::pi * column / model.columns + turned;
      for (const double range : {1.0, 10.0, 120.0}) {
        const Eigen::Vector3d expected = velodyne_driver_point(laser, rotation, range);
        EXPECT_LT((model.point_v(row, column, range) - expected).norm(), 1e-6) << "row " << row;
      }
    }
    ++row;
  }
}

TEST(VelodyneCalibration, AgreesWithTheFormulaOfTheCalibration) {
  const std::vector<std::string> files = {"velodyne_ros/64e_s2.1-sztaki.yaml",
                                          "velodyne_ros/64e_s3-xiesc.yaml",
                                          "velodyne_ros/64e_utexas.yaml",
                                          "velodyne_ros/VLP16db.yaml",
                                          "velodyne_ros/VLP16_hires_db.yaml",
                                          "velodyne_ros/32db.yaml",
                                          "velodyne_ros/VeloView-VLP-32C.yaml",
                                          "velodyne_ros/VLS128.yaml",
                                          "velodyne_decoder/VLP-16.yml",
                                          "velodyne_decoder/HDL-32E.yml",
                                          "velodyne_decoder/HDL-64E_S3-VeloView.yml",
                                          "velodyne_decoder/Alpha_Prime.yml",
                                          "velodyne_nebula/VLP16.yaml",
                                          "velodyne_nebula/HDL64e_s2.yaml",
                                          "velodyne_nebula/VLS128.yaml"};
  MAPLESS_SKIP_WITHOUT(test::shared_data("calib"));
  for (const std::string& file : files) {
    SCOPED_TRACE(file);
    expect_rays_of_the_formula(test::shared_data("calib/" + file));
  }
}

TEST(VelodyneCalibration, NamedModelsAgreeWithTheirCalibrationFiles) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"HDL-64E-S2", "velodyne_ros/64e_s2.1-sztaki.yaml"},
      {"HDL-64E-S3", "velodyne_ros/64e_s3-xiesc.yaml"},
      {"VLP-16", "velodyne_ros/VLP16db.yaml"},
      {"HDL-32E", "velodyne_ros/32db.yaml"}};
  MAPLESS_SKIP_WITHOUT(test::shared_data("calib"));
  for (const auto& [name, file] : cases) {
    SCOPED_TRACE(name);
    const LidarModel named = named_model(name),
                     read = read_velodyne_calibration(test::shared_data("calib/" + file));
    ASSERT_EQ(named.lasers.size(), read.lasers.size());
    for (std::size_t i = 0; i < named.lasers.size(); ++i) {
      // The HDL-32E's file prints steps of 4/3 degree to two digits.
      EXPECT_NEAR(named.lasers[i].elevation_rad, read.lasers[i].elevation_rad,
                  name == "HDL-32E" ? 2e-4 : 1e-7);
      EXPECT_NEAR(named.lasers[i].azimuth_offset_rad, read.lasers[i].azimuth_offset_rad, 1e-7);
      EXPECT_LT((named.lasers[i].origin_h_m - read.lasers[i].origin_h_m).norm(), 1e-6);
      EXPECT_EQ(named.lasers[i].firing_offset, read.lasers[i].firing_offset);
    }
  }
}

std::string sixteen_lasers() {
  std::string text = "num_lasers: 16\nlasers:\n";
  for (int i = 0; i < 16; ++i) {
    text += "- {laser_id: " + std::to_string(i) +
            ", rot_correction: 0, vert_correction: " + std::to_string(0.01 * i) + "}\n";
  }
  return text;
}

TEST(VelodyneCalibration, BadFilesNameFileLineKeyAndValue) {
  const auto broken = [](const std::string& from, const std::string& to) {
    return refusal(replaced(sixteen_lasers(), from, to), read_velodyne_calibration);
  };
  EXPECT_EQ(refusal(sixteen_lasers(), read_velodyne_calibration), "accepted");
  EXPECT_THAT(broken("num_lasers: 16", "num_lasers: 15"), HasSubstr("num_lasers = 15"));
  EXPECT_THAT(broken("laser_id: 3", "laser_id: 2"),
              AllOf(HasSubstr("s.yaml:6"), HasSubstr("laser_id = 2: there twice")));
  EXPECT_THAT(broken("laser_id: 3", "laser_id: 16"), HasSubstr("laser_id = 16"));
  EXPECT_THAT(broken("rot_correction: 0, ", ""), HasSubstr("laser 0 rot_correction: missing"));
  EXPECT_THAT(broken("rot_correction: 0", "rot_correction: east"), HasSubstr("rot_correction = east"));
  EXPECT_THAT(broken("vert_correction: 0.150000", "vert_correction: 8.6"), HasSubstr("8.6 rad"));
  EXPECT_THAT(refusal("lasers: [{vert_correction: 0, rot_correction: 0}]", read_velodyne_calibration),
              HasSubstr("lasers = 1: no Velodyne sensor"));
}

TEST(VelodyneCalibration, AVlp32HasItsOwnTiming) {
  MAPLESS_SKIP_WITHOUT(test::shared_data("calib"));
  for (const std::string file : {"velodyne_ros/VeloView-VLP-32C.yaml", "velodyne_nebula/VLP32.yaml"}) {
    const LidarModel model = read_velodyne_calibration(test::shared_data("calib/" + file));
    EXPECT_EQ(model.columns, std::lround(0.1 / 55.296e-6)) << file;
    Duration last;
    for (const Laser& laser : model.lasers) last = std::max(last, laser.firing_offset);
    EXPECT_EQ(last, Duration::from_seconds(15 * 2.304e-6)) << file;  // sixteen pairs
  }
}

TEST(OusterMetadata, IsThatOfTheNamedModelInEveryFirmware) {
  MAPLESS_SKIP_WITHOUT(test::shared_data("calib"));
  for (const std::string name : {"2_2_os-992119000444-128", "2_4_0_os-992146000760-128_legacy"}) {
    SCOPED_TRACE(name);
    const LidarModel read = model_from_name_or_file(test::shared_data("calib/ouster_json/" + name + ".json"));
    const LidarModel named = named_model("OS1-128");
    EXPECT_EQ(read.columns, 1024);
    ASSERT_EQ(read.lasers.size(), named.lasers.size());
    for (std::size_t i = 0; i < named.lasers.size(); ++i) {
      // Of another unit: each is aligned on its own.
      EXPECT_NEAR(read.lasers[i].elevation_rad, named.lasers[i].elevation_rad, 0.01);
      EXPECT_LT((read.lasers[i].origin_h_m - named.lasers[i].origin_h_m).norm(), 1e-5);
    }
  }
}

constexpr const char* kOuster = R"({"lidar_mode": "512x20", "beam_altitude_angles": [10, 0, -10],
 "beam_azimuth_angles": [3, 0, -3], "lidar_origin_to_beam_origin_mm": 15.8})";

TEST(OusterMetadata, LiesWithAltitudeAboveAndAzimuthClockwise) {
  const test::TemporaryFolder folder;
  write_file_atomically(folder / "os.json", kOuster);
  const LidarModel model = model_from_name_or_file((folder / "os.json").string());
  EXPECT_EQ(model.columns, 512);
  EXPECT_EQ(model.rotation_rate_hz, 20);
  // Column 0 looks to the rear; the highest beam leads clockwise by 3 degrees and rises by 10.
  const double degree = std::numbers::pi / 180, rho = 20 * std::cos(10 * degree);
  const Eigen::Vector3d expected(-rho * std::cos(3 * degree) - 0.0158, rho * std::sin(3 * degree),
                                 20 * std::sin(10 * degree) + 0.03618);
  EXPECT_LT((model.point_v(2, 0, 20) - expected).norm(), 1e-9) << model.point_v(2, 0, 20).transpose();
  const auto broken = [](const std::string& from, const std::string& to) {
    return refusal(replaced(kOuster, from, to), read_ouster_metadata);
  };
  EXPECT_THAT(broken("512x20", "512"), HasSubstr("lidar_mode = 512"));
  EXPECT_THAT(broken("[3, 0, -3]", "[3, 0]"), HasSubstr("not a list of 3 numbers"));
  EXPECT_THAT(broken("beam_altitude_angles", "angles"), HasSubstr("beam_altitude_angles: missing"));
}

TEST(HesaiCorrection, IsThatOfTheNamedModels) {
  MAPLESS_SKIP_WITHOUT(test::shared_data("calib"));
  const auto file = [](const std::string& name) {
    return test::shared_data("calib/hesai_nebula/" + name + ".csv").string();
  };
  for (const auto& [name, csv] : {std::pair{"Pandar64", "Pandar64"}, {"XT-32", "PandarXT32"}}) {
    LidarModel read = model_from_name_or_file(file(csv)), named = named_model(name);
    ASSERT_EQ(read.lasers.size(), named.lasers.size());
    for (std::size_t i = 0; i < named.lasers.size(); ++i)
      EXPECT_LT((read.point_v(static_cast<int>(i), 7, 50) - named.point_v(static_cast<int>(i), 7, 50)).norm(),
                1e-4);
  }
  for (const std::string name :
       {"Pandar128E4X", "Pandar40P", "PandarQT128", "PandarQT64", "PandarXT16", "PandarXT32M"})
    EXPECT_NO_THROW((void)model_from_name_or_file(file(name))) << name;
  EXPECT_THAT(refusal(read_whole_file(file("PandarAT128")), read_hesai_correction),
              HasSubstr("no spinning sensor"));
}

TEST(HesaiCorrection, BadRowsAreNamed) {
  EXPECT_THAT(refusal("Channel,Elevation,Azimuth\n1,15,0\n3,13,0\n", read_hesai_correction),
              AllOf(HasSubstr("s.yaml:3"), HasSubstr("not channel 2")));
  EXPECT_THAT(refusal("Channel,Elevation,Azimuth\n1,15,0\n", read_hesai_correction), HasSubstr("rows = 1"));
  EXPECT_THAT(refusal("", read_hesai_correction), HasSubstr("rows = 0"));
}

TEST(ModelFromNameOrFile, DistinguishesNamesAndFiles) {
  const test::TemporaryFolder folder;
  write_file_atomically(folder / "native.yaml", kSensor);
  write_file_atomically(folder / "velodyne.yaml", sixteen_lasers());
  EXPECT_EQ(model_from_name_or_file("hdl-64e-s2").name, "HDL-64E-S2");
  EXPECT_EQ(model_from_name_or_file(folder / "native.yaml").name, "two beams");
  EXPECT_EQ(model_from_name_or_file(folder / "velodyne.yaml").name, "velodyne");
  try {
    (void)model_from_name_or_file("HDL-64");
    FAIL();
  } catch (const ParameterError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("HDL-64"), HasSubstr("HDL-64E-S3")));
  }
}

TEST(ModelFromNameOrFile, NamesTheKnownFormatsForAnotherFile) {
  const test::TemporaryFolder folder;
  for (const char* text : {"{\"beam_altitude_angles\": [1, 2]}", "Laser id,Elevation,Azimuth\n1,14.8,-1\n"}) {
    write_file_atomically(folder / "other", text);
    try {
      (void)model_from_name_or_file(folder / "other");
      FAIL();
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr("other:1"), HasSubstr("Velodyne"), HasSubstr("sensor.yaml")));
    }
  }
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
