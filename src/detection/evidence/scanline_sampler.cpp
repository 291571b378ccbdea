#include "detection/evidence/scanline_sampler.hpp"

#include <algorithm>
#include <cstring>

#include "detection/freespace/four_lanes.hpp"

namespace mapless::inline v1 {
namespace {

constexpr std::size_t kMaxSpan =
    64;  // [points]; chosen: a thin object inside a longer span might not be sampled

// Points farther than 0.1 m from the line between the ends of their span cut it. Chosen: several standard
// deviations of the noise of range, or every span would be cut. Squared.
constexpr float kOffLine2_m2 = 0.1F * 0.1F;

// Votes against each of two points between which no point is queried: what the oldest scan alone gives.
constexpr int kFirmVotes = kMaxSurfaceVotes;

bool both_dynamic(const PointEvidence& a, const PointEvidence& b) {
  return a.total() > 0 && b.total() > 0 && a.recently_free == b.recently_free;
}

bool firmly_static(const PointEvidence& e) { return is_static(e) && e.total() <= -kFirmVotes; }

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

ScanlineSampler::ScanlineSampler(const LidarScan& scan, const LocalPoints& points,
                                 const EvidenceCollector& collector)
    : scan_(scan), points_(points.points), collector_(collector), image_(scan) {}

void ScanlineSampler::sample(std::span<const Row> rows, bool between, std::vector<PointEvidence>& evidence) {
  thread_local Workspace work;
  work_ = &work;
  between_ = between;
  evidence_ = &evidence;
  work_->queries.clear();
  work_->open.clear();
  for (const Row& row : rows) begin(row);
  collector_.query(work_->queries, work_->collector, evidence);
  while (!work_->open.empty()) {
    work_->queries.clear();
    work_->halves.clear();
    for (const Span& span : work_->open) settle(span);
    collector_.query(work_->queries, work_->collector, evidence);
    work_->open.swap(work_->halves);
  }
}

void ScanlineSampler::begin(const Row& row) {
  if (row.begin == row.end) return;
  load(row);
  query(row.begin);
  const std::size_t last = row.end - 1;
  for (std::size_t i = row.begin; i < last; i += kMaxSpan) cut({i, std::min(i + kMaxSpan, last)});
}

void ScanlineSampler::load(const Row& row) {
  first_ = row.begin;
  const std::size_t size = row.end - row.begin;
  for (std::vector<float>* v : {&work_->x, &work_->y, &work_->z}) {
    v->resize(size + 4);
    std::fill(v->end() - 4, v->end(), 0.0F);
  }
  for (std::size_t i = 0; i < size; ++i) {
    const Eigen::Vector3f& p = points_[first_ + i];
    work_->x[i] = p.x();
    work_->y[i] = p.y();
    work_->z[i] = p.z();
  }
}

// Into spans whose points all lie near the line between their ends; the left end is queried already.
void ScanlineSampler::cut(const Span& span) {
  const std::size_t corner = farthest_off(span);
  if (corner == span.left) {
    query(span.right);
    work_->open.push_back(span);
    return;
  }
  cut({span.left, corner});
  cut({corner, span.right});
}

// The point between the ends that is farthest from the line through them; the left end where all are near.
std::size_t ScanlineSampler::farthest_off(const Span& span) const {
  const std::size_t left = span.left - first_, right = span.right - first_;
  const float from_x = work_->x[left], from_y = work_->y[left], from_z = work_->z[left];
  const float chord_x = work_->x[right] - from_x, chord_y = work_->y[right] - from_y,
              chord_z = work_->z[right] - from_z;
  const float length2 = chord_x * chord_x + chord_y * chord_y + chord_z * chord_z;
  const float per_length2 = length2 > 0 ? 1 / length2 : 0;
  Floats most = Floats{} + kOffLine2_m2;
  Ints farthest = Ints{} + static_cast<int>(left);
  Ints index = Ints{0, 1, 2, 3} + static_cast<int>(left + 1);
  for (std::size_t i = left + 1; i < right; i += 4, index += 4) {
    const Floats x = four_from(&work_->x[i]) - from_x;
    const Floats y = four_from(&work_->y[i]) - from_y;
    const Floats z = four_from(&work_->z[i]) - from_z;
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

// Enters the evidence of the points between, or adds a query and the two spans beside it.
void ScanlineSampler::settle(const Span& span) {
  const auto [left, right] = span;
  if (right - left < 2) return;
  std::vector<PointEvidence>& evidence = *evidence_;
  if ((is_static(evidence[left]) && is_static(evidence[right])) || evidence[left] == evidence[right] ||
      both_dynamic(evidence[left], evidence[right])) {
    for (std::size_t i = left + 1; i < right; ++i) take(i - left < right - i ? left : right, i);
    return;
  }
  const std::size_t middle = (left + right) / 2;
  query(middle);
  work_->halves.push_back({left, middle});
  work_->halves.push_back({middle, right});
}

void ScanlineSampler::query(std::size_t i) {
  if (between_ && take_from_rows_beside(i)) return;
  work_->queries.push_back(i);
  if (ScanExplanation* const explanation = collector_.explanation())
    explanation->source[i] = static_cast<std::int32_t>(i);
}

// The evidence of return `from`, for return `to`.
void ScanlineSampler::take(std::size_t from, std::size_t to) {
  (*evidence_)[to] = (*evidence_)[from];
  if (ScanExplanation* const explanation = collector_.explanation())
    explanation->source[to] = explanation->source[from];
}

bool ScanlineSampler::take_from_rows_beside(std::size_t i) {
  const LidarReturn& r = scan_.returns[i];
  const std::ptrdiff_t b = in_row(r, r.laser - 1), a = in_row(r, r.laser + 1);
  if (a < 0 || b < 0) return false;
  const PointEvidence& lower = (*evidence_)[static_cast<std::size_t>(b)];
  if (!firmly_static(lower) || !firmly_static((*evidence_)[static_cast<std::size_t>(a)])) return false;
  const auto& from = points_[static_cast<std::size_t>(b)];
  if (distance_to_segment2_m2(points_[i], from, points_[static_cast<std::size_t>(a)]) > kOffLine2_m2)
    return false;
  take(static_cast<std::size_t>(b), i);
  return true;
}

// The return of a row in the direction of r, or -1.
std::ptrdiff_t ScanlineSampler::in_row(const LidarReturn& r, int row) const {
  return scan_.cell(row, image_.scan_column(row, image_.aligned_column(r.laser, r.column)));
}

}  // namespace mapless
