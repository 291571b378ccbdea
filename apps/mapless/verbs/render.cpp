#include <memory>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/option_checks.hpp"
#include "options/output_file.hpp"
#include "options/recording_options.hpp"
#include "pictures/scan_picture.hpp"
#include "verbs/verbs.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::app {
namespace {

struct RenderOptions {
  RecordingOptions recording;
  std::string result;
  std::size_t scan = 0;
  int around = 0;
  int every = 1;
  int reduce = 1;
  std::string picture;
  std::string view = "both";
  PictureOptions drawing;
};

// Labels of a result, or the recording's own truth where there is none.
PicturedScan read_labelled(const Dataset& dataset, const std::string& result, std::size_t k) {
  PicturedScan out{dataset.read(k), {}, dataset.read_labels(k)};
  if (!result.empty()) {
    out.labels = read_labels_of(ResultFolder(result), k, out.scan);
    return out;
  }
  if (!out.truth) {
    throw ParameterError(
        {"OUT", "", "", "not given, and the recording has no labels", "give a result of mapless detect"});
  }
  out.labels = *std::exchange(out.truth, std::nullopt);
  return out;
}

SE3 pose_at(const Trajectory& trajectory, const LidarScan& scan, const LidarReturn& r) {
  return trajectory.at(scan.compensated_to ? *scan.compensated_to : scan.time_of(r)).T_v0;
}

Time middle_of(const LidarScan& scan) {
  return scan.compensated_to
             ? *scan.compensated_to
             : scan.start + Duration::from_nanoseconds((scan.end() - scan.start).nanoseconds() / 2);
}

// The points of the other scan at their own instants, as seen from T_m0; labels of both after each other.
void append(PicturedScan& all, const PicturedScan& other, const Trajectory& trajectory, const SE3& T_m0) {
  const std::size_t before = all.labels.size();
  for (LidarReturn r : other.scan.returns) {
    const SE3 T_mv = T_m0 * pose_at(trajectory, other.scan, r).inverse();
    r.position_v = (T_mv * r.position_v.cast<double>()).cast<float>();
    r.input_index += static_cast<std::uint32_t>(before);
    all.scan.returns.push_back(r);
  }
  all.labels.insert(all.labels.end(), other.labels.begin(), other.labels.end());
  if (all.truth && other.truth) all.truth->insert(all.truth->end(), other.truth->begin(), other.truth->end());
}

PicturedScan scans_around(const Dataset& dataset, const RenderOptions& options, const LidarScan& middle) {
  const auto trajectory = dataset.trajectory();
  if (!trajectory) {
    throw ParameterError({"--around", "", std::to_string(options.around),
                          "the recording has no trajectory, which places its scans", "leave --around out"});
  }
  const SE3 T_m0 = trajectory->at(middle_of(middle)).T_v0;
  PicturedScan all{middle, {}, std::nullopt};
  all.scan.returns.clear();
  for (int step = -options.around; step <= options.around; step += options.every) {
    const auto k = static_cast<std::int64_t>(options.scan) + step;
    if (k < 0 || k >= static_cast<std::int64_t>(dataset.size())) continue;
    const PicturedScan one = read_labelled(dataset, options.result, static_cast<std::size_t>(k));
    if (all.labels.empty() && one.truth) all.truth.emplace();
    append(all, one, *trajectory, T_m0);
  }
  return all;
}

int render(RenderOptions options) {
  require_not_input(options.picture, options.recording.path, options.result);
  const auto dataset = options.recording.open();
  if (options.scan >= dataset->size()) {
    throw ParameterError({"--scan", "", std::to_string(options.scan), "there is no such scan",
                          fmt::format("the recording has {} scans", dataset->size())});
  }
  const auto [scan, labels, truth] = read_labelled(*dataset, options.result, options.scan);
  if (options.around > 0) options.drawing.from_above = scans_around(*dataset, options, scan);
  options.drawing.bird_view = options.view != "range";
  options.drawing.range_image = options.view != "bev";
  options.drawing.title = fmt::format("scan {} of {} ({}, {})", options.scan, dataset->size(),
                                      dataset->format(), dataset->model()->name);
  draw_scan(scan, labels, truth, options.drawing).write_png(options.picture, options.reduce);
  fmt::print("{}\n", options.picture);
  return 0;
}

}  // namespace

void add_render(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand(
      "render",
      "Draw a labelled scan as a picture: static points grey, dynamic points coloured by object; where the "
      "recording has true labels, true positives green, false positives orange, false negatives blue");
  const auto options = std::make_shared<RenderOptions>();
  add_recording_options(*verb, options->recording);
  add_labels_option(*verb, options->result);
  verb->add_option("--scan", options->scan, "number of the scan in the recording, from 0")
      ->required()
      ->check(whole_number(0));
  verb->add_option("-o,--output", options->picture, "PNG file to write")->required();
  verb->add_option("--view", options->view, "bird's-eye view, range image, or both")
      ->check(CLI::IsMember({"both", "bev", "range"}))
      ->capture_default_str();
  verb->add_option("--extent-m", options->drawing.extent_m,
                   "distance from the sensor to the left and right edge of the bird's-eye view [m]")
      ->check(number_between(1, 1000))
      ->capture_default_str();
  verb->add_option(
          "--around", options->around,
          "number of scans before and after --scan that the bird's-eye view also shows, placed with the "
          "recording's trajectory")
      ->check(CLI::Range(0, 10000))
      ->capture_default_str();
  verb->add_option("--every", options->every, "with --around: show only every Nth scan")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb->add_option("--reduce", options->reduce,
                   "reduce the picture by this factor in width and height, for a smaller file")
      ->check(CLI::Range(1, 8))
      ->capture_default_str();
  verb->callback([options, &exit_code] { exit_code = render(*options); });
}

}  // namespace mapless::app
