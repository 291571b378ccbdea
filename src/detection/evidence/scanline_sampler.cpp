#include "detection/evidence/scanline_sampler.hpp"

#include <algorithm>
#include <cstring>

#include "detection/freespace/four_lanes.hpp"

namespace mapless::inline v1 {
namespace {

constexpr std::size_t kLongest = 64;  // span [points]

// Squared, how far what lies between two points may be off their line: some standard deviations of the
// noise of range, or every span would be cut.
constexpr float kOffLine2_m2 = 0.1F * 0.1F;

// Votes against each of two points between which what lies is not asked about: the farthest scan alone.
constexpr int kFirm = kMostSurfaceVotes;

bool same(const PointVotes& a, const PointVotes& b) {
  return a.earlier == b.earlier && a.later == b.later && a.seen_through == b.seen_through &&
         a.surface_seen == b.surface_seen && a.recently == b.recently && a.vacated == b.vacated &&
         a.moving_seen == b.moving_seen;
}

bool move(const PointVotes& a, const PointVotes& b) {
  return a.total() > 0 && b.total() > 0 && a.recently == b.recently;
}

bool stands_firmly(const PointVotes& v) { return is_static(v) && v.total() <= -kFirm; }

// Squared distance of a point from the segment between a and b [m^2].
float distance_to_segment2_m2(const Eigen::Vector3f& q, const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  const Eigen::Vector3f chord = b - a;
  const float length2 = chord.squaredNorm();
  const float along = length2 > 0 ? std::clamp(chord.dot(q - a) / length2, 0.0F, 1.0F) : 0;
  return (q - a - along * chord).squaredNorm();
}

Floats four_from(const float* first) {
  Floats four;
  std::memcpy(&four, first, sizeof(Floats));
  return four;
}

}  // namespace

RowVotes::RowVotes(const LidarScan& scan, const LocalPoints& points, const Witnesses& witnesses)
    : scan_(scan), points_(points.points), witnesses_(witnesses), image_(scan) {}

void RowVotes::vote(std::span<const Row> rows, bool between, std::vector<PointVotes>& votes) {
  thread_local Room room;
  room_ = &room;
  between_ = between;
  votes_ = &votes;
  room_->questions.clear();
  room_->open.clear();
  for (const Row& row : rows) begin(row);
  witnesses_.ask(room_->questions, room_->hearing, votes);
  while (!room_->open.empty()) {
    room_->questions.clear();
    room_->halves.clear();
    for (const Span& span : room_->open) settle(span);
    witnesses_.ask(room_->questions, room_->hearing, votes);
    room_->open.swap(room_->halves);
  }
}

void RowVotes::begin(const Row& row) {
  if (row.begin == row.end) return;
  load(row);
  question(row.begin);
  const std::size_t last = row.end - 1;
  for (std::size_t i = row.begin; i < last; i += kLongest) cut({i, std::min(i + kLongest, last)});
}

void RowVotes::load(const Row& row) {
  first_ = row.begin;
  const std::size_t size = row.end - row.begin;
  for (std::vector<float>* v : {&room_->x, &room_->y, &room_->z}) {
    v->resize(size + 4);
    std::fill(v->end() - 4, v->end(), 0.0F);
  }
  for (std::size_t i = 0; i < size; ++i) {
    const Eigen::Vector3f& p = points_[first_ + i];
    room_->x[i] = p.x();
    room_->y[i] = p.y();
    room_->z[i] = p.z();
  }
}

// Into spans between whose ends all lie on the line; the left end was asked already.
void RowVotes::cut(const Span& span) {
  const std::size_t corner = farthest_off(span);
  if (corner == span.left) {
    question(span.right);
    room_->open.push_back(span);
    return;
  }
  cut({span.left, corner});
  cut({corner, span.right});
}

// The point between that is farthest from the line through the ends, or the left end where all are near it.
std::size_t RowVotes::farthest_off(const Span& span) const {
  const std::size_t left = span.left - first_, right = span.right - first_;
  const float from_x = room_->x[left], from_y = room_->y[left], from_z = room_->z[left];
  const float chord_x = room_->x[right] - from_x, chord_y = room_->y[right] - from_y,
              chord_z = room_->z[right] - from_z;
  const float length2 = chord_x * chord_x + chord_y * chord_y + chord_z * chord_z;
  const float per_length2 = length2 > 0 ? 1 / length2 : 0;
  Floats most = Floats{} + kOffLine2_m2;
  Ints farthest = Ints{} + static_cast<int>(left);
  Ints index = Ints{0, 1, 2, 3} + static_cast<int>(left + 1);
  for (std::size_t i = left + 1; i < right; i += 4, index += 4) {
    const Floats x = four_from(&room_->x[i]) - from_x;
    const Floats y = four_from(&room_->y[i]) - from_y;
    const Floats z = four_from(&room_->z[i]) - from_z;
    const Floats along = (x * chord_x + y * chord_y + z * chord_z) * per_length2;
    const Floats off_x = x - along * chord_x, off_y = y - along * chord_y, off_z = z - along * chord_z;
    const Floats off2 = off_x * off_x + off_y * off_y + off_z * off_z;
    const Ints farther = (off2 > most) & (index < static_cast<int>(right));
    most = farther ? off2 : most;
    farthest = farther ? index : farthest;
  }
  const auto take_farther = [&](const Floats& other_most, const Ints& other) {
    const Ints farther = (other_most > most) | ((other_most == most) & (other < farthest));
    most = farther ? other_most : most;
    farthest = farther ? other : farthest;
  };
  take_farther(MAPLESS_SHUFFLE(most, most, 2, 3, 0, 1), MAPLESS_SHUFFLE(farthest, farthest, 2, 3, 0, 1));
  take_farther(MAPLESS_SHUFFLE(most, most, 1, 0, 3, 2), MAPLESS_SHUFFLE(farthest, farthest, 1, 0, 3, 2));
  return first_ + static_cast<std::size_t>(farthest[0]);
}

// Gives the points between their votes, or leaves questions to be asked and spans to be settled then.
void RowVotes::settle(const Span& span) {
  const auto [left, right] = span;
  if (right - left < 2) return;
  std::vector<PointVotes>& votes = *votes_;
  if ((is_static(votes[left]) && is_static(votes[right])) || same(votes[left], votes[right]) ||
      move(votes[left], votes[right])) {
    for (std::size_t i = left + 1; i < right; ++i) votes[i] = votes[i - left < right - i ? left : right];
    return;
  }
  const std::size_t middle = (left + right) / 2;
  question(middle);
  room_->halves.push_back({left, middle});
  room_->halves.push_back({middle, right});
}

void RowVotes::question(std::size_t i) {
  if (!between_ || !known_from_beside(i)) room_->questions.push_back(i);
}

bool RowVotes::known_from_beside(std::size_t i) {
  const LidarReturn& r = scan_.returns[i];
  const std::ptrdiff_t b = beside(r, r.laser - 1), a = beside(r, r.laser + 1);
  if (a < 0 || b < 0) return false;
  const PointVotes& lower = (*votes_)[static_cast<std::size_t>(b)];
  if (!stands_firmly(lower) || !stands_firmly((*votes_)[static_cast<std::size_t>(a)])) return false;
  const auto& from = points_[static_cast<std::size_t>(b)];
  if (distance_to_segment2_m2(points_[i], from, points_[static_cast<std::size_t>(a)]) > kOffLine2_m2)
    return false;
  (*votes_)[i] = lower;
  return true;
}

// The return of another row in the same direction, or -1.
std::ptrdiff_t RowVotes::beside(const LidarReturn& r, int row) const {
  return scan_.cell(row, image_.scan_column(row, image_.aligned_column(r.laser, r.column)));
}

}  // namespace mapless
