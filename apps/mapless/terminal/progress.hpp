#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace mapless::app {

/// How far a long piece of work is, on stderr: a bar with rate and time left on a terminal, elsewhere a plain
/// line at the first step and then about every tenth of the work.
class Progress {
 public:
  /// `what` is the unit of the work: "scans".
  explicit Progress(std::string what);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(std::size_t done, std::size_t total);
  /// Removes the bar, so that something else can be printed.
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
