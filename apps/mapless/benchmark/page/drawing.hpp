#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "pictures/canvas.hpp"

namespace mapless::app {

enum class TextSize { normal, title };

struct LineStyle {
  Color color;
  double width = 1;  ///< [px]
  bool dashed = false;
};

/// The surface that a plot is drawn on. Unit: pixels, x to the right, y down; a text's y is its vertical
/// middle.
class Drawing {
 public:
  virtual ~Drawing() = default;
  virtual void line(double x1, double y1, double x2, double y2, const LineStyle& style) = 0;
  virtual void disc(double x, double y, double radius, Color color) = 0;
  virtual void text(double x, double y, std::string_view text, Anchor anchor, TextSize size, Color color) = 0;
};

/// Draws SVG, which scales with the page and keeps text selectable.
class SvgDrawing final : public Drawing {
 public:
  SvgDrawing(int width, int height) : width_(width), height_(height) {}
  void line(double x1, double y1, double x2, double y2, const LineStyle& style) override;
  void disc(double x, double y, double radius, Color color) override;
  void text(double x, double y, std::string_view text, Anchor anchor, TextSize size, Color color) override;

  /// The element <svg>; screen readers read `title`.
  [[nodiscard]] std::string svg(std::string_view title) const;

 private:
  int width_, height_;
  std::string body_;
};

/// Draws a PNG file with two by two pixels for each pixel of the drawing.
class PngDrawing final : public Drawing {
 public:
  PngDrawing(int width, int height);
  void line(double x1, double y1, double x2, double y2, const LineStyle& style) override;
  void disc(double x, double y, double radius, Color color) override;
  void text(double x, double y, std::string_view text, Anchor anchor, TextSize size, Color color) override;

  [[nodiscard]] const Canvas& canvas() const { return canvas_; }

 private:
  Canvas canvas_;
};

}  // namespace mapless::app
