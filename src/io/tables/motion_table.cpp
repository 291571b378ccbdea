#include <array>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "io/files/text.hpp"
#include "io/tables/pose_numbers.hpp"
#include <mapless/io/files.hpp>
#include <mapless/io/trajectory_file.hpp>

namespace mapless::inline v1 {
namespace {

std::string text_of(const MotionRow& row) {
  const Eigen::Matrix3d& C = row.motion_covariance_v;
  const std::array upper = {C(0, 0), C(0, 1), C(0, 2), C(1, 1), C(1, 2), C(2, 2)};
  return fmt::format("{},{},{},{},{:.4f},{:.4f},{:.6f},{:.3e}\n", row.scan, decimal_seconds(row.pose.time),
                     fmt::join(pose_numbers(row.pose.T_v0.inverse()), ","), row.state, row.inlier_ratio,
                     row.mean_robust_weight, row.constraint_ratio, fmt::join(upper, ","));
}

}  // namespace

std::string motion_table_rows(const std::vector<MotionRow>& rows) {
  std::string text;
  for (const MotionRow& row : rows) text += text_of(row);
  return text;
}

void write_motion_table(const std::filesystem::path& file, const std::vector<MotionRow>& rows) {
  write_file_atomically(file, std::string(kMotionTableHead) + motion_table_rows(rows));
}

}  // namespace mapless
