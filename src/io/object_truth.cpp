#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "io/text.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/atomic_file.hpp>
#include <mapless/io/object_truth.hpp>

namespace mapless {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kObjectsHead = "object_id,class,kind";
constexpr std::string_view kStatesHead = "scan,object_id,time_s,x_m,y_m,z_m,vx_mps,vy_mps,vz_mps,speed_mps";

// One line of a table and where it stands, for messages.
struct Line {
  std::string where;
  std::vector<std::string_view> cells;

  [[noreturn]] void refuse(std::string field, std::string_view value, std::string problem) const {
    throw InputError({where, std::move(field), std::string(value), std::move(problem),
                      "restore the table of the original recording"});
  }
  [[nodiscard]] std::uint32_t object_id(std::size_t cell) const {
    const auto id = parse_integer(cells[cell]);
    if (!id || *id < 1 || *id > std::numeric_limits<std::uint16_t>::max())
      refuse("object_id", cells[cell], "not a number from 1 to 65535");
    return static_cast<std::uint32_t>(*id);
  }
  [[nodiscard]] double number(std::size_t cell) const {
    const auto number = parse_double(cells[cell]);
    if (!number || !std::isfinite(*number)) refuse("number", cells[cell], "not a finite number");
    return *number;
  }
};

std::vector<std::string_view> split_cells(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

// The lines below the head. They refer to `text`.
std::vector<Line> lines_of(const fs::path& file, std::string_view text, std::string_view head) {
  const std::vector<std::string_view> lines = split_lines(text);
  const std::size_t width = split_cells(head).size();
  std::vector<Line> out;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    Line line{fmt::format("{}:{}", file.string(), i + 1), split_cells(lines[i])};
    if (i == 0 && lines[i] != head) line.refuse("head", lines[i], fmt::format("not {}", head));
    if (line.cells.size() != width) line.refuse("line", lines[i], fmt::format("not {} values", width));
    if (i > 0) out.push_back(std::move(line));
  }
  if (lines.empty()) throw InputError({file.string(), "head", "", "the file is empty", "restore it"});
  return out;
}

void read_descriptions(const fs::path& file, ObjectTruth& truth) {
  const std::string text = read_whole_file(file);
  for (const Line& line : lines_of(file, text, kObjectsHead)) {
    const ObjectDescription description{std::string(line.cells[1]), std::string(line.cells[2])};
    if (!truth.descriptions.emplace(line.object_id(0), description).second)
      line.refuse("object_id", line.cells[0], "given twice");
  }
}

void read_states(const fs::path& file, ObjectTruth& truth) {
  const std::string text = read_whole_file(file);
  for (const Line& line : lines_of(file, text, kStatesHead)) {
    const auto scan = parse_integer(line.cells[0]);
    if (!scan || *scan < 0) line.refuse("scan", line.cells[0], "not a number from 0");
    const auto time = parse_decimal_seconds(line.cells[2]);
    if (!time) line.refuse("time_s", line.cells[2], "not decimal seconds");
    const ObjectState state{*time,
                            {line.number(3), line.number(4), line.number(5)},
                            {line.number(6), line.number(7), line.number(8)},
                            line.number(9)};
    if (state.speed_mps < 0) line.refuse("speed_mps", line.cells[9], "below 0");
    if (!truth.states.emplace(std::pair(static_cast<std::size_t>(*scan), line.object_id(1)), state).second)
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
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file_, error);
  std::ofstream out(file_, std::ios::app | std::ios::binary);
  errno = 0;
  out.write(rows.data(), static_cast<std::streamsize>(rows.size()));
  out.close();
  if (out && !error) return;
  const std::string reason = std::strerror(errno);
  if (!error) fs::resize_file(file_, size, error);
  throw OutputError(
      {file_.string(), "", "", "cannot be written: " + reason, "check the folder and the disk"});
}

}  // namespace mapless
