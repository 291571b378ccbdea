#pragma once

#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::test {

/// What compensate_locally gives beside `scan`, of a scan that was compensated already.
inline LocalPoints local_points(const CompensatedScan& scan) {
  LocalPoints local;
  local.origin_0 =
      scan.column_T_0v.empty() ? Eigen::Vector3d::Zero() : scan.column_T_0v.front().translation();
  for (const Eigen::Vector3d& p_0 : scan.points_0)
    local.points.emplace_back((p_0 - local.origin_0).cast<float>());
  return local;
}

}  // namespace mapless::test
