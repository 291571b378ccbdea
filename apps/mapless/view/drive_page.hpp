#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "reports/json.hpp"
#include "view/labelled_drive.hpp"

namespace mapless::app {

/// What the page says above the scans.
struct PageTitle {
  std::string recording;  ///< path of IN, as given
  std::string result;     ///< path of OUT, as given; empty: none
};

/// The explanations of points (explanation_block.hpp); without blocks the page has none.
struct ExplainedDrive {
  std::map<std::size_t, std::string> blocks;  ///< by number of the scan
  Json header;
};

/// The page that shows the scans of a drive: one HTML file with viewer, points, poses and objects in it,
/// which loads nothing. Axes of the page: those of the sensor at the start of the first scan, x forward, z
/// up. `scans`: at least one, increasing. `progress` (scans done, scans) may be empty. Uses all threads; the
/// bytes do not depend on how many. Throws what LabelledDrive::read throws.
[[nodiscard]] std::string drive_page(const LabelledDrive& drive, const std::vector<std::size_t>& scans,
                                     const PageTitle& title, const ExplainedDrive& explained,
                                     const std::function<void(std::size_t, std::size_t)>& progress);

/// The page without a drive: page.html, built from viewer/.
[[nodiscard]] std::string_view page_template();

}  // namespace mapless::app
