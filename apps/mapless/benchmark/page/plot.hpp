#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pictures/canvas.hpp"

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

/// A line plot, its legend to the right. Points beyond the axes are left out.
struct Plot {
  std::string title;
  Axis x, y;
  std::vector<PlotLine> lines;

  static constexpr int kWidth = 760, kHeight = 400;  // [px]

  /// An element of the page, with the numbers in it, which plots_html() draws there.
  [[nodiscard]] std::string figure() const;
  /// The same plot as a picture, of two by two pixels for each pixel of the sizes above.
  [[nodiscard]] Canvas png() const;
  /// Position in the picture [px of the sizes above] of a point of the plot.
  [[nodiscard]] std::pair<double, double> pixel(double x_value, double y_value) const;
};

/// What draws the figures of a page, once, at its end: uPlot in a script, and its style. Built from viewer/.
[[nodiscard]] std::string_view plots_html();

/// An axis from 0 to at least `largest`, with ticks at round steps.
[[nodiscard]] Axis axis_from_zero(std::string name, double largest);

}  // namespace mapless::app
