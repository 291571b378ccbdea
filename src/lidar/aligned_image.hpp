#pragma once

#include <vector>

#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// The scan image with every row shifted by the azimuth offset of its laser, in whole columns: neighbours in
/// the image are neighbours in space. Columns wrap.
class AlignedImage {
 public:
  explicit AlignedImage(const LidarScan& scan);

  /// Column in the aligned image, in [0, columns), of the firing `column` of `laser`.
  [[nodiscard]] int aligned_column(int laser, int column) const {
    return wrap(column + shift_[static_cast<std::size_t>(laser)]);
  }
  /// Its inverse; `aligned` may lie up to a turn outside [0, columns).
  [[nodiscard]] int scan_column(int laser, int aligned) const {
    return wrap(aligned - shift_[static_cast<std::size_t>(laser)]);
  }

 private:
  // At most a turn or two outside: repeated addition is faster than a division.
  [[nodiscard]] int wrap(int column) const {
    while (column < 0) column += columns_;
    while (column >= columns_) column -= columns_;
    return column;
  }

  int columns_;
  std::vector<int> shift_;  // of each laser
};

}  // namespace mapless
