#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace mapless::inline v1 {

/// The folder a run of the detector writes. Scan numbers are those of the recording, from 0, six digits:
///
///     labels/NNNNNN.label   one uint32 per input record, in input order (io/labels.hpp): 251 and the
///     object's number, label_number of its id,
///                           in the high 16 bits where dynamic, 9 where static, 0 for a record without a
///                           return
///     objects.csv           one row per object and scan: where it is and how fast, with an id kept over time
///     (io/object_table.hpp)
///     stages/NNNNNN.stages  one uint8 per input record: bit s is 1 where the point counted as dynamic after
///     stage s
///                           (0 candidates, 1 past freespace, 2 future freespace, 3 filter,
///                           4 region growth; detection/stages.hpp); 0 for a record without a return
///     poses_kitti.txt       T_0v (world from sensor) at the start of each labelled scan, 12 numbers a row,
///     in order
///     trajectory.txt        the same instants, nine more within each of these scans and the end of the last
///     one, as TUM rows
///     config.yaml           every parameter as it was used; `--config` reads it back
///     summary.json          what was read, used and found; "complete" is false until the last scan is
///     labelled
///
/// Every file is written beside and renamed, but for objects.csv, which grows by all rows of a scan at once,
/// before the scan's labels are there: whatever stops a run, the files there are whole.
class ResultFolder {
 public:
  explicit ResultFolder(std::filesystem::path path) : path_(std::move(path)) {}

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path labels() const { return path_ / "labels"; }
  [[nodiscard]] std::filesystem::path stages() const { return path_ / "stages"; }
  [[nodiscard]] std::filesystem::path label_file(std::size_t scan) const;
  [[nodiscard]] std::filesystem::path stage_file(std::size_t scan) const;
  [[nodiscard]] std::filesystem::path objects() const { return path_ / "objects.csv"; }
  [[nodiscard]] std::filesystem::path kitti_poses() const { return path_ / "poses_kitti.txt"; }
  [[nodiscard]] std::filesystem::path trajectory() const { return path_ / "trajectory.txt"; }
  [[nodiscard]] std::filesystem::path config() const { return path_ / "config.yaml"; }
  [[nodiscard]] std::filesystem::path summary() const { return path_ / "summary.json"; }

  /// Throws OutputError where the folder cannot take a new result: it exists and `overwrite` is false, it is
  /// a file, or it is neither empty nor an earlier result (of which summary.json is the sign). Changes
  /// nothing.
  void require_free(bool overwrite) const;

  /// Makes the folder anew, `summary` first: with `overwrite`, the files of an earlier result listed above
  /// are removed, and nothing else. Throws OutputError as require_free does, or with the system's reason.
  void create(bool overwrite, std::string_view summary) const;

  /// The scans that have a label file, in order; the folder need not be one of ours. Throws InputError where
  /// there is no folder `labels`.
  [[nodiscard]] std::vector<std::size_t> labelled_scans() const;

 private:
  std::filesystem::path path_;
};

/// summary.json begins with this, which is how an earlier result is told from anybody else's folder.
inline constexpr std::string_view kProgramName = "mapless detect";
inline constexpr std::string_view kSummaryBegin = "{\n  \"program\": \"mapless detect\"";

/// Writes beside and renames. Throws OutputError.
void write_stage_file(const std::filesystem::path& file, const std::vector<std::uint8_t>& masks);

/// Throws InputError for a file that cannot be read or whose length is not `expected_count`.
[[nodiscard]] std::vector<std::uint8_t> read_stage_file(const std::filesystem::path& file,
                                                        std::size_t expected_count);

}  // namespace mapless
