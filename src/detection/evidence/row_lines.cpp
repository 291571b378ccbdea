#include "detection/evidence/row_lines.hpp"

namespace mapless::inline v1 {
namespace {

// What is shorter has left its place soon enough.
constexpr float kShortest_m = 1.5F;

constexpr float kStraight = 0.94F;  // cosine of 20 degrees

}  // namespace

void RowLines::add(std::size_t left, std::size_t right) {
  const Eigen::Vector3f step = points_[right] - points_[left];
  const float steps = static_cast<float>(right - left);
  const float link_m = steps * (link_m_ + link_per_m_ * scan_.returns[left].range_m);
  const float length2 = step.squaredNorm();
  if (length2 > link_m * link_m) {  // a gap
    keep();
    return;
  }
  const Eigen::Vector3f so_far = points_[last_] - points_[first_];
  const float along = so_far.dot(step);
  const bool goes_on = first_ != last_ && left == last_ && along > 0 &&
                       along * along > kStraight * kStraight * so_far.squaredNorm() * length2;
  if (!goes_on) {
    keep();
    first_ = left;
  }
  last_ = right;
}

void RowLines::keep() {
  if (first_ == last_) return;
  if ((points_[last_] - points_[first_]).squaredNorm() >= kShortest_m * kShortest_m)
    lines_.push_back({static_cast<std::int32_t>(first_), static_cast<std::int32_t>(last_)});
  first_ = last_ = 0;
}

}  // namespace mapless
