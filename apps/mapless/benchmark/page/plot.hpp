#pragma once

#include <string>
#include <utility>
#include <vector>

#include "benchmark/page/drawing.hpp"

namespace mapless::app {

struct PlotLine {
  std::string name;
  std::vector<std::pair<double, double>> points;  ///< x, y
  std::vector<std::string> point_names;           ///< none, or one per point, printed beside it
  std::size_t color = 0;                          ///< index into a short palette, modulo its size
  bool dashed = false;
};

struct Axis {
  std::string name;
  double from = 0, to = 1, step = 0.2;  ///< of the ticks
};

/// A line plot, its legend to the right.
struct Plot {
  std::string title;
  Axis x, y;
  std::vector<PlotLine> lines;

  static constexpr int kWidth = 760, kHeight = 400;  // [px]

  void draw(Drawing& drawing) const;
  [[nodiscard]] std::string svg() const;
  [[nodiscard]] Canvas png() const;
  /// Position in the drawing [px] of a point of the plot.
  [[nodiscard]] std::pair<double, double> pixel(double x_value, double y_value) const;
};

/// An axis from 0 to at least `largest`, with ticks at round steps.
[[nodiscard]] Axis axis_from_zero(std::string name, double largest);

}  // namespace mapless::app
