#include "detection/creeping_surfaces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include "detection/surface_patches.hpp"
#include "detection/witnesses.hpp"

namespace mapless {
namespace {

using Eigen::Vector3f;

// Of the earlier scans; from far on one by itself tells slow motion from noise.
constexpr int kNearest = 2, kFar = 3, kFarthest = 8;
constexpr int kFirst = 4;     // asked first: most patches stand, and one scan that is far enough says so
constexpr int kSettled = -9;  // votes of what scans of seconds ago saw in its place already

constexpr std::size_t kMostAsked = 16, kFewestHeard = 6;  // points of a patch
constexpr std::size_t kGlance = 4;
constexpr float kApart_m = 0.5F;  // what a ray hit farther from the point is another thing

constexpr float kLeastAdvance_m = 0.03F, kLeastSpeed_mps = 0.12F;
constexpr float kSigmas = 4;
constexpr float kOfTwoScans = 1.5F;  // of one scan's noise: the noise of a difference
constexpr float kUnsteady_m = 0.015F, kUnsteadyShare = 0.3F;  // what braking makes of a steady speed

constexpr std::size_t kFewestPatches = 2;
constexpr float kLeastLater = 0.4F, kMostLater = 1.5F;  // of the advance expected until the later scan

// Parallel or convex: neither rises above the other's plane. Single points are noisier than middles.
constexpr float kRise_m = 0.03F, kPointRise_m = 0.05F, kRisePerMetre = 0.05F;
constexpr float kReach_m = 0.6F;  // between the middles of two patches of one thing
constexpr float kBehind_m = 0.5F;
constexpr float kSameWay = 0.9F;  // cosine between normals

struct Witness {
  FreespaceProbe probe;
  int gap;
  float since_s;
};

// What moved between a patch and the same place of another scan, along the normal.
struct Advance {
  float mean_m = 0, std_m = 0;
  std::size_t heard = 0;
};

struct Motion {
  bool creeps = false, stands = false;
  float later_m = 0, later_expected_m = 0;  // along the normal until the later scan; 0 expected: not seen
};

// The mean of the middle half: edges of other things are far off.
Advance advance_of(std::array<float, kMostAsked>& shifts_m, std::size_t count) {
  Advance out;
  out.heard = count;
  if (count == 0) return out;
  std::sort(shifts_m.begin(), shifts_m.begin() + static_cast<std::ptrdiff_t>(count));
  const std::size_t cut = count / 4;
  for (std::size_t k = cut; k < count - cut; ++k) out.mean_m += shifts_m[k];
  out.mean_m /= static_cast<float>(count - 2 * cut);
  const float quartiles_m = shifts_m[count - 1 - cut] - shifts_m[cut];
  out.std_m = 0.74F * quartiles_m / std::sqrt(static_cast<float>(count));
  return out;
}

bool is_convex(const SurfacePatch& a, const SurfacePatch& b) {
  const Vector3f d = b.centre - a.centre;
  const float rise = kRise_m + kRisePerMetre * d.norm();
  return a.normal.dot(d) <= rise && b.normal.dot(d) >= -rise;
}

// Neither seen to stand for seconds nor found to move by rays.
std::vector<char> open_questions(const std::vector<PointVotes>& votes) {
  std::vector<char> wanted(votes.size());
  std::transform(votes.begin(), votes.end(), wanted.begin(), [](const PointVotes& v) {
    const bool settled = is_static(v) && v.total() <= kSettled;
    const bool found = v.seen_through && v.total() > 0;
    return settled || found ? 0 : 1;
  });
  return wanted;
}

class CreepingSurfaces {
 public:
  CreepingSurfaces(const LidarScan& scan, const LocalPoints& points, const std::vector<AskedScan>& asked,
                   const VotingParameters& parameters, std::vector<PointVotes>& votes)
      : scan_(scan), points_(points.points), votes_(votes), patches_(scan, points, open_questions(votes)) {
    const auto scan_s = static_cast<float>((scan.end() - scan.start).seconds());
    const auto witness = [&](const AskedScan& a) {
      return Witness{FreespaceProbe(*a.image, points.origin_0, parameters), a.gap,
                     scan_s * static_cast<float>(a.gap)};
    };
    std::vector<AskedScan> by_use = asked;
    std::stable_sort(by_use.begin(), by_use.end(), [](const AskedScan& a, const AskedScan& b) {
      return std::abs(a.gap - kFirst) < std::abs(b.gap - kFirst);
    });
    for (const AskedScan& a : by_use) {
      if (a.gap < 0) later_.emplace(witness(a));
      if (a.gap >= kNearest && a.gap <= kFarthest) earlier_.push_back(witness(a));
    }
  }

  void vote() {
    if (!later_ || earlier_.size() < 2) return;
    motions_.resize(patches_.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, patches_.size(), 32), [&](const auto& part) {
      for (std::size_t p = part.begin(); p != part.end(); ++p) motions_[p] = motion(p);
    });
    taken_.assign(patches_.size(), false);
    for (std::size_t p = 0; p < patches_.size(); ++p) {
      if (!motions_[p].creeps || taken_[p]) continue;
      std::vector<std::size_t> object = linked(p);
      if (object.size() < kFewestPatches || !goes_on(object)) continue;
      grow(object, [&](std::size_t from, std::size_t next) { return may_belong(from, next); });
      claim(object);
    }
  }

 private:
  [[nodiscard]] const Vector3f& point(std::int32_t i) const { return points_[static_cast<std::size_t>(i)]; }

  // Since the scan of a witness, by at most so many of the patch's points.
  [[nodiscard]] Advance advance(std::size_t p, const Witness& witness, std::size_t most) const {
    const auto members = patches_.members(p);
    const std::size_t wanted = std::min(members.size(), most);
    std::array<float, kMostAsked> shifts_m{};
    std::size_t count = 0;
    constexpr std::size_t kStep = FreespaceProbe::kAtOnce;
    for (std::size_t first = 0; first < wanted; first += kStep) {
      FreespaceProbe::Points asked;
      for (std::size_t l = 0; l < kStep; ++l) {
        const std::int32_t i = members[std::min(first + l, wanted - 1) * members.size() / wanted];
        asked.x[l] = point(i).x();
        asked.y[l] = point(i).y();
        asked.z[l] = point(i).z();
        if (l == 0) asked.near = static_cast<float>(scan_.returns[static_cast<std::size_t>(i)].column);
      }
      const auto answers = witness.probe.look(asked);
      for (std::size_t l = 0; l < std::min(kStep, wanted - first); ++l) {
        const FreespaceProbe::Answer answer = answers[l];
        if (answer.laser < 0 || !witness.probe.ended(answer)) continue;
        const Vector3f d = Vector3f(asked.x[l], asked.y[l], asked.z[l]) -
                           witness.probe.endpoint(answer.laser, answer.column);
        if (d.squaredNorm() <= kApart_m * kApart_m) shifts_m[count++] = patches_[p].normal.dot(d);
      }
    }
    return advance_of(shifts_m, count);
  }

  [[nodiscard]] Motion motion(std::size_t p) const {
    Motion out;
    if (!patches_[p].is_plane) return out;
    const Witness* oldest = nullptr;
    float speed_mps = 0;
    std::array<Advance, kFarthest + 1> advances;
    std::size_t heard = 0;
    for (const Witness& w : earlier_) {
      const bool far = w.gap >= kFar;
      if (heard == 0 && far) {
        const Advance glance = advance(p, w, kGlance);
        if (glance.heard == 0) continue;
        if (glance.heard == kGlance && std::abs(glance.mean_m) < kLeastAdvance_m / 2) return {.stands = true};
      }
      Advance& a = advances[static_cast<std::size_t>(w.gap)] = advance(p, w, kMostAsked);
      if (a.heard < kFewestHeard) continue;
      if (far && std::abs(a.mean_m) < least_advance_m(p, a)) return out;
      ++heard;
      if (oldest != nullptr && oldest->gap > w.gap) continue;
      oldest = &w;
      speed_mps = a.mean_m / w.since_s;
    }
    if (heard < 2 || oldest->gap < kFar || std::abs(speed_mps) < kLeastSpeed_mps) return out;
    for (const Witness& w : earlier_) {
      const Advance& a = advances[static_cast<std::size_t>(w.gap)];
      const float expected_m = speed_mps * w.since_s;
      const float off_m = std::abs(a.mean_m - expected_m);
      if (a.heard >= kFewestHeard && off_m > kUnsteady_m + kUnsteadyShare * std::abs(expected_m)) return out;
    }
    out.creeps = true;
    const Advance later = advance(p, *later_, kMostAsked);
    if (later.heard < kFewestHeard) return out;
    out.later_m = later.mean_m;
    out.later_expected_m = speed_mps * later_->since_s;
    return out;
  }

  [[nodiscard]] float least_advance_m(std::size_t p, const Advance& a) const {
    const float noise_m = kOfTwoScans * patches_[p].thickness_m / std::sqrt(static_cast<float>(a.heard));
    return std::max(kLeastAdvance_m, kSigmas * std::max(a.std_m, noise_m));
  }

  // Patches that creep together with the first.
  std::vector<std::size_t> linked(std::size_t first) {
    std::vector<std::size_t> object = {first};
    taken_[first] = true;
    grow(object, [&](std::size_t, std::size_t next) { return motions_[next].creeps; });
    return object;
  }

  // By what `may_join`, is not taken, and parallel or convex to its neighbour.
  template <class MayJoin>
  void grow(std::vector<std::size_t>& object, MayJoin&& may_join) {
    for (std::size_t k = 0; k < object.size(); ++k) {
      const std::size_t from = object[k];
      patches_.for_each_beside(from, [&](std::size_t next) {
        if (taken_[next] || !may_join(from, next) || !is_one_surface(from, next)) return;
        taken_[next] = true;
        object.push_back(next);
      });
    }
  }

  // A side slides within itself and seems to stand, but what looks the same way as a face that moves does
  // not.
  [[nodiscard]] bool may_belong(std::size_t from, std::size_t next) const {
    if (!patches_[next].is_plane) return false;
    const bool same_way = std::abs(patches_[from].normal.dot(patches_[next].normal)) > kSameWay;
    return !same_way || !motions_[next].stands || motions_[from].stands;
  }

  [[nodiscard]] bool is_one_surface(std::size_t a, std::size_t b) const {
    const float apart2 = (patches_[b].centre - patches_[a].centre).squaredNorm();
    return apart2 <= kReach_m * kReach_m && is_convex(patches_[a], patches_[b]);
  }

  [[nodiscard]] bool goes_on(const std::vector<std::size_t>& object) const {
    float agreement = 0, expected = 0;
    for (const std::size_t p : object) {
      const Motion& m = motions_[p];
      agreement += m.later_m * m.later_expected_m;
      expected += m.later_expected_m * m.later_expected_m;
    }
    return expected > 0 && agreement >= kLeastLater * expected && agreement <= kMostLater * expected;
  }

  void claim(const std::vector<std::size_t>& object) {
    std::vector<bool> mine(patches_.size(), false), beside(patches_.size(), false);
    for (const std::size_t p : object) {
      mine[p] = true;
      for (const std::int32_t i : patches_.members(p)) claim(i);
    }
    for (const std::size_t p : object) {
      patches_.for_each_beside(p, [&](std::size_t rim) {
        if (taken_[rim] || beside[rim] || patches_[rim].is_plane) return;
        beside[rim] = true;
        for (const std::int32_t i : patches_.members(rim)) {
          if (belongs(point(i), rim, mine)) claim(i);
        }
      });
    }
  }

  // A point of a patch that is no plane: edges, and where two things meet.
  [[nodiscard]] bool belongs(const Vector3f& q, std::size_t rim, const std::vector<bool>& mine) const {
    bool joins = false, is_other = false;
    patches_.for_each_beside(rim, [&](std::size_t p) {
      const Vector3f d = q - patches_[p].centre;
      if (!patches_[p].is_plane || d.squaredNorm() > kReach_m * kReach_m) return;
      const float height = patches_[p].normal.dot(d);
      const float rise = kPointRise_m + kRisePerMetre * d.norm();
      if (mine[p]) {
        is_other = is_other || height > rise;
        joins = joins || height > -kBehind_m;
      } else {
        is_other = is_other || std::abs(height) < rise;
      }
    });
    return joins && !is_other;
  }

  void claim(std::int32_t i) {
    PointVotes& v = votes_[static_cast<std::size_t>(i)];
    v.earlier = static_cast<std::int16_t>(std::max(v.total(), kSeenThroughVotes) - v.later);
    v.seen_through = v.recently = true;
  }

  const LidarScan& scan_;
  const std::vector<Vector3f>& points_;
  std::vector<PointVotes>& votes_;
  SurfacePatches patches_;
  std::vector<Witness> earlier_;
  std::optional<Witness> later_;
  std::vector<Motion> motions_;  // of each patch
  std::vector<bool> taken_;      // patches of an object
};

}  // namespace

void vote_for_creeping(const LidarScan& scan, const LocalPoints& points, const std::vector<AskedScan>& asked,
                       const VotingParameters& parameters, std::vector<PointVotes>& votes) {
  CreepingSurfaces(scan, points, asked, parameters, votes).vote();
}

}  // namespace mapless
