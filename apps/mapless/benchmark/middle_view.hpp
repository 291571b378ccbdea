#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <mapless/detection/detector.hpp>
#include <mapless/io/dataset.hpp>
#include <mapless/io/labels.hpp>

namespace mapless::app {

/// Keeps the labels of the scans in the middle of a recording, and writes them as a page of `mapless view`.
class MiddleView {
 public:
  /// `scans`: of the recording.
  explicit MiddleView(std::size_t scans);

  /// Takes the labels of one scan, if it is in the middle.
  void add(const Detection& detection);
  /// `recording` is what the page calls it. Throws InputError, OutputError.
  void write(const Dataset& dataset, const std::string& recording, const std::filesystem::path& file) const;

  static constexpr std::size_t kScans = 20;  // at most; some 0.35 MB each with 64 lasers (docs/viewer.md)

 private:
  std::size_t first_, end_;
  std::map<std::size_t, std::vector<std::uint32_t>> labels_;
  std::vector<ObjectRow> objects_;
};

}  // namespace mapless::app
