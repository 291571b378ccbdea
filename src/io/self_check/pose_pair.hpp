#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "io/self_check/surfel_image.hpp"
#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// T_0v(t) by one account of the motion; none where it does not say.
using Motion = std::function<std::optional<SE3>(Time)>;

/// The poses of a scan at the instants of its points: of a compensated scan, all those of the instant that it
/// is compensated to. None where `motion` does not cover them.
[[nodiscard]] std::optional<ScanPoses> poses_of(const LidarScan& scan, const Motion& motion);

/// Two scans, and how well they fit each other by an account of the motion.
class PosePair {
 public:
  /// A point of the second scan counts as this far from the first at most [m].
  static constexpr double kCap_m = 0.5;

  PosePair(const LidarScan& first, const LidarScan& second);

  /// Mean distance of points of the second scan from the surfaces that the first saw there, each at most
  /// kCap_m; kCap_m where there is no such surface. 0: all the same; about 0.3: unrelated. None where
  /// `motion` does not cover the scans.
  [[nodiscard]] std::optional<double> blur_m(const Motion& motion) const;
  /// Of a constant velocity varpi (of T_0v = exp(-varpi t)) since the start of the first scan.
  [[nodiscard]] double blur_m(const Vector6d& velocity) const;
  /// How much better two accounts of the motion are than their neighbours, in standard deviations of chance:
  /// b points of the second scan are on a surface of the first, to 0.08 m, under the account alone, c under a
  /// motion 0.6, 1.2 or 2.4 m beside it alone, of those that this moves by 0.3 m along their normal;
  /// (b - c) / sqrt(b + c + 1) (McNemar 1947), the median of these motions. About 0 where nothing that is
  /// seen has the motion, or nothing tells it from its neighbours.
  struct Peaks {
    double said = 0, found = 0;
  };
  /// `found`: a constant velocity since the start of the first scan. The neighbours lie on the line between
  /// the two accounts, beyond them and, up to half of the way, between them. None where `said` does not cover
  /// the scans, or the two move the points by less than 0.6 m (median).
  [[nodiscard]] std::optional<Peaks> peaks(const Motion& said, const Vector6d& found) const;
  /// How `said` compares with `found` where they are too near each other for peaks(): whether it lies on the
  /// flank of the same peak. In standard deviations of chance, as there, of points on surfaces.
  struct Flank {
    double apart_m = 0;   ///< displacement of the points between the two (median)
    double found = 0;     ///< how much better `found` is than `said`
    double half_way = 0;  ///< how much better the motion half way between the two is than `said`
  };
  /// None where `said` does not cover the scans.
  [[nodiscard]] std::optional<Flank> flank(const Motion& said, const Vector6d& found) const;
  /// How much better each of `others` is than `said`, in standard deviations of chance, of points on
  /// surfaces, as above; 0 where one of the two does not cover the scans.
  [[nodiscard]] std::vector<double> preferences(const Motion& said, const std::vector<Motion>& others) const;
  /// Whether the points that are on surfaces under `found` alone lie within half a turn of the sensor. They
  /// may then be of one vehicle: a plane separates it from the sensor. A wrong motion shows all around.
  [[nodiscard]] bool one_sided(const Motion& said, const Vector6d& found) const;
  /// The constant velocity near `velocity` under which the two fit best.
  [[nodiscard]] Vector6d registered(Vector6d velocity) const;
  /// The constant velocity between the starts of the two scans.
  [[nodiscard]] std::optional<Vector6d> mean_velocity(const Motion& motion) const;
  /// Share of the beams that end at the same range in both scans, to 0.15 m. A sensor that stands still sees
  /// 0.9 and more, 0.85 where trams pass; one that drives on a motorway, or beside vehicles as fast as
  /// itself, less than 0.75. None where the scans have other beams.
  [[nodiscard]] std::optional<double> equal_share() const;
  /// Points of the second scan that are compared.
  [[nodiscard]] std::size_t size() const { return sample_.size(); }

 private:
  struct Match {
    Eigen::Vector3d first_0, second_0, normal_0;
    double first_s, second_s;  // since the start of the first scan
  };
  struct Comparison {
    std::optional<Match> match;
    bool free = false;  // the rays of the first scan passed through the point
  };
  [[nodiscard]] Comparison compare(const Surfel& s, const ScanPoses& first, const ScanPoses& second,
                                   double reach_m) const;
  [[nodiscard]] double blur_m(const ScanPoses& first, const ScanPoses& second) const;
  struct Poses {
    ScanPoses first, second;
  };
  [[nodiscard]] std::vector<bool> on_surfaces(const Poses& poses) const;
  [[nodiscard]] Poses beside(const Poses& poses, const Vector6d& velocity) const;
  /// Two accounts of the motion, from the start of the first scan on.
  struct Accounts {
    Poses said, found;
    Vector6d towards_found;  // the velocity that leads from `said` to `found`
    double apart_m;          // displacement of the points between the two (median)
  };
  [[nodiscard]] std::optional<Accounts> accounts(const Motion& said, const Vector6d& found) const;
  static double moved_m(const Surfel& s, const Poses& poses, const Poses& other);
  [[nodiscard]] double peak(const Poses& poses, const Vector6d& towards_other, double apart_m) const;
  bool step(Vector6d& velocity, double reach_m, double scale_m) const;

  const LidarScan &first_scan_, &second_scan_;
  SurfelImage first_, second_;
  std::vector<Surfel> sample_;  // of the second
};

}  // namespace mapless
