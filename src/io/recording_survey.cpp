#include <algorithm>
#include <filesystem>
#include <map>
#include <string_view>

#include <fmt/format.h>

#include "core/median.hpp"
#include "lidar/self_check/scan_checks.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>

namespace mapless::inline v1 {
namespace {

// A period between scans beyond this many median periods is a gap: one missing scan gives 2, jitter less
// than 1.5.
constexpr double kGapPeriods = 1.5;
// Bare clouds vary in size with the scene. A size that differs from the median by more than this factor is
// reported.
constexpr double kSizeFactor = 2.0;

struct ScanSizes {
  std::vector<std::size_t> number, records, returns;  // of the readable scans
  std::size_t with_unusable = 0;                      // scans that have unusable records
};

void count_cells(const LidarScan& scan, RecordingSurvey& survey) {
  std::size_t faulty = 0, nothing = 0;
  for (const std::int32_t cell : scan.cells) {
    const ReturnCode code = code_of_cell(cell);
    if (code == ReturnCode::faulty) ++faulty;
    if (code == ReturnCode::nothing) ++nothing;
  }
  survey.faulty += faulty;
  survey.nothing += nothing;
  const std::size_t explained = scan.returns.size() + faulty + nothing;
  if (scan.input_size > explained) survey.unusable += scan.input_size - explained;
}

void survey_scan(const LidarScan& scan, std::size_t k, RecordingSurvey& survey, ScanSizes& sizes) {
  if (survey.readable_scans++ == 0) {
    survey.time_source = scan.time_source;
    survey.ring_source = scan.ring_source;
  }
  if (scan.compensated_to && !survey.compensated) {
    survey.compensated = true;
    const double length = (scan.end() - scan.start).seconds();
    if (length > 0) survey.compensated_to_fraction = (*scan.compensated_to - scan.start).seconds() / length;
  }
  survey.records += scan.input_size;
  survey.returns += scan.returns.size();
  sizes.number.push_back(k);
  sizes.records.push_back(scan.input_size);
  sizes.returns.push_back(scan.returns.size());
  const std::size_t unusable_before = survey.unusable;
  count_cells(scan, survey);
  if (survey.unusable > unusable_before) ++sizes.with_unusable;
}

void survey_labels(const Dataset& dataset, std::size_t k, RecordingSurvey& survey) {
  const auto labels = dataset.read_labels(k);
  if (!labels) return;
  ++survey.labelled_scans;
  for (const std::uint32_t label : *labels) {
    switch (motion_of_label(label)) {
      case MotionTruth::moving:
        ++survey.moving_points;
        break;
      case MotionTruth::still:
        ++survey.still_points;
        break;
      case MotionTruth::unknown:
        ++survey.unknown_points;
        break;
    }
  }
}

void survey_times(const Dataset& dataset, RecordingSurvey& survey) {
  if (survey.scans == 0) return;
  survey.begin = dataset.scan_start(0);
  survey.end = dataset.scan_end(survey.scans - 1);
  std::vector<std::int64_t> periods;
  for (std::size_t k = 1; k < survey.scans; ++k) {
    periods.push_back((dataset.scan_start(k) - dataset.scan_start(k - 1)).nanoseconds());
  }
  if (periods.empty()) return;
  std::vector<std::int64_t> sorted = periods;
  std::sort(sorted.begin(), sorted.end());
  survey.median_period_s = Duration::from_nanoseconds(sorted[sorted.size() / 2]).seconds();
  for (std::size_t k = 1; k < survey.scans; ++k) {
    const double period = Duration::from_nanoseconds(periods[k - 1]).seconds();
    if (period < 0) {
      survey.oddities.push_back(fmt::format("scan {}: starts {:.6f} s before scan {}", k, -period, k - 1));
    } else if (period == 0) {
      survey.oddities.push_back(fmt::format("scan {}: the same time as scan {}", k, k - 1));
    } else if (period > kGapPeriods * survey.median_period_s) {
      survey.oddities.push_back(
          fmt::format("scan {}: a gap of {:.3f} s after scan {}, where {:.3f} s is usual", k, period, k - 1,
                      survey.median_period_s));
    }
  }
}

bool far_from(std::size_t value, std::size_t usual) {
  const auto v = static_cast<double>(value), u = static_cast<double>(usual);
  return v * kSizeFactor < u || v > kSizeFactor * u;
}

void find_odd_sizes(const ScanSizes& sizes, RecordingSurvey& survey) {
  if (sizes.number.empty()) return;
  survey.median_returns = median(sizes.returns);
  const auto [min, max] = std::minmax_element(sizes.returns.begin(), sizes.returns.end());
  survey.min_returns = *min;
  survey.max_returns = *max;
  const std::size_t usual = median(sizes.records);
  const auto alike = std::count(sizes.records.begin(), sizes.records.end(), usual);
  const bool fixed_size = 2 * static_cast<std::size_t>(alike) > sizes.records.size();
  for (std::size_t i = 0; i < sizes.number.size(); ++i) {
    const std::size_t records = sizes.records[i], returns = sizes.returns[i];
    if (fixed_size ? records != usual : far_from(records, usual)) {
      survey.oddities.push_back(
          fmt::format("scan {}: {} records, where {} is usual", sizes.number[i], records, usual));
    } else if (returns == 0) {
      survey.oddities.push_back(
          fmt::format("scan {}: not one usable point among {} records", sizes.number[i], records));
    } else if (far_from(returns, survey.median_returns)) {
      survey.oddities.push_back(fmt::format("scan {}: {} usable points, where {} is usual", sizes.number[i],
                                            returns, survey.median_returns));
    }
  }
}

void find_unusable_records(const ScanSizes& sizes, RecordingSurvey& survey) {
  if (sizes.with_unusable == 0) return;
  survey.oddities.push_back(fmt::format(
      "{} scans: {} records are no usable points (NaN, infinite, in the sensor itself, or farther returns "
      "of a ray)",
      sizes.with_unusable, survey.unusable));
}

class DuplicateFinder {
 public:
  void add(const Dataset& dataset, std::size_t k, std::vector<std::string>& oddities) {
    // Scans of one file cannot be compared by their files: all have its name, or that of a message within it.
    if (dataset.size() > 1 && dataset.scan_file(0) == dataset.scan_file(1)) return;
    if (!std::filesystem::is_regular_file(dataset.scan_file(k))) return;
    const std::size_t hash = std::hash<std::string>()(read_whole_file(dataset.scan_file(k)));
    const auto [earlier, is_new] = by_hash_.emplace(hash, k);
    if (is_new ||
        read_whole_file(dataset.scan_file(k)) != read_whole_file(dataset.scan_file(earlier->second))) {
      return;
    }
    oddities.push_back(fmt::format("scan {}: the same bytes as scan {}", k, earlier->second));
  }

 private:
  std::map<std::size_t, std::size_t> by_hash_;
};

}  // namespace

RecordingSurvey survey_recording(const Dataset& dataset,
                                 const std::function<void(std::size_t, std::size_t)>& progress) {
  RecordingSurvey survey;
  survey.scans = dataset.size();
  ScanSizes sizes;
  DuplicateFinder duplicates;
  ScanChecks points;
  for (std::size_t k = 0; k < survey.scans; ++k) {
    try {
      const LidarScan scan = dataset.read(k);
      survey_scan(scan, k, survey, sizes);
      points.add(scan, k, nullptr);
      duplicates.add(dataset, k, survey.oddities);
    } catch (const InputError& error) {
      survey.oddities.push_back(fmt::format("scan {}: {}", k, error.what()));
    }
    try {
      survey_labels(dataset, k, survey);
    } catch (const InputError& error) {
      survey.oddities.push_back(fmt::format("labels of scan {}: {}", k, error.what()));
    }
    if (progress) progress(k + 1, survey.scans);
  }
  survey_times(dataset, survey);
  find_odd_sizes(sizes, survey);
  find_unusable_records(sizes, survey);
  const std::vector<std::string> odd = points.lines();
  survey.oddities.insert(survey.oddities.end(), odd.begin(), odd.end());
  return survey;
}

}  // namespace mapless
