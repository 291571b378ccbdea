#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "option_checks.hpp"
#include "recording_options.hpp"
#include "scan_picture.hpp"
#include "verbs.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/labels.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::app {
namespace {

struct RenderOptions {
  RecordingOptions recording;
  std::string result;
  std::size_t scan = 0;
  std::string picture;
  std::string view = "both";
  PictureOptions drawing;
};

int render(RenderOptions options) {
  const auto dataset = options.recording.open();
  if (options.scan >= dataset->size()) {
    throw ParameterError({"--scan", "", std::to_string(options.scan), "there is no such scan",
                          fmt::format("the recording has {} scans", dataset->size())});
  }
  const LidarScan scan = dataset->read(options.scan);
  const auto labels = read_label_file(ResultFolder(options.result).label_file(options.scan), scan.input_size);
  options.drawing.bird_view = options.view != "range";
  options.drawing.range_image = options.view != "bev";
  options.drawing.title = fmt::format("scan {} of {} ({}, {})", options.scan, dataset->size(),
                                      dataset->format(), dataset->model()->name);
  draw_scan(scan, labels, dataset->read_labels(options.scan), options.drawing).write_png(options.picture);
  fmt::print("{}\n", options.picture);
  return 0;
}

}  // namespace

void add_render(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand(
      "render",
      "Draw a labelled scan: static grey, dynamic by object; with truth green hit, red false, blue missed");
  const auto options = std::make_shared<RenderOptions>();
  add_recording_options(*verb, options->recording);
  verb->add_option("OUT", options->result,
                   "the result of mapless detect, or a folder with labels/NNNNNN.label")
      ->required();
  verb->add_option("--scan", options->scan, "number of the scan in the recording, from 0")
      ->required()
      ->check(whole_number(0));
  verb->add_option("-o,--output", options->picture, "the picture, a PNG file")->required();
  verb->add_option("--view", options->view, "bird's-eye view, range image, or both")
      ->check(CLI::IsMember({"both", "bev", "range"}))
      ->capture_default_str();
  verb->add_option("--extent-m", options->drawing.extent_m,
                   "from the sensor to the left and right edge of the bird's-eye view [m]")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  verb->callback([options, &exit_code] { exit_code = render(*options); });
}

}  // namespace mapless::app
