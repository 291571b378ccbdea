#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include <Eigen/Core>

#include "detection/freespace/ray_image.hpp"
#include <mapless/detection/detection.hpp>
#include <mapless/detection/parameters.hpp>

namespace mapless::inline v1 {

/// How much the range of a surface changes per metre across the rays. Of a vertical side seen square on both
/// are 0; of ground near the horizon `up` is many.
struct SurfaceSlopes {
  static constexpr float kUnknown = 1e9F;
  float up = kUnknown;
  float left = kUnknown;  ///< to the side, within a row
};

/// This folder answers one question: did the rays of that scan pass through this place? In: a compensated
/// scan (RayImage) and points in the world, about an origin near them, in single precision. Out: a verdict
/// and the firing that passes nearest. Nothing outside changes a RayImage, but to mark its dynamic returns.
///
/// FreespaceProbe observes points q through one RayImage. Every ray has its own pose at its own instant
/// (paper Eq. 1 and 2). Of each laser the firing that passes nearest to q is taken; of these, the nearest one
/// above q and the nearest one below; and of both lasers a window of firings (VotingParameters::window_deg),
/// and those beside it (beside_window_deg).
///
/// - border: a ray of the windows ends within the tolerance of q's own range. A surface is there. The
///   tolerance is that of a ray which passes q's surface as far aside as the laser's nearest firing does, by
///   the surface's slopes; and at most tolerance_m(), where they are not known.
/// - outside: the nearest ray ends short of q.
/// - unobserved: the nearest ray passes beyond q, but a neighbouring ray (adjacent column, or within
///   kHidesWithin_m) stops short: an edge, or a gap between two rings. Also where no ray passes within
///   max_ray_distance_m + max_ray_distance_spacings x laser spacing x range, where the nearest firing is
///   faulty, and above the highest or below the lowest laser, unless q is on its beam to kEdgeSpacings of the
///   laser spacing: how a slanting surface goes on there is unknown.
/// - inside: all rays of the windows pass beyond q. Rays beside them may have ended on a surface about q, as
///   among leaves: surface_beside.
///
/// check_freespace (the published method) is apart, for reasons its header gives; both share
/// FreespaceVerdict. The oracle is tests/oracle/freespace_probe_oracle.hpp, brute force over all rays in
/// double precision; tests/detection/freespace/freespace_agreement_test.cpp compares the implementations with
/// one another.
class FreespaceProbe {
 public:
  FreespaceProbe(const RayImage& image, const Eigen::Vector3d& origin_0, const VotingParameters& parameters);

  /// The verdict on a point, and the firing that passes nearest to it (laser -1: none).
  struct Answer {
    FreespaceVerdict verdict = FreespaceVerdict::unobserved;
    int laser = -1, column = -1;
    float short_by_m = 0;  ///< how far before the point that firing ended; NaN where it is not known
    float aside_m = 0;     ///< how far from the point its ray passes, up or to the side, by whichever is more
    bool surface_beside = false;  ///< a ray beside the windows ended at the range of the point
  };
  /// `q`: a point minus origin_0 [m]. `column`: a guess of the column whose firings pass near q; holds the
  /// column found afterwards. Any number will do, a good one is faster.
  [[nodiscard]] Answer observe(const Eigen::Vector3f& q, float& column, SurfaceSlopes slopes = {}) const {
    return observe_about_image(q + origin_, column, slopes);
  }
  [[nodiscard]] FreespaceVerdict verdict(const Eigen::Vector3f& q, float& column,
                                         SurfaceSlopes slopes = {}) const {
    return observe(q, column, slopes).verdict;
  }
  static constexpr std::size_t kAtOnce = 8;
  struct Points {  ///< as `q` above, mostly near one another
    alignas(32) std::array<float, kAtOnce> x, y, z;
    float near = 0;                                 ///< guess of the column in which the scan observes them
    float near_last = 0;                            ///< the same of the last of them, for the next eight
    alignas(32) std::array<float, kAtOnce> column;  ///< found for each
    /// SurfaceSlopes of each.
    alignas(32) std::array<float, kAtOnce> slope_up = unknown_slopes(), slope_left = unknown_slopes();
    [[nodiscard]] static constexpr std::array<float, kAtOnce> unknown_slopes() {
      std::array<float, kAtOnce> all{};
      all.fill(SurfaceSlopes::kUnknown);
      return all;
    }
  };
  struct Answers {
    alignas(32) std::array<std::int32_t, kAtOnce> verdict{}, laser{}, column{}, surface_beside{};
    std::array<float, kAtOnce> short_by_m{}, aside_m{};
    [[nodiscard]] Answer operator[](std::size_t k) const {
      return {static_cast<FreespaceVerdict>(verdict[k]),
              laser[k],
              column[k],
              short_by_m[k],
              aside_m[k],
              surface_beside[k] != 0};
    }
    void set(std::size_t k, const Answer& answer) {
      verdict[k] = static_cast<std::int32_t>(answer.verdict);
      laser[k] = answer.laser;
      column[k] = answer.column;
      short_by_m[k] = answer.short_by_m;
      aside_m[k] = answer.aside_m;
      surface_beside[k] = answer.surface_beside ? 1 : 0;
    }
  };
  enum class Vectors { of_four, of_eight };
  /// What this processor has. The answers of both are the same, to the last bit.
  [[nodiscard]] static Vectors widest_vectors();
  /// `observe` for eight points at once, in less time than three points take one by one. The answers differ
  /// only within rounding, or 0.1 mm per metre of range, of the limit between two answers.
  [[nodiscard]] Answers observe(Points& points, Vectors vectors = widest_vectors()) const;
  /// The same for many, in less time: the ranges around some points are fetched while the columns of the next
  /// are found. The guess `near` of eight points is corrected by how far the last of the eight before was
  /// found from its `near_last`.
  void observe(std::span<Points> points, std::span<Answers> answers,
               Vectors vectors = widest_vectors()) const;

  /// Largest distance between the end of a ray and a surface of unknown slopes at `range_m` that the ray may
  /// have hit [m].
  [[nodiscard]] float tolerance_m(int laser, float range_m) const {
    return tolerance_at_0_m_ +
           tolerance_spacings_ * fan_.beams[static_cast<std::size_t>(laser)].spacing_rad * range_m;
  }

  /// Whether the answer's firing has a return. Without one it went to the maximum range and hides nothing.
  [[nodiscard]] bool ended(const Answer& answer) const;
  /// Whether the return of the answer's firing was found dynamic.
  [[nodiscard]] bool dynamic(const Answer& answer) const {
    return image_.dynamic(answer.laser, answer.column);
  }
  /// Where the ray of a cell with a return ended, minus origin_0 [m].
  [[nodiscard]] Eigen::Vector3f endpoint(int laser, int column) const;
  /// Prefetches what `endpoint` reads.
  void prepare_endpoint(int column) const;

 private:
  using Pose = RayImage::Pose;
  using Beam = BeamFan::Beam;
  using Bank = BeamFan::Bank;
  // A laser's firing nearest to a point.
  struct Sighting {
    const Beam* beam = nullptr;
    int column = 0;
    float range_m = 0;   // of the point's foot on the beam
    float height_m = 0;  // of the point above the beam
    float left_m = 0;    // and left of it
    [[nodiscard]] bool found() const { return beam != nullptr; }
  };
  struct Bracket {
    Sighting above, below;  // beams above and below the point
    void take(const Sighting& s);
    [[nodiscard]] const Sighting& nearest() const;
  };
  // What the firings around a point observe.
  struct Window {
    bool border = false, hides = false, surface_beside = false;
    float nearest_range_m = std::numeric_limits<float>::quiet_NaN();  // of the firing that passes nearest
  };
  template <int lanes>
  struct Lanes;  // `lanes` points at once

  // `q` from here on: about the image's origin.
  [[nodiscard]] Answer observe_about_image(const Eigen::Vector3f& q, float& column,
                                           SurfaceSlopes slopes) const;
  [[nodiscard]] bool find_column(const Eigen::Vector3f& q, float& column, Eigen::Vector3f& q_h) const;
  [[nodiscard]] Eigen::Vector3f in_laser(const Eigen::Vector3f& q, const Beam& beam, int column) const;
  [[nodiscard]] Sighting sight(const Eigen::Vector3f& q, const Beam& beam, float column,
                               float columns_per_m) const;
  [[nodiscard]] Bracket bracket(const Eigen::Vector3f& q, float column, const Eigen::Vector3f& q_h) const;
  [[nodiscard]] float max_distance_m(const Sighting& nearest) const;
  [[nodiscard]] static int columns_within(float half_window, float elevation_cosine);
  void add_window(const Sighting& s, bool is_nearest, SurfaceSlopes slopes, Window& window) const;

  const RayImage& image_;
  float tolerance_at_0_m_, tolerance_spacings_;
  float half_window_, half_beside_;  // columns of a horizontal beam
  float reach_at_0_m_, reach_spacings_;
  // A firing more columns aside than this does not observe the point. Chosen: the nearest firing is at most
  // half a column aside, and 1.25 more near the seam, where the next laser may have fired a turn earlier.
  static constexpr float kMaxColumnsAside = 2;
  // A column is found once the point is this near to it: half a column, and a quarter against alternating.
  static constexpr float kSettledColumns = 0.75F;
  // Chosen: what drifting rings and noise of elevation may be off, as a share of the laser spacing.
  static constexpr float kEdgeSpacings = 0.1F;
  // Far away, neighbouring columns pass beside a small object rather than at its place; only rays within this
  // distance of q can hide it. Measured: docs/notebook/detection.md, "within 0.12 m of a point".
  static constexpr float kHidesWithin_m = 0.12F;
  [[nodiscard]] float hides_within_columns_m() const {
    return kHidesWithin_m * std::abs(fan_.columns_per_rad);
  }
  Eigen::Vector3f origin_;  // of the points, about the image's
  int pose_stride_;         // of the poses that `observe` of many points uses, as they stay in the cache
  const BeamFan& fan_;
};

}  // namespace mapless
