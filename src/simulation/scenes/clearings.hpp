#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace mapless::inline v1 {

/// Where nothing may be placed: about the paths, for walkers must not run through trunks, and about other
/// things. A square of 2 x `half_m` metres about the origin, in cells of half a metre.
class Clearings {
 public:
  explicit Clearings(double half_m)
      : half_m_(half_m),
        side_(static_cast<int>(2 * half_m / kCell)),
        taken_(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_)) {}
  [[nodiscard]] bool is_free(const Eigen::Vector2d& p) const { return !taken_[cell(p)]; }
  void take(const Eigen::Vector2d& p, double radius) {
    for (double x = -radius; x <= radius; x += kCell) {
      for (double y = -radius; y <= radius; y += kCell) taken_[cell(p + Eigen::Vector2d(x, y))] = true;
    }
  }

 private:
  static constexpr double kCell = 0.5;
  [[nodiscard]] std::size_t cell(const Eigen::Vector2d& p) const {
    const auto index = [this](double x) {
      return static_cast<std::size_t>(std::clamp(static_cast<int>((x + half_m_) / kCell), 0, side_ - 1));
    };
    return index(p.x()) * static_cast<std::size_t>(side_) + index(p.y());
  }
  double half_m_;
  int side_;
  std::vector<bool> taken_;
};

}  // namespace mapless
