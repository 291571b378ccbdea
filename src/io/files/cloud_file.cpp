#include <algorithm>
#include <cstddef>

#include <fmt/format.h>

#include "io/files/las_file.hpp"
#include "io/files/little_endian.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::inline v1 {
namespace {

constexpr double kFloatReach_m = 8192;

bool needs_doubles(const ExportCloud& cloud) {
  return std::any_of(cloud.points.begin(), cloud.points.end(),
                     [](const Eigen::Vector3d& p) { return p.cwiseAbs().maxCoeff() >= kFloatReach_m; });
}

std::string pcd_header(const ExportCloud& cloud, bool doubles) {
  std::string fields = "x y z", sizes = doubles ? "8 8 8" : "4 4 4", types = "F F F", counts = "1 1 1";
  for (const CloudColumn& column : cloud.columns) {
    fields += fmt::format(" {}", column.name);
    sizes += " 4";
    types += column.is_float ? " F" : " U";
    counts += " 1";
  }
  return fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\nCOUNT {}\n"
      "WIDTH {}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      fields, sizes, types, counts, cloud.points.size(), cloud.points.size());
}

std::string ply_header(const ExportCloud& cloud, bool doubles) {
  std::string out =
      fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", cloud.points.size());
  for (const char axis : {'x', 'y', 'z'})
    out += fmt::format("property {} {}\n", doubles ? "double" : "float", axis);
  for (const CloudColumn& column : cloud.columns)
    out += fmt::format("property {} {}\n", column.is_float ? "float" : "uint", column.name);
  return out + "end_header\n";
}

}  // namespace

std::string cloud_file(const ExportCloud& cloud, CloudFormat format) {
  if (format == CloudFormat::las) return las_file(cloud);
  const bool doubles = needs_doubles(cloud);
  std::string out = format == CloudFormat::pcd ? pcd_header(cloud, doubles) : ply_header(cloud, doubles);
  out.reserve(out.size() + cloud.points.size() * ((doubles ? 24 : 12) + 4 * cloud.columns.size()));
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    for (const double v : cloud.points[i]) doubles ? append(out, v) : append(out, static_cast<float>(v));
    for (const CloudColumn& column : cloud.columns) append(out, column.values[i]);
  }
  return out;
}

CloudFormat cloud_format_of(const std::filesystem::path& file) {
  const std::string ending = file.extension().string();
  if (ending == ".pcd") return CloudFormat::pcd;
  if (ending == ".ply") return CloudFormat::ply;
  if (ending == ".las") return CloudFormat::las;
  throw ParameterError(
      {file.string(), "", "", "ends in none of .pcd, .ply and .las", "give the file such a name"});
}

void write_cloud_file(const std::filesystem::path& file, const ExportCloud& cloud) {
  write_file_atomically(file, cloud_file(cloud, cloud_format_of(file)));
}

}  // namespace mapless
