#include "detection/evidence/sliding_rows.hpp"

#include <algorithm>
#include <iterator>

#include "detection/evidence/off_line.hpp"
#include "detection/segmentation/disjoint_sets.hpp"
#include "lidar/aligned_image.hpp"

namespace mapless::inline v1 {
namespace {

// A stack: rows no more than three apart whose receding ends lie near each other, on the edge of one thing.
// So many must slide, and more than become shorter. A row by itself may be a rail, or the crest of something.
constexpr int kFewestRows = 5;
constexpr int kMostApart = 4;
constexpr float kNear_m = 0.3F, kNearSpacings = 1.5F;

// What lies between two rows that slide is of the same surface where it is as near to the line between them.
constexpr float kOffSurface_m = 0.1F;

class SlidingRows {
  using Row = RecedingEnds::Line;

 public:
  SlidingRows(const LidarScan& scan, const LocalPoints& points, std::vector<PointVotes>& votes)
      : scan_(scan), points_(points.points), image_(scan), votes_(votes) {}

  void move_stacks(const std::vector<Row>& rows) {
    for (const std::vector<Row>& stack : stacks(rows)) {
      const auto sliding =
          std::count_if(stack.begin(), stack.end(), [](const Row& row) { return row.slides; });
      if (sliding >= kFewestRows && 2 * sliding > std::ssize(stack)) move(stack);
    }
  }

 private:
  [[nodiscard]] const Eigen::Vector3f& point(std::int32_t i) const {
    return points_[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] const LidarReturn& hit(std::int32_t i) const {
    return scan_.returns[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] int aligned_column(std::int32_t i) const {
    return image_.aligned_column(hit(i).laser, hit(i).column);
  }

  // Rows come laser by laser.
  [[nodiscard]] std::vector<std::vector<Row>> stacks(const std::vector<Row>& rows) const {
    DisjointSets sets(rows.size());
    const auto size = static_cast<std::int32_t>(rows.size());
    for (std::int32_t a = 0; a < size; ++a) {
      const Row& lower = rows[static_cast<std::size_t>(a)];
      for (std::int32_t b = a + 1; b < size; ++b) {
        const Row& upper = rows[static_cast<std::size_t>(b)];
        if (hit(upper.end).laser - hit(lower.end).laser > kMostApart) break;
        if (on_one_edge(lower, upper)) sets.unite(a, b);
      }
    }
    std::vector<std::vector<Row>> stacks(rows.size());
    for (std::int32_t a = 0; a < size; ++a)
      stacks[static_cast<std::size_t>(sets.find(a))].push_back(rows[static_cast<std::size_t>(a)]);
    return stacks;
  }

  [[nodiscard]] bool on_one_edge(const Row& a, const Row& b) const {
    if ((a.end == a.line.first) != (b.end == b.line.first)) return false;
    const auto rise_rad = static_cast<float>(elevation_rad(b) - elevation_rad(a));
    const float near_m = kNear_m + kNearSpacings * rise_rad * hit(a.end).range_m;
    return (point(a.end) - point(b.end)).squaredNorm() < near_m * near_m;
  }
  [[nodiscard]] double elevation_rad(const Row& row) const {
    return scan_.model->lasers[static_cast<std::size_t>(hit(row.end).laser)].elevation_rad;
  }

  void move(const std::vector<Row>& stack) {
    std::vector<std::int32_t> below(static_cast<std::size_t>(scan_.columns), -1);  // by aligned column
    for (const Row& row : stack) {
      if (!row.slides) continue;
      for (std::int32_t i = row.line.first; i <= row.line.last; ++i) {
        std::int32_t& lower = below[static_cast<std::size_t>(aligned_column(i))];
        if (lower >= 0) move_between(lower, i);
        lower = i;
        move(i);
      }
    }
  }

  void move_between(std::int32_t lower, std::int32_t upper) {
    const int column = aligned_column(lower);
    for (int laser = hit(lower).laser + 1; laser < hit(upper).laser; ++laser) {
      const std::int32_t i = scan_.cell(laser, image_.scan_column(laser, column));
      if (i >= 0 && off_line2(point(i), point(lower), point(upper)) <= kOffSurface_m * kOffSurface_m) move(i);
    }
  }

  void move(std::int32_t i) {
    PointVotes sliding;
    sliding.earlier = kSlidingVotes;
    sliding.seen_through = sliding.surface_seen = sliding.recently = true;
    votes_[static_cast<std::size_t>(i)] = sliding;
  }

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  AlignedImage image_;
  std::vector<PointVotes>& votes_;
};

}  // namespace

void hear_sliding_rows(const LidarScan& scan, const LocalPoints& points, std::span<const RowLine> lines,
                       const RecedingEnds& ends, std::vector<PointVotes>& votes) {
  const auto rows = ends.among(lines);
  if (!rows.empty()) SlidingRows(scan, points, votes).move_stacks(rows);
}

}  // namespace mapless
