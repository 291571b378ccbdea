#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "detection/segmentation/disjoint_sets.hpp"
#include <mapless/core/se3.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Finds the returns on the sensor's own vehicle (a bonnet, mirrors, a mast), learnt while it moves.
///
/// A cell of the scan image is a ray fixed in the sensor frame. On the own vehicle its range is constant.
/// Elsewhere it changes as the sensor moves, except on surfaces along the motion, such as flat ground.
///
/// - Key scans: the sensor has moved by kKeyDistance_m or turned by kKeyAngle_rad since the one before.
/// - A cell is constant if its range was the same, within the tolerance, in at least kFewestKeyScans key
///   scans, and in nine tenths of those with a return. While there are fewer key scans, but at least
///   kFewestFirstKeyScans, it has to be the same in all of them; without another range, returns may lack in
///   two of ten of these. A return in a column beside it counts, too: of paint that returns every second
///   firing nearly every cell has one in each scan. Only ranges below kLargestRange_m are learnt.
/// - A run of consecutive constant cells of a row, of one surface, ends freely if something nearer or farther
///   is beside both of its ends, or nothing, and was there in all key scans; or if the run goes all around.
///   The side of a lorry that passes slides along itself, so its ranges are constant; but its ends and its
///   gaps move: next to the constant cells the surface goes on, or went on before. Cells of few returns, up
///   to kMostBridged, do not divide a run.
/// - A body is made of runs of neighbouring rows, of one surface. It is on the own vehicle if half of it or
///   more is in runs that end freely. Ground between parts of the own vehicle may count as one of them.
///   So it must have been in most of the last key scans, up to kMostOwn: what is behind its edges comes and
///   goes.
/// - A return is on the own vehicle if its range is that of such a cell in its row, at most
///   kColumnsAside from its own. Anything in front of the own vehicle has another range.
///
/// A vehicle alongside whose ends move by less than three columns in all key scans so far cannot be
/// distinguished from the own one: in half a second one that is slower or faster by less than 0.14 m/s
/// (HDL-64E; 4 m to its end, 3 m to its side).
class OwnVehicle {
 public:
  /// Takes the next scan. `T_v0`: pose of the sensor at the start of the scan; `tolerance_m`: largest
  /// difference between two ranges of one surface [m].
  void learn(const LidarScan& scan, const SE3& T_v0, double tolerance_m);
  /// The returns of a scan on the own vehicle as learnt so far, by increasing index.
  [[nodiscard]] std::vector<std::int32_t> find(const LidarScan& scan, double tolerance_m) const;

 private:
  struct Cell {
    float range_m = 0;        // 0: none below kLargestRange_m
    std::uint8_t same = 0;    // key scans with this range
    std::uint8_t others = 0;  // with another
    std::int8_t own = 0;      // key scans in which its body was the own vehicle less the others, of the last
    [[nodiscard]] bool constant(int key_scans) const;
    void add(float seen_m, float tolerance_m);
  };
  [[nodiscard]] std::size_t cell_index(int row, int column) const;
  [[nodiscard]] bool is_key_scan(const SE3& T_v0);
  void count_ranges(const LidarScan& scan, float tolerance_m);
  void count_range(const LidarScan& scan, int row, int column, float tolerance_m);
  struct Run {  // consecutive constant cells of one row, of one surface
    int row;
    bool ends_freely;  // on both sides
    std::vector<int> columns;
  };
  [[nodiscard]] std::vector<Run> all_runs(const LidarScan& scan) const;
  [[nodiscard]] DisjointSets bodies_of(const std::vector<Run>& runs) const;
  void find_own_cells(const LidarScan& scan);
  [[nodiscard]] std::vector<std::vector<int>> constant_runs(int row) const;
  [[nodiscard]] bool ends_freely(const LidarScan& scan, int row, int column, int side) const;

  std::shared_ptr<const LidarModel> model_;
  std::vector<Cell> cells_;             // row-major, one per laser and column of the model
  std::vector<std::uint8_t> own_;       // of each cell, 0 or 1
  std::vector<std::uint8_t> near_own_;  // whether such a cell is at most kColumnsAside away
  bool any_own_ = false;
  std::optional<SE3> key_T_v0_;  // of the last key scan
  int key_scans_ = 0;            // so far
};

}  // namespace mapless
