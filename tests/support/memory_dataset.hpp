#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <mapless/core/errors.hpp>
#include <mapless/io/dataset.hpp>

namespace mapless::test {

/// A recording held in memory: scans of one laser, `columns` records each, a tenth of a second long, from
/// `starts`. Record i lies i + 1 metres ahead.
class MemoryDataset final : public Dataset {
 public:
  MemoryDataset(std::vector<Time> starts, int columns) : starts_(std::move(starts)) {
    model_.name = "one laser";
    model_.columns = columns;
    model_.max_range_m = 100;
    model_.lasers.resize(1);
  }

  std::map<std::size_t, std::vector<std::uint32_t>> labels;  ///< truth, by scan
  std::map<std::size_t, std::size_t> sizes;                  ///< records of scans that are not `columns` long
  std::map<std::size_t, std::size_t> missing;                ///< records without a usable point, by scan
  std::vector<std::size_t> unreadable;                       ///< scans whose reading fails
  std::shared_ptr<const Trajectory> own_trajectory;          ///< null: none
  std::optional<Duration> compensated_to;                    ///< after the start of each scan
  std::vector<std::filesystem::path> files;                  ///< of the scans, where there are any

  [[nodiscard]] std::string format() const override { return "native"; }
  [[nodiscard]] std::size_t size() const override { return starts_.size(); }
  [[nodiscard]] std::shared_ptr<const LidarModel> model() const override {
    return std::make_shared<const LidarModel>(model_);
  }
  [[nodiscard]] Time scan_start(std::size_t k) const override { return starts_.at(k); }
  [[nodiscard]] Time scan_end(std::size_t k) const override {
    return starts_.at(k) + Duration::from_nanoseconds(100'000'000);
  }
  [[nodiscard]] std::filesystem::path scan_file(std::size_t k) const override {
    return files.empty() ? std::filesystem::path("memory") : files.at(k);
  }
  [[nodiscard]] LidarScan read(std::size_t k) const override {
    for (const std::size_t bad : unreadable) {
      if (bad == k) throw InputError({scan_file(k).string(), "", "", "is broken", ""});
    }
    LidarScan scan;
    scan.model = model();
    scan.start = scan_start(k);
    scan.columns = model_.columns;
    scan.column_period = Duration::from_nanoseconds(100'000'000 / model_.columns);
    scan.time_source = Provenance::sensor;
    scan.ring_source = Provenance::recovered_from_order;
    if (compensated_to) scan.compensated_to = scan.start + *compensated_to;
    scan.input_size = sizes.count(k) != 0 ? sizes.at(k) : static_cast<std::size_t>(model_.columns);
    scan.cells.assign(static_cast<std::size_t>(model_.columns), empty_cell(ReturnCode::absent));
    const std::size_t usable = scan.input_size - (missing.count(k) != 0 ? missing.at(k) : 0);
    for (std::size_t i = 0; i < usable; ++i) {
      const auto column = static_cast<std::int32_t>(i) % model_.columns;
      const float range = static_cast<float>(i) + 1;
      scan.returns.push_back({{range, 0, 0}, range, 0, column, 0, static_cast<std::uint32_t>(i)});
      scan.cells[static_cast<std::size_t>(column)] = static_cast<std::int32_t>(i);
    }
    return scan;
  }
  [[nodiscard]] std::optional<std::vector<std::uint32_t>> read_labels(std::size_t k) const override {
    if (labels.count(k) == 0) return std::nullopt;
    return labels.at(k);
  }
  [[nodiscard]] std::shared_ptr<const Trajectory> trajectory() const override { return own_trajectory; }

 private:
  std::vector<Time> starts_;
  LidarModel model_;
};

/// Starts of `count` scans, a tenth of a second apart from time 0.
inline std::vector<Time> regular_starts(int count) {
  std::vector<Time> starts;
  for (int k = 0; k < count; ++k) starts.push_back(Time::from_nanoseconds(100'000'000LL * k));
  return starts;
}

}  // namespace mapless::test
