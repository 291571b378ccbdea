#pragma once

#include <memory>
#include <vector>

/// Labels the turns of a VLP-16 that stands still.
class __attribute__((visibility("default"))) Labeller {
 public:
  /// Throws mapless::ParameterError for a speed below 0.
  explicit Labeller(double min_speed_mps);
  ~Labeller();

  /// One turn: the range [m] of laser l in column c at `ranges[l * columns() + c]`. Returns, for each turn
  /// whose labels are ready, which of its points move, in the order of its ranges.
  std::vector<std::vector<bool>> add(const std::vector<double>& ranges);
  /// The labels of the turns that are still held back.
  std::vector<std::vector<bool>> finish();

  [[nodiscard]] int lasers() const;
  [[nodiscard]] int columns() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};
