#include "pictures/scan_picture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <fmt/format.h>

#include <mapless/io/labels.hpp>

namespace mapless::app {
namespace {

constexpr int kPictureWidth = 1600, kMargin = 20, kInnerWidth = kPictureWidth - 2 * kMargin;
constexpr int kBirdViewHeight = 780, kTitleHeight = 34, kTextHeight = 14;
constexpr double kTextSize = 18;
constexpr int kRangeImageHeight = 256;
constexpr Color kBackground{13, 16, 22}, kPanel{20, 25, 33}, kText{205, 212, 222}, kFaint{96, 108, 124},
    kLabel{159, 165, 174};
// As in the page of `mapless view`: colours that colour-blind people tell apart (Okabe and Ito 2008).
constexpr Color kHit{0, 178, 130}, kFalse{235, 100, 20}, kMissed{86, 180, 233}, kUnjudged{204, 121, 167};

struct Rectangle {
  int x, y, width, height;
};

enum class Verdict : std::uint8_t { still, object, hit, wrong, missed, unjudged };

struct PicturePoint {
  const LidarReturn* r;
  Verdict verdict;
  std::uint32_t object;
};

// Hues a golden angle apart: neighbours in number are far apart in colour.
Color object_color(std::uint32_t object) {
  const float hue = std::fmod(static_cast<float>(object - 1) * 0.618034F + 0.08F, 1.0F) * 6;
  const auto channel = [hue](float shift) {
    const float k = std::fmod(hue + shift, 6.0F);
    return 255.0F * (1 - 0.75F * std::clamp(std::min(k, 4 - k), 0.0F, 1.0F));
  };
  return {channel(5), channel(3), channel(1)};
}

Color color_of(const PicturePoint& p) {
  switch (p.verdict) {
    case Verdict::hit:
      return kHit;
    case Verdict::wrong:
      return kFalse;
    case Verdict::missed:
      return kMissed;
    case Verdict::unjudged:
      return kUnjudged;
    default:
      return object_color(p.object);
  }
}

Verdict verdict_of(bool dynamic, std::optional<MotionTruth> truth) {
  if (!truth) return dynamic ? Verdict::object : Verdict::still;
  switch (*truth) {
    case MotionTruth::moving:
      return dynamic ? Verdict::hit : Verdict::missed;
    case MotionTruth::still:
      return dynamic ? Verdict::wrong : Verdict::still;
    case MotionTruth::unknown:
      return dynamic ? Verdict::unjudged : Verdict::still;
  }
  return Verdict::still;
}

// Static points first, and far ones before near ones: dynamic and near points are drawn over the others.
std::vector<PicturePoint> points_in_drawing_order(const LidarScan& scan,
                                                  const std::vector<std::uint32_t>& labels,
                                                  const std::optional<std::vector<std::uint32_t>>& truth) {
  std::vector<PicturePoint> points;
  points.reserve(scan.returns.size());
  for (const LidarReturn& r : scan.returns) {
    const std::uint32_t label = labels[r.input_index];
    const bool dynamic = motion_of_label(label) == MotionTruth::moving;
    std::optional<MotionTruth> motion;
    if (truth) motion = motion_of_label((*truth)[r.input_index]);
    points.push_back({&r, verdict_of(dynamic, motion), label >> 16});
  }
  std::stable_sort(points.begin(), points.end(), [](const PicturePoint& a, const PicturePoint& b) {
    const bool a_still = a.verdict == Verdict::still, b_still = b.verdict == Verdict::still;
    return a_still != b_still ? a_still : a.r->range_m > b.r->range_m;
  });
  return points;
}

Color grey(float brightness) { return {0.92F * brightness, 0.97F * brightness, 1.06F * brightness}; }

void draw_range_image(Canvas& canvas, const Rectangle& area, const LidarScan& scan,
                      const std::vector<PicturePoint>& points) {
  canvas.rectangle(area.x, area.y, area.width, area.height, kPanel);
  canvas.clip(area.x, area.y, area.width, area.height);
  const int row_height = area.height / scan.rows();
  const int cell_width = (area.width + scan.columns - 1) / std::max(1, scan.columns);
  for (const PicturePoint& p : points) {
    const double azimuth = std::atan2(p.r->position_v.y(), p.r->position_v.x());
    const double turn = (std::numbers::pi - azimuth) / (2 * std::numbers::pi);
    const bool still = p.verdict == Verdict::still;
    const int x = area.x + static_cast<int>(turn * area.width), y = scan.rows() - 1 - p.r->laser;
    const float nearness =
        1 - std::clamp(std::log(std::max(1.0F, p.r->range_m)) / std::log(100.0F), 0.0F, 1.0F);
    canvas.rectangle(x, area.y + y * row_height, cell_width + (still ? 0 : 1), row_height,
                     still ? grey(34 + 190 * nearness) : color_of(p));
  }
  canvas.unclip();
}

double ring_step(double extent_m) {
  for (const double step : {1.0, 2.0, 5.0, 10.0, 20.0, 50.0}) {
    if (extent_m / step <= 6) return step;
  }
  return 100;
}

class BirdView {
 public:
  BirdView(Canvas& canvas, const Rectangle& area, double extent_m)
      : canvas_(canvas), area_(area), extent_m_(extent_m), scale_(area.width / (2 * extent_m)) {}

  void draw(const std::vector<PicturePoint>& points) {
    canvas_.rectangle(area_.x, area_.y, area_.width, area_.height, kPanel);
    canvas_.clip(area_.x, area_.y, area_.width, area_.height);
    draw_rings();
    for (const PicturePoint& p : points) draw_point(p);
    canvas_.arrow_right(centre_x(), centre_y(), 11, {255, 255, 255});
    label_rings();
    canvas_.unclip();
  }

 private:
  [[nodiscard]] double centre_x() const { return area_.x + area_.width / 2.0; }
  [[nodiscard]] double centre_y() const { return area_.y + area_.height / 2.0; }

  void draw_rings() {
    const double step = ring_step(extent_m_);
    for (double radius = step; radius < extent_m_ * 1.2; radius += step) {
      canvas_.ring(centre_x(), centre_y(), radius * scale_, 1.2, kFaint, 0.45);
    }
  }

  // Range labels stand where the rings cross the forward axis.
  void label_rings() {
    const double step = ring_step(extent_m_);
    for (double radius = step; radius < extent_m_; radius += step) {
      const std::string text = fmt::format("{:g} m", radius);
      canvas_.text(centre_x() + radius * scale_ - 3, centre_y() + 13, text, kTextSize, kLabel, Anchor::right);
    }
  }

  void draw_point(const PicturePoint& p) {
    const double x = centre_x() + p.r->position_v.x() * scale_, y = centre_y() - p.r->position_v.y() * scale_;
    if (p.verdict == Verdict::still) {
      const float height = std::clamp((p.r->position_v.z() + 2.5F) / 5.5F, 0.0F, 1.0F);
      canvas_.disc(x, y, 0.9, grey(72 + 100 * height), 0.75);
    } else {
      canvas_.disc(x, y, 2.2, color_of(p), 0.95);
    }
  }

  Canvas& canvas_;
  Rectangle area_;
  double extent_m_;
  double scale_;
};

std::size_t count(const std::vector<PicturePoint>& points, Verdict verdict) {
  return static_cast<std::size_t>(std::count_if(
      points.begin(), points.end(), [verdict](const PicturePoint& p) { return p.verdict == verdict; }));
}

std::size_t count_objects(const std::vector<PicturePoint>& points) {
  std::set<std::uint32_t> objects;
  for (const PicturePoint& p : points) {
    if (p.object != 0 && p.verdict != Verdict::still) objects.insert(p.object);
  }
  return objects.size();
}

void draw_legend(Canvas& canvas, int y, const std::vector<PicturePoint>& points, bool with_truth) {
  double x = kMargin;
  const double middle = y + kTextHeight / 2.0;
  const auto entry = [&](const std::string& text, Color color) {
    canvas.disc(x + 6, middle, 6, color);
    x += 20 + canvas.text(x + 20, middle, text, kTextSize, kText) + 28;
  };
  if (with_truth) {
    entry(fmt::format("hit {}", count(points, Verdict::hit)), kHit);
    entry(fmt::format("false {}", count(points, Verdict::wrong)), kFalse);
    entry(fmt::format("missed {}", count(points, Verdict::missed)), kMissed);
    if (const std::size_t unjudged = count(points, Verdict::unjudged); unjudged > 0) {
      entry(fmt::format("dynamic where truth is unknown {}", unjudged), kUnjudged);
    }
  } else {
    entry(fmt::format("dynamic {}, {} objects by colour", count(points, Verdict::object),
                      count_objects(points)),
          object_color(1));
  }
  entry(fmt::format("static {}", count(points, Verdict::still)), grey(130));
}

}  // namespace

Canvas draw_scan(const LidarScan& scan, const std::vector<std::uint32_t>& labels,
                 const std::optional<std::vector<std::uint32_t>>& truth, const PictureOptions& options) {
  const auto points = points_in_drawing_order(scan, labels, truth);
  const int row_height = std::max(2, kRangeImageHeight / scan.rows());
  const int range_height = options.range_image ? row_height * scan.rows() + kMargin : 0;
  const int bird_height = options.bird_view ? kBirdViewHeight + kMargin : 0;
  Canvas canvas(kPictureWidth, kMargin + kTitleHeight + range_height + bird_height + kTextHeight + kMargin,
                kBackground);
  canvas.text(kMargin, kMargin + kTextHeight / 2.0, options.title, kTextSize, kText);
  int y = kMargin + kTitleHeight;
  if (options.range_image) {
    draw_range_image(canvas, {kMargin, y, kInnerWidth, range_height - kMargin}, scan, points);
    y += range_height;
  }
  if (options.bird_view) {
    BirdView view(canvas, {kMargin, y, kInnerWidth, kBirdViewHeight}, options.extent_m);
    const auto& above = options.from_above;
    view.draw(above ? points_in_drawing_order(above->scan, above->labels, above->truth) : points);
    y += bird_height;
  }
  draw_legend(canvas, y, points, truth.has_value());
  return canvas;
}

}  // namespace mapless::app
