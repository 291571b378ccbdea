#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_pipeline.h>

#include "export/exported_points.hpp"
#include "export/new_folder.hpp"
#include "export/semantic_kitti.hpp"
#include "options/option_checks.hpp"
#include "options/output_file.hpp"
#include "options/recording_options.hpp"
#include "options/scan_range.hpp"
#include "terminal/progress.hpp"
#include "verbs/verbs.hpp"
#include "view/labelled_drive.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/geometry/compensated_scan.hpp>
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace {

namespace fs = std::filesystem;

// Scans in memory at once; more would wait for the disk or for the map.
constexpr std::size_t kScansInWork = 8;

struct ExportOptions {
  RecordingOptions recording;
  std::string result;
  ScanRange range;
  std::string what, format = "pcd", frame = "world";
  double voxel_m = 0.1;
  std::string output, sequence;
};

struct ExportCounts {
  std::size_t scans = 0, is_static = 0, moving = 0, unknown = 0;

  void add(const ExportedPoints& scan) {
    ++scans;
    is_static += scan.is_static;
    moving += scan.moving;
    unknown += scan.unknown;
  }
};

ExportedClass class_of(const std::string& what) {
  if (what == "labelled") return ExportedClass::all;
  return what == "moving" ? ExportedClass::moving : ExportedClass::is_static;
}

CloudFormat format_of(const std::string& format) {
  if (format == "las") return CloudFormat::las;
  return format == "ply" ? CloudFormat::ply : CloudFormat::pcd;
}

// Reads scans on all threads and gives them to `take`, one at a time, in their order.
template <class Take>
ExportCounts for_each_scan(const ExportOptions& options, const LabelledDrive& drive,
                           const std::vector<std::size_t>& scans, const Take& take) {
  const ExportedClass wanted = class_of(options.what);
  const bool in_sensor_frame = options.frame == "sensor";
  ExportCounts counts;
  Progress progress("scans");
  std::size_t next = 0;
  // Of the scans in work, which are taken in their order. TBB loses what it holds itself where a scan fails.
  std::array<ExportedPoints, kScansInWork> points;
  tbb::parallel_pipeline(
      kScansInWork,
      tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, [&](tbb::flow_control& flow) {
        if (next < scans.size()) return next++;
        flow.stop();
        return std::size_t{0};
      }) & tbb::make_filter<std::size_t, std::size_t>(tbb::filter_mode::parallel, [&](std::size_t i) {
        points[i % kScansInWork] = exported_points(drive.read(scans[i]), wanted, in_sensor_frame);
        return i;
      }) & tbb::make_filter<std::size_t, void>(tbb::filter_mode::serial_in_order, [&](std::size_t i) {
        const ExportedPoints& of_scan = points[i % kScansInWork];
        take(scans[i], of_scan.cloud);
        counts.add(of_scan);
        progress.update(counts.scans, scans.size());
      }));
  progress.clear();
  return counts;
}

void export_map(const ExportOptions& options, const LabelledDrive& drive,
                const std::vector<std::size_t>& scans) {
  VoxelMap map(options.voxel_m);
  const ExportCounts counts =
      for_each_scan(options, drive, scans, [&](std::size_t, const ExportCloud& cloud) {
        for (const Eigen::Vector3d& point_0 : cloud.points) {
          if (map.add(point_0)) continue;
          throw InputError({"trajectory", "", fmt::format("({:.0f}) m", fmt::join(point_0, ", ")),
                            "is too far from the first point for a map of this voxel size",
                            "give a larger --voxel-m, or a shorter range of --scans"});
        }
      });
  write_file_atomically(options.output, cloud_file(map.cloud(), format_of(options.format)));
  fmt::print(
      "{}: {} points, one for each voxel of {:g} m with static points\n"
      "{} scans: {} points static and kept, {} dynamic and removed, {} without a label and removed\n",
      options.output, map.size(), options.voxel_m, counts.scans, counts.is_static, counts.moving,
      counts.unknown);
}

void export_scans(const ExportOptions& options, const LabelledDrive& drive,
                  const std::vector<std::size_t>& scans) {
  const fs::path folder = options.output;
  if (fs::exists(folder) && !(fs::is_directory(folder) && fs::is_empty(folder))) {
    throw OutputError({folder.string(), "", "", "is there and is not an empty folder", "give a new folder"});
  }
  NewFolder made(folder);
  const ExportCounts counts =
      for_each_scan(options, drive, scans, [&](std::size_t k, const ExportCloud& cloud) {
        write_file_atomically(folder / fmt::format("{:06}.{}", k, options.format),
                              cloud_file(cloud, format_of(options.format)));
      });
  made.keep();
  fmt::print("{}: {} files; of the points {} are static, {} dynamic, {} without a label\n", folder.string(),
             counts.scans, counts.is_static, counts.moving, counts.unknown);
}

void export_predictions(const ExportOptions& options, const Dataset& dataset) {
  if (options.result.empty()) {
    throw ParameterError(
        {"OUT", "", "", "is needed for --what semantic-kitti", "give the result of mapless detect"});
  }
  const ResultFolder result(options.result);
  const std::string sequence =
      options.sequence.empty() ? semantic_kitti_sequence(options.recording.path) : options.sequence;
  const PredictionCounts counts = write_semantic_kitti(
      dataset, result, options.range.of(result.labelled_scans()), options.output, sequence);
  fmt::print(
      "{}/sequences/{}/predictions: {} files; {} points moving, {} static, of which {} without a label\n",
      options.output, sequence, counts.scans, counts.moving, counts.is_static, counts.unlabelled);
}

int export_clouds(const ExportOptions& options) {
  if (options.format == "mcap") {
    throw ParameterError({"--cloud-format", "", "mcap",
                          "is of the Python package alone, with --what labelled",
                          "pip install 'mapless[mcap]'"});
  }
  const bool is_map = options.what == "map";
  if (is_map && options.frame != "world") {
    throw ParameterError(
        {"--frame", "", options.frame, "does not fit --what map, which has one frame", "leave --frame out"});
  }
  if (is_map) require_not_input(options.output, options.recording.path, options.result);
  const auto dataset = options.recording.open();
  if (options.what == "semantic-kitti") {
    export_predictions(options, *dataset);
    return 0;
  }
  const LabelledDrive drive(*dataset, options.result);
  const std::vector<std::size_t> scans = options.range.of(drive.scans());
  if (is_map && !drive.has_poses()) {
    throw InputError({options.recording.path, "", "", "has no poses, and neither has the result",
                      "give the result of mapless detect as OUT"});
  }
  is_map ? export_map(options, drive, scans) : export_scans(options, drive, scans);
  return 0;
}

}  // namespace

void add_export(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand("export",
                                  "Write the labelled points of a drive as clouds, motion-compensated: "
                                  "static, moving or all points of each "
                                  "scan, or one map of the static points of all scans");
  const auto options = std::make_shared<ExportOptions>();
  add_recording_options(*verb, options->recording);
  add_labels_option(*verb, options->result);
  verb->add_option(
          "--what", options->what,
          "static or moving: those points of each scan; labelled: all, with the fields label, object "
          "and record (number in the input); map: one cloud of the static points of all scans; "
          "semantic-kitti: labels for evaluate_mos.py of semantic-kitti-api")
      ->required()
      ->check(CLI::IsMember({"static", "moving", "labelled", "map", "semantic-kitti"}));
  verb->add_option(
          "-o,--output", options->output,
          "folder to write NNNNNN.pcd to; with --what map, the file; with --what semantic-kitti, the "
          "folder for sequences/NN/predictions/NNNNNN.label")
      ->required();
  verb->add_option("--sequence", options->sequence,
                   "with --what semantic-kitti: NN. Default: the name of the recording if it is a number, "
                   "else 00")
      ->check(whole_number(0));
  verb->add_option("--cloud-format", options->format,
                   "format of the files, binary; mcap: one file of clouds, poses and boxes for Foxglove, "
                   "Lichtblick and Rerun, with --what labelled, of the Python package alone")
      ->check(CLI::IsMember({"pcd", "ply", "las", "mcap"}))
      ->capture_default_str();
  verb->add_option("--frame", options->frame,
                   "axes of the points of a scan: those of the poses, or of the sensor at its start")
      ->check(CLI::IsMember({"world", "sensor"}))
      ->capture_default_str();
  verb->add_option("--voxel-m", options->voxel_m,
                   "with --what map: edge of a voxel, which becomes one point [m]")
      ->check(positive_number())
      ->capture_default_str();
  add_scan_range_options(*verb, options->range);
  verb->callback([options, &exit_code] { exit_code = export_clouds(*options); });
}

}  // namespace mapless::app
