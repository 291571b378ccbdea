#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lidar/aligned_image.hpp"

namespace mapless::inline v1 {

/// A set of returns of a scan, as bits of the aligned image: a row of a window is read at once, and is mostly
/// empty. The first and last columns are stored twice, so that a window at the seam is contiguous.
class MarkedReturns {
 public:
  static constexpr int kWrapColumns = 16;  ///< columns repeated before the first and after the last

  /// Keeps references.
  MarkedReturns(const LidarScan& scan, const AlignedImage& image)
      : scan_(scan),
        image_(image),
        words_per_row_(static_cast<std::size_t>(scan.columns + 2 * kWrapColumns) / 64 + 2),
        words_(words_per_row_ * static_cast<std::size_t>(scan.rows()), 0) {}

  void clear() { words_.assign(words_.size(), 0); }
  /// Of two returns that share a cell only the one in the scan image can be marked.
  void mark(std::int32_t i) {
    each_bit(i, [](std::uint64_t& word, std::uint64_t bit) { word |= bit; });
  }
  void unmark(std::int32_t i) {
    each_bit(i, [](std::uint64_t& word, std::uint64_t bit) { word &= ~bit; });
  }
  void mark(std::span<const std::int32_t> returns) {
    for (const std::int32_t i : returns) mark(i);
  }
  void unmark(std::span<const std::int32_t> returns) {
    for (const std::int32_t i : returns) unmark(i);
  }

  /// The marks of `count` <= kWrapColumns columns of a row, from aligned column `first` in [-kWrapColumns,
  /// columns) on; the lowest bit is the first column.
  [[nodiscard]] std::uint64_t window(int row, int first, int count) const {
    const auto at = static_cast<std::size_t>(first + kWrapColumns);
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
    while (column >= scan_.columns - kWrapColumns) column -= scan_.columns;
    for (; column < scan_.columns + kWrapColumns; column += scan_.columns) {
      if (column < -kWrapColumns) continue;
      const auto at = static_cast<std::size_t>(column + kWrapColumns);
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
