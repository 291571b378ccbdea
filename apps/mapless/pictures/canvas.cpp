#include "pictures/canvas.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <png.h>

#include "pictures/font.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace {

constexpr int kLetterAdvance = kLetterColumns + 1;

// Ratio of a pixel's area inside an edge at this signed distance [px].
float coverage(float distance_inside) { return std::clamp(distance_inside + 0.5F, 0.0F, 1.0F); }

std::uint8_t byte_of(float value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0F, 255.0F)));
}

}  // namespace

Canvas::Canvas(int width, int height, Color background)
    : width_(width),
      height_(height),
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), background) {
  unclip();
}

void Canvas::clip(int x, int y, int width, int height) {
  clip_left_ = std::max(0, x);
  clip_top_ = std::max(0, y);
  clip_right_ = std::min(width_, x + width);
  clip_bottom_ = std::min(height_, y + height);
}

void Canvas::blend(int x, int y, Color color, float opacity) {
  if (x < clip_left_ || x >= clip_right_ || y < clip_top_ || y >= clip_bottom_ || opacity <= 0) return;
  Color& p =
      pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
  p.red += opacity * (color.red - p.red);
  p.green += opacity * (color.green - p.green);
  p.blue += opacity * (color.blue - p.blue);
}

void Canvas::rectangle(int x, int y, int width, int height, Color color, float opacity) {
  for (int j = y; j < y + height; ++j) {
    for (int i = x; i < x + width; ++i) blend(i, j, color, opacity);
  }
}

void Canvas::disc(float x, float y, float radius, Color color, float opacity) {
  const int left = static_cast<int>(std::floor(x - radius - 1)),
            right = static_cast<int>(std::ceil(x + radius + 1));
  const int top = static_cast<int>(std::floor(y - radius - 1)),
            bottom = static_cast<int>(std::ceil(y + radius + 1));
  for (int j = top; j < bottom; ++j) {
    for (int i = left; i < right; ++i) {
      const float distance = std::hypot(static_cast<float>(i) + 0.5F - x, static_cast<float>(j) + 0.5F - y);
      blend(i, j, color, opacity * coverage(radius - distance));
    }
  }
}

void Canvas::line(float x1, float y1, float x2, float y2, float width, Color color, float opacity) {
  const float dx = x2 - x1, dy = y2 - y1, length2 = dx * dx + dy * dy, reach = width / 2 + 1;
  const int left = static_cast<int>(std::floor(std::min(x1, x2) - reach)),
            right = static_cast<int>(std::ceil(std::max(x1, x2) + reach));
  const int top = static_cast<int>(std::floor(std::min(y1, y2) - reach)),
            bottom = static_cast<int>(std::ceil(std::max(y1, y2) + reach));
  for (int j = top; j < bottom; ++j) {
    for (int i = left; i < right; ++i) {
      const float x = static_cast<float>(i) + 0.5F - x1, y = static_cast<float>(j) + 0.5F - y1;
      const float along = length2 > 0 ? std::clamp((x * dx + y * dy) / length2, 0.0F, 1.0F) : 0.0F;
      blend(i, j, color, opacity * coverage(width / 2 - std::hypot(x - along * dx, y - along * dy)));
    }
  }
}

void Canvas::ring(float x, float y, float radius, float line_width, Color color, float opacity) {
  for (int j = clip_top_; j < clip_bottom_; ++j) {
    for (int i = clip_left_; i < clip_right_; ++i) {
      const float distance = std::hypot(static_cast<float>(i) + 0.5F - x, static_cast<float>(j) + 0.5F - y);
      blend(i, j, color, opacity * coverage(line_width / 2 - std::abs(distance - radius)));
    }
  }
}

void Canvas::arrow_right(float x, float y, float size, Color color) {
  const int reach = static_cast<int>(std::ceil(size)) + 1;
  for (int j = -reach; j <= reach; ++j) {
    for (int i = -reach; i <= reach; ++i) {
      const float u = static_cast<float>(i), v = std::abs(static_cast<float>(j));
      // Inside the two slanted edges from the tip, and right of the base.
      const float slanted = (size - u - 2 * v) / std::sqrt(5.0F);
      blend(static_cast<int>(x) + i, static_cast<int>(y) + j, color, coverage(std::min(slanted, u + size)));
    }
  }
}

int Canvas::text(int x, int y, std::string_view text, int scale, Color color, float opacity) {
  for (const char letter : text) {
    const LetterRows rows = letter_rows(letter);
    for (int row = 0; row < kLetterRows; ++row) {
      for (int column = 0; column < kLetterColumns; ++column) {
        if ((rows.at(static_cast<std::size_t>(row)) >> (kLetterColumns - 1 - column) & 1) == 0) continue;
        rectangle(x + column * scale, y + row * scale, scale, scale, color, opacity);
      }
    }
    x += kLetterAdvance * scale;
  }
  return x;
}

int Canvas::text_width(std::string_view text, int scale) {
  return static_cast<int>(text.size()) * kLetterAdvance * scale;
}

Color Canvas::mean(int x, int y, int size) const {
  Color sum;
  for (int row = y; row < y + size; ++row) {
    for (int column = x; column < x + size; ++column) {
      const Color& p = pixels_[static_cast<std::size_t>(row * width_ + column)];
      sum = {sum.red + p.red, sum.green + p.green, sum.blue + p.blue};
    }
  }
  const auto count = static_cast<float>(size * size);
  return {sum.red / count, sum.green / count, sum.blue / count};
}

void Canvas::write_png(const std::filesystem::path& file, int reduce) const {
  const int width = width_ / reduce, height = height_ / reduce;
  const auto coarse = [reduce](float value) {
    const std::uint8_t byte = byte_of(value);
    return reduce == 1 ? byte : static_cast<std::uint8_t>(byte / 8 * 8 + 4);
  };
  std::vector<std::uint8_t> bytes;
  bytes.reserve(static_cast<std::size_t>(width * height) * 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Color p = mean(x * reduce, y * reduce, reduce);
      bytes.insert(bytes.end(), {coarse(p.red), coarse(p.green), coarse(p.blue)});
    }
  }
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = 0;
  std::string png;
  if (png_image_write_to_memory(&image, nullptr, &size, 0, bytes.data(), 0, nullptr) != 0) {
    png.resize(size);
    png_image_write_to_memory(&image, png.data(), &size, 0, bytes.data(), 0, nullptr);
  }
  if (PNG_IMAGE_FAILED(image))
    throw OutputError({file.string(), "PNG", "", image.message, "try a smaller picture"});
  png.resize(size);
  write_file_atomically(file, png);
}

}  // namespace mapless::app
