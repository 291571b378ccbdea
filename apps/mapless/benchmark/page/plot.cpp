#include "benchmark/page/plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "reports/json_text.hpp"

namespace mapless::app {
namespace {

constexpr double kLeft = 56, kRight = 216, kTop = 64, kBottom = 48;  // margins [px]
constexpr double kTextSize = 13, kTitleSize = 16, kDash = 6;         // [px]
constexpr int kPixelsPerUnit = 2;
constexpr Color kInk{34, 38, 46}, kFaint{107, 114, 128}, kGrid{226, 229, 234};
// Colours that colour-blind people tell apart (Okabe and Ito 2008), a little darker where they are light.
constexpr std::array<Color, 8> kPalette = {{{0, 114, 178},
                                            {213, 94, 0},
                                            {0, 158, 115},
                                            {204, 121, 167},
                                            {200, 140, 0},
                                            {66, 160, 213},
                                            {110, 110, 110},
                                            {150, 80, 40}}};

Color color_of(const PlotLine& line) { return kPalette.at(line.color % kPalette.size()); }

std::string hex(Color c) {
  return fmt::format("#{:02x}{:02x}{:02x}", std::lround(c.red), std::lround(c.green), std::lround(c.blue));
}

bool inside(const Axis& axis, double value) { return value >= axis.from - 1e-9 && value <= axis.to + 1e-9; }

std::vector<double> ticks(const Axis& axis) {
  std::vector<double> out;
  const auto count = static_cast<int>(std::floor((axis.to - axis.from) / axis.step + 1e-6));
  for (int i = 0; i <= count; ++i) out.push_back(axis.from + i * axis.step);
  return out;
}

// Without the points beyond the axes.
PlotLine shown(const Plot& plot, const PlotLine& line) {
  PlotLine out{line.name, {}, {}, line.color, line.dashed};
  for (std::size_t i = 0; i < line.points.size(); ++i) {
    if (!inside(plot.x, line.points[i].first) || !inside(plot.y, line.points[i].second)) continue;
    out.points.push_back(line.points[i]);
    if (i < line.point_names.size()) out.point_names.push_back(line.point_names[i]);
  }
  return out;
}

void draw_axes(const Plot& plot, Canvas& canvas) {
  for (const double x : ticks(plot.x)) {
    const auto [px, bottom] = plot.pixel(x, plot.y.from);
    canvas.line(px, kTop, px, bottom, 1, kGrid);
    canvas.text(px, bottom + 14, fmt::format("{:.4g}", x), kTextSize, kFaint, Anchor::middle);
  }
  for (const double y : ticks(plot.y)) {
    const auto [left, py] = plot.pixel(plot.x.from, y);
    canvas.line(left, py, Plot::kWidth - kRight, py, 1, kGrid);
    canvas.text(left - 8, py, fmt::format("{:.4g}", y), kTextSize, kFaint, Anchor::right);
  }
  const auto [left, bottom] = plot.pixel(plot.x.from, plot.y.from);
  canvas.line(left, bottom, Plot::kWidth - kRight, bottom, 1.4, kFaint);
  canvas.line(left, kTop, left, bottom, 1.4, kFaint);
  canvas.text((left + Plot::kWidth - kRight) / 2, bottom + 34, plot.x.name, kTextSize, kInk, Anchor::middle);
  canvas.text(12, kTop - 18, plot.y.name, kTextSize, kInk);
  canvas.text(12, 18, plot.title, kTitleSize, kInk);
}

void draw_line(const Plot& plot, const PlotLine& line, Canvas& canvas) {
  const Color color = color_of(line);
  for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
    const auto [x1, y1] = plot.pixel(line.points[i].first, line.points[i].second);
    const auto [x2, y2] = plot.pixel(line.points[i + 1].first, line.points[i + 1].second);
    canvas.line(x1, y1, x2, y2, 2, color, line.dashed ? kDash : 0);
  }
  for (std::size_t i = 0; i < line.points.size(); ++i) {
    const auto [x, y] = plot.pixel(line.points[i].first, line.points[i].second);
    canvas.disc(x, y, line.dashed ? 2.2 : 3.2, color);
    if (i < line.point_names.size()) canvas.text(x + 7, y - 9, line.point_names[i], kTextSize, color);
  }
}

void draw_legend(const std::vector<PlotLine>& lines, Canvas& canvas) {
  double y = kTop + 8;
  const double x = Plot::kWidth - kRight + 18;
  for (const PlotLine& line : lines) {
    canvas.line(x, y, x + 24, y, 2, color_of(line), line.dashed ? kDash : 0);
    canvas.text(x + 32, y, line.name, kTextSize, kInk);
    y += 22;
  }
}

Json axis_json(const Axis& axis) {
  return {{"name", axis.name}, {"from", axis.from}, {"to", axis.to}, {"step", axis.step}};
}

}  // namespace

std::pair<double, double> Plot::pixel(double x_value, double y_value) const {
  const double width = kWidth - kLeft - kRight, height = kHeight - kTop - kBottom;
  return {kLeft + width * (x_value - x.from) / (x.to - x.from),
          kTop + height * (1 - (y_value - y.from) / (y.to - y.from))};
}

std::string Plot::figure() const {
  Json json = {{"title", title}, {"x", axis_json(x)}, {"y", axis_json(y)}, {"lines", Json::array()}};
  for (const PlotLine& whole : lines) {
    const PlotLine line = shown(*this, whole);
    json["lines"].push_back({{"name", line.name},
                             {"colour", hex(color_of(line))},
                             {"dashed", line.dashed},
                             {"points", line.points},
                             {"names", line.point_names}});
  }
  return "<figure class=\"plot\"><script type=\"application/json\">" + json_for_script(json) +
         "</script></figure>\n";
}

Canvas Plot::png() const {
  Canvas canvas(kWidth, kHeight, {255, 255, 255}, kPixelsPerUnit);
  draw_axes(*this, canvas);
  for (const PlotLine& line : lines) draw_line(*this, shown(*this, line), canvas);
  draw_legend(lines, canvas);
  return canvas;
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
