#include <limits>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "io/files/text.hpp"
#include "io/tables/csv.hpp"
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;

constexpr std::string_view kHead =
    "scan,time_s,id,points,x_m,y_m,z_m,extent_x_m,extent_y_m,extent_z_m,vx_mps,vy_mps,vz_mps,std_vx_mps,"
    "std_vy_mps,std_vz_mps,age_scans";

std::string triple(const Vector3d& v) { return fmt::format("{:.4f},{:.4f},{:.4f}", v.x(), v.y(), v.z()); }

std::string text_of(const ObjectRow& r) {
  return fmt::format("{},{},{},{},{},{},{},{},{}\n", r.scan, decimal_seconds(r.time), r.id, r.points,
                     triple(r.centre_0), triple(r.extent_0), triple(r.velocity_0), triple(r.velocity_std_0),
                     r.age);
}

std::string text_of(const std::vector<ObjectRow>& rows) {
  std::string text;
  for (const ObjectRow& row : rows) text += text_of(row);
  return text;
}

Vector3d triple(const CsvLine& line, std::size_t first) {
  return {line.number(first), line.number(first + 1), line.number(first + 2)};
}

ObjectRow row_of(const CsvLine& line) {
  constexpr long long kMostInt = std::numeric_limits<int>::max();
  ObjectRow row;
  row.scan = static_cast<std::size_t>(line.integer(0, "scan", 0));
  row.time = line.time(1, "time_s");
  row.id = static_cast<std::uint32_t>(line.integer(2, "id", 1, std::numeric_limits<std::uint32_t>::max()));
  row.points = static_cast<int>(line.integer(3, "points", 1, kMostInt));
  row.centre_0 = triple(line, 4);
  row.extent_0 = triple(line, 7);
  row.velocity_0 = triple(line, 10);
  row.velocity_std_0 = triple(line, 13);
  row.age = static_cast<int>(line.integer(16, "age_scans", 1, kMostInt));
  if (row.extent_0.minCoeff() < 0) line.refuse("extent", triple(row.extent_0), "below 0");
  if (row.velocity_std_0.minCoeff() <= 0)
    line.refuse("standard deviation", triple(row.velocity_std_0), "not above 0");
  return row;
}

}  // namespace

ObjectTableWriter::ObjectTableWriter(std::filesystem::path file, GrowingFile::Start start)
    : file_(std::move(file), std::string(kHead) + "\n", start) {}

void ObjectTableWriter::add(const std::vector<ObjectRow>& rows) { file_.append(text_of(rows)); }
void ObjectTableWriter::verify(const std::vector<ObjectRow>& rows) { file_.verify(text_of(rows)); }

std::vector<ObjectRow> read_object_table(const std::filesystem::path& file) {
  const std::string text = read_whole_file(file);
  std::vector<ObjectRow> rows;
  std::set<std::pair<std::size_t, std::uint16_t>> given;
  for (const CsvLine& line : csv_lines(file, text, kHead, "run mapless detect again")) {
    rows.push_back(row_of(line));
    if (!given.emplace(rows.back().scan, label_number(rows.back().id)).second)
      line.refuse("id", line.cells[2], "given twice for one scan");
  }
  return rows;
}

}  // namespace mapless
