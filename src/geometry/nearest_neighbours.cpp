#include "geometry/nearest_neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nanoflann.hpp>
#include <numeric>
#include <utility>

#include "core/argument_checks.hpp"

namespace mapless::inline v1 {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// nanoflann prunes with lower bounds that carry rounding errors, and skips leaf points at exactly the
// distance of the worst result. A bound wider by this factor, far above rounding (1e-16 per operation), keeps
// every tie; the result sets then compare exactly.
constexpr double kPruningSlack = 1 + 1e-9;
// Points of a leaf. Chosen: nanoflann's documentation recommends 10 to 50.
constexpr std::size_t kLeafSize = 16;

struct Points {
  std::vector<Eigen::Vector3d> values;

  [[nodiscard]] std::size_t kdtree_get_point_count() const { return values.size(); }
  [[nodiscard]] double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return values[i][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

// Squared distances as Eigen computes them, to the last bit, so that ties here are ties everywhere else.
struct Metric {
  using ElementType = double;
  using DistanceType = double;
  explicit Metric(const Points& points) : values(points.values) {}
  [[nodiscard]] double evalMetric(const double* q, std::uint32_t i, std::size_t) const {
    return (values[i] - Eigen::Map<const Eigen::Vector3d>(q)).squaredNorm();
  }
  [[nodiscard]] double accum_dist(double a, double b, std::size_t) const { return (a - b) * (a - b); }
  const std::vector<Eigen::Vector3d>& values;
};

using Index = nanoflann::KDTreeSingleIndexAdaptor<Metric, Points, 3, std::uint32_t>;

struct Candidate {
  double squared_distance = kInfinity;
  std::int32_t index = -1;

  bool operator<(const Candidate& other) const {
    return squared_distance < other.squared_distance ||
           (squared_distance == other.squared_distance && index < other.index);
  }
};

double pruning_bound(double squared_distance) {
  return std::max(squared_distance * kPruningSlack, std::numeric_limits<double>::min());
}

// Results are in the order wanted as they come; nanoflann 1.5 and later need DistanceType and sort().
class NearestOne {
 public:
  using DistanceType = double;
  explicit NearestOne(const std::vector<std::int32_t>& original, const Candidate& known = {})
      : original_(original), best_(known), bound_(pruning_bound(known.squared_distance)) {}
  [[nodiscard]] bool full() const { return best_.index >= 0; }
  [[nodiscard]] double worstDist() const { return bound_; }
  void sort() const {}
  bool addPoint(double squared_distance, std::uint32_t i) {
    const Candidate candidate{squared_distance, original_[i]};
    if (candidate < best_) {
      best_ = candidate;
      bound_ = pruning_bound(squared_distance);
    }
    return true;
  }
  [[nodiscard]] const Candidate& best() const { return best_; }

 private:
  const std::vector<std::int32_t>& original_;
  Candidate best_;
  double bound_;
};

class NearestSeveral {
 public:
  using DistanceType = double;
  NearestSeveral(const std::vector<std::int32_t>& original, std::size_t k) : original_(original), k_(k) {
    best_.reserve(k + 1);
  }
  [[nodiscard]] bool full() const { return best_.size() == k_; }
  [[nodiscard]] double worstDist() const {
    return full() ? pruning_bound(best_.back().squared_distance) : kInfinity;
  }
  void sort() const {}
  bool addPoint(double squared_distance, std::uint32_t i) {
    const Candidate candidate{squared_distance, original_[i]};
    if (full() && !(candidate < best_.back())) return true;
    best_.insert(std::upper_bound(best_.begin(), best_.end(), candidate), candidate);
    if (best_.size() > k_) best_.pop_back();
    return true;
  }
  [[nodiscard]] const std::vector<Candidate>& best() const { return best_; }

 private:
  const std::vector<std::int32_t>& original_;
  std::size_t k_;
  std::vector<Candidate> best_;
};

class AllWithin {
 public:
  using DistanceType = double;
  AllWithin(const std::vector<std::int32_t>& original, double squared_radius, std::vector<std::int32_t>& out)
      : original_(original), squared_radius_(squared_radius), out_(out) {}
  [[nodiscard]] bool full() const { return true; }
  [[nodiscard]] double worstDist() const { return pruning_bound(squared_radius_); }
  void sort() const {}
  bool addPoint(double squared_distance, std::uint32_t i) {
    if (squared_distance <= squared_radius_) out_.push_back(original_[i]);
    return true;
  }

 private:
  const std::vector<std::int32_t>& original_;
  double squared_radius_;
  std::vector<std::int32_t>& out_;
};

}  // namespace

struct NearestNeighbours::Tree {
  explicit Tree(std::vector<Eigen::Vector3d> all) : points{std::move(all)}, original(points.values.size()) {
    std::iota(original.begin(), original.end(), 0);
    drop_non_finite_points();
    index = std::make_unique<Index>(3, points, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize));
  }

  // A NaN would break the splitting of the tree.
  void drop_non_finite_points() {
    std::erase_if(original,
                  [this](std::int32_t i) { return !points.values[static_cast<std::size_t>(i)].allFinite(); });
    std::erase_if(points.values, [](const Eigen::Vector3d& p) { return !p.allFinite(); });
  }

  Points points;
  std::vector<std::int32_t> original;  // index, in the points given, of point i of the tree
  // The point that had this index in the points given.
  [[nodiscard]] const Eigen::Vector3d& given(std::int32_t i) const {
    const auto place = std::lower_bound(original.begin(), original.end(), i);
    return points.values[static_cast<std::size_t>(place - original.begin())];
  }

  std::unique_ptr<Index> index;  // whose constructor builds it: nanoflann 1.4.2 cannot do that later
};

NearestNeighbours::NearestNeighbours(std::vector<Eigen::Vector3d> points)
    : tree_(std::make_unique<Tree>(std::move(points))) {}
NearestNeighbours::~NearestNeighbours() = default;
NearestNeighbours::NearestNeighbours(NearestNeighbours&&) noexcept = default;
NearestNeighbours& NearestNeighbours::operator=(NearestNeighbours&&) noexcept = default;

NearestNeighbours::Neighbour NearestNeighbours::nearest(const Eigen::Vector3d& q) const {
  NearestOne result(tree_->original);
  tree_->index->findNeighbors(result, q.data(), {});
  if (!result.full()) return {};
  return {result.best().index, std::sqrt(result.best().squared_distance)};
}

NearestNeighbours::Neighbour NearestNeighbours::nearest(const Eigen::Vector3d& q, Neighbour hint) const {
  if (hint.index < 0) return nearest(q);
  NearestOne result(tree_->original, {(tree_->given(hint.index) - q).squaredNorm(), hint.index});
  tree_->index->findNeighbors(result, q.data(), {});
  return {result.best().index, std::sqrt(result.best().squared_distance)};
}

std::vector<NearestNeighbours::Neighbour> NearestNeighbours::nearest(const Eigen::Vector3d& q, int k) const {
  require_between("NearestNeighbours::nearest", "k", k, 0, std::numeric_limits<int>::max());
  std::vector<Neighbour> neighbours;
  if (k == 0) return neighbours;
  NearestSeveral result(tree_->original, std::min(static_cast<std::size_t>(k), tree_->original.size()));
  tree_->index->findNeighbors(result, q.data(), {});
  neighbours.reserve(result.best().size());
  for (const Candidate& c : result.best()) neighbours.push_back({c.index, std::sqrt(c.squared_distance)});
  return neighbours;
}

void NearestNeighbours::within(const Eigen::Vector3d& q, double radius_m,
                               std::vector<std::int32_t>& out) const {
  require_between("NearestNeighbours::within", "radius_m", radius_m, 0, kInfinity);
  out.clear();
  AllWithin result(tree_->original, radius_m * radius_m, out);
  tree_->index->findNeighbors(result, q.data(), {});
  std::sort(out.begin(), out.end());
}

}  // namespace mapless
