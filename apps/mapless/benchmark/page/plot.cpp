#include "benchmark/page/plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace mapless::app {
namespace {

constexpr double kLeft = 56, kRight = 216, kTop = 64, kBottom = 48;  // margins [px]
constexpr Color kInk{34, 38, 46}, kFaint{107, 114, 128}, kGrid{226, 229, 234};
constexpr std::array<Color, 8> kPalette = {{{31, 95, 191},
                                            {214, 90, 24},
                                            {20, 134, 90},
                                            {150, 60, 160},
                                            {176, 134, 0},
                                            {196, 40, 70},
                                            {70, 130, 150},
                                            {110, 110, 110}}};

bool inside(const Axis& axis, double value) { return value >= axis.from - 1e-9 && value <= axis.to + 1e-9; }

std::vector<double> ticks(const Axis& axis) {
  std::vector<double> out;
  const auto count = static_cast<int>(std::floor((axis.to - axis.from) / axis.step + 1e-6));
  for (int i = 0; i <= count; ++i) out.push_back(axis.from + i * axis.step);
  return out;
}

void draw_axes(const Plot& plot, Drawing& drawing) {
  for (const double x : ticks(plot.x)) {
    const auto [px, bottom] = plot.pixel(x, plot.y.from);
    drawing.line(px, kTop, px, bottom, {kGrid});
    drawing.text(px, bottom + 14, fmt::format("{:.4g}", x), Anchor::middle, TextSize::normal, kFaint);
  }
  for (const double y : ticks(plot.y)) {
    const auto [left, py] = plot.pixel(plot.x.from, y);
    drawing.line(left, py, Plot::kWidth - kRight, py, {kGrid});
    drawing.text(left - 8, py, fmt::format("{:.4g}", y), Anchor::right, TextSize::normal, kFaint);
  }
  const auto [left, bottom] = plot.pixel(plot.x.from, plot.y.from);
  drawing.line(left, bottom, Plot::kWidth - kRight, bottom, {kFaint, 1.4});
  drawing.line(left, kTop, left, bottom, {kFaint, 1.4});
  drawing.text((left + Plot::kWidth - kRight) / 2, bottom + 34, plot.x.name, Anchor::middle, TextSize::normal,
               kInk);
  drawing.text(12, kTop - 18, plot.y.name, Anchor::left, TextSize::normal, kInk);
  drawing.text(12, 18, plot.title, Anchor::left, TextSize::title, kInk);
}

void draw_line(const Plot& plot, const PlotLine& line, Drawing& drawing) {
  const Color color = kPalette.at(line.color % kPalette.size());
  for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
    const auto [x1, y1] = plot.pixel(line.points[i].first, line.points[i].second);
    const auto [x2, y2] = plot.pixel(line.points[i + 1].first, line.points[i + 1].second);
    drawing.line(x1, y1, x2, y2, {color, 2, line.dashed});
  }
  for (std::size_t i = 0; i < line.points.size(); ++i) {
    const auto [x, y] = plot.pixel(line.points[i].first, line.points[i].second);
    drawing.disc(x, y, line.dashed ? 2.2 : 3.2, color);
    if (i < line.point_names.size())
      drawing.text(x + 7, y - 9, line.point_names[i], Anchor::left, TextSize::normal, color);
  }
}

void draw_legend(const std::vector<PlotLine>& lines, Drawing& drawing) {
  double y = kTop + 8;
  const double x = Plot::kWidth - kRight + 18;
  for (const PlotLine& line : lines) {
    drawing.line(x, y, x + 24, y, {kPalette.at(line.color % kPalette.size()), 2, line.dashed});
    drawing.text(x + 32, y, line.name, Anchor::left, TextSize::normal, kInk);
    y += 22;
  }
}

}  // namespace

std::pair<double, double> Plot::pixel(double x_value, double y_value) const {
  const double width = kWidth - kLeft - kRight, height = kHeight - kTop - kBottom;
  return {kLeft + width * (x_value - x.from) / (x.to - x.from),
          kTop + height * (1 - (y_value - y.from) / (y.to - y.from))};
}

void Plot::draw(Drawing& drawing) const {
  draw_axes(*this, drawing);
  for (PlotLine line : lines) {
    std::vector<std::string> names;
    std::vector<std::pair<double, double>> points;
    for (std::size_t i = 0; i < line.points.size(); ++i) {
      if (!inside(x, line.points[i].first) || !inside(y, line.points[i].second)) continue;
      points.push_back(line.points[i]);
      if (i < line.point_names.size()) names.push_back(line.point_names[i]);
    }
    line.points = std::move(points);
    line.point_names = std::move(names);
    draw_line(*this, line, drawing);
  }
  draw_legend(lines, drawing);
}

std::string Plot::svg() const {
  SvgDrawing drawing(kWidth, kHeight);
  draw(drawing);
  return drawing.svg(title);
}

Canvas Plot::png() const {
  PngDrawing drawing(kWidth, kHeight);
  draw(drawing);
  return drawing.canvas();
}

Axis axis_from_zero(std::string name, double largest) {
  const double magnitude = std::pow(10, std::floor(std::log10(std::max(largest, 1e-9))));
  for (const double step : {0.1, 0.2, 0.5, 1.0, 2.0}) {
    if (largest / (step * magnitude) > 8) continue;
    return {std::move(name), 0, std::ceil(largest / (step * magnitude) - 1e-9) * step * magnitude,
            step * magnitude};
  }
  return {std::move(name), 0, largest, largest};
}

}  // namespace mapless::app
