#include "benchmark/movers/mover_picture.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

namespace mapless::app {
namespace {

/// A view along horizontal lines from the sensor, a little turned, tilted down: parallel projection.
class Camera {
 public:
  Camera(const MoverView& view, int width, int height, float margin_m)
      : centre_(view.centre_v),
        pixels_per_m_(static_cast<float>(std::min(width, height)) / 2 / (view.radius_m + margin_m)),
        middle_(static_cast<float>(width) / 2, static_cast<float>(height) / 2) {
    constexpr float kTurn = 0.45F, kTilt = 0.42F;  // [rad]
    const float azimuth = std::atan2(view.centre_v.y(), view.centre_v.x()) + kTurn;
    const Eigen::Vector3f ahead(std::cos(azimuth), std::sin(azimuth), 0);
    right_ = {std::sin(azimuth), -std::cos(azimuth), 0};
    depth_ = std::cos(kTilt) * ahead - std::sin(kTilt) * Eigen::Vector3f::UnitZ();
    up_ = right_.cross(depth_);
  }
  [[nodiscard]] Eigen::Vector2f pixel(const Eigen::Vector3f& p) const {
    return middle_ + pixels_per_m_ * Eigen::Vector2f(right_.dot(p - centre_), -up_.dot(p - centre_));
  }
  [[nodiscard]] float depth(const Eigen::Vector3f& p) const { return depth_.dot(p - centre_); }

 private:
  Eigen::Vector3f centre_, right_, up_, depth_;
  float pixels_per_m_;
  Eigen::Vector2f middle_;
};

Color color_of(const ViewedPoint& p, bool dynamic) {
  if (dynamic && p.known) return p.moving ? kRightColor : kFalseColor;
  return p.moving ? kMissedColor : kStillColor;
}

}  // namespace

Canvas draw_mover(const MoverView& view, int width, int height, float margin_m,
                  const std::function<bool(const ViewedPoint&)>& dynamic) {
  const Camera camera(view, width, height, margin_m);
  std::vector<const ViewedPoint*> points;
  for (const ViewedPoint& p : view.points) points.push_back(&p);
  const auto matters = [&](const ViewedPoint& p) { return p.moving || dynamic(p); };
  std::stable_sort(points.begin(), points.end(), [&](const ViewedPoint* a, const ViewedPoint* b) {
    if (matters(*a) != matters(*b)) return matters(*b);
    return camera.depth(a->position_v) > camera.depth(b->position_v);
  });
  Canvas canvas(width, height, kPaper);
  const float dot = static_cast<float>(std::min(width, height)) / 170;
  for (const ViewedPoint* p : points) {
    const Eigen::Vector2f at = camera.pixel(p->position_v);
    const float radius = matters(*p) ? dot * 1.15F : dot * 0.7F;
    canvas.disc(at.x(), at.y(), radius, color_of(*p, dynamic(*p)), matters(*p) ? 0.95F : 0.6F);
  }
  return canvas;
}

}  // namespace mapless::app
