#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lidar/aligned_image.hpp"

namespace mapless::inline v1 {

/// Returns of a scan that are marked, as bits of the aligned image, which goes on around the turn a little: a
/// whole row of a window is read at once, and is mostly empty.
class MarkedReturns {
 public:
  static constexpr int kBeyond = 16;  ///< columns before the first and after the last

  /// Keeps references.
  MarkedReturns(const LidarScan& scan, const AlignedImage& image)
      : scan_(scan),
        image_(image),
        words_per_row_(static_cast<std::size_t>(scan.columns + 2 * kBeyond) / 64 + 2),
        words_(words_per_row_ * static_cast<std::size_t>(scan.rows()), 0) {}

  void clear() { words_.assign(words_.size(), 0); }
  /// Where two returns share a cell, it is that of the one that shows.
  void mark(std::int32_t i) {
    each_bit(i, [](std::uint64_t& word, std::uint64_t bit) { word |= bit; });
  }
  void unmark(std::int32_t i) {
    each_bit(i, [](std::uint64_t& word, std::uint64_t bit) { word &= ~bit; });
  }

  /// The marks of `count` columns, up to kBeyond, of a row from aligned column `first` on, which is in
  /// [-kBeyond, columns); that of the first is the lowest bit.
  [[nodiscard]] std::uint64_t window(int row, int first, int count) const {
    const auto at = static_cast<std::size_t>(first + kBeyond);
    const std::size_t word = static_cast<std::size_t>(row) * words_per_row_ + at / 64;
    const std::size_t shift = at % 64;
    const std::uint64_t low = words_[word] >> shift;
    const std::uint64_t high = shift == 0 ? 0 : words_[word + 1] << (64 - shift);
    return (low | high) & ((std::uint64_t{1} << count) - 1);
  }

 private:
  template <class Change>
  void each_bit(std::int32_t i, Change&& change) {
    const LidarReturn& r = scan_.returns[static_cast<std::size_t>(i)];
    if (scan_.cell(r.laser, r.column) != i) return;
    int column = image_.aligned_column(r.laser, r.column);
    while (column >= scan_.columns - kBeyond) column -= scan_.columns;
    for (; column < scan_.columns + kBeyond; column += scan_.columns) {
      if (column < -kBeyond) continue;
      const auto at = static_cast<std::size_t>(column + kBeyond);
      change(words_[static_cast<std::size_t>(r.laser) * words_per_row_ + at / 64],
             std::uint64_t{1} << (at % 64));
    }
  }

  const LidarScan& scan_;
  const AlignedImage& image_;
  std::size_t words_per_row_;
  std::vector<std::uint64_t> words_;
};

}  // namespace mapless
