#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "options/recording_options.hpp"
#include "options/scan_range.hpp"
#include "terminal/progress.hpp"
#include "verbs/verbs.hpp"
#include "view/drive_page.hpp"
#include "view/labelled_drive.hpp"
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace {

struct ViewOptions {
  RecordingOptions recording;
  std::string result;
  ScanRange range;
  std::string page;
};

int view(const ViewOptions& options) {
  const auto dataset = options.recording.open();
  const LabelledDrive drive(*dataset, options.result);
  const std::vector<std::size_t> scans = options.range.of(drive.scans());
  Progress progress("scans");
  const std::string page =
      drive_page(drive, scans, {options.recording.path, options.result},
                 [&](std::size_t done, std::size_t total) { progress.update(done, total); });
  progress.clear();
  write_file_atomically(options.page, page);
  fmt::print("{}: {} scans, {:.1f} MB; open it with a browser\n", options.page, scans.size(),
             static_cast<double>(page.size()) * 1e-6);
  return 0;
}

}  // namespace

void add_view(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand(
      "view",
      "Write a page that shows a labelled drive in 3D: one HTML file that a browser opens by a double click, "
      "without a network. Play, step, turn, colour by motion, object, height, laser or truth");
  const auto options = std::make_shared<ViewOptions>();
  add_recording_options(*verb, options->recording);
  add_labels_option(*verb, options->result);
  verb->add_option("-o,--output", options->page, "HTML file to write")->required();
  add_scan_range_options(*verb, options->range);
  verb->callback([options, &exit_code] { exit_code = view(*options); });
}

}  // namespace mapless::app
