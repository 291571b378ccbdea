#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace mapless::app {

/// Prints the progress of a long task to stderr: on a terminal a bar with rate and remaining time, elsewhere
/// a plain line at the first step and at every tenth of the task.
class Progress {
 public:
  /// `what`: the unit of the count, such as "scans".
  explicit Progress(std::string what);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(std::size_t done, std::size_t total);
  /// Removes the bar, so that other text can be printed.
  void clear();

 private:
  void draw_bar(std::size_t done, std::size_t total) const;
  [[nodiscard]] double rate(std::size_t done) const;

  std::string what_;
  bool terminal_;
  bool drawn_ = false;
  std::size_t last_tenth_ = 0;
  std::size_t last_done_ = 0;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace mapless::app
