#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "reports/json.hpp"

namespace mapless::app {

/// The folder of a benchmark:
///
///     index.html       the page, with all its pictures in it; its drives in 3D are in views/
///     benchmark.json   all figures; begins as kBenchmarkBegin
///     plots/*.png      the page's plots
///     pictures/*.png   views of movers
///     views/*.html     drives in 3D (MiddleView)
///     rows/*.json      one finished run each: its job and its result
///     recordings/      RecordingStore, unless elsewhere
///
/// A finished run is reused if the same program made it for the same job.
class BenchmarkFolder {
 public:
  /// `build` identifies the program (build_digest).
  BenchmarkFolder(std::filesystem::path path, std::string build)
      : path_(std::move(path)), build_(std::move(build)) {}

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path pictures() const { return path_ / "pictures"; }
  [[nodiscard]] std::filesystem::path plots() const { return path_ / "plots"; }
  [[nodiscard]] std::filesystem::path views() const { return path_ / "views"; }
  [[nodiscard]] std::filesystem::path recordings() const { return path_ / "recordings"; }
  [[nodiscard]] std::filesystem::path page() const { return path_ / "index.html"; }
  [[nodiscard]] std::filesystem::path figures() const { return path_ / "benchmark.json"; }

  /// Makes the folder; an earlier benchmark is continued. Throws OutputError, and changes nothing, if it is a
  /// file, cannot be made, or holds anything but a benchmark.
  void open() const;

  /// The result of a finished run; absent if the run, one of its pictures or its drive in 3D is missing.
  /// `stem` names its file; `job` has all settings that determine its figures.
  [[nodiscard]] std::optional<Json> finished(const std::string& stem, const Json& job) const;
  void finish(const std::string& stem, const Json& job, const Json& result) const;

 private:
  [[nodiscard]] std::filesystem::path row_file(const std::string& stem) const;
  [[nodiscard]] Json row_head(const Json& job) const;

  std::filesystem::path path_;
  std::string build_;
};

/// benchmark.json begins with this, which identifies the folder as one of a benchmark.
inline constexpr std::string_view kBenchmarkName = "mapless benchmark";
inline constexpr std::string_view kBenchmarkBegin = "{\n  \"program\": \"mapless benchmark\"";

/// A digest of the file of the running program: figures of another build are not reused.
[[nodiscard]] std::string build_digest();

}  // namespace mapless::app
