#include "export/semantic_kitti.hpp"

#include <algorithm>
#include <cstdint>

#include <fmt/format.h>

#include "export/new_folder.hpp"
#include "terminal/progress.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/labels.hpp>

namespace mapless::app {
namespace {

namespace fs = std::filesystem;

bool is_number(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

// Longer numbers are times; those of KITTI raw have ten digits with zeros in front.
constexpr std::size_t kMostDigits = 6;

std::string prediction_name(const fs::path& scan_file, std::size_t k) {
  const std::string stem = scan_file.stem().string();
  const std::string digits = stem.substr(std::min(stem.find_first_not_of('0'), stem.size()));
  return is_number(stem) && digits.size() <= kMostDigits ? fmt::format("{:0>6}", digits)
                                                         : fmt::format("{:06}", k);
}

fs::path predictions_folder(const fs::path& output, const std::string& sequence) {
  return output / "sequences" / sequence / "predictions";
}

}  // namespace

std::string semantic_kitti_sequence(const fs::path& recording) {
  const std::string name = fs::absolute(recording / "").lexically_normal().parent_path().filename().string();
  return is_number(name) ? name : "00";
}

void require_free_predictions(const fs::path& output, const std::string& sequence) {
  const fs::path folder = predictions_folder(output, sequence);
  if (!fs::exists(folder) || fs::is_empty(folder)) return;
  throw OutputError({folder.string(), "", "", "is there and is not an empty folder",
                     "remove it, or give another folder or --sequence"});
}

PredictionCounts write_semantic_kitti(const Dataset& dataset, const ResultFolder& result,
                                      const std::vector<std::size_t>& scans, const fs::path& output,
                                      const std::string& sequence) {
  require_free_predictions(output, sequence);
  const fs::path folder = predictions_folder(output, sequence);
  NewFolder made(folder);
  PredictionCounts counts;
  Progress progress("scans");
  for (const std::size_t k : scans) {
    auto labels = read_labels_of(result, k, dataset.read(k));
    for (std::uint32_t& label : labels) {
      const MotionTruth motion = motion_of_label(label);
      const bool moving = motion == MotionTruth::moving;
      label = moving ? kLabelDynamic : kLabelStatic;
      ++(moving ? counts.moving : counts.is_static);
      counts.unlabelled += motion == MotionTruth::unknown;
    }
    write_label_file(folder / (prediction_name(dataset.scan_file(k), k) + ".label"), labels);
    progress.update(++counts.scans, scans.size());
  }
  progress.clear();
  made.keep();
  return counts;
}

}  // namespace mapless::app
