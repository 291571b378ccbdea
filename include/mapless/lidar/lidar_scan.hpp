#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/time.hpp>
#include <mapless/lidar/lidar_model.hpp>

namespace mapless::inline v1 {

/// What one firing of one laser gave. The first three are the codes of the native format.
enum class ReturnCode : std::uint8_t {
  hit = 0,
  faulty = 1,   ///< no return, and it is not known why: never evidence of free space
  nothing = 2,  ///< no return, and nothing stood within the maximum range
  absent = 3,   ///< the recording has no firing here (bare clouds store hits only)
};

enum class Provenance : std::uint8_t {
  none,
  sensor,                ///< a value per point in the recording
  recovered_from_angle,  ///< from the azimuth
  recovered_from_order,  ///< from the order of the points
};

/// One hit, as the sensor measured it.
struct LidarReturn {
  Eigen::Vector3f position_v;  ///< [m] in the sensor frame at the instant of firing
  float range_m;               ///< from the origin of its laser
  std::int32_t time_ns;        ///< since LidarScan::start
  std::int32_t column;
  std::int32_t laser;
  std::uint32_t input_index;  ///< which record of the input it came from
};

/// One turn of the sensor as an image: rows are lasers by increasing elevation, columns consecutive firings.
/// Columns wrap in azimuth, rows do not. Every usable record of the input is a return; where two fall into
/// one cell (clouds whose columns had to be recovered), the cell shows the nearer.
struct LidarScan {
  std::shared_ptr<const LidarModel> model;
  Time start;                  ///< of column 0
  Duration column_period;      ///< between consecutive columns
  int columns = 0;             ///< of this scan; column c has the hub angle model->hub_angle(c)
  std::size_t input_size = 0;  ///< records of the input, hits or not: the length of a label file
  Provenance time_source = Provenance::none;
  Provenance ring_source = Provenance::none;
  std::optional<Time>
      compensated_to;  ///< set where position_v was already moved to one instant by somebody else

  std::vector<LidarReturn> returns;  ///< by laser, then column, then input index
  std::vector<std::int32_t> cells;   ///< rows x columns, row-major: index into returns, or a negative code

  [[nodiscard]] int rows() const { return static_cast<int>(model->lasers.size()); }
  [[nodiscard]] Time column_time(int column) const {
    return start + Duration::from_nanoseconds(column * column_period.nanoseconds());
  }
  [[nodiscard]] Time end() const { return column_time(columns); }
  [[nodiscard]] Time time_of(const LidarReturn& r) const {
    return start + Duration::from_nanoseconds(r.time_ns);
  }
  [[nodiscard]] std::int32_t cell(int row, int column) const {
    return cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                 static_cast<std::size_t>(column)];
  }
};

/// Cells without a return hold these; anything >= 0 is an index into LidarScan::returns.
[[nodiscard]] constexpr std::int32_t empty_cell(ReturnCode code) { return -static_cast<std::int32_t>(code); }
[[nodiscard]] constexpr ReturnCode code_of_cell(std::int32_t cell) {
  return cell >= 0 ? ReturnCode::hit : static_cast<ReturnCode>(-cell);
}

/// One record of a recording before it is put into its place in the image.
struct LidarRecord {
  Eigen::Vector3f position_v;  ///< [m]; not finite: no return
  std::int32_t laser;          ///< row, 0 is the lowest
  std::int32_t column;
  std::int32_t time_ns;  ///< since the scan's start
  ReturnCode code;
};

/// Puts the records (record i is input i) into their cells. `scan` comes with everything but returns, cells
/// and input_size. Records with code hit but a non-finite position, or nearer than 1 cm to their laser, count
/// as faulty; cells no record names are absent. Throws InputError naming `source` for a laser, column or time
/// out of range.
[[nodiscard]] LidarScan organise(LidarScan scan, const std::vector<LidarRecord>& records,
                                 const std::string& source);

}  // namespace mapless
