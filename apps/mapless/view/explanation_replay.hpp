#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "view/loopback_server.hpp"

namespace mapless::app {

/// Explains scans of a run while a page wants them. A thread of its own labels the run again as far as is
/// needed: it waits once it has what is wanted, goes on for a later scan, and begins anew for an earlier one.
class ExplanationReplay {
 public:
  using Explained = std::function<bool(std::size_t scan)>;
  using Take = std::function<void(std::size_t scan, std::string block)>;
  /// Labels all scans of the run in order. Calls `explained` before each of them, and later, for each of
  /// which it was true, `take`, with an empty block where there is no explanation. Called in the thread,
  /// again and again; lets what these two throw pass. Throws Error where the run cannot be repeated.
  using Replay = std::function<void(const Explained& explained, const Take& take)>;

  explicit ExplanationReplay(Replay replay) : replay_(std::move(replay)) {}
  ~ExplanationReplay();
  ExplanationReplay(const ExplanationReplay&) = delete;
  ExplanationReplay& operator=(const ExplanationReplay&) = delete;

  /// 200 with the block of the scan; 202 with a line about the progress: the scan is wanted from now on, and
  /// no other; 404 with the reason why there is none. Does not wait.
  [[nodiscard]] HttpAnswer answer(std::size_t scan);

  static constexpr std::size_t kKept = 32;  // blocks; some 0.2 MB each with 64 lasers (docs/viewer.md)

 private:
  void run();
  bool explained(std::size_t scan);
  void take(std::size_t scan, std::string block);

  Replay replay_;
  std::mutex mutex_;  // of all that follows
  std::condition_variable changed_;
  bool ending_ = false;
  std::optional<std::size_t> wanted_;  // until its block is there
  std::size_t next_ = 0;               // the scan that is labelled next
  std::set<std::size_t> marked_;       // of this replay, whose explanation is to come
  std::map<std::size_t, std::string> blocks_;
  std::string failure_;
  std::thread thread_;
};

}  // namespace mapless::app
