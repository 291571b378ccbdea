#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "explain/replayed_run.hpp"
#include "options/recording_options.hpp"
#include "options/scan_range.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/progress.hpp"
#include "terminal/stderr.hpp"
#include "verbs/verbs.hpp"
#include "view/drive_page.hpp"
#include "view/explanation_block.hpp"
#include "view/labelled_drive.hpp"
#include "view/loopback_server.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace {

namespace fs = std::filesystem;

struct ViewOptions {
  RecordingOptions recording;
  std::string result;
  ScanRange range;
  std::string page;
  GivenAgain given;
  bool no_explanations = false, serve = false;
  std::uint16_t port = 0;
};

// Runs the detector again, which takes as long as the first time. A result that cannot be computed again
// gives a page all the same.
ExplainedDrive explanations_of(const ViewOptions& options, const LabelledDrive& drive,
                               const std::vector<std::size_t>& scans) {
  ExplainedDrive out;
  if (options.no_explanations || !drive.result() || !fs::exists(drive.result()->summary())) return out;
  const std::set<std::size_t> wanted(scans.begin(), scans.end());
  Progress progress("scans explained");
  try {
    const ReplayedRun run(drive.dataset(), *drive.result(), options.given);
    run.run(
        scans.back(), [&](std::size_t k) { return wanted.contains(k); },
        [&](std::size_t k, const LabelledScan& scan) {
          progress.update(k - run.first() + 1, scans.back() - run.first() + 1);
          const auto& explanation = scan.detection.explanation;
          if (!explanation || !explanation->points_recorded) return;
          out.blocks[k] = encode_explanation(*explanation);
          out.header = explanation_header(run.parameters().detector.voting, explanation->limits);
        });
  } catch (const Error& error) {
    say("mapless: the page explains no point: {}\n", error.what());
    return {};
  }
  progress.clear();
  return out;
}

int write(const ViewOptions& options, const LabelledDrive& drive, const DriveEncoder& encoder,
          const PageTitle& title) {
  const ExplainedDrive explained = explanations_of(options, drive, encoder.scans());
  Progress progress("scans");
  const std::string page = drive_page(
      encoder, title, explained, [&](std::size_t done, std::size_t total) { progress.update(done, total); });
  progress.clear();
  write_file_atomically(options.page, page);
  fmt::print("{}: {} scans, {:.1f} MB; open it with a browser\n", options.page, encoder.scans().size(),
             static_cast<double>(page.size()) * 1e-6);
  return kSuccess;
}

HttpAnswer answer(std::string_view path, const DriveEncoder& encoder, const std::string& page) {
  if (path == "/") return {200, "text/html; charset=utf-8", page};
  // No file is named by a path: it has the number of a scan, or there is nothing.
  constexpr std::string_view kScan = "/scan/";
  std::size_t number = 0;
  const char* const end = path.data() + path.size();
  if (!path.starts_with(kScan)) return {404, {}, "There is no such page.\n"};
  const auto [rest, error] = std::from_chars(path.data() + kScan.size(), end, number);
  if (error != std::errc() || rest != end || !std::ranges::binary_search(encoder.scans(), number))
    return {404, {}, "There is no such scan.\n"};
  try {
    return {200, "application/octet-stream", served_scan(encoder, number)};
  } catch (const Error& problem) {
    return {500, {}, problem.what()};
  }
}

int serve(const ViewOptions& options, const DriveEncoder& encoder, const PageTitle& title) {
  const LoopbackServer server(options.port);
  const std::string page = served_page(encoder, title);
  const InterruptGuard guard;
  fmt::print("http://127.0.0.1:{}/ shows {} scans to a browser on this computer; Ctrl-C ends it\n",
             server.port(), encoder.scans().size());
  std::fflush(stdout);
  server.run([&](std::string_view path) { return answer(path, encoder, page); },
             [] { return InterruptGuard::requested(); });
  return kSuccess;
}

int view(const ViewOptions& options) {
  const auto dataset = options.recording.open();
  const LabelledDrive drive(*dataset, options.result);
  const DriveEncoder encoder(drive, options.range.of(drive.scans()));
  const PageTitle title{options.recording.path, options.result};
  return options.serve ? serve(options, encoder, title) : write(options, drive, encoder, title);
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
  auto* where = verb->add_option_group("where")->require_option(1);
  where->add_option("-o,--output", options->page, "HTML file to write");
  auto* serve = where->add_flag(
      "--serve", options->serve,
      "show the same page without writing it, for long drives: a browser on this computer reads "
      "scans as they are shown, from 127.0.0.1, until Ctrl-C. It explains no point");
  verb->add_option("--port", options->port, "with --serve; 0: any free port")
      ->needs(serve)
      ->capture_default_str();
  add_scan_range_options(*verb, options->range);
  verb->add_flag("--no-explanations", options->no_explanations,
                 "leave out why each point of a result of mapless detect has its label. Without the flag the "
                 "detector runs again, from the first scan of the result on, and compares the labels");
  add_trajectory_options(*verb, options->given.trajectory);
  add_motion_measurement_options(*verb, options->given.measured);
  verb->callback([options, &exit_code] { exit_code = view(*options); });
}

}  // namespace mapless::app
