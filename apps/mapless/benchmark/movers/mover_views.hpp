#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <mapless/detection/detector.hpp>

namespace mapless::app {

/// A point near a moving object: its true label and its labels after each stage.
struct ViewedPoint {
  Eigen::Vector3f position_v;
  bool moving = false;  ///< true label
  bool known = false;   ///< whether there is a true label
  bool dynamic = false;
  StageTrace trace;
};

/// A moving object and its surroundings in one scan.
struct MoverView {
  std::uint32_t object_id = 0;
  std::size_t scan = 0;
  Eigen::Vector3f centre_v = Eigen::Vector3f::Zero();  ///< mean of its moving points [m]
  float radius_m = 0;                                  ///< from the centre to the farthest of them
  std::size_t moving_points = 0, found_points = 0;
  std::vector<ViewedPoint> points;  ///< within radius_m + kSurroundings of the centre

  static constexpr float kSurroundings = 4;  // [m]
};

/// Keeps, for every moving object, the scan with most of its moving points (found or missed), no nearer than
/// kNearest. Memory grows with the number of objects, not of scans.
class MoverViews {
 public:
  /// `truth` has one label per input record of the scan.
  void add(std::size_t scan, const Detection& detection, std::span<const std::uint32_t> truth);

  /// By object id.
  [[nodiscard]] const std::map<std::uint32_t, MoverView>& views() const { return views_; }

  static constexpr float kNearest = 4;              // [m]
  static constexpr std::size_t kFewestPoints = 30;  // moving ones

 private:
  std::map<std::uint32_t, MoverView> views_;
};

/// The views that a gallery shows: at most `count`, of as many classes as possible, those with most points
/// first. `classes` by object id.
[[nodiscard]] std::vector<const MoverView*> choose_for_gallery(
    const std::map<std::uint32_t, MoverView>& views, const std::map<std::uint32_t, std::string>& classes,
    std::size_t count);

}  // namespace mapless::app
