#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// A row of the objects.csv of a result: one object in one scan, in the world of its trajectory.txt.
struct ObjectRow {
  std::size_t scan = 0;  ///< of the recording
  Time time;             ///< mean instant of its points, of which centre, extent and velocity are
  std::uint32_t id = 0;  ///< kept over scans; label_number(id) in the label file
  int points = 0;
  Eigen::Vector3d centre_0 = Eigen::Vector3d::Zero();        ///< of the box along the axes of the world [m]
  Eigen::Vector3d extent_0 = Eigen::Vector3d::Zero();        ///< its sides [m]
  Eigen::Vector3d velocity_0 = Eigen::Vector3d::Zero();      ///< [m/s]
  Eigen::Vector3d velocity_std_0 = Eigen::Vector3d::Zero();  ///< per axis [m/s]
  int age = 1;  ///< scans from its first to this one, both counted
};

/// Writes the table scan by scan: scan,time_s,id,points,x_m,y_m,z_m,extent_x_m,extent_y_m,extent_z_m,vx_mps,
/// vy_mps,vz_mps,std_vx_mps,std_vy_mps,std_vz_mps,age_scans. Between two calls the file is whole.
class ObjectTableWriter {
 public:
  /// Makes the file. Throws OutputError.
  explicit ObjectTableWriter(std::filesystem::path file);

  /// Appends rows. Throws OutputError and leaves the rows before as they were.
  void add(const std::vector<ObjectRow>& rows);

 private:
  std::filesystem::path file_;
};

/// All rows, in the order of the file. Throws InputError naming file and line for what is no such table, and
/// for two rows of one scan with the same number in its labels.
[[nodiscard]] std::vector<ObjectRow> read_object_table(const std::filesystem::path& file);

}  // namespace mapless
