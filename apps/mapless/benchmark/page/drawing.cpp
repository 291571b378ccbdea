#include "benchmark/page/drawing.hpp"

#include <cmath>

#include <fmt/format.h>

#include "benchmark/page/html.hpp"

namespace mapless::app {
namespace {

constexpr int kPixelsPerUnit = 2;
constexpr double kDash = 6;  // [px] of the drawing

std::string hex(Color c) {
  return fmt::format("#{:02x}{:02x}{:02x}", std::lround(c.red), std::lround(c.green), std::lround(c.blue));
}

int font_size(TextSize size) { return size == TextSize::title ? 16 : 13; }

}  // namespace

void SvgDrawing::line(double x1, double y1, double x2, double y2, const LineStyle& style) {
  body_ += fmt::format(
      R"(<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" stroke="{}" stroke-width="{:.2g}")", x1, y1,
      x2, y2, hex(style.color), style.width);
  if (style.dashed) body_ += fmt::format(R"( stroke-dasharray="{0} {0}")", kDash);
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
                       x, y + 4.5, name, font_size(size), hex(color),
                       size == TextSize::title ? R"( font-weight="600")" : "", escaped(text));
}

std::string SvgDrawing::svg(std::string_view title) const {
  return fmt::format(
      R"(<svg viewBox="0 0 {} {}" role="img" xmlns="http://www.w3.org/2000/svg"><title>{}</title>)"
      "\n{}</svg>\n",
      width_, height_, escaped(title), body_);
}

PngDrawing::PngDrawing(int width, int height) : canvas_(width, height, {255, 255, 255}, kPixelsPerUnit) {}

void PngDrawing::line(double x1, double y1, double x2, double y2, const LineStyle& style) {
  canvas_.line(x1, y1, x2, y2, style.width, style.color, style.dashed ? kDash : 0);
}

void PngDrawing::disc(double x, double y, double radius, Color color) { canvas_.disc(x, y, radius, color); }

void PngDrawing::text(double x, double y, std::string_view text, Anchor anchor, TextSize size, Color color) {
  canvas_.text(x, y, std::string(text), font_size(size), color, anchor);
}

}  // namespace mapless::app
