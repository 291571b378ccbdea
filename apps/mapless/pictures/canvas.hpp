#pragma once

#include <filesystem>
#include <memory>
#include <string>

struct _cairo;  // of cairo.h, which no other file needs

namespace mapless::app {

/// sRGB, 0 to 255.
struct Color {
  double red = 0, green = 0, blue = 0;
};

enum class Anchor { left, middle, right };

/// A picture, drawn by Cairo. Coordinates are x to the right, y down, (0, 0) the upper left corner; shapes
/// are antialiased and clipped to the picture. `opacity` is 0 to 1. Sizes and coordinates are in pixels,
/// unless `pixels_per_unit` says otherwise. Throws OutputError for a picture that is too large.
class Canvas {
 public:
  Canvas(int width, int height, Color background, int pixels_per_unit = 1);

  /// Of the picture [px].
  [[nodiscard]] int width() const;
  [[nodiscard]] int height() const;
  /// The colour of the pixel at (x, y) [px], which must lie in the picture.
  [[nodiscard]] Color pixel(int x, int y) const;

  /// Limits drawing to a rectangle until the next call.
  void clip(double x, double y, double width, double height);
  void unclip();

  void rectangle(double x, double y, double width, double height, Color color, double opacity = 1);
  void disc(double x, double y, double radius, Color color, double opacity = 1);
  /// `dash`: length of the dashes and of the gaps between them, 0 for none.
  void line(double x1, double y1, double x2, double y2, double width, Color color, double dash = 0);
  void ring(double x, double y, double radius, double line_width, Color color, double opacity = 1);
  /// A triangle that points to the right, its middle at (x, y).
  void arrow_right(double x, double y, double size, Color color);
  /// Draws a line of text (UTF-8), y its vertical middle. Returns its width.
  double text(double x, double y, const std::string& text, double size, Color color,
              Anchor anchor = Anchor::left);

  /// Writes a PNG beside the file and renames it. Every `reduce` x `reduce` pixels become one, of fewer
  /// colours where there are several. Throws OutputError.
  void write_png(const std::filesystem::path& file, int reduce = 1) const;

 private:
  std::shared_ptr<_cairo> cairo_;
};

}  // namespace mapless::app
