#include "benchmark/page/drawing.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "benchmark/page/html.hpp"

namespace mapless::app {
namespace {

constexpr float kScale = 2;  // pixels of the file per pixel of the drawing
constexpr double kDash = 6;  // [px] of the drawing

std::string hex(Color c) {
  return fmt::format("#{:02x}{:02x}{:02x}", std::lround(c.red), std::lround(c.green), std::lround(c.blue));
}

float scaled(double pixels) { return static_cast<float>(pixels) * kScale; }

}  // namespace

void SvgDrawing::line(double x1, double y1, double x2, double y2, const LineStyle& style) {
  body_ += fmt::format(
      R"(<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" stroke="{}" stroke-width="{:.2g}")", x1, y1,
      x2, y2, hex(style.color), style.width);
  if (style.dashed) body_ += fmt::format(R"( stroke-dasharray="{0} {0}")", kDash);
  if (style.opacity < 1) body_ += fmt::format(R"( stroke-opacity="{:.2g}")", style.opacity);
  body_ += R"( stroke-linecap="round"/>)"
           "\n";
}

void SvgDrawing::disc(double x, double y, double radius, Color color) {
  body_ += fmt::format(R"(<circle cx="{:.1f}" cy="{:.1f}" r="{:.1f}" fill="{}"/>)"
                       "\n",
                       x, y, radius, hex(color));
}

void SvgDrawing::text(double x, double y, std::string_view text, Anchor anchor, TextSize size, Color color) {
  const char* const name = anchor == Anchor::left ? "start" : anchor == Anchor::middle ? "middle" : "end";
  body_ += fmt::format(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="{}" font-size="{}" fill="{}"{}>{}</text>)"
                       "\n",
                       x, y + 4.5, name, size == TextSize::title ? 16 : 13, hex(color),
                       size == TextSize::title ? R"( font-weight="600")" : "", escaped(text));
}

std::string SvgDrawing::svg(std::string_view title) const {
  return fmt::format(
      R"(<svg viewBox="0 0 {} {}" role="img" xmlns="http://www.w3.org/2000/svg"><title>{}</title>)"
      "\n{}</svg>\n",
      width_, height_, escaped(title), body_);
}

PngDrawing::PngDrawing(int width, int height)
    : canvas_(static_cast<int>(kScale) * width, static_cast<int>(kScale) * height, {255, 255, 255}) {}

void PngDrawing::line(double x1, double y1, double x2, double y2, const LineStyle& style) {
  const auto piece = [&](double from, double to) {
    canvas_.line(scaled(x1 + from * (x2 - x1)), scaled(y1 + from * (y2 - y1)), scaled(x1 + to * (x2 - x1)),
                 scaled(y1 + to * (y2 - y1)), scaled(style.width), style.color,
                 static_cast<float>(style.opacity));
  };
  const double length = std::hypot(x2 - x1, y2 - y1);
  if (!style.dashed || length == 0) return piece(0, 1);
  for (double at = 0; at < length; at += 2 * kDash) piece(at / length, std::min(1.0, (at + kDash) / length));
}

void PngDrawing::disc(double x, double y, double radius, Color color) {
  canvas_.disc(scaled(x), scaled(y), scaled(radius), color);
}

void PngDrawing::text(double x, double y, std::string_view text, Anchor anchor, TextSize size, Color color) {
  const int dots = size == TextSize::title ? 3 : 2;
  const int width = Canvas::text_width(text, dots);
  const int shift = anchor == Anchor::left ? 0 : anchor == Anchor::middle ? width / 2 : width;
  canvas_.text(static_cast<int>(scaled(x)) - shift, static_cast<int>(scaled(y)) - 7 * dots / 2, text, dots,
               color);
}

}  // namespace mapless::app
