#include "pictures/canvas.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include <cairo.h>
#include <fmt/format.h>

#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace {

constexpr double kCapHeight = 0.73;  // height of a capital letter of DejaVu Sans by the size of the font

std::shared_ptr<cairo_t> picture(int width, int height) {
  cairo_surface_t* const surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height);
  std::shared_ptr<cairo_t> cairo(cairo_create(surface), cairo_destroy);
  cairo_surface_destroy(surface);  // cairo holds it
  if (cairo_status(cairo.get()) != CAIRO_STATUS_SUCCESS) {
    throw OutputError({"picture", "size", fmt::format("{} x {}", width, height),
                       cairo_status_to_string(cairo_status(cairo.get())), "draw a smaller picture"});
  }
  return cairo;
}

cairo_surface_t* surface_of(cairo_t* cairo) { return cairo_get_target(cairo); }

// The row of 0xRRGGBB.
std::uint32_t* row_of(cairo_surface_t* surface, int y) {
  cairo_surface_flush(surface);
  unsigned char* const row =
      cairo_image_surface_get_data(surface) + std::ptrdiff_t{y} * cairo_image_surface_get_stride(surface);
  return reinterpret_cast<std::uint32_t*>(row);  // of a surface of 32 bits a pixel
}

void choose(cairo_t* cairo, Color color, double opacity) {
  cairo_set_source_rgba(cairo, color.red / 255, color.green / 255, color.blue / 255, opacity);
}

// Fewer colours make a smaller file.
void coarsen(cairo_surface_t* surface) {
  for (int y = 0; y < cairo_image_surface_get_height(surface); ++y) {
    std::uint32_t* const row = row_of(surface, y);
    std::transform(row, row + cairo_image_surface_get_width(surface), row,
                   [](std::uint32_t pixel) { return (pixel & 0xF8F8F8) | 0x040404; });
  }
  cairo_surface_mark_dirty(surface);
}

cairo_status_t append(void* png, const unsigned char* bytes, unsigned int count) {
  static_cast<std::string*>(png)->append(bytes, bytes + count);
  return CAIRO_STATUS_SUCCESS;
}

}  // namespace

Canvas::Canvas(int width, int height, Color background, int pixels_per_unit)
    : cairo_(picture(width * pixels_per_unit, height * pixels_per_unit)) {
  choose(cairo_.get(), background, 1);
  cairo_paint(cairo_.get());
  cairo_scale(cairo_.get(), pixels_per_unit, pixels_per_unit);
  cairo_set_line_cap(cairo_.get(), CAIRO_LINE_CAP_ROUND);
  cairo_select_font_face(cairo_.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  // The same letters whatever the settings of the desktop.
  cairo_font_options_t* const font = cairo_font_options_create();
  cairo_font_options_set_antialias(font, CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_style(font, CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(font, CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(cairo_.get(), font);
  cairo_font_options_destroy(font);
}

int Canvas::width() const { return cairo_image_surface_get_width(surface_of(cairo_.get())); }

int Canvas::height() const { return cairo_image_surface_get_height(surface_of(cairo_.get())); }

Color Canvas::pixel(int x, int y) const {
  const std::uint32_t pixel = row_of(surface_of(cairo_.get()), y)[x];
  const auto channel = [pixel](int shift) { return static_cast<double>(pixel >> shift & 0xFF); };
  return {channel(16), channel(8), channel(0)};
}

void Canvas::clip(double x, double y, double width, double height) {
  unclip();
  cairo_rectangle(cairo_.get(), x, y, width, height);
  cairo_clip(cairo_.get());
}

void Canvas::unclip() { cairo_reset_clip(cairo_.get()); }

void Canvas::rectangle(double x, double y, double width, double height, Color color, double opacity) {
  choose(cairo_.get(), color, opacity);
  cairo_rectangle(cairo_.get(), x, y, width, height);
  cairo_fill(cairo_.get());
}

void Canvas::disc(double x, double y, double radius, Color color, double opacity) {
  choose(cairo_.get(), color, opacity);
  cairo_arc(cairo_.get(), x, y, radius, 0, 2 * std::numbers::pi);
  cairo_fill(cairo_.get());
}

void Canvas::line(double x1, double y1, double x2, double y2, double width, Color color, double dash) {
  choose(cairo_.get(), color, 1);
  cairo_set_line_width(cairo_.get(), width);
  cairo_set_dash(cairo_.get(), &dash, dash > 0 ? 1 : 0, 0);
  cairo_move_to(cairo_.get(), x1, y1);
  cairo_line_to(cairo_.get(), x2, y2);
  cairo_stroke(cairo_.get());
}

void Canvas::ring(double x, double y, double radius, double line_width, Color color, double opacity) {
  choose(cairo_.get(), color, opacity);
  cairo_set_line_width(cairo_.get(), line_width);
  cairo_set_dash(cairo_.get(), nullptr, 0, 0);
  cairo_new_sub_path(cairo_.get());
  cairo_arc(cairo_.get(), x, y, radius, 0, 2 * std::numbers::pi);
  cairo_stroke(cairo_.get());
}

void Canvas::arrow_right(double x, double y, double size, Color color) {
  choose(cairo_.get(), color, 1);
  cairo_move_to(cairo_.get(), x + size, y);
  cairo_line_to(cairo_.get(), x - size, y + size);
  cairo_line_to(cairo_.get(), x - size, y - size);
  cairo_fill(cairo_.get());
}

double Canvas::text(double x, double y, const std::string& text, double size, Color color, Anchor anchor) {
  cairo_set_font_size(cairo_.get(), size);
  cairo_text_extents_t extents;
  cairo_text_extents(cairo_.get(), text.c_str(), &extents);
  const double shift = anchor == Anchor::left ? 0 : anchor == Anchor::middle ? 0.5 : 1;
  choose(cairo_.get(), color, 1);
  cairo_move_to(cairo_.get(), x - shift * extents.x_advance, y + kCapHeight / 2 * size);
  cairo_show_text(cairo_.get(), text.c_str());
  return extents.x_advance;
}

void Canvas::write_png(const std::filesystem::path& file, int reduce) const {
  std::shared_ptr<cairo_t> reduced = cairo_;
  if (reduce > 1) {
    reduced = picture(width() / reduce, height() / reduce);
    cairo_scale(reduced.get(), 1.0 / reduce, 1.0 / reduce);
    cairo_set_source_surface(reduced.get(), surface_of(cairo_.get()), 0, 0);
    cairo_paint(reduced.get());
    coarsen(surface_of(reduced.get()));
  }
  std::string png;
  const cairo_status_t status = cairo_surface_write_to_png_stream(surface_of(reduced.get()), append, &png);
  if (status != CAIRO_STATUS_SUCCESS) {
    throw OutputError({file.string(), "PNG", "", cairo_status_to_string(status), "draw a smaller picture"});
  }
  write_file_atomically(file, png);
}

}  // namespace mapless::app
