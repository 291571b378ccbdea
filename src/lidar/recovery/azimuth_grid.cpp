#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <cstdlib>
#include <numbers>

#include <tbb/parallel_for.h>

#include "core/median.hpp"
#include "lidar/recovery/ring_points.hpp"

namespace mapless::inline v1 {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
// Search range of the horizontal origin of a laser: 1.5 times that of an HDL-64E (0.026 m), the widest known.
constexpr double kLargestAcross_m = 0.04;
// Steps of that search. A step of 2 mm moves the azimuth of a point at 5 m by 0.4 mrad, a quarter of the grid
// of an HDL-64E (1.6 mrad); the second and third pass refine it.
constexpr double kCoarseAcross_m = 0.002, kMediumAcross_m = 0.001, kFineAcross_m = 0.0001;
// Least gain in concentration of a horizontal origin over none. Chosen: small against the 1/sqrt(1500) =
// 0.026 to which a mean of as many random phases is known, and above the rounding of the azimuths.
constexpr double kLeastGain = 0.005;
// Azimuth offsets of two lasers differ by less: 20 degrees (HDL-64E: 18.5 degrees).
constexpr double kLargestOffset_rad = 0.35;
// Sample sizes that bound the time of the search; each mean over them is known to 1/sqrt(size).
constexpr std::size_t kPointsPerRing = 1500, kStepsInSample = 5000, kPositionsInSample = 2500;
constexpr std::size_t kRingsForGrid = 6, kPointsPerRingForGrid = 300, kPointsForConcentration = 800;
// Fewer points of a ring show no phase: its mean is known to 1/sqrt(20) = 0.22.
constexpr std::size_t kFewestPointsForPhase = 20;

// Azimuth steps that are used: not zero, and below 6 degrees, the coarsest column grid. Both points at the
// same distance to 1 %, so that horizontal origins cancel.
constexpr double kLeastStep_rad = 1e-6, kLargestStep_rad = 0.1;
constexpr double kSameDistance = 0.01;
// A step above 1.5 times the median has a missing return in between. Steps above 4.5 times the median are
// left out of the search for the spacing: their phase amplifies its error.
constexpr double kMissingReturn = 1.5, kLongestStep = 4.5;
// Candidate spacings, as multiples of the median step, which is one or two grid positions; 0.5 % apart.
constexpr double kWidestSpacing = 1.3, kNarrowestSpacing = 0.2, kSpacingRatio = 0.995;
// Mean cosine of the steps' phases: a grid shows from 0.5 on; the divisors of a spacing score like it, so the
// widest one within 85 % of the best is taken.
constexpr double kGridScore = 0.5, kNearBestScore = 0.85;
// The number of grid positions is searched within 1/80 of the value the spacing gives, 2.5 times the 0.5 %
// above.
constexpr int kPositionsReach = 80;
// Mean mark under the points of a ring in its right place: 0.9 allows one point in twenty off the firings.
constexpr double kAgreement = 0.9;
// With firings at more than this share of the positions, the sensor fires at every position.
constexpr double kFiresAtEvery = 0.95;
// Scans vary in their number of firings; one column in a thousand is left free for those with more than were
// seen.
constexpr int kSpareColumnEvery = 1000;

// asin(across / rho), to 1e-8 for all but points on the spin axis.
double across_angle(double across_m, double rho_m) {
  const double x = std::clamp(across_m / rho_m, -1.0, 1.0);
  return x + x * x * x / 6;
}

// Steps of azimuth between stored neighbours at about the same distance: free of offsets and horizontal
// origins.
std::vector<double> azimuth_steps(const std::vector<RingPoints>& rings) {
  std::vector<double> steps;
  for (const RingPoints& ring : rings) {
    for (std::size_t i = 1; i < ring.size(); ++i) {
      const double step = ring[i].azimuth_rad - ring[i - 1].azimuth_rad;
      if (ring[i].scan != ring[i - 1].scan || step <= kLeastStep_rad || step > kLargestStep_rad) continue;
      if (std::abs(ring[i].rho_m - ring[i - 1].rho_m) < kSameDistance * ring[i].rho_m) steps.push_back(step);
    }
  }
  return steps;
}

double mean_cosine(const std::vector<double>& steps, double spacing) {
  double sum = 0;
  for (const double step : steps) sum += std::cos(kTwoPi * step / spacing);
  return sum / static_cast<double>(steps.size());
}

// The widest spacing of which nearly all steps are multiples; 0 if there is none.
double grid_spacing(std::vector<double> steps, double median_step) {
  std::erase_if(steps, [&](double s) { return s > kLongestStep * median_step; });
  const std::size_t stride = std::max<std::size_t>(1, steps.size() / kStepsInSample);
  std::vector<double> sample;
  for (std::size_t i = 0; i < steps.size(); i += stride) sample.push_back(steps[i]);
  std::vector<double> spacings;
  std::vector<double> scores;
  for (double s = kWidestSpacing * median_step; s > kNarrowestSpacing * median_step; s *= kSpacingRatio) {
    spacings.push_back(s);
    scores.push_back(mean_cosine(sample, s));
  }
  const double best = *std::max_element(scores.begin(), scores.end());
  if (best < kGridScore) return 0;
  std::size_t i = 0;
  while (scores[i] < kNearBestScore * best) ++i;
  while (i + 1 < scores.size() && scores[i + 1] > scores[i]) ++i;
  return spacings[i];
}

std::vector<const RingPoint*> sample_of(const RingPoints& ring, std::size_t most) {
  std::vector<const RingPoint*> sample;
  const std::size_t stride =
      std::max<std::size_t>(1, (ring.size() + most - 1) / std::max<std::size_t>(most, 1));
  for (std::size_t i = 0; i < ring.size(); i += stride) sample.push_back(&ring[i]);
  return sample;
}

// Mean of exp(i 2 pi (azimuth - across part) / spacing): 1 in size where all azimuths are on one grid.
std::complex<double> concentration(const std::vector<const RingPoint*>& ring, double across_m,
                                   double start_azimuth_rad, int steps) {
  std::complex<double> sum;
  for (const RingPoint* p : ring) {
    const double azimuth = p->azimuth_rad - start_azimuth_rad - across_angle(across_m, p->rho_m);
    sum += std::polar(1.0, azimuth * steps);
  }
  return ring.empty() ? 0 : sum / static_cast<double>(ring.size());
}

struct Placement {
  double across_m = 0;
  std::complex<double> mean;
};

Placement best_placement(const std::vector<const RingPoint*>& ring, double start_azimuth_rad, int steps,
                         double around_m, double reach_m, double resolution_m) {
  // No horizontal origin, unless another is clearly better: with all points at one distance they cannot be
  // distinguished.
  Placement best{around_m, concentration(ring, around_m, start_azimuth_rad, steps)};
  double to_beat = std::abs(best.mean) + (around_m == 0 ? kLeastGain : 0);
  const auto reach = static_cast<int>(std::lround(reach_m / resolution_m));
  for (int i = -reach; i <= reach; ++i) {
    const double across = around_m + i * resolution_m;
    const std::complex<double> mean = concentration(ring, across, start_azimuth_rad, steps);
    if (std::abs(mean) <= to_beat) continue;
    best = {across, mean};
    to_beat = std::abs(mean);
  }
  return best;
}

// Grid positions of the points of every ring, counted in the direction of spin from the seam, one row per
// scan.
class FiringPositions {
 public:
  FiringPositions(const std::vector<RingPoints>& rings, const AzimuthGrid& grid, double start_azimuth_rad,
                  double sign)
      : steps_(grid.encoder_steps), positions_(rings.size()) {
    for (std::size_t i = 0; i < rings.size(); ++i) {
      if (!grid.rings[i].known) continue;
      for (const RingPoint& p : rings[i]) {
        const double hub = p.azimuth_rad - grid.rings[i].offset_rad -
                           across_angle(grid.rings[i].across_m, p.rho_m) - start_azimuth_rad;
        scans_ = std::max(scans_, p.scan + 1);
        positions_[i].push_back(
            {p.scan, wrapped(static_cast<int>(std::lround(sign * hub * steps_ / kTwoPi)))});
      }
    }
  }

  [[nodiscard]] int scans() const { return scans_; }

  // +1: the ring fired here; -1: it did not; 0: unknown, it may have fired without a return. The sensor fires
  // at every position or at every second one: a position between two that fired and without a return did not
  // fire.
  [[nodiscard]] std::vector<std::int8_t> marks_of_ring(std::size_t ring) const {
    std::vector<std::int8_t> marks(size(), 0);
    for (const auto& [scan, j] : positions_[ring]) marks[index(scan, j)] = 1;
    for (int scan = 0; scan < scans_; ++scan) {
      for (int j = 0; j < steps_; ++j) {
        const bool between =
            marks[index(scan, wrapped(j - 1))] == 1 && marks[index(scan, wrapped(j + 1))] == 1;
        if (marks[index(scan, j)] == 0 && between) marks[index(scan, j)] = -1;
      }
    }
    return marks;
  }

  // +1 where at least three lasers fired, -1 elsewhere, every ring shifted by its own whole steps.
  [[nodiscard]] std::vector<std::int8_t> marks_of_all(const std::vector<int>& shifts) const {
    std::vector<int> lasers(size(), 0);
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      for (const auto& [scan, j] : positions_[i]) ++lasers[index(scan, wrapped(j + shifts[i]))];
    }
    std::vector<std::int8_t> marks(size(), -1);
    for (std::size_t k = 0; k < marks.size(); ++k) {
      if (lasers[k] >= kFiringLasers) marks[k] = 1;
    }
    return marks;
  }

  // Mean mark under the points of a ring shifted by `shift`.
  [[nodiscard]] double agreement(std::size_t ring, int shift, const std::vector<std::int8_t>& marks) const {
    const std::size_t stride = positions_[ring].size() / kPositionsInSample + 1;
    long sum = 0;
    long count = 0;
    for (std::size_t i = 0; i < positions_[ring].size(); i += stride) {
      sum += marks[index(positions_[ring][i].scan, wrapped(positions_[ring][i].j + shift))];
      ++count;
    }
    return count == 0 ? 0 : static_cast<double>(sum) / static_cast<double>(count);
  }

  // Firings of the fullest scan.
  [[nodiscard]] int most_firings(const std::vector<std::int8_t>& marks) const {
    long most = 0;
    for (int scan = 0; scan < scans_; ++scan) {
      const auto begin = marks.begin() + static_cast<std::ptrdiff_t>(index(scan, 0));
      most = std::max<long>(most, std::count(begin, begin + steps_, 1));
    }
    return static_cast<int>(most);
  }

 private:
  struct Position {
    int scan;
    int j;
  };
  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(scans_) * static_cast<std::size_t>(steps_);
  }
  [[nodiscard]] std::size_t index(int scan, int j) const {
    return static_cast<std::size_t>(scan * steps_ + j);
  }
  [[nodiscard]] int wrapped(int j) const { return ((j % steps_) + steps_) % steps_; }

  int steps_;
  int scans_ = 0;
  std::vector<std::vector<Position>> positions_;
};

int best_shift(const FiringPositions& positions, std::size_t ring, const std::vector<std::int8_t>& marks,
               int reach, double& agreement) {
  int best = 0;
  agreement = positions.agreement(ring, 0, marks);
  for (int shift = -reach; shift <= reach; ++shift) {
    const double a = positions.agreement(ring, shift, marks);
    if (a <= agreement) continue;
    agreement = a;
    best = shift;
  }
  return best;
}

// Whole steps of every ring, from the firing positions all lasers share: first against the fullest ring, then
// against all rings together.
std::vector<int> whole_shifts(const FiringPositions& positions, AzimuthGrid& grid, std::size_t fullest) {
  const auto reach = static_cast<int>(kLargestOffset_rad * grid.encoder_steps / kTwoPi);
  std::vector<int> shifts(grid.rings.size(), 0);
  double agreement = 0;
  const std::vector<std::int8_t> one = positions.marks_of_ring(fullest);
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    if (grid.rings[i].known) shifts[i] = best_shift(positions, i, one, reach, agreement);
  }
  const std::vector<std::int8_t> all = positions.marks_of_all(shifts);
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    if (!grid.rings[i].known) continue;
    shifts[i] = best_shift(positions, i, all, reach, agreement);
    if (agreement < kAgreement) grid.rings[i].known = false;
  }
  return shifts;
}

void place_rings(const std::vector<RingPoints>& rings, double start_azimuth_rad, AzimuthGrid& grid) {
  tbb::parallel_for(std::size_t{0}, rings.size(), [&](std::size_t i) {
    if (rings[i].size() < kFewestPointsForPhase) return;
    const auto sample = sample_of(rings[i], kPointsPerRing);
    Placement p =
        best_placement(sample, start_azimuth_rad, grid.encoder_steps, 0, kLargestAcross_m, kMediumAcross_m);
    if (p.across_m != 0) {
      p = best_placement(sample, start_azimuth_rad, grid.encoder_steps, p.across_m, kMediumAcross_m,
                         kFineAcross_m);
    }
    if (std::abs(p.mean) < kConcentrated) return;
    grid.rings[i] = {std::arg(p.mean) / grid.encoder_steps, p.across_m, true};
  });
}

void take_whole_offsets(const std::vector<RingPoints>& rings, double start_azimuth_rad, double sign,
                        std::size_t fullest, AzimuthGrid& grid) {
  const FiringPositions positions(rings, grid, start_azimuth_rad, sign);
  const std::vector<int> shifts = whole_shifts(positions, grid, fullest);
  int least = 0;
  int most = 0;
  bool first = true;
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    if (!grid.rings[i].known) continue;
    least = first ? shifts[i] : std::min(least, shifts[i]);
    most = first ? shifts[i] : std::max(most, shifts[i]);
    first = false;
  }
  const int centre = (least + most) / 2;
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    // A point found at position j fired at j + shift: its laser looks back by the shift, against the spin.
    if (grid.rings[i].known) {
      grid.rings[i].offset_rad -= sign * (shifts[i] - centre) * kTwoPi / grid.encoder_steps;
    } else {
      grid.rings[i] = {};
    }
  }
  const int firings = positions.most_firings(positions.marks_of_all(shifts));
  grid.columns = firings + (firings + kSpareColumnEvery - 1) / kSpareColumnEvery;
  grid.absolute = true;
}

}  // namespace

double find_grid_spacing(const std::vector<RingPoints>& rings) {
  const std::vector<double> steps = azimuth_steps(rings);
  return steps.empty() ? 0 : grid_spacing(steps, median(steps));
}

// From the rings with the most points.
int find_grid_positions(const std::vector<RingPoints>& rings, double spacing_rad, double start_azimuth_rad) {
  std::vector<const RingPoints*> by_size;
  for (const RingPoints& ring : rings) by_size.push_back(&ring);
  std::stable_sort(by_size.begin(), by_size.end(), [](auto* a, auto* b) { return a->size() > b->size(); });
  if (by_size.size() > kRingsForGrid) by_size.resize(kRingsForGrid);
  std::vector<std::vector<const RingPoint*>> samples;
  for (const RingPoints* ring : by_size) samples.push_back(sample_of(*ring, kPointsPerRingForGrid));
  const auto middle = static_cast<int>(std::lround(kTwoPi / spacing_rad));
  const int reach = std::max(2, middle / kPositionsReach);
  int best = 0;
  double best_score = 0;
  for (int n = middle - reach; n <= middle + reach; ++n) {
    double score = 0;
    for (const auto& sample : samples) {
      score +=
          std::abs(best_placement(sample, start_azimuth_rad, n, 0, kLargestAcross_m, kCoarseAcross_m).mean);
    }
    if (score > best_score) {
      best = n;
      best_score = score;
    }
  }
  return best_score > kConcentrated * static_cast<double>(samples.size()) ? best : 0;
}

double grid_concentration(const RingPoints& ring, double start_azimuth_rad, int positions) {
  const auto sample = sample_of(ring, kPointsForConcentration);
  return std::abs(
      best_placement(sample, start_azimuth_rad, positions, 0, kLargestAcross_m, kCoarseAcross_m).mean);
}

AzimuthGrid find_azimuth_grid(const std::vector<RingPoints>& rings, double start_azimuth_rad, double sign) {
  AzimuthGrid grid;
  grid.rings.resize(rings.size());
  const std::vector<double> steps = azimuth_steps(rings);
  if (steps.empty()) return grid;
  const double median_step = median(steps);
  double sum = 0;
  double count = 0;
  for (const double step : steps) {
    if (step > kMissingReturn * median_step) continue;
    sum += step;
    ++count;
  }
  grid.columns = static_cast<int>(std::lround(kTwoPi * count / sum));
  const double spacing = grid_spacing(steps, median_step);
  if (spacing == 0) return grid;
  grid.encoder_steps = find_grid_positions(rings, spacing, start_azimuth_rad);
  if (grid.encoder_steps == 0) return grid;
  place_rings(rings, start_azimuth_rad, grid);
  std::size_t fullest = 0;
  for (std::size_t i = 0; i < rings.size(); ++i) {
    if (grid.rings[i].known && (!grid.rings[fullest].known || rings[i].size() > rings[fullest].size()))
      fullest = i;
  }
  if (!grid.rings[fullest].known) {
    grid.encoder_steps = 0;
  } else if (grid.columns > kFiresAtEvery * grid.encoder_steps) {
    grid.columns = grid.encoder_steps;  // neighbouring positions cannot be distinguished
  } else {
    take_whole_offsets(rings, start_azimuth_rad, sign, fullest, grid);
  }
  return grid;
}

}  // namespace mapless
