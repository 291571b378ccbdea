#pragma once

/// @file
/// Room simulation: recordings with exact truth. In go the name of a scene, a seed and a lidar model; out
/// come scans with a label per point, poses, and a recording in one of the formats that io reads. It knows
/// nothing of odometry and detection. The same seed gives the same bytes, for any number of threads.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>
#include <mapless/lidar/lidar_model.hpp>
#include <mapless/lidar/lidar_scan.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// Material of a surface; determines its diffuse reflectivity and the chance of a faulty return.
enum class Material : std::uint8_t {
  asphalt,
  earth,
  concrete,
  brick,
  foliage,
  wood,
  metal,
  paint,
  dark_paint,
  glass,
  cloth
};

/// Diffuse reflectivity at a lidar's wavelength, 0 to 1.
[[nodiscard]] float reflectivity(Material material);

/// A triangle mesh; every triangle has one material and reflects on both sides. Coordinates in metres, in the
/// frame s of the shape. The functions that add to it throw ParameterError for an argument out of bounds.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Eigen::Matrix<std::uint32_t, 3, 1>> triangles;
  std::vector<Material> materials;  ///< of each triangle

  void add_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, Material m);
  /// A quadrilateral; its corners in order along its outline.
  void add_quad(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                const Eigen::Vector3d& d, Material m);
  /// A box with edges parallel to the axes.
  void add_box(const Eigen::Vector3d& lowest, const Eigen::Vector3d& highest, Material m);
  /// A frustum from `base` to `tip` whose cross-section is a regular polygon of `sides` >= 3, closed at both
  /// ends. Radii at least 0; base and tip differ.
  void add_frustum(const Eigen::Vector3d& base, double base_radius_m, const Eigen::Vector3d& tip,
                   double tip_radius_m, int sides, Material m);
  /// A convex polygon in the x-z plane (at least three points (x, z) in order), extruded from y =
  /// -half_width_m to +half_width_m.
  void add_extrusion(const std::vector<Eigen::Vector2d>& outline_xz, double half_width_m, Material m);
  /// An ellipsoid of `rings` x 2 `rings` facets, rings >= 2.
  void add_ellipsoid(const Eigen::Vector3d& centre, const Eigen::Vector3d& radii_m, int rings, Material m);
  /// Every triangle of `other`, transformed to the frame of this mesh.
  void append(const Mesh& other, const SE3& T_here_other);
};

enum class ObjectClass : std::uint8_t {
  ground,
  building,
  vegetation,
  furniture,
  car,
  van,
  truck,
  bus,
  motorcycle,
  cyclist,
  person,
  dog,
  bird,
  drone,
  ball
};
[[nodiscard]] std::string_view to_string(ObjectClass c);

/// A pose as a function of time. It must be a pure function: the same result for the same time, from any
/// thread.
using Motion = std::function<SE3(Time)>;

/// A shape that does not move. Frame s is that of the shape.
struct StaticObject {
  std::size_t shape = 0;
  SE3 T_0s;
  ObjectClass object_class = ObjectClass::building;
  int object_id = 0;  ///< number in the labels, at most 65535; 0: none (ground, buildings)
};

/// An object that can move, made of one or more rigid parts. Frame b is that of its body, s that of a part's
/// shape.
struct Mover {
  struct Part {
    std::size_t shape = 0;
    Motion T_bs;  ///< empty: identity
  };
  int object_id = 0;  ///< number in the labels, 1 to 65535
  ObjectClass object_class = ObjectClass::car;
  Motion T_0b;
  double radius_m = 3;  ///< of a sphere about the body's origin that contains all parts at all times
  /// The body that the sensor is mounted on: static in the true labels, and no mover in the tables.
  bool carries_sensor = false;
  std::vector<Part> parts;

  [[nodiscard]] SE3 T_0s(std::size_t part, Time t) const {
    return parts[part].T_bs ? T_0b(t) * parts[part].T_bs(t) : T_0b(t);
  }
};

/// Everything rays can hit. Frame 0: level, z up.
struct WorldDescription {
  std::vector<Mesh> shapes;
  std::vector<StaticObject> statics;
  std::vector<Mover> movers;
};

/// One ray at its own instant. Origin in metres, direction of unit length, both in frame 0.
struct TimedRay {
  Eigen::Vector3d origin_0;
  Eigen::Vector3d direction_0;
  Time time;
};

/// The first surface on a ray.
struct RayHit {
  double range_m = 0;
  Eigen::Vector3d velocity_0 =
      Eigen::Vector3d::Zero();  ///< of the surface at the hit point and instant [m/s]
  double cos_incidence = 1;     ///< cosine of the angle between ray and surface normal, 0 to 1
  int object_id = 0;
  bool carries_sensor = false;  ///< on the body that the sensor is mounted on
  ObjectClass object_class = ObjectClass::ground;
  Material material = Material::asphalt;
};

/// A world to cast rays into, with Embree. Every shape is an instance; the parts of movers are motion-blurred
/// instances over the prepared time interval, so that one acceleration structure serves the rays of every
/// instant in it.
class SimulatedWorld {
 public:
  /// Throws InputError for a shape number out of range, a triangle of an absent vertex, and a mover without
  /// motion, with an object_id not in [1, 65535] or a radius that is not positive.
  explicit SimulatedWorld(WorldDescription description);
  ~SimulatedWorld();
  SimulatedWorld(const SimulatedWorld&) = delete;
  SimulatedWorld& operator=(const SimulatedWorld&) = delete;

  /// Prepares the world for rays at instants in [begin, end] within the sphere of radius `reach_m` about
  /// `centre_0`; movers outside the sphere at both ends are left out. The search interpolates vertices
  /// linearly between nine poses of every part; the hit is then computed with the exact pose. Throws
  /// ParameterError for end < begin or a reach that is not in [0, 1e6] m. Not thread-safe.
  void prepare(Time begin, Time end, const Eigen::Vector3d& centre_0, double reach_m);

  /// First surface on each ray within `max_range_m`; hits[i] belongs to rays[i]. Throws ParameterError for
  /// spans of different length, a range not in (0, 1e6] m, and a time outside the prepared interval.
  /// Thread-safe after prepare().
  void cast(std::span<const TimedRay> rays, double max_range_m, std::span<std::optional<RayHit>> hits) const;

  [[nodiscard]] const WorldDescription& description() const { return description_; }

 private:
  class Scenes;
  [[nodiscard]] RayHit exact_hit(const TimedRay& ray, double range_m, unsigned instance,
                                 unsigned triangle) const;

  WorldDescription description_;
  std::unique_ptr<Scenes> scenes_;
};

/// Options of make_scene. The same seed with a longer duration gives the same motion, continued.
struct SceneOptions {
  std::uint64_t seed = 1;
  double duration_s = 10;  ///< from time 0; above 0 and at most kMaxSceneDuration_s
  /// Rotates the world frame by a random rotation (of the seed), so that its z axis is not vertical.
  bool arbitrary_world = true;
};
/// The paths of all movers are as long as this duration needs [s].
inline constexpr double kMaxSceneDuration_s = 600;

/// A place with everything that moves in it, and the poses of a sensor that moves through it.
struct Scene {
  std::string name;
  WorldDescription world;  ///< in the level frame 0: z up
  /// Of the sensor with respect to frame 0, at 200 Hz, from 0.1 s before time 0 to 0.1 s after the duration.
  std::vector<TimedPose> poses;
  SE3 T_w0;  ///< world frame w of the recording from the level frame 0

  /// The poses with respect to the world frame of the recording: T_vw.
  [[nodiscard]] std::vector<TimedPose> poses_in_world() const;
};

/// Builds the scene of this name (scene_names()). Throws ParameterError for an unknown name, listing the
/// names, and for a duration out of bounds.
[[nodiscard]] Scene make_scene(std::string_view name, const SceneOptions& options);
/// Names of all scenes, in a fixed order.
[[nodiscard]] const std::vector<std::string>& scene_names();

/// A surface that moves faster than this is dynamic in the true labels (paper, section V) [m/s].
inline constexpr double kDynamicSpeed_mps = 0.2;

struct SensorOptions {
  double range_noise_m = 0.02;  ///< standard deviation of the Gaussian range noise, 0 to 10
  bool faulty = true;           ///< dark, glass and grazed surfaces give no return at random
  std::uint64_t seed = 1;
};

/// One turn. Each vector has one entry per firing, ordered by laser, then column.
struct SimulatedScan {
  Time start;
  std::vector<LidarRecord> records;
  std::vector<std::uint32_t> labels;  ///< class and object id (io/labels.hpp); 0 without a return
  std::vector<float> intensities;     ///< 0 to 1
};

/// A lidar that moves along a trajectory through a world. Every ray starts at the pose of its laser at its
/// own firing time. Noise and faults depend on seed, scan, laser and column only.
class SimulatedSensor {
 public:
  /// `world` must outlive the sensor; scan() prepares it, so that two sensors of one world take turns. Throws
  /// ParameterError for a null model or trajectory and for options out of bounds, InputError for an invalid
  /// model (validate).
  SimulatedSensor(std::shared_ptr<const LidarModel> model, std::shared_ptr<const Trajectory> trajectory,
                  SimulatedWorld& world, SensorOptions options);

  /// Scan `number`, which starts at time number / rotation_rate_hz. Throws TrajectoryDomainError if the
  /// trajectory does not cover it.
  [[nodiscard]] SimulatedScan scan(int number);
  /// The same scan as the input of odometry and detection, without its truth.
  [[nodiscard]] std::shared_ptr<const LidarScan> lidar_scan(int number);
  /// `cast` of this sensor, as above.
  [[nodiscard]] std::shared_ptr<const LidarScan> lidar_scan(const SimulatedScan& cast) const;

 private:
  void cast_column(int number, int column, SimulatedScan& out) const;
  void finish_record(int number, int laser, int column, const Eigen::Matrix3d& C_vh,
                     const std::optional<RayHit>& hit, SimulatedScan& out) const;
  [[nodiscard]] double fault_probability(const RayHit& hit) const;
  [[nodiscard]] Time firing_time(Time start, int column, int laser) const;

  std::shared_ptr<const LidarModel> model_;
  std::shared_ptr<const Trajectory> trajectory_;
  SimulatedWorld& world_;
  SensorOptions options_;
  std::vector<Eigen::Vector3d> directions_h_;  // of each laser, in the hub
  Duration column_period_;
  Duration first_firing_, last_firing_;  // least and largest firing offset of the lasers
};

/// Writes a simulated recording in one of the formats of sequence_formats().
class SequenceWriter {
 public:
  virtual ~SequenceWriter() = default;
  /// Appends the next scan in order of time. Throws OutputError.
  virtual void add(const SimulatedScan& scan) = 0;
  /// Completes the recording: until then its readers refuse the folder. Throws OutputError.
  virtual void finish() = 0;
};

/// "native", "mdlidar" and "kitti". mdlidar stores the true pose at the start and the end of each frame, and
/// neither the reason of a missing return nor firing times within a column. KITTI clouds are
/// motion-compensated to the middle of their scan, as in the KITTI odometry dataset, with labels/ beside
/// velodyne/.
[[nodiscard]] const std::vector<std::string>& sequence_formats();

/// The model with the properties that the format can store: without firing offsets for mdlidar, and with
/// turns that begin at the rear for KITTI, whose readers recover the time of a point from its azimuth.
[[nodiscard]] LidarModel model_for_format(LidarModel model, std::string_view format);

/// Creates `folder` and a writer of this format into it. The writer adds objects.csv and, scan by scan,
/// object_states.csv (io/labels.hpp). Throws OutputError if the folder exists or cannot be created,
/// ParameterError for an unknown format or a null model, InputError for an invalid model (validate).
[[nodiscard]] std::unique_ptr<SequenceWriter> make_sequence_writer(std::string_view format,
                                                                   const std::filesystem::path& folder,
                                                                   std::shared_ptr<const LidarModel> model,
                                                                   const Scene& scene);

}  // namespace mapless
