#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <mapless/io/labels.hpp>

namespace mapless::inline v1 {

// Declared only: room evaluation includes this header and must not depend on detection.
struct Detection;
struct TrackedObject;
struct LidarScan;

/// The program named in summary.json, and the start of that file, by which require_free recognises an earlier
/// result: of `mapless detect`, and of `mapless odometry`, which writes poses_kitti.txt, trajectory.txt,
/// poses.csv, config.yaml and summary.json alone.
inline constexpr std::string_view kProgramName = "mapless detect";
inline constexpr std::string_view kSummaryBegin = "{\n  \"program\": \"mapless detect\"";
inline constexpr std::string_view kOdometryProgramName = "mapless odometry";
inline constexpr std::string_view kOdometrySummaryBegin = "{\n  \"program\": \"mapless odometry\"";

/// The folder that a run of the detector writes. Scan numbers are those of the recording, from 0, six digits:
///
///     labels/NNNNNN.label   one uint32 per input record, in input order (io/labels.hpp): 251 for a
///                           dynamic point, with the label_number of its object in the high 16 bits;
///                           9 for a static point; 0 for a record without a return, and for all records
///                           of a scan whose motion odometry has lost
///     objects.csv           one row per tracked object and scan: id, position, size, velocity
///                           (io/labels.hpp)
///     stages/NNNNNN.stages  one uint8 per input record: bit s is 1 if the point is dynamic after
///                           stage s (detection/detection.hpp); 0 for a record without a return
///     probability/NNNNNN.f32  only with --probability: one float32 per input record, little endian, the
///                           probability that the point moves; NaN where it is not known: without a return,
///                           and in a scan whose motion odometry has lost
///     poses_kitti.txt       T_0v (world from sensor) at the start of each labelled scan, 12 numbers per row
///     trajectory.txt        TUM rows at the same instants, at nine more within each of these scans, and
///                           at the end of the last one
///     poses.csv             only along own odometry, one row per labelled scan: its pose, the state of its
///                           motion (good, degenerate or lost) and the figures behind it
///     config.yaml           the value of every parameter of the run; `--config` reads it
///     summary.json          input, parameters and statistics of the run; "complete" is false until the
///                           last scan is labelled
///
/// Files are written atomically, except the four tables, which grow by all rows of a scan at once, before the
/// labels of that scan are written; trajectory.txt follows one scan later. Everything is synchronised to the
/// disk as it is written. If a run is stopped, every file in the folder is complete up to its last scan.
class ResultFolder {
 public:
  explicit ResultFolder(std::filesystem::path path) : path_(std::move(path)) {}

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path labels() const { return path_ / "labels"; }
  [[nodiscard]] std::filesystem::path stages() const { return path_ / "stages"; }
  [[nodiscard]] std::filesystem::path probabilities() const { return path_ / "probability"; }
  [[nodiscard]] std::filesystem::path label_file(std::size_t scan) const;
  [[nodiscard]] std::filesystem::path stage_file(std::size_t scan) const;
  [[nodiscard]] std::filesystem::path probability_file(std::size_t scan) const;
  [[nodiscard]] std::filesystem::path objects() const { return path_ / "objects.csv"; }
  [[nodiscard]] std::filesystem::path kitti_poses() const { return path_ / "poses_kitti.txt"; }
  [[nodiscard]] std::filesystem::path trajectory() const { return path_ / "trajectory.txt"; }
  [[nodiscard]] std::filesystem::path poses() const { return path_ / "poses.csv"; }
  [[nodiscard]] std::filesystem::path config() const { return path_ / "config.yaml"; }
  [[nodiscard]] std::filesystem::path summary() const { return path_ / "summary.json"; }

  /// Throws OutputError if a new result cannot be written here: the path is a file, or the folder is not
  /// empty and `overwrite` is false or it is no earlier result (whose summary.json begins with
  /// `summary_begin`). A folder with nothing but the lock of a run and a part of its first summary is empty.
  /// Changes nothing.
  void require_free(bool overwrite, std::string_view summary_begin = kSummaryBegin) const;

  /// Creates the folder and writes `summary`. With `overwrite`, removes the files of an earlier result listed
  /// above and nothing else. Throws OutputError as require_free does, or with the reason of the system.
  void create(bool overwrite, std::string_view summary) const;

  /// The same for a result of `mapless odometry`: its tables are removed, and no folder is made in it.
  void create_for_odometry(bool overwrite, std::string_view summary) const;

  /// Creates the folder for the files of probabilities. Throws OutputError.
  void create_probabilities() const;

  /// Removes the files that a killed run was about to write (write_file_atomically). Throws OutputError.
  void remove_partial_files() const;

  /// Numbers of the scans with a label file, increasing. The folder may be made by another program. Throws
  /// InputError if there is no folder `labels`.
  [[nodiscard]] std::vector<std::size_t> labelled_scans() const;

 private:
  void remove_tables() const;

  std::filesystem::path path_;
};

/// The file in an output folder that a run holds locked (apps/mapless/run/folder_lock.hpp).
inline constexpr std::string_view kLockFile = ".lock";

/// Writes a stage file atomically. Throws OutputError.
void write_stage_file(const std::filesystem::path& file, const std::vector<std::uint8_t>& masks);

/// Reads a stage file. Throws InputError for a file that cannot be read or whose length is not
/// `expected_count`.
[[nodiscard]] std::vector<std::uint8_t> read_stage_file(const std::filesystem::path& file,
                                                        std::size_t expected_count);

/// Writes a file of probabilities atomically. Throws OutputError.
void write_probability_file(const std::filesystem::path& file, const std::vector<float>& probabilities);

/// Reads a file of probabilities. Throws InputError for a file that cannot be read, whose length is not
/// `expected_count` x 4 bytes, or with a number outside [0, 1] that is not NaN.
[[nodiscard]] std::vector<float> read_probability_file(const std::filesystem::path& file,
                                                       std::size_t expected_count);

/// Throws InputError naming `file` where `labels`, written by mapless detect, one per input record, are not
/// of `scan`: more than 1 % are at records without a return, or missing where there is one. Labels that are
/// all 0 fit every scan. Nothing is shown where every record has a return.
void require_labels_of(const LidarScan& scan, const std::vector<std::uint32_t>& labels,
                       const std::filesystem::path& file);
/// Reads the labels of `scan`, number `k` of the recording, one per input record. Throws InputError as
/// read_label_file(), and, in a folder that mapless detect wrote, as require_labels_of().
[[nodiscard]] std::vector<std::uint32_t> read_labels_of(const ResultFolder& result, std::size_t k,
                                                        const LidarScan& scan);

/// One label per input record, in input order: kLabelDynamic with the number of the object in the high 16
/// bits, kLabelStatic, or 0 for a record without a return; all 0 where Detection::motion_known is false.
[[nodiscard]] std::vector<std::uint32_t> labels_of(const Detection& detection);
/// The same labels, with label_number(id) of the tracked objects as their number. `objects`: all objects of
/// the scan.
[[nodiscard]] std::vector<std::uint32_t> labels_of(const Detection& detection,
                                                   const std::vector<TrackedObject>& objects);

/// The tracked objects of scan number `scan` as rows of objects.csv.
[[nodiscard]] std::vector<ObjectRow> object_rows(std::size_t scan, const std::vector<TrackedObject>& objects);

/// One byte per input record: bit s is 1 if the point is dynamic after Stage s; 0 without a return.
[[nodiscard]] std::vector<std::uint8_t> stage_masks_of(const Detection& detection);

}  // namespace mapless
