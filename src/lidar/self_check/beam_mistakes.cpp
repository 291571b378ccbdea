#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/median.hpp"
#include "lidar/self_check/beam_check.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

// More explanations than this do not help.
constexpr std::size_t kMostMistakes = 2;
// Elevations that are this much wider or narrower than the points are scaled.
constexpr double kScaled = 0.05;
// Points in the world frame are back on their beams to 10 tolerances, if by one pose a scan; else they are 45
// degrees off.
constexpr double kWorldMisfit = 10;

/// One attempt to explain why points are off their beams.
class Attempt {
 public:
  Attempt(const std::vector<BeamSample>& samples, const LidarModel& model)
      : samples_(samples), model_(model), tolerance_(beam_tolerance(model)) {}

  [[nodiscard]] bool explains(const std::vector<BeamSample>& samples, const LidarModel& model) const {
    return beam_errors(samples, model).misfit(tolerance_) <= 1;
  }
  [[nodiscard]] const std::vector<BeamSample>& samples() const { return samples_; }
  [[nodiscard]] const LidarModel& model() const { return model_; }
  [[nodiscard]] const BeamTolerance& tolerance() const { return tolerance_; }

 private:
  const std::vector<BeamSample>& samples_;
  const LidarModel& model_;
  BeamTolerance tolerance_;
};

std::vector<BeamSample> transformed(std::vector<BeamSample> samples, const Eigen::Matrix3d& axes) {
  for (BeamSample& s : samples) s.position_v = axes * s.position_v;
  return samples;
}

// The angle that most errors share, by the mean of their directions.
double shared_angle(const std::vector<double>& errors) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const double e : errors) sum += Eigen::Vector2d(std::cos(e), std::sin(e));
  return std::atan2(sum.y(), sum.x());
}

LidarModel turned(LidarModel model, double angle_rad) {
  model.start_azimuth_rad += angle_rad;
  return model;
}

LidarModel reversed(LidarModel model) {
  model.direction = model.direction == SpinDirection::clockwise ? SpinDirection::counter_clockwise
                                                                : SpinDirection::clockwise;
  return model;
}

std::string constant_turn(const Attempt& attempt) {
  const double angle = shared_angle(beam_errors(attempt.samples(), attempt.model()).azimuth);
  if (!attempt.explains(attempt.samples(), turned(attempt.model(), angle))) return "";
  return fmt::format(
      "all points look turned by {:.1f} degrees about z (start_azimuth_deg, azimuth_offset_deg, the axes of "
      "the "
      "points, or the order of the columns)",
      angle / kDegree);
}

std::string wrong_direction(const Attempt& attempt) {
  const LidarModel other = reversed(attempt.model());
  const std::string text = fmt::format("the columns run {}, the sensor is said to turn {}",
                                       other.sign() > 0 ? "counter-clockwise" : "clockwise",
                                       other.sign() > 0 ? "clockwise" : "counter-clockwise");
  if (attempt.explains(attempt.samples(), other)) return text;
  const double angle = shared_angle(beam_errors(attempt.samples(), other).azimuth);
  if (!attempt.explains(attempt.samples(), turned(other, angle))) return "";
  return text + fmt::format(", and begin {:.1f} degrees from start_azimuth_deg", angle / kDegree);
}

// "y negated", "x and y swapped", else the axes that x, y and z stand for.
std::string axes_text(const std::array<int, 3>& order, const std::array<int, 3>& signs) {
  constexpr std::array<const char*, 3> kNames = {"x", "y", "z"};
  const auto name = [&](std::size_t i) {
    return std::string(signs[i] < 0 ? "-" : "") + kNames[static_cast<std::size_t>(order[i])];
  };
  std::vector<std::string> negated, moved;
  for (std::size_t i = 0; i < 3; ++i) {
    if (signs[i] < 0) negated.emplace_back(kNames[i]);
    if (order[i] != static_cast<int>(i)) moved.emplace_back(kNames[i]);
  }
  if (moved.empty()) return fmt::format("{} of the points look negated", fmt::join(negated, " and "));
  if (negated.empty() && moved.size() == 2)
    return fmt::format("{} of the points look swapped", fmt::join(moved, " and "));
  return fmt::format("x, y, z of the points look like {}, {}, {}", name(0), name(1), name(2));
}

// constant_turn finds a rotation about z.
std::string wrong_axes(const Attempt& attempt) {
  std::array<int, 3> order = {0, 1, 2};
  std::vector<std::string> fewest;  // the simplest first: fewer negations
  for (int negations = 0; negations <= 3; ++negations) {
    order = {0, 1, 2};
    do {
      for (int bits = 0; bits < 8; ++bits) {
        const std::array<int, 3> signs = {bits & 1 ? -1 : 1, bits & 2 ? -1 : 1, bits & 4 ? -1 : 1};
        if (std::count(signs.begin(), signs.end(), -1) != negations) continue;
        Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
        for (int i = 0; i < 3; ++i)
          axes(i, order[static_cast<std::size_t>(i)]) = signs[static_cast<std::size_t>(i)];
        const bool about_z = axes(2, 2) > 0 && axes.determinant() > 0;
        if (about_z || !attempt.explains(transformed(attempt.samples(), axes), attempt.model())) continue;
        return axes_text(order, signs);
      }
    } while (std::next_permutation(order.begin(), order.end()));
  }
  return "";
}

// Median elevation of the points of each row; none for a row with few.
std::vector<std::optional<double>> row_elevations(const Attempt& attempt) {
  const BeamErrors errors = beam_errors(attempt.samples(), attempt.model());
  const auto& lasers = attempt.model().lasers;
  std::vector<std::vector<double>> of_row(lasers.size());
  for (std::size_t i = 0; i < attempt.samples().size(); ++i) {
    const auto l = static_cast<std::size_t>(attempt.samples()[i].laser);
    of_row[l].push_back(lasers[l].elevation_rad + errors.elevation[i]);
  }
  std::vector<std::optional<double>> elevations(lasers.size());
  for (std::size_t l = 0; l < lasers.size(); ++l) {
    if (of_row[l].size() >= kFewestOfLaser) elevations[l] = median(std::move(of_row[l]));
  }
  return elevations;
}

std::string wrong_rows(const Attempt& attempt) {
  const auto& lasers = attempt.model().lasers;
  const auto elevations = row_elevations(attempt);
  std::size_t seen = 0, fit = 0, moved = 0, upside_down = 0;
  for (std::size_t l = 0; l < lasers.size(); ++l) {
    if (!elevations[l]) continue;
    ++seen;
    std::size_t best = 0;
    for (std::size_t other = 0; other < lasers.size(); ++other) {
      const auto off = [&](std::size_t k) { return std::abs(lasers[k].elevation_rad - *elevations[l]); };
      if (off(other) < off(best)) best = other;
    }
    if (std::abs(lasers[best].elevation_rad - *elevations[l]) > attempt.tolerance().elevation_rad) continue;
    ++fit;
    if (best != l) ++moved;
    if (best + l + 1 == lasers.size()) ++upside_down;
  }
  if (seen == 0 || moved == 0 || 10 * fit < 9 * seen) return "";
  if (10 * upside_down > 9 * seen) return "the rows look upside down (row 0 is the lowest laser)";
  return fmt::format("the rows look in another order than the lasers: {} of {} have the elevation of another",
                     moved, seen);
}

// A line through the elevations of the points over those of the lasers.
std::string scaled_elevations(const Attempt& attempt) {
  const auto& lasers = attempt.model().lasers;
  const auto elevations = row_elevations(attempt);
  std::vector<std::pair<double, double>> pairs;  // said, found
  double mean_said = 0, mean_found = 0;
  for (std::size_t l = 0; l < lasers.size(); ++l) {
    if (elevations[l]) pairs.emplace_back(lasers[l].elevation_rad, *elevations[l]);
  }
  for (const auto& [said, found] : pairs) {
    mean_said += said / static_cast<double>(pairs.size());
    mean_found += found / static_cast<double>(pairs.size());
  }
  double product = 0, square = 0;
  for (const auto& [said, found] : pairs) {
    product += (said - mean_said) * (found - mean_found);
    square += (said - mean_said) * (said - mean_said);
  }
  if (square <= 0) return "";
  const double factor = std::abs(product / square - 1) < kScaled ? 1 : product / square;
  const double offset = mean_found - factor * mean_said;
  if (factor < 0) return "";  // wrong_rows or wrong_axes
  LidarModel other = attempt.model();
  for (Laser& laser : other.lasers) laser.elevation_rad = factor * laser.elevation_rad + offset;
  if (!attempt.explains(attempt.samples(), other)) return "";
  if (factor == 1)
    return fmt::format("all points are {:.1f} degrees above the elevations of their lasers",
                       offset / kDegree);
  return fmt::format("the elevations of the points are {:.2f} times those of the lasers", factor);
}

std::string wrong_elevations(const Attempt& attempt) {
  const auto elevations = row_elevations(attempt);
  LidarModel other = attempt.model();
  for (std::size_t l = 0; l < other.lasers.size(); ++l) {
    if (elevations[l]) other.lasers[l].elevation_rad = *elevations[l];
  }
  if (!attempt.explains(attempt.samples(), other)) return "";
  return "each laser is at one elevation, another than the one said (elevation_deg, origin_m)";
}

std::string wrong_azimuths(const Attempt& attempt) {
  const BeamErrors errors = beam_errors(attempt.samples(), attempt.model());
  LidarModel other = attempt.model();
  std::string first;
  for (std::size_t l = 0; l < other.lasers.size(); ++l) {
    std::vector<double> own;
    for (std::size_t i = 0; i < errors.azimuth.size(); ++i) {
      if (attempt.samples()[i].laser == static_cast<int>(l)) own.push_back(errors.azimuth[i]);
    }
    if (own.size() < kFewestOfLaser) continue;
    Laser& laser = other.lasers[l];
    const double angle = shared_angle(own);
    if (first.empty() && std::abs(angle) > attempt.tolerance().azimuth_rad) {
      first = fmt::format("azimuth_offset_deg of laser {} is {:.1f}, its points are at {:.1f}", l,
                          laser.azimuth_offset_rad / kDegree, (laser.azimuth_offset_rad + angle) / kDegree);
    }
    laser.azimuth_offset_rad += angle;
  }
  return attempt.explains(attempt.samples(), other) ? first : "";
}

std::string in_the_world(const Attempt& attempt, const GivenPoses& given) try {
  std::vector<BeamSample> samples = attempt.samples();
  for (BeamSample& s : samples) s.position_v = given(s.time) * s.position_v;
  return beam_errors(samples, attempt.model()).misfit(attempt.tolerance()) < kWorldMisfit
             ? "the points look like positions in the world frame of the poses, not in that of the sensor"
             : "";
} catch (const TrajectoryDomainError&) {
  return "";
}

}  // namespace

std::string beam_mistakes(const std::vector<BeamSample>& samples, const LidarModel& model,
                          const GivenPoses& given) {
  const Attempt attempt(samples, model);
  std::vector<std::string> found;
  const auto add = [&](const std::string& text) {
    if (!text.empty() && found.size() < kMostMistakes) found.push_back(text);
  };
  add(constant_turn(attempt));
  add(wrong_direction(attempt));
  add(wrong_axes(attempt));
  if (found.empty() && given) add(in_the_world(attempt, given));
  if (found.empty()) add(wrong_azimuths(attempt));
  if (found.empty()) add(scaled_elevations(attempt));
  if (found.size() < kMostMistakes) add(wrong_rows(attempt));
  if (found.empty()) add(wrong_elevations(attempt));
  if (found.empty()) return "another sensor?";
  return fmt::format("{}", fmt::join(found, ", or "));
}

}  // namespace mapless
