#include "detection/tracking/object_association.hpp"

#include <algorithm>
#include <tuple>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kMaxPoints = 64;  // per object, for the time it takes: pairs of points are compared
// Points this near to each other are shared by two objects. Chosen: about a person's width.
constexpr double kShared_m = 0.4;
// Objects overlap if they share this part of the points of either. Chosen: below it, objects that pass touch.
constexpr double kMinShare = 0.1;
// Objects that do not overlap are associated within this many standard deviations of the predicted position,
// and at most so far: 40 m/s for a tenth of a second.
constexpr double kSigmas = 2;
constexpr double kMaxDistance_m = 4;

double points_near(const PredictedObject& a, const PredictedObject& b, double limit_m) {
  int near = 0;
  for (const Vector3d& p : a.points_0) {
    const bool close = std::any_of(b.points_0.begin(), b.points_0.end(), [&](const Vector3d& q) {
      return (p - q).squaredNorm() < limit_m * limit_m;
    });
    near += close ? 1 : 0;
  }
  return near * a.weight;
}

struct Pair {
  double score;  // the highest is associated first
  std::size_t known, seen;
};

void sort_pairs(std::vector<Pair>& pairs) {
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::tuple(-a.score, a.known, a.seen) < std::tuple(-b.score, b.known, b.seen);
  });
}

double size_of(const PredictedObject& object) {
  return static_cast<double>(object.points_0.size()) * object.weight;
}

std::vector<Pair> overlapping_pairs(std::span<const PredictedObject> known,
                                    std::span<const PredictedObject> seen) {
  std::vector<Pair> pairs;
  for (std::size_t k = 0; k < known.size(); ++k) {
    for (std::size_t s = 0; s < seen.size(); ++s) {
      const double limit = kShared_m + std::min(known[k].uncertainty_m, kShared_m);
      if (known[k].box.squaredExteriorDistance(seen[s].box) > limit * limit) continue;
      const double of_known = points_near(known[k], seen[s], limit);
      const double of_seen = points_near(seen[s], known[k], limit);
      const double share = std::max(of_known / size_of(known[k]), of_seen / size_of(seen[s]));
      if (share >= kMinShare) pairs.push_back({of_known + of_seen, k, s});
    }
  }
  sort_pairs(pairs);
  return pairs;
}

std::vector<Pair> pairs_in_reach(std::span<const PredictedObject> known,
                                 std::span<const PredictedObject> seen) {
  std::vector<Pair> pairs;
  for (std::size_t k = 0; k < known.size(); ++k) {
    const double reach =
        std::min(kShared_m + kSigmas * known[k].uncertainty_m + known[k].hidden_m, kMaxDistance_m);
    for (std::size_t s = 0; s < seen.size(); ++s) {
      const double apart = (known[k].box.center() - seen[s].box.center()).norm();
      if (apart <= reach) pairs.push_back({-apart, k, s});
    }
  }
  sort_pairs(pairs);
  return pairs;
}

void take(const std::vector<Pair>& pairs, std::vector<bool>& known_taken, Association& out) {
  for (const Pair& pair : pairs) {
    if (known_taken[pair.known] || out.known[pair.seen]) continue;
    known_taken[pair.known] = true;
    out.known[pair.seen] = pair.known;
  }
}

}  // namespace

void predict(const ObjectSnapshot& snapshot, const Vector3d& displacement_0, double uncertainty_m,
             PredictedObject& out) {
  const std::size_t stride = (snapshot.points_0.size() + kMaxPoints - 1) / kMaxPoints;
  out.points_0.clear();
  out.points_0.reserve(kMaxPoints);
  for (std::size_t i = 0; i < snapshot.points_0.size(); i += stride)
    out.points_0.push_back(snapshot.points_0[i] + displacement_0);
  out.weight = static_cast<double>(snapshot.points_0.size()) / static_cast<double>(out.points_0.size());
  out.box = snapshot.seen_box;
  out.box.translate(displacement_0);
  out.uncertainty_m = uncertainty_m;
  out.hidden_m = 0;
}

Association associate(std::span<const PredictedObject> known, std::span<const PredictedObject> seen) {
  Association out;
  out.known.resize(seen.size());
  out.parent.resize(seen.size());
  std::vector<bool> known_taken(known.size(), false);
  const std::vector<Pair> common = overlapping_pairs(known, seen);
  take(common, known_taken, out);
  take(pairs_in_reach(known, seen), known_taken, out);
  for (const Pair& pair : common) {
    if (!out.known[pair.seen] && !out.parent[pair.seen]) out.parent[pair.seen] = pair.known;
  }
  return out;
}

}  // namespace mapless
