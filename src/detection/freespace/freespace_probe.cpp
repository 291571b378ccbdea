#include "detection/freespace/freespace_probe.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// Enough for a sensor turning at half its spin rate: each iteration multiplies the error by the ratio of the
// two, and 2^-12 of a turn is less than a column.
constexpr int kMaxIterations = 12;
// Poses that observe of many points uses; 4 degrees of turn change no linearised term noticeably.
constexpr int kPosesPerTurn = 256;

// Tangent below which four terms of the series of atan err by less than 0.15^9 / 9 = 4e-9 rad.
constexpr float kSmallTangent = 0.15F;
// Horizontal distance from the spin axis is taken to be at least this, so that columns per metre stay finite.
// No spinning lidar measures as near as that.
constexpr float kMinHorizontal_m = 0.1F;

// atan2(y, x) [rad]. The guess is mostly good, and the angle small.
float angle_of(float y, float x) {
  if (x > 0 && std::abs(y) < kSmallTangent * x) {
    const float t = y / x;
    const float t2 = t * t;
    return t * (1 - t2 * (1 / 3.0F - t2 * (1 / 5.0F - t2 / 7.0F)));
  }
  return std::atan2(y, x);
}

// Of a number above -0.5; the library's own is a call.
int rounded(float x) {
  const float above = x + 0.5F;
  return static_cast<int>(above);
}

// Columns of a window on either side of the nearest ray, of a horizontal beam. Its width is an angle: of
// fewer turns a second each has more columns, but the leaves and edges beside a point are where they were.
float half_window(double width_deg, const LidarModel& model, int at_least) {
  const double columns = width_deg * model.columns / 360;
  return std::max(static_cast<float>(columns / 2), static_cast<float>(at_least));
}

}  // namespace

FreespaceProbe::FreespaceProbe(const RayImage& image, const Vector3d& origin_0,
                               const VotingParameters& parameters)
    : image_(image),
      tolerance_at_0_m_(static_cast<float>(parameters.tolerance_m)),
      tolerance_spacings_(static_cast<float>(parameters.tolerance_spacings)),
      half_window_(half_window(parameters.window_deg, image.model(), parameters.window_columns / 2)),
      half_beside_(std::max(half_window(parameters.beside_window_deg, image.model(), 0), half_window_)),
      reach_at_0_m_(static_cast<float>(parameters.max_ray_distance_m)),
      reach_spacings_(static_cast<float>(parameters.max_ray_distance_spacings)),
      origin_((origin_0 - image.origin_0()).cast<float>()),
      pose_stride_(std::max(image.model().columns / kPosesPerTurn, 1)),
      fan_(image.fan()) {}

void FreespaceProbe::Bracket::take(const Sighting& s) {
  if (!s.found()) return;
  Sighting& side = s.height_m < 0 ? above : below;
  if (!side.found() || std::abs(s.height_m) < std::abs(side.height_m)) side = s;
}

const FreespaceProbe::Sighting& FreespaceProbe::Bracket::nearest() const {
  if (!above.found()) return below;
  if (!below.found()) return above;
  return -above.height_m < below.height_m ? above : below;
}

// The column at which the hub's x axis points at q. A scan is a little more or less than a turn in the world:
// where a direction occurs twice, at its start and its end, either will do; where not at all, there is none.
bool FreespaceProbe::find_column(const Vector3f& q, float& column, Vector3f& q_h) const {
  const auto last = static_cast<float>(image_.columns() - 1);
  const auto turn = std::abs(fan_.columns_per_rad) * 2 * std::numbers::pi_v<float>;
  bool crossed = false;
  for (int i = 0; i < kMaxIterations; ++i) {
    const int at = rounded(std::clamp(column, 0.0F, last));
    q_h = image_.pose(at) * q;
    const float next = static_cast<float>(at) + angle_of(q_h.y(), q_h.x()) * fan_.columns_per_rad;
    if (next >= -0.5F && next < last + 0.5F) {
      const bool settled = std::abs(next - static_cast<float>(at)) < kSettledColumns;
      column = next;
      if (settled) return true;
    } else {
      if (crossed) return false;
      crossed = true;
      column = next < 0 ? next + turn : next - turn;
    }
  }
  return false;
}

// q in the frame of a laser at the instant of a column: beam along x.
Vector3f FreespaceProbe::in_laser(const Vector3f& q, const Beam& beam, int column) const {
  const Vector3f q_h = image_.pose(column) * q;
  const float ahead = beam.azimuth_cosine * q_h.x() + beam.azimuth_sine * q_h.y() - beam.ahead_m;
  const float left = beam.azimuth_cosine * q_h.y() - beam.azimuth_sine * q_h.x() - beam.left_m;
  const float up = q_h.z() - beam.up_m;
  return {beam.cosine * ahead + beam.sine * up, left, beam.cosine * up - beam.sine * ahead};
}

FreespaceProbe::Sighting FreespaceProbe::sight(const Vector3f& q, const Beam& beam, float column,
                                               float columns_per_m) const {
  const int columns = image_.columns();
  float pointing = column + beam.offset_columns - beam.left_m * columns_per_m;
  if (pointing < -0.5F) pointing += static_cast<float>(columns);
  int at = rounded(pointing);
  if (at >= columns) at -= columns;
  Vector3f q_l = in_laser(q, beam, at);
  // The way the sensor went since the hub pointed there turns the beam a little off.
  const float off = q_l.y() * columns_per_m;
  if (std::abs(off) > kSettledColumns) {
    at = rounded(std::clamp(static_cast<float>(at) + off, 0.0F, static_cast<float>(columns - 1)));
    q_l = in_laser(q, beam, at);
  }
  // Near the seam a laser's own firing may lie beyond the scan's end.
  if (q_l.x() <= 0 || std::abs(q_l.y() * columns_per_m) > kMaxColumnsAside) return {};
  return {&beam, at, q_l.x(), q_l.z(), q_l.y()};
}

FreespaceProbe::Bracket FreespaceProbe::bracket(const Vector3f& q, float column, const Vector3f& q_h) const {
  const float horizontal = std::max(std::sqrt(q_h.x() * q_h.x() + q_h.y() * q_h.y()), kMinHorizontal_m);
  const float columns_per_m = fan_.columns_per_rad / horizontal;
  Bracket bracket;
  for (const Bank& bank : fan_.banks) {
    const int size = static_cast<int>(bank.beams.size()) - 2;
    const int first =
        bank.below((q_h.z() - bank.centre_z_m) / std::max(horizontal - bank.centre_x_m, kMinHorizontal_m));
    const auto passes_above = [&](int k) {
      const Sighting s = sight(q, bank.beams[static_cast<std::size_t>(k + 1)], column, columns_per_m);
      bracket.take(s);
      return s.found() && s.height_m < 0;
    };
    // The first one mostly; near the sensor the lasers' places count too.
    int k = first - 1;
    while (k >= 0 && passes_above(k)) --k;
    k = first;
    while (k < size && !passes_above(k)) ++k;
  }
  return bracket;
}

// Largest distance of the nearest ray from a point it observes.
float FreespaceProbe::max_distance_m(const Sighting& nearest) const {
  return reach_at_0_m_ + reach_spacings_ * nearest.beam->spacing_rad * nearest.range_m;
}

// The firings of a beam that rises lie closer together.
int FreespaceProbe::columns_within(float half_window, float elevation_cosine) {
  constexpr auto kMost = static_cast<float>(RayImage::kBeside - 1);
  return static_cast<int>(std::min(half_window / elevation_cosine, kMost));
}

void FreespaceProbe::add_window(const Sighting& s, bool is_nearest, SurfaceSlopes slopes,
                                Window& window) const {
  const float inclined_m = slopes.up * std::abs(s.height_m) + slopes.left * std::abs(s.left_m);
  const float tolerance =
      tolerance_at_0_m_ + std::min(inclined_m, tolerance_spacings_ * s.beam->spacing_rad * s.range_m);
  const int widest = columns_within(half_beside_, s.beam->cosine);
  for (int c = s.column - widest; c <= s.column + widest; ++c) {
    const FreespaceVerdict found = compare_ranges(image_.range_m(s.beam->laser, c), s.range_m, tolerance);
    const float beside = static_cast<float>(std::abs(c - s.column)) * s.beam->cosine;
    if (beside > half_window_) {
      window.surface_beside |= found == FreespaceVerdict::border;
    } else if (found == FreespaceVerdict::outside) {
      if (beside <= 1 || beside * s.range_m <= hides_within_columns_m()) window.hides = true;
    } else if (found == FreespaceVerdict::border) {
      window.border = true;
    }
  }
  if (is_nearest) window.nearest_range_m = image_.range_m(s.beam->laser, s.column);
}

FreespaceProbe::Answer FreespaceProbe::observe_about_image(const Vector3f& q, float& column,
                                                           SurfaceSlopes slopes) const {
  Vector3f q_h;
  if (!find_column(q, column, q_h)) return {};
  const Bracket rays = bracket(q, column, q_h);
  const Sighting& nearest = rays.nearest();
  if (!nearest.found() || std::abs(nearest.height_m) > max_distance_m(nearest)) return {};
  Window window;
  if (rays.above.found()) add_window(rays.above, &nearest == &rays.above, slopes, window);
  if (rays.below.found()) add_window(rays.below, &nearest == &rays.below, slopes, window);
  const auto answer = [&](FreespaceVerdict verdict) {
    return Answer{verdict,
                  nearest.beam->laser,
                  nearest.column,
                  nearest.range_m - window.nearest_range_m,
                  std::max(std::abs(nearest.height_m), std::abs(nearest.left_m)),
                  window.surface_beside};
  };
  if (window.border) return answer(FreespaceVerdict::border);
  if (std::isnan(window.nearest_range_m)) return answer(FreespaceVerdict::unobserved);
  if (window.nearest_range_m < nearest.range_m) return answer(FreespaceVerdict::outside);
  if (window.hides) return answer(FreespaceVerdict::unobserved);
  const bool between = rays.below.found() && rays.above.found();
  const float edge_m = kEdgeSpacings * nearest.beam->spacing_rad * nearest.range_m;
  if (!between && fan_.beams.size() > 1 && std::abs(nearest.height_m) > edge_m) {
    return answer(FreespaceVerdict::unobserved);
  }
  return answer(FreespaceVerdict::inside);
}

bool FreespaceProbe::ended(const Answer& answer) const {
  return image_.range_m(answer.laser, answer.column) < static_cast<float>(image_.model().max_range_m);
}

void FreespaceProbe::prepare_endpoint(int column) const {
  const Eigen::Matrix4f& T_h0 = image_.pose(column).T_h0;
  __builtin_prefetch(T_h0.data());
  __builtin_prefetch(T_h0.data() + T_h0.size() - 1);
}

Vector3f FreespaceProbe::endpoint(int laser, int column) const {
  const Beam& beam = fan_.beams[static_cast<std::size_t>(laser)];
  const Pose& pose = image_.pose(column);
  const float range = image_.range_m(laser, column);
  const float ahead = beam.ahead_m + beam.cosine * range;
  const Vector3f p_h(beam.azimuth_cosine * ahead - beam.azimuth_sine * beam.left_m,
                     beam.azimuth_sine * ahead + beam.azimuth_cosine * beam.left_m,
                     beam.up_m + beam.sine * range);
  return pose.T_h0.topLeftCorner<3, 3>().transpose() * (p_h - pose.T_h0.topRightCorner<3, 1>()) - origin_;
}

}  // namespace mapless
