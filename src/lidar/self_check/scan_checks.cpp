#include "lidar/self_check/scan_checks.hpp"

#include <array>

#include <fmt/format.h>

#include "lidar/self_check/noise_check.hpp"
#include "lidar/self_check/range_check.hpp"
#include "lidar/self_check/time_check.hpp"

namespace mapless::inline v1 {

std::string_view name_of(Trust trust) {
  constexpr std::array<std::string_view, 4> kNames = {"not checked", "right", "doubtful", "wrong"};
  return kNames.at(static_cast<std::size_t>(trust));
}

void Findings::add(const ScanFinding& found, std::size_t k) {
  if (found.trust == Trust::unknown) {
    if (checked_ == 0) worst_ = found;
    return;
  }
  if (found.trust == Trust::wrong) ++wrong_;
  if (found.trust != Trust::right) bad_.push_back(k);
  const bool worse = found.trust > worst_.trust || (found.trust == worst_.trust && found.size > worst_.size);
  if (checked_++ > 0 && !worse) return;
  worst_ = found;
  worst_scan_ = k;
}

CheckResult Findings::result(const FileOf& file_of) const {
  CheckResult out{name_, worst_.trust, worst_.measured, "", "", worst_.remedy};
  if (bad_.empty()) return out;
  if (out.trust == Trust::wrong && 2 * wrong_ < checked_) out.trust = Trust::doubtful;
  out.where = file_of(worst_scan_);
  out.problem = worst_.problem;
  if (bad_.size() < checked_) {
    out.problem +=
        fmt::format(" (in {} of {} scans looked at, scan {} the first)", bad_.size(), checked_, bad_.front());
  }
  return out;
}

std::string Findings::line() const {
  if (bad_.empty()) return "";
  const std::string others = bad_.size() > 1 ? fmt::format(" (and {} others)", bad_.size() - 1) : "";
  return fmt::format("scan {}{}: {}", bad_.front(), others, worst_.problem);
}

void ScanChecks::add(const LidarScan& scan, std::size_t k, const GivenPoses& given) {
  ranges_.add(check_ranges(scan), k);
  beams_.add(check_beams(scan, given), k);
  times_.add(check_point_times(scan), k);
  noise_.add(check_noise(scan), k);
}

std::vector<CheckResult> ScanChecks::results(const FileOf& file_of) const {
  return {beams_.result(file_of), ranges_.result(file_of), times_.result(file_of), noise_.result(file_of)};
}

std::vector<std::string> ScanChecks::lines() const {
  std::vector<std::string> out;
  for (const Findings& findings : {beams_, ranges_, times_, noise_}) {
    if (std::string line = findings.line(); !line.empty()) out.push_back(std::move(line));
  }
  return out;
}

}  // namespace mapless
