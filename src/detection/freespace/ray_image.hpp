#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "detection/freespace/beam_fan.hpp"
#include <mapless/detection/parameters.hpp>
#include <mapless/detection/stages.hpp>
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless::inline v1 {

/// What a scan keeps to be asked about freespace later: how far each of its rays went, and from where. About
/// a twentieth of the scan's size, since neither points nor normals are needed.
class RayImage {
 public:
  /// `before`: an image whose beams serve for this one too, where it is of the same sensor.
  explicit RayImage(const CompensatedScan& scan, const RayImage* before = nullptr);

  /// The hub at one instant, in single precision.
  struct Pose {
    Eigen::Matrix4f T_h0;  ///< world about origin_0() to hub; its last row is not used
    /// How points at rest move in a hub that does not turn, from one column to the next: a step of linear [m]
    /// + angular [rad] x p; of three numbers each.
    Eigen::Vector4f linear, angular;
    [[nodiscard]] Eigen::Vector3f operator*(const Eigen::Vector3f& q) const {
      return T_h0.topLeftCorner<3, 3>() * q + T_h0.topRightCorner<3, 1>();
    }
  };

  [[nodiscard]] const LidarModel& model() const { return *model_; }
  [[nodiscard]] const BeamFan& fan() const { return *fan_; }
  [[nodiscard]] int rows() const { return static_cast<int>(model_->lasers.size()); }
  [[nodiscard]] int columns() const { return static_cast<int>(poses_.size()); }
  /// How far the cell's ray is known to have gone [m]: to its return, or to the maximum range where nothing
  /// stood within it; NaN where it is not known.
  [[nodiscard]] float range_m(int laser, int column) const { return row_m(laser)[column]; }
  /// range_m of all columns of a laser, and NaN for kBeside columns before the first and after the last.
  [[nodiscard]] const float* row_m(int laser) const {
    return ranges_m_.data() + static_cast<std::size_t>(laser) * (poses_.size() + kBeside) + kBeside;
  }
  static constexpr std::size_t kBeside = 16;

  /// Remembers which returns were found dynamic: `object` is 0 for those that were not, one element per
  /// return of `scan`, the scan this was made of.
  void mark_dynamic(const LidarScan& scan, const std::vector<std::uint16_t>& object);
  /// Whether the cell's return was; false where nothing was marked yet.
  [[nodiscard]] bool dynamic(int laser, int column) const {
    return !dynamic_.empty() &&
           dynamic_[static_cast<std::size_t>(laser) * poses_.size() + static_cast<std::size_t>(column)];
  }
  /// Where the sensor was at the scan's start.
  [[nodiscard]] const Eigen::Vector3d& origin_0() const { return origin_0_; }
  /// At the instant of a column.
  [[nodiscard]] const Pose& pose(int column) const { return poses_[static_cast<std::size_t>(column)]; }

 private:
  std::shared_ptr<const LidarModel> model_;
  std::shared_ptr<const BeamFan> fan_;  // where it is stays when the image is moved
  Eigen::Vector3d origin_0_ = Eigen::Vector3d::Zero();
  std::vector<Pose> poses_;      // one per column
  std::vector<float> ranges_m_;  // row-major, with kBeside more columns before each row and after the last
  std::vector<bool> dynamic_;    // row-major; empty until marked
};

/// Asks one RayImage about points near `origin_0`, in single precision about that origin.
///
/// Of the rays around a point q the nearest one above and below are taken, of each laser the firing that
/// passes nearest, every ray from its own pose at its own instant (paper Eq. 1 and 2), and the firings beside
/// those. Where any of them ends within the tolerance of q's own range a surface passes there: border. Where
/// all go on beyond: inside. Where the nearest ends short of it: outside. Where that goes on and others end
/// short, of those next to the nearest or within kHidesWithin_m, far ground may pass between two rings, or a
/// thing may end there: unobserved. Above the
/// highest beam and below the lowest only what is on them, by a tenth of the spacing, can be inside: where a
/// slanting surface goes there is not known.
class FreespaceProbe {
 public:
  FreespaceProbe(const RayImage& image, const Eigen::Vector3d& origin_0, const VotingParameters& parameters);

  /// What the scan says of a point, and the firing that passes nearest to it (laser -1: none).
  struct Answer {
    FreespaceVerdict verdict = FreespaceVerdict::unobserved;
    int laser = -1, column = -1;
    float short_by_m = 0;  ///< how far before the point that firing ended; NaN where it is not known
    float aside_m = 0;     ///< how far from the point its ray passes, up or to the side, by whichever is more
  };
  /// `q`: a point minus origin_0 [m]. `column` is a guess of where the scan looks that way, and holds the
  /// column found afterwards; any number will do, a good one is faster.
  [[nodiscard]] Answer look(const Eigen::Vector3f& q, float& column) const {
    return look_about_image(q + origin_, column);
  }
  [[nodiscard]] FreespaceVerdict ask(const Eigen::Vector3f& q, float& column) const {
    return look(q, column).verdict;
  }
  static constexpr std::size_t kAtOnce = 8;
  struct Points {  ///< as `q` above, mostly near one another
    alignas(32) std::array<float, kAtOnce> x, y, z;
    float near = 0;                                 ///< guess of a column in which the scan looks that way
    float near_last = 0;                            ///< and of the last of them, for those that follow
    alignas(32) std::array<float, kAtOnce> column;  ///< found for each
  };
  struct Answers {
    alignas(32) std::array<std::int32_t, kAtOnce> verdict{}, laser{}, column{};
    std::array<float, kAtOnce> short_by_m{}, aside_m{};
    [[nodiscard]] Answer operator[](std::size_t k) const {
      return {static_cast<FreespaceVerdict>(verdict[k]), laser[k], column[k], short_by_m[k], aside_m[k]};
    }
    void set(std::size_t k, const Answer& answer) {
      verdict[k] = static_cast<std::int32_t>(answer.verdict);
      laser[k] = answer.laser;
      column[k] = answer.column;
      short_by_m[k] = answer.short_by_m;
      aside_m[k] = answer.aside_m;
    }
  };
  enum class Vectors { of_four, of_eight };
  /// What this processor has. The answers of both are the same, to the last bit.
  [[nodiscard]] static Vectors widest_vectors();
  /// `look` at eight points at once, in less time than three take by themselves. Differs where a point is
  /// within rounding, or a tenth of a millimetre a metre, of the limit between two answers.
  [[nodiscard]] Answers look(Points& points, Vectors vectors = widest_vectors()) const;
  /// The same of many, in less time: the lengths of the rays around some come while the next are looked for.
  /// As far as the last of eight is found beside `near_last`, the next are looked for beside their `near`.
  void look(std::span<Points> points, std::span<Answers> answers, Vectors vectors = widest_vectors()) const;

  /// How far a surface at `range_m` may be from a ray's end and still be what it hit.
  [[nodiscard]] float tolerance_m(int laser, float range_m) const {
    return tolerance_at_0_m_ +
           tolerance_spacings_ * fan_.beams[static_cast<std::size_t>(laser)].spacing_rad * range_m;
  }

  /// Whether the firing named hit something; what met nothing goes to the maximum range and hides nothing.
  [[nodiscard]] bool ended(const Answer& answer) const;
  /// Whether what the firing named hit was found dynamic.
  [[nodiscard]] bool dynamic(const Answer& answer) const {
    return image_.dynamic(answer.laser, answer.column);
  }
  /// Where the ray of a cell with a return ended, minus origin_0 [m].
  [[nodiscard]] Eigen::Vector3f endpoint(int laser, int column) const;
  /// Fetches what `endpoint` wants from far memory, to be asked a little later.
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
  // What the firings around a point say of it.
  struct Window {
    bool border = false, hides = false;
    float nearest_range_m = std::numeric_limits<float>::quiet_NaN();  // of the firing that passes nearest
  };
  template <int lanes>
  struct Lanes;  // so many points at once

  // `q` from here on: about the image's origin.
  [[nodiscard]] Answer look_about_image(const Eigen::Vector3f& q, float& column) const;
  [[nodiscard]] bool find_column(const Eigen::Vector3f& q, float& column, Eigen::Vector3f& q_h) const;
  [[nodiscard]] Eigen::Vector3f in_laser(const Eigen::Vector3f& q, const Beam& beam, int column) const;
  [[nodiscard]] Sighting sight(const Eigen::Vector3f& q, const Beam& beam, float column,
                               float columns_per_m) const;
  [[nodiscard]] Bracket bracket(const Eigen::Vector3f& q, float column, const Eigen::Vector3f& q_h) const;
  [[nodiscard]] float reach_m(const Sighting& nearest) const;
  void look_around(const Sighting& s, bool is_nearest, Window& window) const;

  const RayImage& image_;
  float tolerance_at_0_m_, tolerance_spacings_;
  int half_window_;
  float reach_at_0_m_, reach_spacings_;
  static constexpr float kFarAside = 2;  // a firing that many columns off does not speak for a point
  static constexpr float kEdgeSpacings = 0.1F;
  // Columns lie apart by more the farther away they are: past what stands beside a small thing then, and not
  // where that is, one sees.
  static constexpr float kHidesWithin_m = 0.12F;
  [[nodiscard]] float hides_within_columns_m() const {
    return kHidesWithin_m * std::abs(fan_.columns_per_rad);
  }
  Eigen::Vector3f origin_;  // of the points, about the image's
  int pose_stride_;         // a look at many points uses every so many of them
  const BeamFan& fan_;
};

}  // namespace mapless
