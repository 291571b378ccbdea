#pragma once

/// @file
/// Room live: a sensor while it runs. Clouds as the drivers publish them and poses go in; labelled clouds,
/// objects, odometry and diagnostics come out. No middleware is in it: `mapless live` and the ROS 2 node are
/// shells that copy messages into its structs and back.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <mapless/core/time.hpp>
#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// sensor_msgs/PointField: `datatype` is 1 int8, 2 uint8, 3 int16, 4 uint16, 5 int32, 6 uint32, 7 float32,
/// 8 float64.
struct PointCloud2Field {
  std::string name;
  std::uint32_t offset = 0;  ///< of its first byte in a point
  std::uint8_t datatype = 7;
  std::uint32_t count = 1;

  bool operator==(const PointCloud2Field&) const = default;
};

/// sensor_msgs/PointCloud2 with its bytes in memory that the caller owns.
struct PointCloud2View {
  Time stamp;  ///< of the header
  std::string frame_id;
  std::uint32_t height = 1;
  std::uint32_t width = 0;
  std::vector<PointCloud2Field> fields;
  bool is_bigendian = false;
  std::uint32_t point_step = 0;  ///< bytes from one point to the next
  std::uint32_t row_step = 0;    ///< bytes from one row to the next
  std::span<const std::uint8_t> data;

  [[nodiscard]] std::size_t size() const { return std::size_t{height} * width; }
};

/// A cloud that lives as long as its copies do.
struct PointCloud2 {
  PointCloud2View view;               ///< `data` refers to the memory of `owner`
  std::shared_ptr<const void> owner;  ///< the message of the middleware, or bytes of our own
};

/// A field of a cloud by its name, one number per point.
struct NamedNumbers {
  std::string name;
  NumberSpan numbers;
};

/// Which fields of a driver's cloud are position, ring and time, and what the times mean.
struct DriverFields {
  PointFields fields;                 ///< refers to the memory of the cloud
  std::vector<std::string> notes;     ///< "times: ..." and "rings: ...": where they come from
  std::shared_ptr<const void> owner;  ///< of bytes that `fields` refers to in place of the cloud's; or null
};

/// The rules of the drivers of Velodyne, Ouster, Hesai, RoboSense and Autoware (Nebula), by their source
/// code. Ring: the first of the fields ring, channel, laser_number, laser_id, laser, line. Time: the first of
/// t, time, timestamp, timestamps, time_stamp, stamps, offset_time, offset_ns, gps_time. Integer times are
/// nanoseconds, or microseconds where the points span 20,000 to 200,000 of them (a turn at 5 to 50 Hz);
/// floating times are seconds, or times of the Unix epoch in the unit that puts them after 1973. Whether they
/// count from the stamp or from the epoch: TimeReference::automatic. A time field with one value for all
/// points is not used: the azimuths give the times.
///
/// `rows`: of an organised cloud, else 1. Throws InputError naming `source`, the field, its value and the
/// remedy: x, y or z missing or not floating, a Livox cloud (its pattern does not repeat), ring or time not
/// numbers of one per point, points in millimetres.
[[nodiscard]] DriverFields driver_fields(std::span<const NamedNumbers> cloud, std::size_t rows,
                                         const std::string& source);

/// The fields of a cloud that have one number per point, where they are in its memory. A cloud of big-endian
/// numbers, or with bytes between its rows, is copied: `owner` then keeps the copy. Throws InputError naming
/// `source` where a field reaches beyond its point, a type is none of PointField's, or the data are shorter
/// than height, width and steps say.
[[nodiscard]] std::vector<NamedNumbers> named_numbers(const PointCloud2View& cloud,
                                                      std::shared_ptr<const void>& owner,
                                                      const std::string& source);

/// driver_fields of the cloud's named_numbers: what ScanBuilder::build takes, with the cloud's stamp.
[[nodiscard]] DriverFields read_point_cloud2(const PointCloud2View& cloud, const std::string& source);

}  // namespace mapless
