#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <mapless/io/dataset.hpp>

namespace mapless::inline v1 {

/// What reading a whole recording shows: how much there is, where its times and rings come from, and what is
/// odd.
struct RecordingSurvey {
  std::size_t scans = 0;
  std::size_t readable_scans = 0;
  Time begin;
  Time end;
  double median_period_s = 0;  ///< between the starts of scans; 0 for fewer than two

  Provenance time_source = Provenance::none;
  Provenance ring_source = Provenance::none;
  bool compensated = false;            ///< by somebody else, before it was recorded
  double compensated_to_fraction = 0;  ///< of the scan's length, for the first such scan

  std::size_t records = 0;  ///< of all scans, returns or not
  std::size_t returns = 0;
  std::size_t min_returns = 0, median_returns = 0, max_returns = 0;  ///< of a scan
  std::size_t faulty = 0;   ///< cells without a return, cause unknown (NaN points count here)
  std::size_t nothing = 0;  ///< cells with nothing within range
  std::size_t unusable =
      0;  ///< records that are neither a return nor a cell of the image: NaN points of bare clouds

  std::size_t labelled_scans = 0;
  std::size_t moving_points = 0, still_points = 0, unknown_points = 0;  ///< of the truth

  std::vector<std::string>
      oddities;  ///< one line each: what cannot be read, gaps, duplicates, order, size, NaN, points beyond
                 ///< the sensor's range or off its beams, times in another unit
};

/// Reads every scan and label once. A scan or label file that cannot be read is an oddity, not an error.
[[nodiscard]] RecordingSurvey survey_recording(
    const Dataset& dataset, const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace mapless
