#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "reports/json.hpp"
#include "view/labelled_drive.hpp"
#include "view/scan_block.hpp"

namespace mapless::app {

/// What the page says above the scans.
struct PageTitle {
  std::string recording;  ///< path of IN, as given
  std::string result;     ///< path of OUT, as given; empty: none
};

/// Writes a drive as the page reads it (viewer/src/drive.ts). Axes of the page: those of the sensor at the
/// start of the first scan, x forward, z up. Functions throw what LabelledDrive::read throws, and may be
/// called from several threads.
class DriveEncoder {
 public:
  /// `drive` outlives the encoder. `scans`: at least one, increasing. Reads the first of them.
  DriveEncoder(const LabelledDrive& drive, std::vector<std::size_t> scans);

  struct EncodedScan {
    Json header;
    std::string bytes;  ///< encode_scan
  };

  [[nodiscard]] const std::vector<std::size_t>& scans() const { return scans_; }
  /// Of the drive, without its scans.
  [[nodiscard]] Json header(const PageTitle& title) const;
  /// What is known of a scan before it is read: number, time, pose, objects.
  [[nodiscard]] Json outline(std::size_t scan) const;
  [[nodiscard]] EncodedScan encode(std::size_t scan) const;

 private:
  [[nodiscard]] Json placed(std::size_t scan, Time start, Time end, const SE3& T_0v) const;

  const LabelledDrive& drive_;
  std::vector<std::size_t> scans_;
  SE3 T_page_world_;
  OptionalPlanes planes_;
  bool with_truth_ = false;
};

}  // namespace mapless::app
