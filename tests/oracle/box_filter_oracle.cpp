#include "oracle/box_filter_oracle.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Core>

namespace mapless::test {
namespace {

int modulo(int a, int n) { return ((a % n) + n) % n; }

/// Column of the image that shows the cell: with alignment the one that would have looked, with no azimuth
/// offset, where this one looks.
int image_column(const LidarScan& scan, int laser, int column, ImageAlignment alignment) {
  if (alignment == ImageAlignment::raw) return column;
  const LidarModel& model = *scan.model;
  const double columns_per_rad = model.sign() * model.columns / (2 * std::numbers::pi);
  const double offset = model.lasers[static_cast<std::size_t>(laser)].azimuth_offset_rad;
  return modulo(column + static_cast<int>(std::lround(offset * columns_per_rad)), scan.columns);
}

}  // namespace

std::vector<char> outliers_by_window(const LidarScan& scan, const std::vector<char>& dynamic,
                                     const BoxFilterParameters& parameters) {
  constexpr int kPattern[3][4] = {{0, 0, 0, 0}, {1, 1, 1, 1}, {0, 0, 0, 0}};
  // One row of zeros above and below; the window's columns wrap.
  Eigen::MatrixXi image = Eigen::MatrixXi::Zero(scan.rows() + 2, scan.columns);
  Eigen::MatrixXi outlier = image;
  for (std::size_t i = 0; i < scan.returns.size(); ++i) {
    const LidarReturn& r = scan.returns[i];
    image(r.laser + 1, image_column(scan, r.laser, r.column, parameters.image)) = dynamic[i] ? 1 : 0;
  }
  for (int row = 0; row < scan.rows(); ++row) {
    for (int column = 0; column < scan.columns; ++column) {
      int score = 0;
      for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 4; ++x)
          score += image(row + y, modulo(column + x, scan.columns)) == kPattern[y][x] ? 1 : 0;
      if (score <= parameters.score_threshold) continue;
      for (int x = 0; x < 4; ++x) outlier(row + 1, modulo(column + x, scan.columns)) = 1;
    }
  }
  std::vector<char> answer(scan.returns.size(), 0);
  for (std::size_t i = 0; i < answer.size(); ++i) {
    const LidarReturn& r = scan.returns[i];
    const int column = image_column(scan, r.laser, r.column, parameters.image);
    answer[i] = dynamic[i] && outlier(r.laser + 1, column) != 0 ? 1 : 0;
  }
  return answer;
}

}  // namespace mapless::test
