#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/time.hpp>

namespace mapless::inline v1 {

/// A row of objects.csv.
struct ObjectDescription {
  std::string object_class;
  std::string kind;  ///< "mover" or "parked" of a simulated recording
};

/// A row of object_states.csv: a mover in the middle of a scan in which it has a return. World frame of the
/// recording's trajectory.
struct ObjectState {
  Time time;
  /// Centre of the box about all its parts, along the axes of its body [m].
  Eigen::Vector3d centre_0 = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_0 = Eigen::Vector3d::Zero();  ///< of its body's origin [m/s]
  double speed_mps = 0;
};

/// What a recording tells of the objects its true labels number.
struct ObjectTruth {
  bool has_descriptions = false;                                        ///< there is an objects.csv
  bool has_states = false;                                              ///< there is an object_states.csv
  std::map<std::uint32_t, ObjectDescription> descriptions;              ///< by object id
  std::map<std::pair<std::size_t, std::uint32_t>, ObjectState> states;  ///< by scan and object id
};

/// Reads objects.csv (object_id,class,kind) and object_states.csv
/// (scan,object_id,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps,speed_mps) of a folder, where they are. Throws
/// InputError naming file and line for what is no such table, and for an object, or its state, given twice.
[[nodiscard]] ObjectTruth read_object_truth(const std::filesystem::path& folder);

/// Writes object_states.csv scan by scan; between two calls it is whole.
class ObjectStatesWriter {
 public:
  /// Makes the file. Throws OutputError.
  explicit ObjectStatesWriter(std::filesystem::path file);

  /// Appends the states of one scan, by object id. Throws OutputError and leaves the rows before as they
  /// were.
  void add(std::size_t scan, const std::map<std::uint32_t, ObjectState>& states);

 private:
  std::filesystem::path file_;
};

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
