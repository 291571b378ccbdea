#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "detection/evidence/point_evidence.hpp"
#include "detection/evidence/range_rate.hpp"
#include "detection/evidence/slope_image.hpp"
#include "detection/evidence/surface_planes.hpp"
#include "detection/freespace/packed_points.hpp"
#include <mapless/detection/explanation.hpp>
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {

/// A scan whose rays observe the points of the query scan. `gap` [scans]: how far before the query scan it
/// lies; below 0 it is later.
struct ReferenceScan {
  const RayImage* image = nullptr;
  int gap = 1;
};

/// Queries reference scans about single points of one scan, and sums their votes (PointEvidence).
///
/// Reference scans are queried one after another. A point whose votes already prove it static is settled: the
/// scans not queried count as if they had seen the surface too.
///
/// A ray that ends behind the point, but in the plane of its surface, saw the surface (SurfacePlanes).
///
/// A departed occluder counts only if the point can be part of it (consistent_with_departure): an object that
/// went `d` metres in `gap` scans goes on by d / gap until the next scan. If that is clearly more than the
/// noise, and the next scan sees a surface at the point, the occluder was something else, which uncovered the
/// point. What hid the point in scans before that one then tells nothing of it either.
///
/// Scans of other sensors on the same vehicle are queried last, about the points that are not settled, and
/// only for what they saw through (query_others).
class EvidenceCollector {
  struct Reference;

 public:
  /// Keeps references to all but `references` and `others`. `others`: earlier scans of other sensors, by
  /// their gaps in scans of this one. `explanation`: records gaps and observations of `references`; null:
  /// nothing.
  EvidenceCollector(const LidarScan& scan, const LocalPoints& points,
                    const std::vector<ReferenceScan>& references, const RayImage& own,
                    const VotingParameters& parameters, ScanExplanation* explanation = nullptr,
                    const std::vector<ReferenceScan>& others = {});

  /// Memory of one call, kept for the next by its thread.
  struct Workspace {
    struct PointQuery {
      std::uint32_t i;  // return of the scan
      PointEvidence evidence;
      bool seen_next = false;      // as a surface, by the next later scan
      float next_offset_m = 0;     // along the ray, from the point to that surface; NaN: beside it
      bool occluder_left = false;  // of some scan, whether or not it is consistent
      std::uint32_t offsets = 0;   // how many of its offsets are entered
      int uncovered_gap = std::numeric_limits<int>::max();  // of the nearest scan whose occluder uncovered it
    };
    std::vector<PointQuery> queries;
    // As many for each query as there are reference scans.
    std::vector<RangeOffset> offsets;
    std::vector<std::size_t> open;  // queries not settled yet
    PackedPoints points;            // of each of these
    // A return of one reference scan that hid a point from it.
    struct Occluder {
      PointQuery* query;
      int laser, column;       // of that return
      float distance2_m2 = 0;  // to the point, squared
    };
    std::vector<Occluder> occluders;
    PackedPoints places;  // of each occluder
    // What the scans of other sensors observed at a query.
    struct OtherSensors {
      int seen_through = 0, surface = 0;  // votes for the point and against it
      bool recently = false;              // seen through by a recent scan
    };
    std::vector<OtherSensors> others;
    // An occluder whose place the query scan observes free, of all reference scans.
    struct DepartedOccluder {
      PointQuery* query;
      const Reference* reference;
      float distance_m;  // from its place to the point
    };
    std::vector<DepartedOccluder> departed;
  };
  /// Queries all reference scans about returns of the scan, and enters the sums in `evidence` (one element
  /// per return of the scan). Fast where consecutive `returns` are neighbours in a row.
  void query(const std::vector<std::size_t>& returns, Workspace& work,
             std::vector<PointEvidence>& evidence) const;
  /// What is recorded; null: nothing.
  [[nodiscard]] ScanExplanation* explanation() const { return explanation_; }

 private:
  using PointQuery = Workspace::PointQuery;
  struct Reference {
    FreespaceProbe probe;
    int surface_votes;
    bool later;
    bool next;  // the nearest of the later ones
    bool recent;
    bool beside;  // the scan before or after, in a turn in which slow things hardly move
    int gap;
    std::size_t order;  // in references_
  };

  [[nodiscard]] float column(std::size_t i) const { return static_cast<float>(scan_.returns[i].column); }
  void start(const std::vector<std::size_t>& returns, Workspace& work) const;
  void query_reference(const Reference& reference, Workspace& work) const;
  [[nodiscard]] bool hit_plane(const Reference& reference, const FreespaceProbe::Answer& answer,
                               std::size_t i) const;
  void add_answer(const Reference& reference, const FreespaceProbe::Answer& answer, PointQuery& query,
                  Workspace& work) const;
  void query_others(Workspace& work) const;
  void find_departed(const Reference& reference, Workspace& work) const;
  void add_departed(Workspace& work) const;
  [[nodiscard]] bool consistent_with_departure(const Workspace::DepartedOccluder& occluder) const;
  static void add_votes(const Reference& reference, int votes, PointEvidence& evidence);
  void settle(std::size_t queried, Workspace& work) const;
  void add_offset(const Reference& reference, const FreespaceProbe::Answer& answer, int surface_votes,
                  PointQuery& query, Workspace& work) const;
  void add_range_rate(std::size_t number, Workspace& work) const;
  // Where the observation of a point by a reference scan is recorded; null: nowhere.
  [[nodiscard]] Observation* recorded(const Reference& reference, std::size_t i) const {
    return explanation_ ? &explanation_->observations[i * references_.size() + reference.order] : nullptr;
  }

  const LidarScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  SlopeImage slopes_;
  float max_occluder_distance_m_, surface_noise_m_;
  FreespaceProbe own_;
  SurfacePlanes planes_;
  std::vector<Reference> references_;  // in the order of queries
  std::vector<Reference> others_;      // of other sensors
  ScanExplanation* explanation_;
};

}  // namespace mapless
