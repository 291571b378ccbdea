#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "io/files/text.hpp"
#include "io/tables/csv.hpp"
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>

namespace mapless::inline v1 {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kObjectsHead = "object_id,class,kind";
constexpr std::string_view kClassesHead = "id,class";  // of truth by others, who know no kinds
constexpr std::string_view kStatesHead = "scan,object_id,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps,speed_mps";

// One line of a table of truth.
struct TruthLine : CsvLine {
  [[nodiscard]] std::uint32_t object_id(std::size_t cell) const {
    return static_cast<std::uint32_t>(
        integer(cell, "object_id", 1, std::numeric_limits<std::uint16_t>::max()));
  }
};

std::vector<TruthLine> lines_of(const fs::path& file, std::string_view text, std::string_view head) {
  std::vector<TruthLine> out;
  for (CsvLine& line : csv_lines(file, text, head, "restore the table of the original recording"))
    out.push_back({std::move(line)});
  return out;
}

void read_descriptions(const fs::path& file, ObjectTruth& truth) {
  const std::string text = read_whole_file(file);
  const bool has_kinds = text.substr(0, text.find_first_of("\r\n")) != kClassesHead;
  for (const TruthLine& line : lines_of(file, text, has_kinds ? kObjectsHead : kClassesHead)) {
    const ObjectDescription description{std::string(line.cells[1]),
                                        has_kinds ? std::string(line.cells[2]) : ""};
    if (!truth.descriptions.emplace(line.object_id(0), description).second)
      line.refuse("object_id", line.cells[0], "given twice");
  }
}

void read_states(const fs::path& file, ObjectTruth& truth) {
  const std::string text = read_whole_file(file);
  for (const TruthLine& line : lines_of(file, text, kStatesHead)) {
    const auto scan = static_cast<std::size_t>(line.integer(0, "scan", 0));
    const ObjectState state{line.time(2, "time_s"),
                            {line.number(3), line.number(4), line.number(5)},
                            {line.number(6), line.number(7), line.number(8)},
                            line.number(9)};
    if (state.speed_mps < 0) line.refuse("speed_mps", line.cells[9], "below 0");
    if (!truth.states.emplace(std::pair(scan, line.object_id(1)), state).second)
      line.refuse("object_id", line.cells[1], "given twice for one scan");
  }
}

std::string row(std::size_t scan, std::uint32_t object_id, const ObjectState& state) {
  const Eigen::Vector3d& c = state.centre_0;
  const Eigen::Vector3d& v = state.velocity_0;
  return fmt::format("{},{},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f}\n", scan, object_id,
                     decimal_seconds(state.time), c.x(), c.y(), c.z(), v.x(), v.y(), v.z(), state.speed_mps);
}

}  // namespace

ObjectTruth read_object_truth(const fs::path& folder) {
  ObjectTruth truth;
  truth.has_descriptions = fs::exists(folder / "objects.csv");
  truth.has_states = fs::exists(folder / "object_states.csv");
  if (truth.has_descriptions) read_descriptions(folder / "objects.csv", truth);
  if (truth.has_states) read_states(folder / "object_states.csv", truth);
  return truth;
}

ObjectStatesWriter::ObjectStatesWriter(fs::path file) : file_(std::move(file)) {
  write_file_atomically(file_, std::string(kStatesHead) + "\n");
}

void ObjectStatesWriter::add(std::size_t scan, const std::map<std::uint32_t, ObjectState>& states) {
  std::string rows;
  for (const auto& [id, state] : states) rows += row(scan, id, state);
  append_to_file(file_, rows);
}

}  // namespace mapless
