#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <set>
#include <string>

#include "benchmark/plan.hpp"

namespace mapless::app {

/// Recordings of simulated scenes in a folder, each made once: <key.name()> with manifest.json in it. A
/// recording is written under another name and renamed when complete.
class RecordingStore {
 public:
  explicit RecordingStore(std::filesystem::path folder) : folder_(std::move(folder)) {}

  [[nodiscard]] std::filesystem::path path(const RecordingKey& key) const { return folder_ / key.name(); }

  /// Number of scans in a recording of this key. Throws ParameterError if it is 0 or too large.
  [[nodiscard]] static std::size_t scans(const RecordingKey& key);

  /// Whether there is one of this key that the simulator would make the same today: its first and last scan
  /// and the trajectory are made again and compared by digest. Throws OutputError for a folder of that name
  /// without a manifest, which the store did not make.
  [[nodiscard]] bool has(const RecordingKey& key) const;

  /// Makes it; `scan_done` after every scan. False, and nothing left behind, where interrupted. Throws
  /// OutputError where the disk does not take it. Replaces one of this store that is out of date.
  bool make(const RecordingKey& key, const std::function<void()>& scan_done) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace mapless::app
