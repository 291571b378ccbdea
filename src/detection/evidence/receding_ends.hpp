#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "detection/evidence/point_evidence.hpp"
#include "detection/evidence/row_line.hpp"

namespace mapless::inline v1 {

/// What slides along itself has left the place beyond its trailing end: there the scan at hand looks through,
/// and earlier scans saw the surface go on, the farther the earlier they are. So the end of what stands never
/// looks.
class RecedingEnds {
 public:
  /// Asks those of the scans `asked` that are no more than kLongestGap before. Keeps references to the first
  /// two.
  RecedingEnds(const LidarScan& scan, const LocalPoints& points, const std::vector<AskedScan>& asked,
               const RayImage& own, const VotingParameters& parameters);

  struct Line {
    RowLine line;
    std::int32_t end;  ///< the return at the end that has receded
    bool slides;       ///< the other end has not been seen to stay, or to recede too
  };
  /// Those of the lines one end of which has receded, in their order.
  [[nodiscard]] std::vector<Line> among(std::span<const RowLine> lines) const;

 private:
  struct Earlier {
    int gap;
    FreespaceProbe probe;
  };
  // A scan and one twice as far back, of earlier_.
  struct Pair {
    std::size_t nearer, farther;
  };
  struct End {
    RowLine line;                    // to the end
    Eigen::Vector3f point, outward;  // the unit direction in which the line would go on
    float column;
    float clear_m;  // so far beyond the point the surface does not reach unseen
    [[nodiscard]] Eigen::Vector3f beyond(float along_m) const { return point + along_m * outward; }
  };

  // What slides for longer is seen to move otherwise.
  static constexpr int kLongestGap = 8;
  using Steps = std::array<int, kLongestGap + 1>;  // by gap, how far an end has receded since

  // Unit directions in which a line would go on beyond its end, and in which the end is seen.
  struct Course {
    Eigen::Vector3f outward, ray;
  };
  [[nodiscard]] Course course_of(const RowLine& line) const;
  [[nodiscard]] End end_of(const RowLine& line, const Course& course) const;
  [[nodiscard]] bool may_be_free(const RowLine& line, const Course& course) const;
  static void keep(std::vector<End>& ends, const FreespaceProbe& scan, FreespaceVerdict verdict);
  enum class Way { stays, slides, shortens };
  [[nodiscard]] Way way_of(const End& end) const;
  [[nodiscard]] bool goes_on(const Steps& steps, float clear_m) const;
  [[nodiscard]] int steps_receded(const End& end, const Earlier& since) const;
  [[nodiscard]] bool stays(const End& end, float gone_m, const Earlier& since) const;

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  FreespaceProbe own_;
  float column_rad_;
  std::vector<Earlier> earlier_;  // the nearest first
  std::vector<Pair> pairs_;
};

}  // namespace mapless
