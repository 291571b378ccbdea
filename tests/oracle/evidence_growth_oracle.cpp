#include "oracle/evidence_growth_oracle.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include <Eigen/SVD>

namespace mapless::test {

int EvidenceGrowthOracle::image_column(const LidarReturn& r) const {
  const LidarModel& model = *scan_.model;
  const double columns_per_rad = model.sign() * model.columns / (2 * std::numbers::pi);
  const double offset = model.lasers[static_cast<std::size_t>(r.laser)].azimuth_offset_rad;
  return r.column + static_cast<int>(std::lround(offset * columns_per_rad));
}

int EvidenceGrowthOracle::columns_apart(const LidarReturn& a, const LidarReturn& b) const {
  const int apart = std::abs(image_column(a) - image_column(b)) % scan_.columns;
  return std::min(apart, scan_.columns - apart);
}

double EvidenceGrowthOracle::link_m(const LidarReturn& r) const {
  const auto& lasers = scan_.model->lasers;
  double spacing = 2 * std::numbers::pi / scan_.model->columns;
  for (std::size_t l = 1; l < lasers.size(); ++l) {
    if (r.laser == static_cast<int>(l) || r.laser == static_cast<int>(l) - 1)
      spacing = std::max(spacing, lasers[l].elevation_rad - lasers[l - 1].elevation_rad);
  }
  const double per_m = std::max(parameters_.link_per_m, parameters_.link_spacings * spacing);
  return parameters_.link_m + per_m * static_cast<double>(r.range_m);
}

bool EvidenceGrowthOracle::linked(std::size_t i, std::size_t j, int rows, int columns) const {
  const LidarReturn &a = scan_.returns[i], &b = scan_.returns[j];
  if (std::abs(a.laser - b.laser) > rows) return false;
  if (columns_apart(a, b) > columns) return false;
  const double distance = (points_[i].cast<double>() - points_[j].cast<double>()).norm();
  return distance <= std::min(link_m(a), link_m(b));
}

std::vector<FilterVerdict> EvidenceGrowthOracle::filter(const std::vector<PointEvidence>& votes) const {
  std::vector<FilterVerdict> verdicts;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    int score = votes[i].total();
    for (std::size_t j = 0; j < votes.size(); ++j)
      if (j != i && linked(i, j, 1, 2)) score += votes[j].total();
    if (votes[i].total() <= 0) {
      verdicts.push_back(FilterVerdict::not_evaluated);
    } else {
      verdicts.push_back(score >= parameters_.seed_score ? FilterVerdict::kept : FilterVerdict::removed);
    }
  }
  return verdicts;
}

std::vector<std::size_t> EvidenceGrowthOracle::sets(const std::vector<char>& chosen) const {
  std::vector<std::size_t> lowest(chosen.size());
  std::iota(lowest.begin(), lowest.end(), std::size_t{0});
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < chosen.size(); ++i)
      for (std::size_t j = 0; j < chosen.size(); ++j)
        if (chosen[i] && chosen[j] && lowest[j] < lowest[i] && linked(i, j, 2, 4)) {
          lowest[i] = lowest[j];
          changed = true;
        }
  }
  return lowest;
}

void EvidenceGrowthOracle::fill(const std::vector<PointEvidence>& votes, int min_votes,
                                std::vector<char>& dynamic, EvidenceGrowthResult& result) const {
  const std::vector<char> before = dynamic;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    int neighbours = 0;
    for (std::size_t j = 0; j < votes.size(); ++j)
      if (j != i && before[j] && linked(i, j, 1, 2)) ++neighbours;
    if (before[i] || votes[i].total() < min_votes || neighbours < 5) continue;
    dynamic[i] = 1;
    result.verdict[i] = GrowthVerdict::grown;
  }
}

void EvidenceGrowthOracle::add_surfaces(const std::vector<PointEvidence>& votes, std::vector<char>& dynamic,
                                        EvidenceGrowthResult& result) const {
  const std::vector<char> found = dynamic;
  const std::vector<std::size_t> objects = sets(found);
  for (std::size_t first = 0; first < votes.size(); ++first) {
    if (!found[first] || objects[first] != first) continue;
    std::vector<std::size_t> object;
    for (std::size_t i = first; i < votes.size(); ++i)
      if (found[i] && objects[i] == first) object.push_back(i);
    const std::vector<char> surface = surfaces_of(object, votes, dynamic);
    const auto size = static_cast<int>(std::count(surface.begin(), surface.end(), 1));
    const Rim rim = rim_of(surface, votes, dynamic);
    const bool one_side = rim.moving * rim.moving >= size && rim.free > 3 * rim.static_points;
    const bool two_sides = rim.moving * rim.moving >= 4 * size && rim.moving > 3 * rim.static_points;
    if (size > 8 * static_cast<int>(object.size()) || !(one_side || two_sides)) continue;
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (!surface[i]) continue;
      dynamic[i] = 1;
      result.verdict[i] = GrowthVerdict::grown;
    }
  }
}

std::vector<char> EvidenceGrowthOracle::surfaces_of(const std::vector<std::size_t>& object,
                                                    const std::vector<PointEvidence>& votes,
                                                    const std::vector<char>& dynamic) const {
  std::vector<char> whole(votes.size(), 0), surface(votes.size(), 0);
  for (const std::size_t i : object) whole[i] = 1;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (whole[i] || dynamic[i] || votes[i].total() < -4) continue;
      for (std::size_t j = 0; j < votes.size() && !whole[i]; ++j) {
        if (!whole[j] || !linked(i, j, 1, 2)) continue;
        whole[i] = surface[i] = 1;
        changed = true;
      }
    }
  }
  return surface;
}

EvidenceGrowthOracle::Rim EvidenceGrowthOracle::rim_of(const std::vector<char>& surface,
                                                       const std::vector<PointEvidence>& votes,
                                                       const std::vector<char>& dynamic) const {
  Rim rim;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    for (std::size_t j = 0; j < votes.size(); ++j) {
      const LidarReturn &a = scan_.returns[i], &b = scan_.returns[j];
      const int rows = std::abs(a.laser - b.laser);
      if (!surface[i] || surface[j] || rows + columns_apart(a, b) != 1) continue;
      const bool link = linked(i, j, 1, 1);
      if (!link && rows == 0 && b.range_m > a.range_m) ++rim.free;
      if (link && dynamic[j]) ++rim.moving;
      if (link && !dynamic[j] && votes[j].total() < -4) ++rim.static_points;
    }
  }
  return rim;
}

EvidenceGrowthResult EvidenceGrowthOracle::grow(const std::vector<PointEvidence>& votes,
                                                const std::vector<FilterVerdict>& seeds) const {
  const std::size_t size = votes.size();
  EvidenceGrowthResult result;
  result.verdict.assign(size, GrowthVerdict::not_reached);
  result.object.assign(size, 0);
  std::vector<char> seed(size), usable(size), dynamic(size);
  for (std::size_t i = 0; i < size; ++i) seed[i] = seeds[i] == FilterVerdict::kept ? 1 : 0;
  const std::vector<std::size_t> clusters = sets(seed);
  std::map<std::size_t, int> seeds_in;
  for (std::size_t i = 0; i < size; ++i) seeds_in[clusters[i]] += seed[i];
  for (std::size_t i = 0; i < size; ++i) {
    if (!seed[i]) continue;
    const bool large = seeds_in[clusters[i]] >= parameters_.min_seeds;
    result.verdict[i] = large ? GrowthVerdict::seed : GrowthVerdict::too_small;
  }
  for (std::size_t i = 0; i < size; ++i)
    usable[i] =
        result.verdict[i] == GrowthVerdict::seed ||
        (parameters_.grow && (votes[i].total() > 0 || (votes[i].seen_through && votes[i].total() >= -12)));
  const std::vector<std::size_t> regions = sets(usable);
  std::map<std::size_t, bool> has_seed;
  for (std::size_t i = 0; i < size; ++i)
    if (result.verdict[i] == GrowthVerdict::seed) has_seed[regions[i]] = true;
  for (std::size_t i = 0; i < size; ++i) {
    if (!usable[i] || !has_seed[regions[i]]) continue;
    if (result.verdict[i] != GrowthVerdict::seed) result.verdict[i] = GrowthVerdict::grown;
    dynamic[i] = 1;
  }
  for (int round = 0; parameters_.grow && round < 8; ++round)
    fill(votes, round < 2 ? -12 : -4, dynamic, result);
  const bool any_static = std::any_of(votes.begin(), votes.end(), [](auto& v) { return v.total() < -4; });
  const std::vector<char> own = dynamic;
  if (parameters_.grow && any_static) add_surfaces(votes, dynamic, result);
  std::vector<PointEvidence> counted = votes;  // surfaces that slide: not at all
  for (std::size_t i = 0; i < size; ++i)
    if (dynamic[i] && !own[i]) counted[i].past = counted[i].future = 0;
  number(counted, dynamic, result);
  return result;
}

double EvidenceGrowthOracle::displacement_m(const std::vector<PointEvidence>& votes,
                                            const std::vector<std::size_t>& object) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double recent = 0, radius = 0;
  for (const std::size_t i : object) {
    sum += points_[i].cast<double>();
    recent += votes[i].recently_free ? 1 : 0;
  }
  const auto count = static_cast<double>(object.size());
  for (const std::size_t i : object) {
    radius = std::max(radius, (points_[i].cast<double>() - sum / count).norm());
  }
  return 2 * radius * recent / count;
}

// Votes count half where a scan saw a surface, and as the cosine of the elevation; each row is scaled down to
// the most it may count.
int EvidenceGrowthOracle::weighted_votes(const std::vector<PointEvidence>& votes,
                                         const std::vector<std::size_t>& object) const {
  std::map<int, std::pair<double, double>> rows;  // votes of each, as they are and weighted
  for (const std::size_t i : object) {
    const int laser = scan_.returns[i].laser;
    const double cosine = std::cos(scan_.model->lasers[static_cast<std::size_t>(laser)].elevation_rad);
    auto& [all, weighted] = rows[laser];
    all += cosine * votes[i].total();
    weighted += cosine * (votes[i].surface_seen ? 0.5 : 1.0) * votes[i].total();
  }
  double sum = 0;
  for (const auto& [row, of_row] : rows) {
    const auto& [all, weighted] = of_row;
    sum += all > parameters_.min_evidence ? weighted / all * parameters_.min_evidence : weighted;
  }
  return static_cast<int>(std::lround(sum));
}

Body EvidenceGrowthOracle::body(const std::vector<PointEvidence>& votes,
                                const std::vector<std::size_t>& object) const {
  std::set<int> rows;
  std::size_t whole = 0, stood = 0;
  for (const std::size_t i : object) {
    rows.insert(scan_.returns[i].laser);
    if (!votes[i].seen_through) ++whole;
    if (votes[i].stood_before) ++stood;
  }
  if (rows.size() >= 3 && whole >= 4 && 5 * whole >= object.size()) return Body::rigid;
  if (10 * stood > object.size()) return Body::standing;
  return on_line(votes, object) ? Body::line : Body::unclear;
}

bool EvidenceGrowthOracle::on_line(const std::vector<PointEvidence>& votes,
                                   const std::vector<std::size_t>& object) const {
  const auto surface_seen = [&](std::size_t i) { return votes[i].surface_seen; };
  if (object.size() < 3 || std::none_of(object.begin(), object.end(), surface_seen)) return false;
  Eigen::MatrixX3d points(object.size(), 3);
  for (std::size_t n = 0; n < object.size(); ++n)
    points.row(static_cast<Eigen::Index>(n)) = points_[object[n]].cast<double>().transpose();
  points.rowwise() -= points.colwise().mean().eval();
  const Eigen::Vector3d spread =
      points.jacobiSvd().singularValues() / std::sqrt(static_cast<double>(object.size()));
  return spread[0] >= 0.1 && 10 * spread[1] <= spread[0];
}

void EvidenceGrowthOracle::number(const std::vector<PointEvidence>& votes, const std::vector<char>& dynamic,
                                  EvidenceGrowthResult& result) const {
  const std::vector<std::size_t> objects = sets(dynamic);
  std::map<std::size_t, std::vector<std::size_t>> members;  // by an object's lowest point
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (dynamic[i]) members[objects[i]].push_back(i);
  }
  std::map<std::size_t, std::uint16_t> numbers;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (!dynamic[i]) continue;
    const std::size_t object = objects[i];
    auto& number = numbers[object];
    if (number == 0) {
      number = static_cast<std::uint16_t>(++result.objects);
      const auto& all = members[object];
      result.evidence.push_back(
          {static_cast<float>(displacement_m(votes, all)), weighted_votes(votes, all), body(votes, all)});
    }
    result.object[i] = number;
  }
}

}  // namespace mapless::test
