#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "explain/replayed_run.hpp"
#include "options/output_file.hpp"
#include "options/recording_options.hpp"
#include "options/scan_range.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/progress.hpp"
#include "terminal/stderr.hpp"
#include "verbs/verbs.hpp"
#include "view/drive_page.hpp"
#include "view/explanation_block.hpp"
#include "view/explanation_replay.hpp"
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

bool can_explain(const ViewOptions& options, const LabelledDrive& drive) {
  return !options.no_explanations && drive.result() && fs::exists(drive.result()->summary());
}

// Runs the detector again, which takes as long as the first time. A result that cannot be computed again
// gives a page all the same.
// `problem`: why not. It is said once the page is there: what is wrong with a file keeps the page from being
// written, too, and is then the one error.
ExplainedDrive explanations_of(const ViewOptions& options, const LabelledDrive& drive,
                               const std::vector<std::size_t>& scans, std::string& problem) {
  ExplainedDrive out;
  if (!can_explain(options, drive)) return out;
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
    progress.clear();
    problem = error.what();
    return {};
  }
  progress.clear();
  return out;
}

int write(const ViewOptions& options, const LabelledDrive& drive, const DriveEncoder& encoder,
          const PageTitle& title) {
  std::string problem;
  const ExplainedDrive explained = explanations_of(options, drive, encoder.scans(), problem);
  Progress progress("scans");
  const std::string page = drive_page(
      encoder, title, explained, [&](std::size_t done, std::size_t total) { progress.update(done, total); });
  progress.clear();
  write_file_atomically(options.page, page);
  if (!problem.empty()) say("mapless: the page explains no point: {}\n", problem);
  fmt::print("{}: {} scans, {:.1f} MB; open it with a browser\n", options.page, encoder.scans().size(),
             static_cast<double>(page.size()) * 1e-6);
  return kSuccess;
}

// For the page that is served, by running the detector again once a point is clicked.
ExplanationReplay::Replay replay_of(const ViewOptions& options, const LabelledDrive& drive) {
  return [&](const ExplanationReplay::Explained& explained, const ExplanationReplay::Take& take) {
    const ReplayedRun run(drive.dataset(), *drive.result(), options.given);
    std::set<std::size_t> wanted;
    run.run(
        run.first() + run.count() - 1, [&](std::size_t k) { return explained(k) && wanted.insert(k).second; },
        [&](std::size_t k, const LabelledScan& scan) {
          if (wanted.erase(k) == 0) return;
          const auto& e = scan.detection.explanation;
          const bool known = e && e->points_recorded;
          take(k, known ? served_explanation(explanation_header(run.parameters().detector.voting, e->limits),
                                             encode_explanation(*e))
                        : "");
        });
  };
}

// What a path asks for: the page, or something of one scan. No file is named by a path.
class ServedDrive {
 public:
  ServedDrive(const DriveEncoder& encoder, std::string page, ExplanationReplay* explanations)
      : encoder_(encoder), page_(std::move(page)), explanations_(explanations) {}

  [[nodiscard]] HttpAnswer answer(std::string_view path) const {
    if (path == "/") return {200, "text/html; charset=utf-8", page_};
    try {
      if (const auto scan = number_after("/scan/", path))
        return {200, "application/octet-stream", served_scan(encoder_, *scan)};
      if (const auto scan = number_after("/explain/", path); scan && explanations_ != nullptr)
        return explanations_->answer(*scan);
    } catch (const Error& problem) {
      return {500, {}, problem.what()};
    }
    return {404, {}, "There is no such page.\n"};
  }

 private:
  // Of a scan that is served.
  [[nodiscard]] std::optional<std::size_t> number_after(std::string_view start, std::string_view path) const {
    if (!path.starts_with(start)) return std::nullopt;
    std::size_t number = 0;
    const char* const end = path.data() + path.size();
    const auto [rest, error] = std::from_chars(path.data() + start.size(), end, number);
    if (error != std::errc() || rest != end || !std::ranges::binary_search(encoder_.scans(), number))
      return std::nullopt;
    return number;
  }

  const DriveEncoder& encoder_;
  std::string page_;
  ExplanationReplay* explanations_;  // null: none
};

int serve(const ViewOptions& options, const LabelledDrive& drive, const DriveEncoder& encoder,
          const PageTitle& title) {
  const LoopbackServer server(options.port);
  const bool explained = can_explain(options, drive);
  ExplanationReplay explanations(replay_of(options, drive));
  const ServedDrive served(encoder, served_page(encoder, title, explained),
                           explained ? &explanations : nullptr);
  const InterruptGuard guard;
  fmt::print("http://127.0.0.1:{}/ shows {} scans to a browser on this computer; Ctrl-C ends it\n",
             server.port(), encoder.scans().size());
  std::fflush(stdout);
  server.run([&](std::string_view path) { return served.answer(path); },
             [] { return InterruptGuard::requested(); });
  return kSuccess;
}

int view(const ViewOptions& options) {
  require_not_input(options.page, options.recording.path, options.result);
  const auto dataset = options.recording.open();
  const LabelledDrive drive(*dataset, options.result);
  const DriveEncoder encoder(drive, options.range.of(drive.scans()));
  const PageTitle title{options.recording.path, options.result};
  return options.serve ? serve(options, drive, encoder, title) : write(options, drive, encoder, title);
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
      "scans as they are shown, from 127.0.0.1, until Ctrl-C. A point is explained once the detector has "
      "run again up to its scan");
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
