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

/// A scan as the detector gets it.
struct InputScan {
  std::shared_ptr<const LidarScan> scan;
  bool was_compensated = false;  ///< in the recording; here it is undone
};

/// Reads scans ahead of whoever takes them, on a thread of its own. At most two wait.
class ScanReader {
 public:
  using Read = std::function<InputScan(std::size_t scan)>;

  /// Calls `read` for scan `first` and those after it.
  ScanReader(Read read, std::size_t first, std::size_t count);
  /// Finishes the scan it reads, and no more.
  ~ScanReader();
  ScanReader(const ScanReader&) = delete;
  ScanReader& operator=(const ScanReader&) = delete;

  /// Scan k, which comes after the one taken before; those between them are passed over, and what reading
  /// them threw with them. Throws what reading k threw.
  [[nodiscard]] InputScan take(std::size_t k);
  /// True where `take` of the next scan returns at once.
  [[nodiscard]] bool is_ready() const { return !queue_.empty(); }
  /// Reads no more. Returns once the scan in hand is read.
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
