#include "fuzz/readers.hpp"

#include <algorithm>
#include <cstdint>
#include <fstream>

#include <fmt/format.h>

#include "io/formats/mdlidar/mdlidar_writer.hpp"
#include "io/formats/native/native_writer.hpp"
#include "support/bare_cloud.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/detection/parameters.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::fuzz {
namespace {

namespace fs = std::filesystem;
using test::write_text;

// As small as a recording can be that every reader accepts: fuzzing changes bytes one by one.
constexpr int kLasers = 4, kColumns = 36, kScans = 3;
constexpr std::int64_t kTurn_ns = 100'000'000;
constexpr std::int64_t kStart_ns = 1'700'000'000'000'000'000;

void write_native(const fs::path& folder) {
  LidarModel model = test::make_bare_cloud_model(kLasers, kColumns);
  NativeWriter writer(folder / "recording", model);
  for (int k = 0; k < kScans; ++k) {
    std::vector<LidarRecord> records;
    std::vector<std::uint32_t> labels;
    for (int laser = 0; laser < kLasers; ++laser) {
      for (int column = 0; column < kColumns; ++column) {
        const auto time_ns = static_cast<std::int32_t>(kTurn_ns * column / kColumns);
        const double range_m = 5 + laser + 0.1 * column;
        const ReturnCode code = column % 7 == 3 ? ReturnCode::nothing : ReturnCode::hit;
        records.push_back(
            {model.point_v(laser, column, range_m).cast<float>(), laser, column, time_ns, code});
        labels.push_back(column < 4 ? kLabelDynamic | 1U << 16 : kLabelStatic);
      }
    }
    writer.add_scan(Time::from_nanoseconds(kStart_ns + k * kTurn_ns), records, labels);
  }
  std::vector<TimedPose> poses;
  for (int k = 0; k <= kScans; ++k) {
    Vector6d moved = Vector6d::Zero();
    moved.head<3>() << k, 0.1 * k, 0;
    poses.push_back({Time::from_nanoseconds(kStart_ns + k * kTurn_ns), SE3::exp(moved)});
  }
  writer.finish(poses);
}

// Everything that detect, info and evaluate read of a recording before they compute.
void read_recording(const fs::path& folder) {
  const auto dataset = open_dataset(folder);
  const auto trajectory = dataset->trajectory();
  (void)survey_recording(*dataset);
  if (trajectory) require_coverage(*dataset, *trajectory, 0, dataset->size());
  (void)check_recording(*dataset, trajectory, 0, dataset->size());
  for (std::size_t k = 0; k < dataset->size(); ++k) {
    (void)dataset->read(k);
    (void)dataset->read_labels(k);
  }
}

void read_whole_recording(const fs::path& folder) { read_recording(folder / "recording"); }

// The sensor is recovered from the points alone: it takes more of them.
LidarModel bare_model() { return test::make_bare_cloud_model(6, 360); }
test::Cloud bare_cloud() { return test::make_bare_cloud(bare_model(), 0); }

void write_kitti(const fs::path& folder) {
  std::string times, poses;
  for (int k = 0; k < kScans; ++k) {
    test::write_kitti_cloud(folder / "recording/velodyne" / fmt::format("{:06}.bin", k), bare_cloud());
    times += fmt::format("{:e}\n", 0.1 * k);
    poses += fmt::format("1 0 0 0 0 1 0 0 0 0 1 {}\n", k);
  }
  write_text(folder / "recording/times.txt", times);
  write_text(folder / "recording/poses.txt", poses);
  write_text(folder / "recording/calib.txt",
             "P0: 1 0 0 0 0 1 0 0 0 0 1 0\nTr: 0 -1 0 0.1 0 0 -1 -0.2 1 0 0 -0.3\n");
}

void write_kitti_raw(const fs::path& folder) {
  const fs::path points = folder / "recording/velodyne_points";
  for (const auto& [name, part] :
       {std::pair("timestamps_start", 0), {"timestamps", 5}, {"timestamps_end", 9}}) {
    std::string lines;
    for (int k = 0; k < kScans; ++k) lines += fmt::format("2011-09-26 13:02:25.{}{}0000000\n", k, part);
    write_text(points / (std::string(name) + ".txt"), lines);
  }
  for (int k = 0; k < kScans; ++k)
    test::write_kitti_cloud(points / "data" / fmt::format("{:010}.bin", k), bare_cloud());
}

void write_mdlidar(const fs::path& folder) {
  std::vector<MdlidarLaser> lasers;
  for (int l = 0; l < kLasers; ++l) lasers.push_back({0.02, 0.1, 0.01 * l, -0.1 * l});
  MdlidarWriter writer(folder / "recording", lasers, kColumns, Duration::from_nanoseconds(kTurn_ns));
  for (int k = 0; k < kScans; ++k) {
    MdlidarFrame frame;
    frame.start = Time::from_nanoseconds(kStart_ns + k * kTurn_ns);
    frame.end = frame.start + Duration::from_nanoseconds(kTurn_ns - 1);
    for (int i = 0; i < kLasers * kColumns; ++i) {
      MdlidarPoint point;
      point.rotation_deg = static_cast<float>(10 * (i % kColumns));
      if (i % 5 != 0) point.range_m = 5.0F + static_cast<float>(i % kColumns) / 10;
      point.object_id = i % 3;
      frame.points.push_back(point);
    }
    writer.write(frame);
  }
  writer.finish();
}

// Clouds as pcl writes them.
void write_pcd_folder(const fs::path& folder) {
  std::string body;
  const LidarModel model = bare_model();
  std::size_t points = 0;
  for (int laser = 0; laser < 6; ++laser) {
    for (int column = 0; column < model.columns; ++column, ++points) {
      const Eigen::Vector3d p = model.point_v(laser, column, 5 + laser + 0.01 * column);
      body += fmt::format("{:.3f} {:.3f} {:.3f} {} {:.5f}\n", p.x(), p.y(), p.z(), laser,
                          0.1 * column / model.columns);
    }
  }
  for (int k = 0; k < kScans; ++k) {
    write_text(
        folder / "recording" / fmt::format("{:06}.pcd", k),
        fmt::format("VERSION 0.7\nFIELDS x y z ring time\nSIZE 4 4 4 2 4\nTYPE F F F U F\nCOUNT 1 1 1 1 1\n"
                    "WIDTH {0}\nHEIGHT 1\nPOINTS {0}\nDATA ascii\n{1}",
                    points, body));
  }
  write_text(folder / "recording/times.txt", "0\n0.1\n0.2\n");
}

void write_velodyne_calibration(const fs::path& folder) {
  std::string text = "lasers:\n";
  for (int l = 0; l < 16; ++l) {
    text += fmt::format(
        "- {{laser_id: {}, rot_correction: 0.01, vert_correction: {}, vert_offset_correction: 0.1,\n"
        "   horiz_offset_correction: 0.02, dist_correction: 0.0}}\n",
        l, 0.035 * (l - 8) + 0.017);
  }
  write_text(folder / "calibration.yaml", text + "num_lasers: 16\ndistance_resolution: 0.002\n");
}

void write_ouster_metadata(const fs::path& folder) {
  std::string altitude, azimuth;
  for (int l = 0; l < 16; ++l) {
    altitude += fmt::format("{}{}", l > 0 ? ", " : "", 15 - 2 * l);
    azimuth += fmt::format("{}{}", l > 0 ? ", " : "", 1.5 - (l % 4));
  }
  write_text(folder / "metadata.json",
             fmt::format("{{\"beam_altitude_angles\": [{}], \"beam_azimuth_angles\": [{}], \"lidar_mode\": "
                         "\"1024x10\", \"lidar_origin_to_beam_origin_mm\": 15.8}}\n",
                         altitude, azimuth));
}

void write_hesai_correction(const fs::path& folder) {
  std::string text = "Laser id,Elevation,Azimuth\n";
  for (int l = 0; l < 32; ++l) text += fmt::format("{},{},{}\n", l + 1, 15 - l, 0.1 * (l % 3));
  write_text(folder / "correction.csv", text);
}

void write_parameters(const fs::path& folder) {
  DetectorParameters values, defaults;
  write_text(folder / "config.yaml",
             parameters_yaml(parameter_references(values), parameter_references(defaults)));
}

void write_tables(const fs::path& folder) {
  write_text(folder / "objects.csv", "object_id,class,kind\n1,car,mover\n7,tree,parked\n");
  ObjectStatesWriter states(folder / "object_states.csv");
  states.add(0, {{1, ObjectState{}}, {7, ObjectState{}}});
  states.add(1, {{1, ObjectState{}}});
  fs::create_directory(folder / "result");
  ObjectTableWriter table(folder / "result/objects.csv");
  for (std::size_t k = 0; k < kScans; ++k) {
    ObjectRow row;
    row.scan = k;
    row.id = 3;
    row.points = 40;
    row.velocity_std_0 = {0.1, 0.1, 0.1};
    table.add({row});
  }
  write_text(folder / "speeds.csv", "time_s,speed_m_s\n0.0,1.5\n0.1,1.75\n");
  write_text(folder / "turns.csv", "time_s,x_rad_s,y_rad_s,z_rad_s\n0.0,0,0.1,-0.25\n0.5,0,0,1e-3\n");
}

void read_model(const fs::path& file) { (void)model_from_name_or_file(file.string()); }

}  // namespace

const std::vector<Reader>& readers() {
  static const std::vector<Reader> all = {
      {"native_sensor", "recording/sensor.yaml", "yaml.dict", write_native, read_whole_recording},
      {"native_times", "recording/times.txt", "numbers.dict", write_native, read_whole_recording},
      {"native_trajectory", "recording/trajectory.txt", "numbers.dict", write_native, read_whole_recording},
      {"native_scan", "recording/scans/000001.pcd", "pcd.dict", write_native, read_whole_recording},
      {"native_labels", "recording/labels/000001.label", "numbers.dict", write_native, read_whole_recording},
      {"kitti_cloud", "recording/velodyne/000001.bin", "numbers.dict", write_kitti, read_whole_recording},
      {"kitti_times", "recording/times.txt", "numbers.dict", write_kitti, read_whole_recording},
      {"kitti_poses", "recording/poses.txt", "numbers.dict", write_kitti, read_whole_recording},
      {"kitti_calibration", "recording/calib.txt", "numbers.dict", write_kitti, read_whole_recording},
      {"kitti_raw_times", "recording/velodyne_points/timestamps_start.txt", "numbers.dict", write_kitti_raw,
       read_whole_recording},
      {"mdlidar_header", "recording/header", "numbers.dict", write_mdlidar, read_whole_recording},
      {"mdlidar_frame", "recording/frame/data_1", "numbers.dict", write_mdlidar, read_whole_recording},
      {"mdlidar_calibration", "recording/vel_64_calib.csv", "numbers.dict", write_mdlidar,
       read_whole_recording},
      {"pcd_cloud", "recording/000001.pcd", "pcd.dict", write_pcd_folder, read_whole_recording},
      {"velodyne_calibration", "calibration.yaml", "yaml.dict", write_velodyne_calibration,
       [](const fs::path& folder) { read_model(folder / "calibration.yaml"); }},
      {"ouster_metadata", "metadata.json", "yaml.dict", write_ouster_metadata,
       [](const fs::path& folder) { read_model(folder / "metadata.json"); }},
      {"hesai_correction", "correction.csv", "numbers.dict", write_hesai_correction,
       [](const fs::path& folder) { read_model(folder / "correction.csv"); }},
      {"parameters", "config.yaml", "yaml.dict", write_parameters,
       [](const fs::path& folder) {
         DetectorParameters values;
         read_parameters_file(folder / "config.yaml", parameter_references(values));
       }},
      {"true_objects", "objects.csv", "numbers.dict", write_tables,
       [](const fs::path& folder) { (void)read_object_truth(folder); }},
      {"true_states", "object_states.csv", "numbers.dict", write_tables,
       [](const fs::path& folder) { (void)read_object_truth(folder); }},
      {"object_table", "result/objects.csv", "numbers.dict", write_tables,
       [](const fs::path& folder) { (void)read_object_table(folder / "result/objects.csv"); }},
      {"speeds", "speeds.csv", "numbers.dict", write_tables,
       [](const fs::path& folder) { (void)read_speeds(folder / "speeds.csv"); }},
      {"angular_velocities", "turns.csv", "numbers.dict", write_tables,
       [](const fs::path& folder) { (void)read_angular_velocities(folder / "turns.csv"); }},
  };
  return all;
}

std::string refusal(const Reader& reader, const fs::path& folder, std::string_view bytes) {
  std::ofstream(folder / reader.file, std::ios::binary) << bytes;
  try {
    reader.read(folder);
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

}  // namespace mapless::fuzz
