#include "detection/published/box_filter.hpp"

#include <cstddef>

#include "lidar/aligned_image.hpp"

namespace mapless::inline v1 {
namespace {

// The window 0000 / 1111 / 0000 of paper step 4.
constexpr int kWindowRows = 3;
constexpr int kWindowColumns = 4;

// Dynamic pixels of the scan image, in raw or aligned columns.
class DynamicImage {
 public:
  DynamicImage(const LidarScan& scan, const std::vector<char>& dynamic, ImageAlignment alignment)
      : scan_(scan), image_(scan), alignment_(alignment) {
    pixels_.assign(static_cast<std::size_t>(scan.rows() * scan.columns), 0);
    for (std::size_t i = 0; i < dynamic.size(); ++i) {
      if (dynamic[i]) pixels_[pixel_of(scan.returns[i])] = 1;
    }
  }

  [[nodiscard]] std::size_t pixel_of(const LidarReturn& r) const {
    return index(r.laser,
                 alignment_ == ImageAlignment::raw ? r.column : image_.aligned_column(r.laser, r.column));
  }

  [[nodiscard]] std::size_t index(int row, int column) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(scan_.columns) +
           static_cast<std::size_t>(column);
  }

  [[nodiscard]] bool at(int row, int column) const {
    return row >= 0 && row < scan_.rows() && pixels_[index(row, wrap(column))];
  }

  [[nodiscard]] int wrap(int column) const {
    return column < scan_.columns ? column : column - scan_.columns;
  }

 private:
  const LidarScan& scan_;
  AlignedImage image_;
  ImageAlignment alignment_;
  std::vector<char> pixels_;
};

// Pixels of the window with its middle row at `row`, first column `column`, that agree with 0000 / 1111 /
// 0000.
int score(const DynamicImage& image, int row, int column) {
  int agreeing = 0;
  for (int r = 0; r < kWindowRows; ++r) {
    const bool expected = r == kWindowRows / 2;
    for (int c = 0; c < kWindowColumns; ++c) {
      agreeing += image.at(row - kWindowRows / 2 + r, column + c) == expected;
    }
  }
  return agreeing;
}

}  // namespace

std::vector<FilterVerdict> filter_boxes(const LidarScan& scan, const std::vector<char>& dynamic,
                                        const BoxFilterParameters& parameters) {
  const DynamicImage image(scan, dynamic, parameters.image);
  std::vector<char> outlier(static_cast<std::size_t>(scan.rows() * scan.columns), 0);
  for (int row = 0; row < scan.rows(); ++row) {
    for (int column = 0; column < scan.columns; ++column) {
      if (score(image, row, column) <= parameters.score_threshold) continue;
      for (int c = 0; c < kWindowColumns; ++c) outlier[image.index(row, image.wrap(column + c))] = 1;
    }
  }
  std::vector<FilterVerdict> verdicts(dynamic.size(), FilterVerdict::not_evaluated);
  for (std::size_t i = 0; i < dynamic.size(); ++i) {
    if (!dynamic[i]) continue;
    verdicts[i] = outlier[image.pixel_of(scan.returns[i])] ? FilterVerdict::removed : FilterVerdict::kept;
  }
  return verdicts;
}

}  // namespace mapless
