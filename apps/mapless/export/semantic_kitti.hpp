#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <mapless/io/dataset.hpp>
#include <mapless/io/result_folder.hpp>

namespace mapless::app {

/// How many points were written with which label.
struct PredictionCounts {
  std::size_t scans = 0, moving = 0, is_static = 0;
  std::size_t unlabelled = 0;  ///< of is_static: without a label in the result
};

/// The sequence of a recording in sequences/NN: "NN"; "00" for any other recording.
[[nodiscard]] std::string semantic_kitti_sequence(const std::filesystem::path& recording);

/// Throws OutputError where the folder for the predictions holds something.
void require_free_predictions(const std::filesystem::path& output, const std::string& sequence);

/// Writes the labels of scans of a result for evaluate_mos.py of semantic-kitti-api:
/// output/sequences/`sequence`/predictions/NNNNNN.label, with the number that the scan's file has for a name,
/// else with that of the scan. One uint32 per input record, 251 moving or 9 static. A record
/// without a label is static: the evaluation would leave a prediction of 0 out, and flatter the result.
/// Throws InputError for labels that do not fit the recording, OutputError.
PredictionCounts write_semantic_kitti(const Dataset& dataset, const ResultFolder& result,
                                      const std::vector<std::size_t>& scans,
                                      const std::filesystem::path& output, const std::string& sequence);

}  // namespace mapless::app
