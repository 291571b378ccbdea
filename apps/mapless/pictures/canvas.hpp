#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

namespace mapless::app {

/// sRGB, 0 to 255.
struct Color {
  float red = 0, green = 0, blue = 0;
};

/// A picture to draw on. Coordinates are pixels, x to the right, y down, (0, 0) the upper left corner; shapes
/// are antialiased and clipped to the picture. `opacity` is 0 to 1.
class Canvas {
 public:
  Canvas(int width, int height, Color background);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// The colour of the pixel at (x, y), which must lie in the picture.
  [[nodiscard]] Color pixel(int x, int y) const {
    return pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                   static_cast<std::size_t>(x)];
  }

  /// Limits drawing to a rectangle until the next call.
  void clip(int x, int y, int width, int height);
  void unclip() { clip(0, 0, width_, height_); }

  void rectangle(int x, int y, int width, int height, Color color, float opacity = 1);
  void disc(float x, float y, float radius, Color color, float opacity = 1);
  void line(float x1, float y1, float x2, float y2, float width, Color color, float opacity = 1);
  void ring(float x, float y, float radius, float line_width, Color color, float opacity = 1);
  /// A triangle that points to the right, its middle at (x, y).
  void arrow_right(float x, float y, float size, Color color);
  /// Draws text in letters of 5 x 7 dots of `scale` pixels, upper left corner at (x, y). Returns the x behind
  /// the last letter.
  int text(int x, int y, std::string_view text, int scale, Color color, float opacity = 1);
  [[nodiscard]] static int text_width(std::string_view text, int scale);

  /// Writes a PNG beside the file and renames it. Every `reduce` x `reduce` pixels become one, of fewer
  /// colours where there are several. Throws OutputError.
  void write_png(const std::filesystem::path& file, int reduce = 1) const;

 private:
  [[nodiscard]] Color mean(int x, int y, int size) const;
  void blend(int x, int y, Color color, float opacity);

  int width_, height_;
  int clip_left_ = 0, clip_top_ = 0, clip_right_ = 0, clip_bottom_ = 0;
  std::vector<Color> pixels_;
};

}  // namespace mapless::app
