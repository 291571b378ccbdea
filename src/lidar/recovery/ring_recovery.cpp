#include "lidar/recovery/ring_recovery.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "core/parallel_parts.hpp"
#include "lidar/recovery/ring_points.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

constexpr double kTurn_rad = 2 * std::numbers::pi;
// A new ring starts at the front again: the azimuth drops by nearly a turn. Inside a ring it drops by less
// than 2 degrees because of horizontal origins, and by a few degrees at the seam because of motion
// compensation while turning.
constexpr double kRingDrop_rad = 0.5;
// Points are stored by the hub's angle. Their azimuths differ from it by rounding and compensation, 2 cm at
// 100 m, and by the horizontal origin of the laser, 0.026 m for an HDL-64E: so far from the front, where
// rings begin, a point may lie on the other side of it.
constexpr double kFrontJitter_rad = 2e-4, kFrontJitter_m = 0.03;
// Mean distance from the beams, in steps of elevation, of points that have nothing to do with the lasers.
constexpr double kRandomMisfit = 0.25;

double turn_from_zero(double angle_rad) {
  const double a = std::abs(angle_rad) < kTurn_rad ? angle_rad : std::fmod(angle_rad, kTurn_rad);
  return std::signbit(a) ? a + kTurn_rad : a;  // includes -0, just before the front
}

double azimuth_of(const Eigen::Vector3f& p) {
  return turn_from_zero(std::atan2(static_cast<double>(p.y()), static_cast<double>(p.x())));
}

float slope_of(const Eigen::Vector3f& p) { return p.z() / p.head<2>().norm(); }

// True if the elevation of point i is nearer to that of point a than to that of point b.
bool belongs_to(const std::vector<Eigen::Vector3f>& points, std::size_t i, std::size_t a, std::size_t b) {
  if (!is_usable(points[i]) || !is_usable(points[a]) || !is_usable(points[b])) return false;
  const float slope = slope_of(points[i]);
  return std::abs(slope - slope_of(points[a])) < std::abs(slope - slope_of(points[b]));
}

double front_jitter_rad(const Eigen::Vector3f& p) {
  return kFrontJitter_rad + kFrontJitter_m / static_cast<double>(p.head<2>().norm());
}

bool is_behind_front(const Eigen::Vector3f& p) { return azimuth_of(p) < front_jitter_rad(p); }
bool is_before_front(const Eigen::Vector3f& p) { return azimuth_of(p) > kTurn_rad - front_jitter_rad(p); }

// True if all usable points of [begin, end) lie on the front itself: not a ring.
bool is_jitter(const std::vector<Eigen::Vector3f>& points, std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) {
    if (is_usable(points[i]) && !is_behind_front(points[i]) && !is_before_front(points[i])) return false;
  }
  return true;
}

// Assigns points on the front that rounding moved across it to their own ring.
void settle_points_on_the_front(const std::vector<Eigen::Vector3f>& points,
                                std::vector<std::size_t>& starts) {
  if (starts.size() > 1 && is_jitter(points, starts.back(), points.size())) starts.pop_back();
  if (starts.size() > 1 && is_jitter(points, 0, starts[1])) starts.erase(starts.begin() + 1);
  for (std::size_t k = 1; k + 1 < starts.size();) {
    if (is_jitter(points, starts[k], starts[k + 1])) {
      starts.erase(starts.begin() + static_cast<std::ptrdiff_t>(k));
    } else {
      ++k;
    }
  }
  for (std::size_t k = 1; k < starts.size(); ++k) {
    std::size_t& s = starts[k];
    if (s < 2 || s + 1 >= points.size()) continue;
    if (is_before_front(points[s - 1]) && belongs_to(points, s - 1, s, s - 2)) {
      --s;
    } else if (is_behind_front(points[s]) && belongs_to(points, s, s - 1, s + 1)) {
      ++s;
    }
  }
}

// Angle between a point and the beam of a laser, in the plane through the spin axis.
double elevation_error(const Eigen::Vector3f& p, const Laser& laser) {
  const double rho = std::hypot(p.x(), p.y());
  return std::atan2(p.z() - laser.origin_h_m.z(), rho) - laser.elevation_rad;
}

// Assignment of points to rings of least cost whose ring number never decreases along the stored order
// (dynamic programming).
std::vector<std::int32_t> nearest_rings_in_order(const std::vector<Eigen::Vector3f>& points,
                                                 const LidarModel& model, const std::vector<int>& row_of_ring,
                                                 double largest_error_rad, double& mean_error) {
  const std::size_t rings = row_of_ring.size();
  std::vector<double> cost(rings, 0);
  std::vector<bool> entered(points.size() * rings, false);
  std::size_t usable = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t k = 1; k < rings; ++k) {
      if (cost[k - 1] >= cost[k]) continue;
      cost[k] = cost[k - 1];
      entered[i * rings + k] = true;
    }
    if (!is_usable(points[i])) continue;
    ++usable;
    for (std::size_t k = 0; k < rings; ++k) {
      const Laser& laser = model.lasers[static_cast<std::size_t>(row_of_ring[k])];
      cost[k] += std::min(std::abs(elevation_error(points[i], laser)), largest_error_rad);
    }
  }
  std::size_t ring = static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  mean_error = usable == 0 ? 0 : cost[ring] / static_cast<double>(usable);
  std::vector<std::int32_t> rows(points.size());
  for (std::size_t i = points.size(); i-- > 0;) {
    rows[i] = row_of_ring[ring];
    while (entered[i * rings + ring]) --ring;
  }
  return rows;
}

// Column of every encoder position at which the sensor fired: the nearest free one; -1 where it did not fire.
std::vector<std::int32_t> columns_of_firings(const std::vector<int>& lasers_at, int columns) {
  std::vector<std::size_t> firings;
  for (std::size_t j = 0; j < lasers_at.size(); ++j) {
    if (lasers_at[j] >= kFiringLasers) firings.push_back(j);
  }
  const auto count = static_cast<std::int32_t>(firings.size());
  std::vector<std::int32_t> column_of(lasers_at.size(), -1);
  if (count > columns) return column_of;
  const double columns_per_step = columns / static_cast<double>(lasers_at.size());
  std::int32_t next_free = 0;
  for (std::int32_t i = 0; i < count; ++i) {
    const std::size_t j = firings[static_cast<std::size_t>(i)];
    const auto nearest = static_cast<std::int32_t>(std::lround(static_cast<double>(j) * columns_per_step));
    const std::int32_t column = std::min(std::max(nearest, next_free), columns - (count - i));
    column_of[j] = column;
    next_free = column + 1;
  }
  return column_of;
}

std::int32_t rounded_modulo(double x, int n) {
  const long rounded = std::lround(x);
  if (rounded >= 0 && rounded < n) return static_cast<std::int32_t>(rounded);
  return static_cast<std::int32_t>(((rounded % n) + n) % n);
}

// Angle of a point about the spin axis less that of the hub when its laser fired.
struct HubOffset {
  double azimuth_rad, across_m;

  explicit HubOffset(const Laser& laser)
      : azimuth_rad(laser.azimuth_offset_rad),
        across_m(laser.origin_h_m.y() * std::cos(laser.azimuth_offset_rad) -
                 laser.origin_h_m.x() * std::sin(laser.azimuth_offset_rad)) {}

  // Horizontal origin: across the beam, so it turns the azimuth by asin(h / rho).
  [[nodiscard]] double across_rad(const Eigen::Vector3f& p) const {
    if (across_m == 0) return 0;
    return std::asin(std::clamp(across_m / std::sqrt(p.head<2>().cast<double>().squaredNorm()), -1.0, 1.0));
  }
};

double hub_turn(const Eigen::Vector3f& p, const HubOffset& offset, const LidarModel& model) {
  const double hub = std::atan2(p.y(), p.x()) - offset.azimuth_rad - offset.across_rad(p);
  const double turn = turn_from_zero(model.sign() * (hub - model.start_azimuth_rad)) / kTurn_rad;
  return turn < 1 ? turn : 0;
}

void give_firings_their_columns(const std::vector<Eigen::Vector3f>& points, int encoder_steps, int columns,
                                RecoveredFirings& firings) {
  std::vector<int> lasers_at(static_cast<std::size_t>(encoder_steps), 0);
  const auto position = [&](std::size_t i) {
    return static_cast<std::size_t>(rounded_modulo(firings.turn[i] * encoder_steps, encoder_steps));
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_usable(points[i])) ++lasers_at[position(i)];
  }
  const std::vector<std::int32_t> column_of = columns_of_firings(lasers_at, columns);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t j = position(i);
    if (column_of[j] < 0) continue;
    firings.columns[i] = column_of[j];
  }
}

RecoveredFirings columns_and_turns(const std::vector<Eigen::Vector3f>& points,
                                   const std::vector<std::int32_t>& lasers, const LidarModel& model,
                                   int encoder_steps) {
  RecoveredFirings firings;
  firings.columns.assign(points.size(), 0);
  firings.turn.assign(points.size(), 0);
  const std::vector<HubOffset> offsets(model.lasers.begin(), model.lasers.end());
  const auto turn_of = [&](std::size_t i) {
    return hub_turn(points[i], offsets[static_cast<std::size_t>(lasers[i])], model);
  };
  for_parts(points.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    // Of a point without position only its neighbours in the file are known: it gets the turn of the last one
    // before it that has a position.
    std::size_t before = begin;
    while (before > 0 && !is_usable(points[before])) --before;
    double turn = before < begin && is_usable(points[before]) ? turn_of(before) : 0;
    for (std::size_t i = begin; i < end; ++i) {
      if (is_usable(points[i])) turn = turn_of(i);
      firings.turn[i] = turn;
      firings.columns[i] = rounded_modulo(turn * model.columns, model.columns);
    }
  });
  if (encoder_steps > 0) give_firings_their_columns(points, encoder_steps, model.columns, firings);
  return firings;
}

}  // namespace

BareCloudLayout top_first_layout(const LidarModel& model) {
  BareCloudLayout layout;
  layout.row_of_ring.resize(model.lasers.size());
  std::iota(layout.row_of_ring.rbegin(), layout.row_of_ring.rend(), 0);
  return layout;
}

std::vector<std::size_t> ring_starts(const std::vector<Eigen::Vector3f>& points) {
  std::vector<std::size_t> starts;
  double before = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_usable(points[i])) continue;
    const double azimuth = azimuth_of(points[i]);
    if (azimuth < before - kRingDrop_rad) starts.push_back(starts.empty() ? 0 : i);
    before = azimuth;
  }
  settle_points_on_the_front(points, starts);
  return starts;
}

std::vector<std::int32_t> recover_lasers(const std::vector<Eigen::Vector3f>& points, const LidarModel& model,
                                         const BareCloudLayout& layout, const std::string& source) {
  std::vector<std::int32_t> rows(points.size(), 0);
  const std::vector<std::size_t> starts = ring_starts(points);
  if (starts.empty()) return rows;
  if (starts.size() == model.lasers.size()) {
    for (std::size_t ring = 0; ring < starts.size(); ++ring) {
      const std::size_t end = ring + 1 < starts.size() ? starts[ring + 1] : points.size();
      std::fill(rows.begin() + static_cast<std::ptrdiff_t>(starts[ring]),
                rows.begin() + static_cast<std::ptrdiff_t>(end), layout.row_of_ring[ring]);
    }
    return rows;
  }
  const double step = model.largest_elevation_step();
  double mean_error = 0;
  rows = nearest_rings_in_order(points, model, layout.row_of_ring, step, mean_error);
  if (mean_error > kRandomMisfit * step) {
    throw InputError({source, "rings", std::to_string(starts.size()),
                      "the sensor has " + std::to_string(model.lasers.size()) +
                          " lasers, and the points do not lie on their beams in stored order",
                      "the points must be stored ring after ring; name the sensor if it is another"});
  }
  return rows;
}

std::vector<std::int32_t> recover_columns(const std::vector<Eigen::Vector3f>& points,
                                          const std::vector<std::int32_t>& lasers, const LidarModel& model,
                                          int encoder_steps) {
  return columns_and_turns(points, lasers, model, encoder_steps).columns;
}

RecoveredFirings recover_firings(const std::vector<Eigen::Vector3f>& points,
                                 const std::vector<std::int32_t>& lasers, const LidarModel& model,
                                 int encoder_steps) {
  RecoveredFirings firings = columns_and_turns(points, lasers, model, encoder_steps);
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    double& turn = firings.turn[i];
    const double off = std::abs(turn * model.columns - firings.columns[i]);
    const double nearest_way = std::min(off, model.columns - off);
    sum += nearest_way * nearest_way;
    if (encoder_steps > 0) {
      // Firings come at a steady rate; the encoder's positions are rounded.
      turn = static_cast<double>(firings.columns[i]) / model.columns;
    } else if (turn * model.columns - firings.columns[i] > 1) {
      turn = 0;  // just before the seam and nearest to column 0: it gets the time of that column
    }
  }
  if (!points.empty()) firings.residual_columns_rms = std::sqrt(sum / static_cast<double>(points.size()));
  return firings;
}

std::vector<LidarRecord> recover_records(const std::vector<Eigen::Vector3f>& points, const LidarModel& model,
                                         const BareCloudLayout& layout, Duration turn_duration,
                                         const std::string& source) {
  const std::vector<std::int32_t> lasers = recover_lasers(points, model, layout, source);
  const RecoveredFirings firings = recover_firings(points, lasers, model, layout.encoder_steps);
  std::vector<LidarRecord> records(points.size());
  const auto duration_ns = static_cast<double>(turn_duration.nanoseconds());
  for (std::size_t i = 0; i < points.size(); ++i) {
    records[i] = {points[i], lasers[i], firings.columns[i],
                  static_cast<std::int32_t>(firings.turn[i] * duration_ns),
                  is_usable(points[i]) ? ReturnCode::hit : ReturnCode::faulty};
  }
  return records;
}

}  // namespace mapless
