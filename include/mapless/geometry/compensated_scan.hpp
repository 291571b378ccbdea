#pragma once

/// @file
/// Room geometry: points in space. In go a LidarScan and a Trajectory; out come points and rays in the world
/// frame with the motion of the sensor during the scan accounted for, normals, and nearest neighbours. Every
/// result is computed once per scan and not changed afterwards. VoxelMap alone gathers points of many scans.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/parameters.hpp>
#include <mapless/core/se3.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// A motion-compensated scan (paper, section III-A, step 1): every return in the world frame 0, and the pose
/// of the sensor at the instant of every column, from which the origin and direction of every ray follow.
struct CompensatedScan {
  std::shared_ptr<const LidarScan> scan;
  std::vector<TrajectoryState> column_states;  ///< at LidarScan::column_time, one per column
  std::vector<SE3> column_T_0v;                ///< world from sensor: the inverses of their T_v0
  std::vector<Eigen::Vector3d> points_0;       ///< one per return, in the order of scan->returns [m]

  /// Origin of the ray of `laser` at the instant of `column`, in the world frame [m].
  [[nodiscard]] Eigen::Vector3d ray_origin_0(int laser, int column) const;
  /// Unit direction of that ray in the world frame.
  [[nodiscard]] Eigen::Vector3d ray_direction_0(int laser, int column) const;
};

/// Transforms every return from the sensor frame at its own instant to frame 0 (paper Eq. 1). Throws
/// ParameterError for a null scan, InputError for a scan that is already motion-compensated (see
/// restore_measured_rays), TrajectoryDomainError if the trajectory does not cover the scan.
[[nodiscard]] CompensatedScan compensate(std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory);

/// The points of a scan relative to an origin near them, in the axes of frame 0. Single precision resolves
/// them to a fraction of a millimetre at any distance from the world's origin.
struct LocalPoints {
  Eigen::Vector3d origin_0;             ///< position of the sensor at the start of the scan [m]
  std::vector<Eigen::Vector3f> points;  ///< one per return: position in frame 0 minus origin_0 [m]
};

/// compensate() in single precision: a scan with empty points_0, and its points. Throws as compensate() does.
[[nodiscard]] std::pair<CompensatedScan, LocalPoints> compensate_locally(
    std::shared_ptr<const LidarScan> scan, const Trajectory& trajectory);

/// Undoes the motion compensation by another system: transforms every point from the sensor frame at
/// t_c = scan.compensated_to to the sensor frame at its own instant t, p_v(t) = T_v0(t) T_v0(t_c)^-1 p.
/// Returns a scan whose compensated_to is empty and whose cells are assigned anew. Throws InputError for a
/// scan that is not compensated, TrajectoryDomainError if the trajectory does not cover the scan and t_c.
[[nodiscard]] LidarScan restore_measured_rays(const LidarScan& scan, const Trajectory& trajectory);

class NearestNeighbours;

enum class NormalMethod { image_window, nearest_neighbours };
inline constexpr std::array<std::string_view, 2> kNormalMethodNames = {"image_window", "nearest_neighbours"};
constexpr std::span<const std::string_view> choice_names(NormalMethod) { return kNormalMethodNames; }

enum class ImageAlignment { raw, aligned };
inline constexpr std::array<std::string_view, 2> kImageAlignmentNames = {"raw", "aligned"};
constexpr std::span<const std::string_view> choice_names(ImageAlignment) { return kImageAlignmentNames; }

struct NormalParameters {
  NormalMethod method = NormalMethod::image_window;
  int window_rows = 3;
  int window_columns = 7;
  double gate_m = 0.10;
  double min_incidence_deg = 5.0;
  int neighbours = 10;
  int min_points = 5;
  double max_thickness_ratio = 0.25;
  double min_width_ratio = 0.05;

  static constexpr auto declarations() {
    using P = NormalParameters;
    return std::tuple{
        declare(&P::method, "method",
                "where a point's neighbours come from: a window of the aligned scan image, or the k nearest "
                "in space",
                "paper step 2; method.md 2"),
        declare_odd(&P::window_rows, "window_rows", "lasers", 1, 15, "height of the image window",
                    "method.md 2"),
        declare_odd(&P::window_columns, "window_columns", "columns", 1, 31,
                    "least width of the image window; it is widened to be as wide as it is high where "
                    "lasers are sparse",
                    "method.md 2"),
        declare(&P::gate_m, "gate_m", "m", 0.0, 10.0,
                "window points farther from the point than gate_m + range x angle between the two beams / "
                "sin(min_incidence_deg) do not count",
                "method.md 2"),
        declare(&P::min_incidence_deg, "min_incidence_deg", "deg", 0.1, 90.0,
                "the flattest incidence at which neighbouring beams are taken to hit one surface; see gate_m",
                "method.md 2"),
        declare(&P::neighbours, "neighbours", "points", 3, 100, "k of method nearest_neighbours",
                "paper step 2"),
        declare(&P::min_points, "min_points", "points", 3, 100,
                "with fewer points, itself included, a point has no normal", "paper step 2"),
        declare(&P::max_thickness_ratio, "max_thickness_ratio", "", 0.0, 1.0,
                "planar: smallest over middle standard deviation of the neighbours at most this",
                "method.md 2"),
        declare(&P::min_width_ratio, "min_width_ratio", "", 0.0, 1.0,
                "not line-like: middle over largest standard deviation of the neighbours at least this",
                "method.md 2"),
    };
  }
};

/// One normal per return, in the world frame, unit length, oriented towards the origin of the return's own
/// ray; zero where the point has none.
[[nodiscard]] std::vector<Eigen::Vector3f> estimate_normals(const CompensatedScan& scan,
                                                            const NearestNeighbours& neighbours,
                                                            const NormalParameters& parameters);

/// Where a point lies with respect to the rays of a scan (paper step 3). Every freespace check answers so.
enum class FreespaceVerdict : std::uint8_t {
  not_evaluated,
  inside,     ///< in freespace: the ray passes beyond the point
  border,     ///< on a surface: the ray ends at the point
  outside,    ///< hidden: the ray ends short of the point
  unobserved  ///< no ray passes near, or the nearest has no usable return
};

/// The kernel of every freespace check: a point at `range_m` along a ray that is known to have gone `ray_m`
/// (NaN: not known). `tolerance_m`: how far from the end of the ray the surface it hit may lie. All [m].
template <class Real>
[[nodiscard]] FreespaceVerdict compare_ranges(Real ray_m, Real range_m, Real tolerance_m) {
  if (std::isnan(ray_m)) return FreespaceVerdict::unobserved;
  if (ray_m < range_m - tolerance_m) return FreespaceVerdict::outside;
  return ray_m <= range_m + tolerance_m ? FreespaceVerdict::border : FreespaceVerdict::inside;
}

/// One whole number per point, or one float32, whose bits the values are.
struct CloudColumn {
  std::string_view name;
  std::vector<std::uint32_t> values;
  bool is_float = false;
};

/// A cloud for other programs, which cloud_file() writes: points with further columns of the same length.
struct ExportCloud {
  std::vector<Eigen::Vector3d> points;  ///< [m]
  std::vector<CloudColumn> columns;
};

/// A cloud of one point per voxel: the mean of the points in it.
class VoxelMap {
 public:
  /// `edge_m`: of a voxel [m], above 0. `max_voxels`: where it is given, the index of all voxels (8 bytes
  /// each) is allocated at once, so that add() never takes long; every voxel takes another 64 bytes.
  explicit VoxelMap(double edge_m, std::optional<std::size_t> max_voxels = std::nullopt);

  /// False where the point is left out: it is more than a million voxels from the first one along an axis, or
  /// in a new voxel after max_voxels.
  [[nodiscard]] bool add(const Eigen::Vector3d& point_0);

  [[nodiscard]] std::size_t size() const { return voxels_.size(); }
  /// In the order in which the voxels were first met, with the column `points`: how many each has.
  [[nodiscard]] ExportCloud cloud() const;

 private:
  struct Voxel {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();  ///< of the points, relative to origin_0_
    std::uint32_t points = 0;
  };

  double edge_m_;
  std::size_t max_voxels_;
  std::optional<Eigen::Vector3d> origin_0_;  ///< the first point
  std::unordered_map<std::uint64_t, std::size_t> index_;
  std::vector<Voxel> voxels_;
};

}  // namespace mapless
