#include "io/formats/pcd/pcd_folder_dataset.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "io/files/text.hpp"
#include "io/formats/pcd/pcd_fields.hpp"
#include "io/tables/scan_times.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/labels.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;

bool is_numbered(const fs::path& file) {
  return file.stem().string().find_first_not_of("0123456789") == std::string::npos;
}

// The number in a name of digits as what orders it: its length without leading zeros, and its digits.
std::pair<std::size_t, std::string> number_of(const fs::path& file) {
  std::string digits = file.stem().string();
  digits.erase(0, digits.find_first_not_of('0'));
  return {digits.size(), digits};
}

std::vector<fs::path> pcd_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".pcd" && entry.is_regular_file()) files.push_back(entry.path());
  }
  const bool numbered = std::all_of(files.begin(), files.end(), is_numbered);
  std::sort(files.begin(), files.end(), [numbered](const fs::path& a, const fs::path& b) {
    return numbered && number_of(a) != number_of(b) ? number_of(a) < number_of(b) : a < b;
  });
  return files;
}

// A Unix time in nanoseconds has 18 or 19 digits, one in seconds at most 10, with or without decimals.
std::optional<Time> time_of_name(const fs::path& file) {
  const std::string name = file.stem().string();
  const bool whole = name.find('.') == std::string::npos;
  if (whole && (name.size() == 18 || name.size() == 19)) {
    const auto ns = parse_integer(name);
    return ns ? std::optional(Time::from_nanoseconds(*ns)) : std::nullopt;
  }
  // Shorter names are numbers of scans.
  const bool seconds =
      name.find_first_not_of("0123456789.") == std::string::npos && (!whole || name.size() == 10);
  return seconds ? parse_decimal_seconds(name) : std::nullopt;
}

std::optional<std::vector<Time>> times_of_names(const std::vector<fs::path>& files) {
  std::vector<Time> times;
  for (const fs::path& file : files) {
    const std::optional<Time> time = time_of_name(file);
    if (!time) return std::nullopt;
    times.push_back(*time);
  }
  return times;
}

std::vector<Time> times_of_points(const std::vector<fs::path>& files) {
  std::vector<Time> times;
  for (const fs::path& file : files) {
    const std::optional<Time> first = first_time(read_pcd(file));
    if (!first) {
      throw InputError({file.string(), "start", "", "the scan has no time",
                        "put a times.txt beside the scans, with the start of one scan in seconds per line"});
    }
    times.push_back(*first);
  }
  return times;
}

void require_increasing(const std::vector<Time>& times, const std::vector<fs::path>& files) {
  for (std::size_t k = 1; k < times.size(); ++k) {
    if (times[k] > times[k - 1]) continue;
    throw InputError({files[k].string(), "start", fmt::format("{} ns", times[k].nanoseconds()),
                      fmt::format("not after the scan before it ({} ns)", times[k - 1].nanoseconds()),
                      "put the scans in order, or give their starts in times.txt"});
  }
}

class PcdFolder final : public CloudSource {
 public:
  PcdFolder(fs::path folder, const DatasetOptions& options)
      : folder_(std::move(folder)), files_(pcd_files(folder_)) {
    if (files_.empty()) {
      throw InputError({folder_.string(), "scans", "0", "no *.pcd in it", "give the folder of the scans"});
    }
    find_times();
    labels_ = options.labels.empty() ? folder_ / "labels" : options.labels;
    if (!options.labels.empty() && !fs::is_directory(labels_)) {
      throw InputError(
          {labels_.string(), "labels", "", "not a folder", "give the folder of the label files"});
    }
  }

  [[nodiscard]] std::string format() const override { return "pcd"; }
  [[nodiscard]] fs::path path() const override { return folder_; }
  [[nodiscard]] const std::vector<Time>& starts() const override { return starts_; }
  [[nodiscard]] fs::path scan_file(std::size_t k) const override { return files_[k]; }
  [[nodiscard]] std::vector<std::string> notes() const override {
    return {times_note_,
            "points are taken as measured, not motion-compensated: PCD files do not define this"};
  }

  [[nodiscard]] Cloud read(std::size_t k) const override {
    auto cloud = std::make_shared<const PcdCloud>(read_pcd(files_[k]));
    const PointFields fields = fields_of(*cloud);
    return {fields, std::move(cloud), starts_[k], std::nullopt};
  }

  [[nodiscard]] std::optional<std::vector<std::uint32_t>> read_labels(std::size_t k) const override {
    const fs::path file = labels_ / files_[k].filename().replace_extension(".label");
    if (!fs::exists(file)) return std::nullopt;
    return read_label_file(file, read_pcd(files_[k]).size());
  }

 private:
  void find_times() {
    if (fs::exists(folder_ / "times.txt")) {
      starts_ = read_scan_times(folder_ / "times.txt", files_.size());
      times_note_ = "times: of each scan from times.txt";
    } else if (auto times = times_of_names(files_)) {
      starts_ = std::move(*times);
      times_note_ = "times: of each scan from the names of the files, as Unix times of its start";
    } else {
      starts_ = times_of_points(files_);
      times_note_ = "times: of each scan from its earliest point";
    }
    require_increasing(starts_, files_);
  }

  fs::path folder_;
  std::vector<fs::path> files_;
  fs::path labels_;
  std::vector<Time> starts_;
  std::string times_note_;
};

}  // namespace

bool looks_pcd_folder(const fs::path& path) {
  return !fs::exists(path / "sensor.yaml") && !pcd_files(path).empty();
}

std::unique_ptr<Dataset> open_pcd_folder(const fs::path& path, const DatasetOptions& options) {
  return make_cloud_dataset(std::make_shared<const PcdFolder>(path, options), options.sensor);
}

}  // namespace mapless
