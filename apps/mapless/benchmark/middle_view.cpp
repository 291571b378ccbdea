#include "benchmark/middle_view.hpp"

#include <algorithm>

#include "view/drive_page.hpp"
#include "view/labelled_drive.hpp"
#include <mapless/io/files.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::app {

MiddleView::MiddleView(std::size_t scans)
    : first_(scans / 2 - std::min(scans / 2, kScans / 2)), end_(std::min(scans, first_ + kScans)) {}

void MiddleView::add(const Detection& detection) {
  const std::size_t k = detection.sequence_number;
  if (k < first_ || k >= end_) return;
  labels_[k] = labels_of(detection, detection.tracked);
  const std::vector<ObjectRow> rows = object_rows(k, detection.tracked);
  objects_.insert(objects_.end(), rows.begin(), rows.end());
}

void MiddleView::write(const Dataset& dataset, const std::string& recording,
                       const std::filesystem::path& file) const {
  const LabelledDrive drive(dataset, labels_, objects_);
  const DriveEncoder encoder(drive, drive.scans());
  write_file_atomically(file, drive_page(encoder, {recording, ""}, {}, {}));
}

}  // namespace mapless::app
