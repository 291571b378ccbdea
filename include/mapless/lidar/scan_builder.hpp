#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <mapless/core/time.hpp>
#include <mapless/lidar/lidar_model.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Turns points with, or without, ring and time into a LidarScan: the image of rays that the detector needs.
///
/// Laser of a point: its ring (numbers from 0, by increasing or decreasing elevation, whichever fits the
/// points); without rings, the laser whose cone passes nearest. Column: the nearest to the hub's angle, which
/// is the azimuth less the laser's own part (recover_firings); the time of the point gives the turn, so that
/// a scan may begin at any azimuth and be longer than a turn. Time: the point's own; without times, that of
/// the column. Labels come out in the order of the points: LidarReturn::input_index is the index here.
///
/// Immutable after construction; `build` may be called from several threads.
class ScanBuilder {
 public:
  /// For a known sensor. Throws InputError where the model cannot be one (validate).
  explicit ScanBuilder(const LidarModel& model);

  /// For an unknown sensor: estimates its lasers from scans of it , about eight from
  /// all over a recording. Rings from the field `ring`, else from the rows of an organised cloud, else from
  /// the order (ring after ring, as KITTI stores them). Spin from the times; without times, clockwise at the
  /// rate of the stamps. `stamps` has one element per scan of the recording, in time order, and may hold more
  /// than `scans`. Throws InputError naming `source` where the points do not lie on the beams of a spinning
  /// lidar.
  [[nodiscard]] static ScanBuilder recover(std::span<const PointFields> scans, std::span<const Time> stamps,
                                           const std::string& source);

  ~ScanBuilder();
  ScanBuilder(ScanBuilder&&) noexcept;
  ScanBuilder& operator=(ScanBuilder&&) noexcept;

  /// The duration of a turn, where it is known better than by the model's rotation rate: the median distance
  /// of the stamps of a recording.
  void set_turn_duration(Duration turn);

  /// `stamp`: start of the scan where points have no times or times since the stamp. With times, the scan
  /// starts at its earliest point. Throws InputError naming `source`, the field and its value: fields of
  /// different lengths, x, y or z missing, rings that are not integers or not of the sensor, times that are
  /// not finite, coarser than the scan, all equal, or more than three turns after the first, points that do
  /// not lie on the sensor's beams.
  [[nodiscard]] LidarScan build(const PointFields& points, Time stamp,
                                const std::string& source = "scan") const;

  [[nodiscard]] const std::shared_ptr<const LidarModel>& model() const;
  /// Quality of the estimate; absent for a known sensor.
  [[nodiscard]] std::optional<ModelEstimate> estimate() const;
  /// How the sensor was recovered, one line each; empty for a known sensor.
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  struct State;
  explicit ScanBuilder(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace mapless
