#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <memory>
#include <thread>

#include "run/bounded_queue.hpp"
#include "run/busy_time.hpp"
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::app {

/// A scan as the detector takes it.
struct InputScan {
  std::shared_ptr<const LidarScan> scan;
  bool was_compensated = false;  ///< in the recording; undone in `scan`
};

/// Reads scans ahead on a thread of its own; at most two wait to be taken.
class ScanReader {
 public:
  using Read = std::function<InputScan(std::size_t scan)>;

  /// Calls `read` for scan `first` and those after it.
  ScanReader(Read read, std::size_t first, std::size_t count);
  /// Finishes reading the current scan.
  ~ScanReader();
  ScanReader(const ScanReader&) = delete;
  ScanReader& operator=(const ScanReader&) = delete;

  /// Scan k, after the one taken before; the scans between them are skipped, with the exceptions of reading
  /// them. Throws what reading k threw.
  [[nodiscard]] InputScan take(std::size_t k);
  /// True where `take` of the next scan returns at once.
  [[nodiscard]] bool is_ready() const { return !queue_.empty(); }
  /// Stops reading. Returns once the current scan is read.
  void stop();
  /// How long reading took; once stopped.
  [[nodiscard]] const BusyTime& busy() const { return busy_; }

 private:
  struct Item {
    std::size_t k = 0;
    InputScan input;
    std::exception_ptr error;
  };
  void run(std::size_t first, std::size_t count);
  [[nodiscard]] Item read(std::size_t k);

  Read read_;
  BoundedQueue<Item> queue_;
  std::atomic<std::size_t> wanted_;  // no scan before this one is taken any more
  BusyTime busy_;                    // of the thread, until it is joined
  std::thread thread_;
};

}  // namespace mapless::app
