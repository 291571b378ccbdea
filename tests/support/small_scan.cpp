#include "support/small_scan.hpp"

#include <memory>
#include <numbers>

namespace mapless::test {

LidarScan small_scan(const std::vector<double>& offsets_in_columns, double range_m,
                     const std::vector<char>& missing, SpinDirection direction) {
  auto model = std::make_shared<LidarModel>();
  model->columns = kSmallColumns;
  model->direction = direction;
  model->max_range_m = 100;
  for (std::size_t l = 0; l < offsets_in_columns.size(); ++l) {
    Laser laser;
    laser.elevation_rad = 0.01 * static_cast<double>(l);
    laser.azimuth_offset_rad = offsets_in_columns[l] * model->sign() * 2 * std::numbers::pi / kSmallColumns;
    model->lasers.push_back(laser);
  }
  std::vector<LidarRecord> records;
  for (int l = 0; l < static_cast<int>(offsets_in_columns.size()); ++l) {
    for (int c = 0; c < kSmallColumns; ++c) {
      const bool gone = !missing.empty() && missing[records.size()] != 0;
      records.push_back({model->point_v(l, c, range_m).cast<float>(), l, c, c,
                         gone ? ReturnCode::faulty : ReturnCode::hit});
    }
  }
  LidarScan scan;
  scan.model = model;
  scan.columns = kSmallColumns;
  scan.column_period = Duration::from_nanoseconds(1000);
  return organise(scan, records, "test");
}

}  // namespace mapless::test
