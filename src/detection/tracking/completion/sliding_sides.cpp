#include "detection/tracking/completion/sliding_sides.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "detection/freespace/packed_points.hpp"
#include "detection/tracking/completion/body_completion.hpp"
#include "detection/tracking/object_members.hpp"

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kRemembered_s = 1;   // chosen: until the velocity of the front is sure again
constexpr float kRearNoise_m = 0.3F;  // how far behind the remembered rear points are taken

// The rear is looked for at each gap between points of a side, and at its end.
constexpr float kLeastGap_m = 0.3F;
// Places this far behind the points before the rear are asked, and at least this many columns of the scan:
// near enough to be where the body was, too far for a ray that grazes its end.
constexpr float kMoved_m = 0.5F, kColumns = 3;
// Farther than that a side is seen too aslant. Chosen.
constexpr float kMostMoved_m = 4;
// Older scans may have seen something else. Chosen.
constexpr double kOldest_s = 2;
// What the front has passed in the last second; chosen, as at walking speed that is half a metre.
constexpr double kPassed_s = 1;
constexpr double kHidden = 0.5;  // least share of the rays there; chosen
// Share of the rays, and least number of them. Chosen: noise and glass spoil one in ten.
constexpr double kMost = 0.7;
constexpr int kLeastRays = 8;
constexpr std::size_t kMostAsked = 160;  // chosen for the time it takes

struct Places {
  std::vector<Vector3f> points;
  std::vector<float> columns;  // guesses for FreespaceProbe
  void add(const Vector3f& point, float column) {
    points.push_back(point);
    columns.push_back(column);
  }
};

struct Agreement {
  int agree = 0, all = 0;  // rays
  void add(const Agreement& other) {
    agree += other.agree;
    all += other.all;
  }
  [[nodiscard]] bool most() const { return agree >= kLeastRays && agree >= kMost * all; }
};

// Asks the rays about the ends of a side.
class EndsTest {
 public:
  EndsTest(const LidarScan& scan, const ObjectProposals& proposed) : scan_(scan), proposed_(proposed) {}

  // Whether the places that the front has passed since an earlier scan were mostly hidden in that scan. Then
  // the points there are the road behind a vehicle, which the vehicle itself hid: before the front of a side
  // is air. Half its speed is taken, as it may have sped up. `age` [scans]: of its track.
  [[nodiscard]] bool front_hid(const SlidingSide& side, const SideSearch& search, double speed,
                               int age) const {
    const ReferenceRays* before = nullptr;
    double before_s = 0;
    for (const ReferenceRays& r : proposed_.references) {
      const double since_s = (scan_.start - r.rays->start()).seconds();
      if (r.gap <= 0 || r.gap >= age || since_s > kPassed_s || since_s < before_s) continue;
      before = &r;
      before_s = since_s;
    }
    if (!before) return false;
    const auto passed_m = static_cast<float>(speed * before_s / 2);
    Places places;
    for (const SlidingSide::Point& p : side.points) {
      if (p.along_m < side.front_m - passed_m) break;
      const auto i = static_cast<std::size_t>(p.number);
      if (!search.moves(p.number))
        places.add(proposed_.points.points[i], static_cast<float>(scan_.returns[i].column));
    }
    const Agreement hidden = observe(*before->rays, places, FreespaceVerdict::outside, nullptr);
    return hidden.agree >= kLeastRays && hidden.agree >= kHidden * hidden.all;
  }

  // Number of points of the side up to the rear; 0: no rear moved.
  [[nodiscard]] std::size_t points_before_rear(const SlidingSide& side, const SideSearch& search,
                                               double speed) const {
    for (std::size_t k = SideSearch::kLeastPoints; k <= side.points.size(); ++k) {
      const bool last = k == side.points.size();
      if (!last && side.points[k - 1].along_m - side.points[k].along_m < kLeastGap_m) continue;
      if (!search.moves(side.points[k - 1].number) && rear_moved(side, k, speed)) return k;
    }
    return 0;
  }

 private:
  [[nodiscard]] bool rear_moved(const SlidingSide& side, std::size_t count, double speed) const {
    const SlidingSide::Point& rear = side.points[count - 1];
    const float moved_m = std::max(kMoved_m, kColumns * column_m(side, rear));
    if (moved_m > kMostMoved_m) return false;
    Places freed;
    const Places behind = places_behind(side, count, moved_m);
    if (!observe(*proposed_.rays, behind, FreespaceVerdict::inside, &freed).most()) return false;
    Agreement before;
    for (const ReferenceRays& r : proposed_.references) {
      const double before_s = (scan_.start - r.rays->start()).seconds();
      if (before_s <= 0 || before_s > kOldest_s || speed * before_s < static_cast<double>(moved_m)) continue;
      before.add(observe(*r.rays, freed, FreespaceVerdict::border, nullptr));
    }
    return before.most();
  }

  // Distance along the side between two columns of the scan, at its rear: much where rays graze it.
  [[nodiscard]] float column_m(const SlidingSide& side, const SlidingSide::Point& rear) const {
    const float column_rad = 2 * std::numbers::pi_v<float> / static_cast<float>(scan_.columns);
    const float range_m = scan_.returns[static_cast<std::size_t>(rear.number)].range_m;
    const Vector3d origin = proposed_.rays->origin_0() - proposed_.points.origin_0;
    return range_m * range_m * column_rad / std::max(0.1F, side.distance_m(origin.cast<float>()));
  }

  [[nodiscard]] Places places_behind(const SlidingSide& side, std::size_t count, float moved_m) const {
    std::size_t begin = count;
    while (begin > 0 && side.points[begin - 1].along_m < side.points[count - 1].along_m + moved_m) --begin;
    const auto rearmost = std::span(side.points).subspan(begin, count - begin);
    const std::size_t stride = (rearmost.size() + kMostAsked - 1) / kMostAsked;
    Places places;
    for (std::size_t k = 0; k < rearmost.size(); k += stride) {
      const auto i = static_cast<std::size_t>(rearmost[k].number);
      places.add(proposed_.points.points[i] - moved_m * side.along,
                 static_cast<float>(scan_.returns[i].column));
    }
    return places;
  }

  // How many of the rays observed at the places have this verdict. `with` gets their places.
  [[nodiscard]] Agreement observe(const RayImage& rays, const Places& places, FreespaceVerdict verdict,
                                  Places* with) const {
    PackedPoints points;
    points.reserve(places.points.size());
    for (std::size_t k = 0; k < places.points.size(); ++k) points.add(places.points[k], places.columns[k]);
    Agreement rays_there;
    points.observe(FreespaceProbe(rays, proposed_.points.origin_0, proposed_.parameters),
                   [&](std::size_t k, const FreespaceProbe::Answer& answer) {
                     rays_there.all += answer.verdict == FreespaceVerdict::unobserved ? 0 : 1;
                     if (answer.verdict != verdict) return;
                     ++rays_there.agree;
                     if (with) with->add(places.points[k], places.columns[k]);
                   });
    return rays_there;
  }

  const LidarScan& scan_;
  const ObjectProposals& proposed_;
};

std::size_t points_before(const SlidingSide& side, float along_m) {
  const auto behind = std::find_if(side.points.begin(), side.points.end(),
                                   [&](const SlidingSide::Point& p) { return p.along_m < along_m; });
  return static_cast<std::size_t>(behind - side.points.begin());
}

}  // namespace

std::vector<std::uint32_t> SlidingSides::take(const LidarScan& scan, const ObjectProposals& proposed,
                                              const std::vector<TrackedObject>& tracked,
                                              const std::vector<TrackMotion>& motions,
                                              std::vector<std::uint16_t>& object) {
  std::vector<std::uint32_t> taken;
  const ObjectMembers members(object);
  SideSearch search(scan, proposed, motions, object);
  const EndsTest test(scan, proposed);
  const Vector3d& origin_0 = proposed.points.origin_0;
  std::erase_if(rears_,
                [&](const auto& one) { return (scan.start - one.second.time).seconds() > kRemembered_s; });
  for (const TrackedObject& front : tracked) {
    const auto seen = rears_.find(front.id);
    const bool sure = surely_moves(front);
    if (!motions[front.number - 1U].moves || (!sure && seen == rears_.end())) continue;
    const Vector3d velocity_0 = sure ? front.velocity_0 : seen->second.velocity_0;
    const auto side = search.side_of(members.of(front.number), velocity_0.cast<float>());
    if (!side) continue;
    if (sure && test.front_hid(*side, search, velocity_0.norm(), front.age)) continue;
    std::size_t count = sure ? test.points_before_rear(*side, search, velocity_0.norm()) : 0;
    if (count > 0) {
      const auto rear = static_cast<std::size_t>(side->points[count - 1].number);
      rears_[front.id] = {scan.start, proposed.points.points[rear].cast<double>() + origin_0, velocity_0};
    } else if (seen != rears_.end()) {
      const double since_s = (scan.start - seen->second.time).seconds();
      const Vector3d rear = seen->second.place_0 + since_s * seen->second.velocity_0 - origin_0;
      count = points_before(*side, side->along.dot(rear.cast<float>()) - kRearNoise_m);
    }
    for (std::size_t k = 0; k < count; ++k) {
      const std::int32_t i = side->points[k].number;
      if (search.moves(i)) continue;
      object[static_cast<std::size_t>(i)] = front.number;
      taken.push_back(static_cast<std::uint32_t>(i));
    }
  }
  std::sort(taken.begin(), taken.end());
  return taken;
}

}  // namespace mapless
