#include <algorithm>
#include <cctype>
#include <set>

#include "io/formats/kitti/kitti_odometry_dataset.hpp"
#include "io/formats/kitti/kitti_raw_dataset.hpp"
#include "io/formats/mdlidar/mdlidar_dataset.hpp"
#include "io/formats/native/native_dataset.hpp"
#include "io/formats/pcd/pcd_folder_dataset.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;

struct Format {
  std::string name;
  std::string looked_for;
  bool (*looks_like)(const fs::path&);
  std::unique_ptr<Dataset> (*open)(const fs::path&, const DatasetOptions&);
};

const std::vector<Format>& formats() {
  static const std::vector<Format> all = {
      {"native", "sensor.yaml with scans/", looks_native, open_native},
      {"kitti-raw", "velodyne_points/data", looks_kitti_raw, open_kitti_raw},
      {"kitti", "velodyne/*.bin", looks_kitti_odometry, open_kitti_odometry},
      {"mdlidar", "header and frame/", looks_mdlidar, open_mdlidar},
      {"pcd", "*.pcd", looks_pcd_folder, open_pcd_folder},
  };
  return all;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

const Format& named_format(const std::string& name) {
  for (const Format& format : formats()) {
    if (format.name == name) return format;
  }
  throw ParameterError({"--format", "", name, "unknown format", "one of " + joined(dataset_formats())});
}

// Container formats for which Python has libraries that are kept up to date.
bool is_read_by_python(const fs::path& file) {
  static const std::set<std::string> extensions = {".bag", ".mcap", ".db3", ".pcap", ".pcapng", ".osf"};
  std::string extension = file.extension().string();
  for (char& letter : extension) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  return extensions.contains(extension);
}

bool is_rosbag2_folder(const fs::path& path) {
  if (!fs::is_directory(path) || !fs::exists(path / "metadata.yaml")) return false;
  const auto is_part = [](const fs::directory_entry& entry) { return is_read_by_python(entry.path()); };
  return std::any_of(fs::directory_iterator(path), fs::directory_iterator(), is_part);
}

[[noreturn]] void refuse_what_python_reads(const fs::path& path, const std::string& format) {
  throw InputError({path.string(), "format", format,
                    "bags and packet captures are read by the Python package of mapless",
                    "install it (docs/python.md), whose command takes the same arguments"});
}

const Format& recognised_format(const fs::path& path) {
  const std::vector<std::string> names = recognised_formats(path);
  if (names.empty()) {
    if (is_rosbag2_folder(path)) refuse_what_python_reads(path, "rosbag2");
    std::string looked_for;
    for (const Format& format : formats())
      looked_for += (looked_for.empty() ? "" : ", ") + format.looked_for + " (" + format.name + ")";
    throw InputError(
        {path.string(), "format", "none", "no recording here; looked for " + looked_for,
         "give the folder of a recording, or name its format with --format; the Python package reads more "
         "formats (docs/python_formats.md)"});
  }
  if (names.size() > 1) {
    throw InputError({path.string(), "format", joined(names), "the folder holds more than one recording",
                      "name the one to read with --format"});
  }
  return named_format(names.front());
}

}  // namespace

std::unique_ptr<Dataset> open_dataset(const fs::path& path, const DatasetOptions& options) try {
  if (fs::is_regular_file(path) && is_read_by_python(path))
    refuse_what_python_reads(path, path.extension().string());
  if (!fs::is_directory(path)) {
    throw InputError({path.string(), "", "", fs::exists(path) ? "not a folder" : "no such folder",
                      "give the folder of a recording"});
  }
  const Format& format = options.format.empty() ? recognised_format(path) : named_format(options.format);
  return format.open(path, options);
} catch (const fs::filesystem_error& error) {
  throw_read_error({error.path1().string(), "", "", "cannot be looked at: " + error.code().message(),
                    "check the path and its permissions"},
                   error.code());
}

std::vector<std::string> recognised_formats(const fs::path& path) {
  std::vector<std::string> names;
  for (const Format& format : formats()) {
    if (format.looks_like(path)) names.push_back(format.name);
  }
  return names;
}

const std::vector<std::string>& dataset_formats() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Format& format : formats()) all.push_back(format.name);
    return all;
  }();
  return names;
}

}  // namespace mapless
