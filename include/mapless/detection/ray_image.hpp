#pragma once

#include <limits>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include <mapless/detection/parameters.hpp>
#include <mapless/detection/stages.hpp>
#include <mapless/geometry/compensated_scan.hpp>

namespace mapless {

/// What a scan keeps to be asked about freespace later: how far each of its rays went, and from where. About
/// a twentieth of the scan's size, since neither points nor normals are needed.
class RayImage {
 public:
  explicit RayImage(const CompensatedScan& scan);

  [[nodiscard]] const LidarModel& model() const { return *model_; }
  [[nodiscard]] int rows() const { return static_cast<int>(model_->lasers.size()); }
  [[nodiscard]] int columns() const { return static_cast<int>(column_T_h0_.size()); }
  /// How far the cell's ray is known to have gone [m]: to its return, or to the maximum range where nothing
  /// stood within it; NaN where it is not known.
  [[nodiscard]] float range_m(int laser, int column) const {
    return ranges_m_[static_cast<std::size_t>(laser) * column_T_h0_.size() +
                     static_cast<std::size_t>(column)];
  }
  /// World to hub at the instant of a column.
  [[nodiscard]] const SE3& column_T_h0(int column) const {
    return column_T_h0_[static_cast<std::size_t>(column)];
  }

 private:
  std::shared_ptr<const LidarModel> model_;
  std::vector<SE3> column_T_h0_;
  std::vector<float> ranges_m_;  // row-major
};

/// Asks one RayImage about points near `origin_0`, in single precision about that origin.
///
/// Of the rays around a point q the nearest one above and below are taken, of each laser the firing that
/// passes nearest, every ray from its own pose at its own instant (paper Eq. 1 and 2), and the firings beside
/// those. Where any of them ends within the tolerance of q's own range, or some end short of it and some
/// beyond, a surface passes through or near q: border. Where all go on beyond: inside. Where the nearest ends
/// short of it: outside. A surface between two lasers is thus seen as well as one on a laser, with no normal
/// to be known; far ground, of which one ring ends short of q and the next beyond, is border.
class FreespaceProbe {
 public:
  FreespaceProbe(const RayImage& image, const Eigen::Vector3d& origin_0, const VotingParameters& parameters);

  /// What the scan says of a point, and the firing that passes nearest to it (laser -1: none).
  struct Answer {
    FreespaceVerdict verdict = FreespaceVerdict::unobserved;
    int laser = -1, column = -1;
  };
  /// `q`: a point minus origin_0 [m]. `column` is a guess of where the scan looks that way, and holds the
  /// column found afterwards; any number will do, a good one is faster.
  [[nodiscard]] Answer look(const Eigen::Vector3f& q, float& column) const;
  [[nodiscard]] FreespaceVerdict ask(const Eigen::Vector3f& q, float& column) const {
    return look(q, column).verdict;
  }

  /// Whether the firing named hit something; what met nothing goes to the maximum range and hides nothing.
  [[nodiscard]] bool ended(const Answer& answer) const;
  /// Where the ray of a cell with a return ended, minus origin_0 [m].
  [[nodiscard]] Eigen::Vector3f endpoint(int laser, int column) const;

 private:
  struct Pose {  // origin-centred world to hub
    Eigen::Matrix3f rotation;
    Eigen::Vector3f translation;
    [[nodiscard]] Eigen::Vector3f operator*(const Eigen::Vector3f& q) const {
      return rotation * q + translation;
    }
  };
  struct Beam {                 // of one laser
    Eigen::Vector2f azimuth;    // cosine and sine of its offset
    Eigen::Vector2f elevation;  // the same of its elevation
    Eigen::Vector3f origin;     // in the hub, turned by the azimuth offset [m]
    float offset_columns;       // how much later than the hub's x axis it points somewhere
    float spacing_rad;          // elevation to the farther of its neighbours
  };
  // Lasers that start at one height, by elevation: within a bank the beams above and below a point are
  // neighbours.
  struct Bank {
    float height_m;
    std::vector<int> lasers;
    std::vector<float> slopes;  // tangents of their elevations
    std::vector<int> at_least;  // for equal steps of the slope: how many lasers surely lie below
    float steps_per_slope;
    /// How many of the lasers point below `slope`.
    [[nodiscard]] int below(float slope) const;
  };
  // A laser's firing nearest to a point.
  struct Sighting {
    int laser = -1;
    int column = 0;
    float range_m = 0;   // of the point's foot on the beam
    float height_m = 0;  // of the point above the beam
    [[nodiscard]] bool found() const { return laser >= 0; }
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

  void make_poses(const Eigen::Vector3d& origin_0);
  void make_beams();
  void make_banks();
  [[nodiscard]] bool find_column(const Eigen::Vector3f& q, float& column, Eigen::Vector3f& q_h) const;
  [[nodiscard]] Eigen::Vector3f in_laser(const Eigen::Vector3f& q, const Beam& beam, int column) const;
  [[nodiscard]] Sighting sight(const Eigen::Vector3f& q, int laser, float column, float columns_per_m) const;
  [[nodiscard]] Bracket bracket(const Eigen::Vector3f& q, float column, const Eigen::Vector3f& q_h) const;
  [[nodiscard]] float reach_m(const Bracket& bracket) const;
  void look_around(const Sighting& s, bool is_nearest, Window& window) const;

  const RayImage& image_;
  VotingParameters parameters_;
  float columns_per_rad_;
  std::vector<Pose> poses_;  // of each column
  std::vector<Beam> beams_;
  std::vector<Bank> banks_;
};

}  // namespace mapless
