#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "reports/json.hpp"
#include "view/drive_encoder.hpp"

namespace mapless::app {

/// The explanations of points (explanation_block.hpp); without blocks the page has none.
struct ExplainedDrive {
  std::map<std::size_t, std::string> blocks;  ///< by number of the scan
  Json header;
};

/// The page that shows the scans of a drive: one HTML file with viewer, points, poses and objects in it,
/// which loads nothing. `progress` (scans done, scans) may be empty. Uses all threads; the bytes do not
/// depend on how many. Throws what DriveEncoder throws.
[[nodiscard]] std::string drive_page(const DriveEncoder& encoder, const PageTitle& title,
                                     const ExplainedDrive& explained,
                                     const std::function<void(std::size_t, std::size_t)>& progress);

/// The same page without the points, which it loads scan by scan from `scan/NUMBER` beside it, and, if
/// `explained`, the explanations of a scan from `explain/NUMBER` (ExplanationReplay::answer) on a click.
[[nodiscard]] std::string served_page(const DriveEncoder& encoder, const PageTitle& title, bool explained);

/// The explanations of a scan as the served page reads them: the size of a JSON text (uint32, little endian),
/// the text (explanation_header) and the block (encode_explanation).
[[nodiscard]] std::string served_explanation(const Json& header, const std::string& block);

/// What the served page loads: the size of a JSON text (uint32, little endian), the text, which is the scan's
/// header, and its points (encode_scan).
[[nodiscard]] std::string served_scan(const DriveEncoder& encoder, std::size_t scan);

/// The page without a drive: page.html, built from viewer/.
[[nodiscard]] std::string_view page_template();

}  // namespace mapless::app
