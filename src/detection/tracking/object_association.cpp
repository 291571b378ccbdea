#include "detection/tracking/object_association.hpp"

#include <algorithm>
#include <tuple>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kMostPoints = 64;
constexpr double kCommon_m = 0.4;     // points no farther apart are common to two objects
constexpr double kUncertainties = 2;  // the place may be off by so many standard deviations
constexpr double kFarthest_m = 4;     // 40 m/s for a tenth of a second
constexpr double kLeastShare = 0.1;   // of the smaller object must be common

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
  double score;  // the higher the sooner
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

std::vector<Pair> overlaps(std::span<const PredictedObject> known, std::span<const PredictedObject> seen) {
  std::vector<Pair> pairs;
  for (std::size_t k = 0; k < known.size(); ++k) {
    for (std::size_t s = 0; s < seen.size(); ++s) {
      const double limit = kCommon_m + std::min(known[k].uncertainty_m, kCommon_m);
      if (known[k].box.squaredExteriorDistance(seen[s].box) > limit * limit) continue;
      const double of_known = points_near(known[k], seen[s], limit);
      const double of_seen = points_near(seen[s], known[k], limit);
      const double share = std::max(of_known / size_of(known[k]), of_seen / size_of(seen[s]));
      if (share >= kLeastShare) pairs.push_back({of_known + of_seen, k, s});
    }
  }
  sort_pairs(pairs);
  return pairs;
}

std::vector<Pair> within_reach(std::span<const PredictedObject> known,
                               std::span<const PredictedObject> seen) {
  std::vector<Pair> pairs;
  for (std::size_t k = 0; k < known.size(); ++k) {
    const double reach =
        std::min(kCommon_m + kUncertainties * known[k].uncertainty_m + known[k].hidden_m, kFarthest_m);
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

void expect(const ObjectSnapshot& view, const Vector3d& displacement_0, double uncertainty_m,
            PredictedObject& out) {
  const std::size_t stride = (view.points_0.size() + kMostPoints - 1) / kMostPoints;
  out.points_0.clear();
  out.points_0.reserve(kMostPoints);
  for (std::size_t i = 0; i < view.points_0.size(); i += stride)
    out.points_0.push_back(view.points_0[i] + displacement_0);
  out.weight = static_cast<double>(view.points_0.size()) / static_cast<double>(out.points_0.size());
  out.box = view.seen_box;
  out.box.translate(displacement_0);
  out.uncertainty_m = uncertainty_m;
  out.hidden_m = 0;
}

Association associate(std::span<const PredictedObject> known, std::span<const PredictedObject> seen) {
  Association out;
  out.known.resize(seen.size());
  out.parent.resize(seen.size());
  std::vector<bool> known_taken(known.size(), false);
  const std::vector<Pair> common = overlaps(known, seen);
  take(common, known_taken, out);
  take(within_reach(known, seen), known_taken, out);
  for (const Pair& pair : common) {
    if (!out.known[pair.seen] && !out.parent[pair.seen]) out.parent[pair.seen] = pair.known;
  }
  return out;
}

}  // namespace mapless
