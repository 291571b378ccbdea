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
#include <mapless/io/files.hpp>

namespace mapless::inline v1 {

/// Labels of the SemanticKITTI moving-object convention: class in the low 16 bits, object number in the high
/// 16 bits.
inline constexpr std::uint32_t kLabelUnknown = 0;
inline constexpr std::uint32_t kLabelStatic = 9;
inline constexpr std::uint32_t kLabelDynamic = 251;

/// Object number in a label for the object id >= 1: ids beyond 65535 start again at 1.
[[nodiscard]] constexpr std::uint16_t label_number(std::uint32_t id) {
  return static_cast<std::uint16_t>((id - 1) % 65535u + 1);
}

/// Motion state of a label: classes 251 to 259 (any moving class) are moving; 0 and 1 (outlier) are unknown.
enum class MotionTruth { unknown, still, moving };
[[nodiscard]] constexpr MotionTruth motion_of_label(std::uint32_t label) {
  const std::uint32_t c = label & 0xFFFFu;
  if (c >= 251 && c <= 259) return MotionTruth::moving;
  return c <= 1 ? MotionTruth::unknown : MotionTruth::still;
}

/// Reads a label file: one little-endian uint32 per input record. Throws InputError for a file that cannot be
/// read, whose length is not `expected_count` x 4 bytes, or with a class above 259.
[[nodiscard]] std::vector<std::uint32_t> read_label_file(const std::filesystem::path& file,
                                                         std::size_t expected_count);

/// Writes a label file atomically (write_file_atomically). Throws OutputError.
void write_label_file(const std::filesystem::path& file, const std::vector<std::uint32_t>& labels);

/// A row of the objects.csv of a recording.
struct ObjectDescription {
  std::string object_class;
  std::string kind;  ///< "mover", "parked" or "carrier" (of the sensor) in a simulated recording
};

/// A row of object_states.csv: the true state of a mover in the middle of a scan in which it has a return, in
/// the world frame of the recording's trajectory.
struct ObjectState {
  Time time;
  /// Centre of the bounding box of all its parts along the axes of its body [m].
  Eigen::Vector3d centre_0 = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_0 = Eigen::Vector3d::Zero();  ///< of the origin of its body [m/s]
  double speed_mps = 0;
};

/// True objects of a recording, by the numbers in its true labels.
struct ObjectTruth {
  bool has_descriptions = false;                            ///< the recording has an objects.csv
  bool has_states = false;                                  ///< the recording has an object_states.csv
  std::map<std::uint32_t, ObjectDescription> descriptions;  ///< by object id
  std::map<std::pair<std::size_t, std::uint32_t>, ObjectState> states;  ///< by scan and object id
};

/// Reads objects.csv (object_id,class,kind; or id,class, of objects of no known kind) and object_states.csv
/// (scan,object_id,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps,speed_mps) of a folder, if present. Throws
/// InputError naming file and line for another table, and for an object or a state that occurs twice.
[[nodiscard]] ObjectTruth read_object_truth(const std::filesystem::path& folder);

/// Writes object_states.csv scan by scan. Between two calls the file is complete.
class ObjectStatesWriter {
 public:
  /// Creates the file. Throws OutputError.
  explicit ObjectStatesWriter(std::filesystem::path file);

  /// Appends the states of one scan, by object id. Throws OutputError; the file then keeps its earlier rows.
  void add(std::size_t scan, const std::map<std::uint32_t, ObjectState>& states);

 private:
  std::filesystem::path file_;
};

/// A row of the objects.csv of a result: one tracked object in one scan, in the world frame of its
/// trajectory.txt.
struct ObjectRow {
  std::size_t scan = 0;  ///< number of the scan in the recording
  Time time;             ///< mean time of its points, at which centre and velocity hold
  std::uint32_t id = 0;  ///< constant over scans; label_number(id) in the label file
  int points = 0;
  Eigen::Vector3d centre_0 = Eigen::Vector3d::Zero();        ///< of the bounding box along the world axes [m]
  Eigen::Vector3d extent_0 = Eigen::Vector3d::Zero();        ///< sides of that box [m]
  Eigen::Vector3d velocity_0 = Eigen::Vector3d::Zero();      ///< [m/s]
  Eigen::Vector3d velocity_std_0 = Eigen::Vector3d::Zero();  ///< standard deviation per axis [m/s]
  int age = 1;  ///< number of scans from its first to this one, both included
};

/// Writes the table scan by scan: scan,time_s,id,points,x_m,y_m,z_m,extent_x_m,extent_y_m,extent_z_m,vx_mps,
/// vy_mps,vz_mps,std_vx_mps,std_vy_mps,std_vz_mps,age_scans. Between two calls the file is complete.
class ObjectTableWriter {
 public:
  /// Creates the file, or goes on with that of an earlier run. Throws as GrowingFile does.
  explicit ObjectTableWriter(std::filesystem::path file, GrowingFile::Start start = GrowingFile::Start::anew);

  /// Appends rows. Throws OutputError; the file then keeps its earlier rows.
  void add(const std::vector<ObjectRow>& rows);
  /// Throws InputError where the file of the earlier run does not hold these rows next.
  void verify(const std::vector<ObjectRow>& rows);

 private:
  GrowingFile file_;
};

/// All rows in the order of the file. Throws InputError naming file and line for another table, and for two
/// rows of one scan with the same label_number.
[[nodiscard]] std::vector<ObjectRow> read_object_table(const std::filesystem::path& file);

}  // namespace mapless
