#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "detection/detection_pipeline.hpp"
#include "detection/segmentation/linked_neighbours.hpp"
#include "detection/segmentation/marked_returns.hpp"
#include "detection/tracking/motion_classifier.hpp"

namespace mapless::inline v1 {

/// A plane surface along the velocity of an object: its points from the object's front backwards, as far as
/// no gap is wider than kWidestGap_m. Positions `along_m` are along the velocity, as it lies in the plane.
struct SlidingSide {
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
  float offset_m = 0;
  Eigen::Vector3f along = Eigen::Vector3f::UnitX();
  float front_m = 0;                  ///< foremost point of the object in the plane
  float lowest_m = 0, highest_m = 0;  ///< reach of the object across `along` in the plane

  struct Point {
    float along_m;
    std::int32_t number;
  };
  std::vector<Point> points;  ///< from the front backwards; those of moving objects among them

  [[nodiscard]] Eigen::Vector3f across() const { return normal.cross(along); }
  [[nodiscard]] float distance_m(const Eigen::Vector3f& p) const {
    return std::abs(normal.dot(p) - offset_m);
  }
};

/// Looks for the sides of objects in one scan.
class SideSearch {
 public:
  /// Keeps references. `object`: number of the proposed object of each point, `motions`: by number - 1.
  SideSearch(const LidarScan& scan, const ObjectProposals& proposed, const std::vector<TrackMotion>& motions,
             const std::vector<std::uint16_t>& object);

  /// The side of an object, given by the numbers of its points: static points linked to it lie in one plane
  /// with points of its own, along its velocity, and do not go on ahead of it.
  [[nodiscard]] std::optional<SlidingSide> side_of(std::span<const std::int32_t> object,
                                                   const Eigen::Vector3f& velocity);

  [[nodiscard]] bool moves(std::int32_t point) const {
    const std::uint16_t number = object_[static_cast<std::size_t>(point)];
    return number != 0 && motions_[number - 1U].moves;
  }

  static constexpr float kWidestGap_m = 1.5F;      ///< chosen: between the carriages of a tram
  static constexpr std::size_t kLeastPoints = 20;  ///< static ones; chosen: fewer are an edge, not a side

 private:
  using Points = std::vector<std::int32_t>;
  [[nodiscard]] Points static_points_beside(std::span<const std::int32_t> object);
  [[nodiscard]] bool find_plane(const Points& among, const Eigen::Vector3f& velocity,
                                SlidingSide& side) const;
  template <class Visit>
  void for_each_unreached(std::int32_t point, Visit&& visit) const {
    neighbours_.for_each<LinkedNeighbours::Of::unmarked>(point, kLinkRows, kLinkColumns, reached_, visit);
  }
  template <class Ends>
  [[nodiscard]] Points linked_in_plane(Points found, const Eigen::Vector3f& velocity, Ends&& ends,
                                       SlidingSide& side);
  void fit(const Points& to, const Eigen::Vector3f& velocity, SlidingSide& side) const;
  [[nodiscard]] bool measure(const Points& linked, SlidingSide& side) const;
  void place_points(SlidingSide& side) const;
  [[nodiscard]] const Eigen::Vector3f& at(std::int32_t point) const {
    return points_[static_cast<std::size_t>(point)];
  }
  [[nodiscard]] bool own_vehicle(std::int32_t point) const {
    return votes_[static_cast<std::size_t>(point)].own_vehicle;
  }

  const std::vector<Eigen::Vector3f>& points_;
  const std::vector<PointEvidence>& votes_;
  const std::vector<TrackMotion>& motions_;
  const std::vector<std::uint16_t>& object_;
  LinkedNeighbours neighbours_;
  MarkedReturns reached_;  // none between two calls
};

}  // namespace mapless
