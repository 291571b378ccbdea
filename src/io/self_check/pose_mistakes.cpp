#include "io/self_check/pose_mistakes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <mapless/core/errors.hpp>

namespace mapless::inline v1 {
namespace {

std::optional<SE3> pose_at(const Trajectory& given, Time t) {
  if (t < given.begin() || t > given.end()) return std::nullopt;
  return given.at(t).T_v0.inverse();
}

Motion changed(const std::shared_ptr<const Trajectory>& given, const std::function<SE3(const SE3&)>& change) {
  return [given, change](Time t) -> std::optional<SE3> {
    const auto T_0v = pose_at(*given, t);
    return T_0v ? std::optional(change(*T_0v)) : std::nullopt;
  };
}

Motion at_other_times(const std::shared_ptr<const Trajectory>& given, double factor, double shift_s) {
  return [given, factor, shift_s](Time t) -> std::optional<SE3> {
    const double seconds = factor * t.seconds() + shift_s;
    if (std::abs(seconds) > Duration::kMaxSeconds) return std::nullopt;
    return pose_at(*given, Time::from_seconds(seconds));
  };
}

// All matrices that exchange and negate axes, the identity first.
std::vector<Eigen::Matrix3d> signed_permutations() {
  std::vector<Eigen::Matrix3d> out;
  std::array<int, 3> order = {0, 1, 2};
  do {
    for (unsigned bits = 0; bits < 8; ++bits) {
      Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
      for (unsigned i = 0; i < 3; ++i) axes(static_cast<int>(i), order[i]) = (bits >> i & 1U) != 0 ? -1 : 1;
      out.push_back(axes);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return out;
}

std::string axes_text(const Eigen::Matrix3d& axes) {
  constexpr std::array<const char*, 3> kNames = {"x", "y", "z"};
  std::string text;
  for (int i = 0; i < 3; ++i) {
    Eigen::Index j = 0;
    axes.row(i).cwiseAbs().maxCoeff(&j);
    text += fmt::format("{}{}{}", i > 0 ? ", " : "", axes(i, j) < 0 ? "-" : "",
                        kNames[static_cast<std::size_t>(j)]);
  }
  return text;
}

void add_units(const std::shared_ptr<const Trajectory>& given, std::vector<PoseMistake>& out) {
  constexpr std::array<std::pair<const char*, double>, 5> kUnits = {
      {{"millimetres", 1e-3},
       {"centimetres", 1e-2},
       {"feet", 0.3048},
       {"kilometres", 1e3},
       {"metres, the points feet", 1 / 0.3048}}};
  for (const auto& [name, metres] : kUnits) {
    out.push_back({fmt::format("positions look like {}", name), changed(given, [m = metres](const SE3& T) {
                     return SE3(T.rotation(), m * T.translation());
                   })});
  }
  constexpr std::array<std::pair<const char*, double>, 3> kTimes = {
      {{"milliseconds", 1e3}, {"microseconds", 1e6}, {"nanoseconds", 1e9}}};
  for (const auto& [name, factor] : kTimes)
    out.push_back({fmt::format("times of the poses look like {}", name), at_other_times(given, factor, 0)});
  for (const double shift_s : {0.1, 0.2, 0.5, 1.0, -0.1, -0.2, -0.5, -1.0}) {
    out.push_back(
        {fmt::format("times of the poses look {} s {}", std::abs(shift_s), shift_s > 0 ? "late" : "early"),
         at_other_times(given, 1, shift_s)});
  }
}

void add_axes(const std::shared_ptr<const Trajectory>& given, std::vector<PoseMistake>& out) {
  for (const Eigen::Matrix3d& axes : signed_permutations()) {
    if (axes.isIdentity()) continue;
    out.push_back(
        {fmt::format("x, y, z of the positions look like {}", axes_text(axes)),
         changed(given, [axes](const SE3& T) { return SE3(T.rotation(), axes * T.translation()); })});
  }
  for (const Eigen::Matrix3d& axes : signed_permutations()) {
    if (axes.isIdentity() || axes.determinant() < 0) continue;
    out.push_back(
        {fmt::format("poses look like those of a body whose axes are {} of the sensor's", axes_text(axes)),
         changed(given, [axes](const SE3& T) { return SE3(T.rotation() * axes, T.translation()); })});
  }
}

}  // namespace

Motion motion_of(const std::shared_ptr<const Trajectory>& given) {
  return changed(given, [](const SE3& T) { return T; });
}

std::vector<PoseMistake> pose_mistakes(const std::shared_ptr<const Trajectory>& given) {
  std::vector<PoseMistake> out;
  out.push_back(
      {"the scans look as if the sensor stood still", [](Time) -> std::optional<SE3> { return SE3(); }});
  out.push_back(
      {"poses look inverted (sensor from world)", changed(given, [](const SE3& T) { return T.inverse(); })});
  out.push_back({"quaternions look like w x y z", changed(given, [](const SE3& T) {
                   const Eigen::Quaterniond q(T.rotation());
                   return SE3(Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w()).toRotationMatrix(),
                              T.translation());
                 })});
  out.push_back({"rotations look inverted", changed(given, [](const SE3& T) {
                   return SE3(T.rotation().transpose(), T.translation());
                 })});
  add_units(given, out);
  add_axes(given, out);
  return out;
}

}  // namespace mapless
