#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#if MAPLESS_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <fmt/format.h>

#include "core/argument_checks.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/simulation/scene.hpp>

namespace mapless::inline v1 {
namespace {

using Eigen::Vector3d;

// Poses of a part in one interval. A wheel at 14 m/s (44 rad/s) turns by 0.55 rad between two of them in a
// turn of 0.1 s; straight lines between its vertices then err by 4 % of its radius. The hit itself uses the
// exact pose.
constexpr unsigned kPoses = 9;
// Half the time over which the velocity of a surface is a difference quotient. In twice 0.2 ms a surface at 1
// m/s moves by 0.4 mm, far more than the rounding of positions of kilometres (1e-12 m).
constexpr Duration kHalfVelocityStep = Duration::from_nanoseconds(200'000);
constexpr double kMaxReach_m = 1e6;
// The exact hit replaces that of the search unless the plane of the triangle is seen edge-on, or the two
// differ by more than single precision and straight-line motion explain: then the triangle is another one.
// Chosen: about 4 % of a wheel's radius.
constexpr double kMinCosine = 1e-3;
constexpr double kMaxCorrection_m = 0.02;

constexpr int kMaxObjectId = 65535;  // a label holds 16 bits of it

void require_valid(const WorldDescription& world) {
  const auto refuse = [](const std::string& field, std::size_t value, const std::string& problem) {
    throw InputError({"world", field, std::to_string(value), problem, "correct the scene"});
  };
  for (std::size_t i = 0; i < world.shapes.size(); ++i) {
    const Mesh& mesh = world.shapes[i];
    if (mesh.materials.size() != mesh.triangles.size()) {
      refuse(fmt::format("materials of shape {}", i), mesh.materials.size(), "not one for each triangle");
    }
    for (const auto& t : mesh.triangles) {
      if (t.maxCoeff() >= mesh.vertices.size()) {
        refuse(fmt::format("triangle of shape {}", i), t.maxCoeff(), "no such vertex");
      }
    }
  }
  const auto require_shape = [&](std::size_t shape) {
    if (shape >= world.shapes.size()) refuse("shape", shape, "there is no such shape");
  };
  for (const StaticObject& s : world.statics) require_shape(s.shape);
  for (const Mover& m : world.movers) {
    for (const Mover::Part& p : m.parts) require_shape(p.shape);
    const auto refuse_mover = [&m](const std::string& field, const std::string& value,
                                   const std::string& problem) {
      throw InputError(
          {"world", fmt::format("{} of mover {}", field, m.object_id), value, problem, "correct the scene"});
    };
    if (!m.T_0b) refuse_mover("T_0b", "empty", "a mover needs a motion");
    if (m.object_id < 1 || m.object_id > kMaxObjectId)
      refuse_mover("object_id", std::to_string(m.object_id), fmt::format("not from 1 to {}", kMaxObjectId));
    if (!(m.radius_m > 0 && std::isfinite(m.radius_m)))
      refuse_mover("radius_m", fmt::format("{}", m.radius_m), "not a positive number of metres");
  }
}

std::array<float, 12> column_major(const SE3& T) {
  std::array<float, 12> out{};
  for (int c = 0; c < 4; ++c) {
    const Vector3d column = c < 3 ? Vector3d(T.rotation().col(c)) : T.translation();
    for (int r = 0; r < 3; ++r) out[static_cast<std::size_t>(3 * c + r)] = static_cast<float>(column[r]);
  }
  return out;
}

void set_pose(RTCGeometry instance, unsigned step, const SE3& T) {
  const std::array<float, 12> matrix = column_major(T);
  rtcSetGeometryTransform(instance, step, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, matrix.data());
}

// The rays of a query start near each other and point the same way: coherent.
void intersect(const int* valid, RTCScene scene, RTCRayHit8& query) {
#if MAPLESS_EMBREE_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect8(valid, scene, &query, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(valid, scene, &context, &query);
#endif
}

RTCScene shape_scene(RTCDevice device, const Mesh& mesh) {
  RTCScene scene = rtcNewScene(device);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                           3 * sizeof(float), mesh.vertices.size());
  void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                          3 * sizeof(std::uint32_t), mesh.triangles.size());
  std::copy_n(mesh.vertices.data(), mesh.vertices.size(), static_cast<Eigen::Vector3f*>(vertices));
  std::copy_n(mesh.triangles.data(), mesh.triangles.size(),
              static_cast<Eigen::Matrix<std::uint32_t, 3, 1>*>(indices));
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  return scene;
}

}  // namespace

std::string_view to_string(ObjectClass c) {
  constexpr std::array<std::string_view, 15> kNames = {
      "ground",     "building", "vegetation", "furniture", "car",  "van",   "truck", "bus",
      "motorcycle", "cyclist",  "person",     "dog",       "bird", "drone", "ball"};
  return kNames[static_cast<std::size_t>(c)];
}

/// The world as Embree holds it. Instance numbers: the static objects, then the parts of the movers in order.
class SimulatedWorld::Scenes {
 public:
  struct PartOfMover {
    std::size_t mover, part;
  };

  // Built by one thread: the structure, and which of two equally near triangles a ray hits, is always the
  // same.
  explicit Scenes(const WorldDescription& world) : device_(rtcNewDevice("threads=1")) {
    if (device_ == nullptr)
      throw InputError({"Embree", "", "", "cannot be started", "check its installation"});
    top_ = rtcNewScene(device_);
    rtcSetSceneFlags(top_, RTC_SCENE_FLAG_DYNAMIC);
    for (const Mesh& mesh : world.shapes) shapes_.push_back(shape_scene(device_, mesh));
    for (const StaticObject& s : world.statics) set_pose(add_instance(s.shape, 1), 0, s.T_0s);
    for (std::size_t m = 0; m < world.movers.size(); ++m) {
      for (std::size_t p = 0; p < world.movers[m].parts.size(); ++p) {
        add_instance(world.movers[m].parts[p].shape, kPoses);
        parts_.push_back({m, p});
      }
    }
    for (std::size_t i = 0; i < world.statics.size(); ++i) rtcCommitGeometry(instances_[i]);
  }
  ~Scenes() {
    for (RTCGeometry g : instances_) rtcReleaseGeometry(g);
    for (RTCScene s : shapes_) rtcReleaseScene(s);
    rtcReleaseScene(top_);
    rtcReleaseDevice(device_);
  }
  Scenes(const Scenes&) = delete;
  Scenes& operator=(const Scenes&) = delete;

  void prepare(const WorldDescription& world, Time begin, Time end, const Vector3d& centre, double reach) {
    begin_ = begin;
    end_ = end;
    span_s_ = (end - begin).seconds();
    const std::size_t first = world.statics.size();
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const Mover& mover = world.movers[parts_[i].mover];
      RTCGeometry instance = instances_[first + i];
      const auto near = [&](Time t) {
        return (mover.T_0b(t).translation() - centre).norm() < reach + mover.radius_m;
      };
      if (!near(begin) && !near(end)) {
        rtcDisableGeometry(instance);
        continue;
      }
      rtcEnableGeometry(instance);
      for (unsigned k = 0; k < kPoses; ++k) {
        const Time t = begin + Duration::from_seconds(span_s_ * k / (kPoses - 1));
        set_pose(instance, k, mover.T_0s(parts_[i].part, t));
      }
      rtcCommitGeometry(instance);
    }
    rtcCommitScene(top_);
  }

  [[nodiscard]] float ray_time(Time t) const {
    if (t < begin_ || t > end_) {
      throw ParameterError({"SimulatedWorld::cast", "time of a ray", fmt::format("{} ns", t.nanoseconds()),
                            fmt::format("outside the prepared interval, {} to {} ns", begin_.nanoseconds(),
                                        end_.nanoseconds()),
                            "prepare the world for the instants of all rays"});
    }
    const double fraction = span_s_ > 0 ? (t - begin_).seconds() / span_s_ : 0;
    return static_cast<float>(std::clamp(fraction, 0.0, 1.0));
  }
  [[nodiscard]] RTCScene top() const { return top_; }
  [[nodiscard]] PartOfMover part(std::size_t i) const { return parts_[i]; }

 private:
  RTCGeometry add_instance(std::size_t shape, unsigned poses) {
    RTCGeometry instance = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, shapes_[shape]);
    rtcSetGeometryTimeStepCount(instance, poses);
    for (unsigned k = 0; k < poses; ++k) set_pose(instance, k, SE3());
    rtcCommitGeometry(instance);
    rtcAttachGeometryByID(top_, instance, static_cast<unsigned>(instances_.size()));
    instances_.push_back(instance);
    return instance;
  }

  RTCDevice device_;
  RTCScene top_ = nullptr;
  std::vector<RTCScene> shapes_;
  std::vector<RTCGeometry> instances_;
  std::vector<PartOfMover> parts_;
  Time begin_, end_;
  double span_s_ = 0;
};

SimulatedWorld::SimulatedWorld(WorldDescription description) : description_(std::move(description)) {
  require_valid(description_);
  scenes_ = std::make_unique<Scenes>(description_);
}

SimulatedWorld::~SimulatedWorld() = default;

void SimulatedWorld::prepare(Time begin, Time end, const Vector3d& centre_0, double reach_m) {
  require_between("SimulatedWorld::prepare", "end - begin [s]", (end - begin).seconds(), 0,
                  Duration::kMaxSeconds);
  require_between("SimulatedWorld::prepare", "reach_m", reach_m, 0, kMaxReach_m);
  scenes_->prepare(description_, begin, end, centre_0, reach_m);
}

RayHit SimulatedWorld::exact_hit(const TimedRay& ray, double range_m, unsigned instance,
                                 unsigned triangle) const {
  const std::size_t statics = description_.statics.size();
  RayHit hit;
  hit.range_m = range_m;
  std::size_t shape = 0;
  SE3 T_0s;
  const Mover* mover = nullptr;
  std::size_t part = 0;
  if (instance < statics) {
    const StaticObject& object = description_.statics[instance];
    shape = object.shape;
    T_0s = object.T_0s;
    hit.object_class = object.object_class;
    hit.object_id = object.object_id;
  } else {
    const Scenes::PartOfMover which = scenes_->part(instance - statics);
    mover = &description_.movers[which.mover];
    part = which.part;
    shape = mover->parts[part].shape;
    T_0s = mover->T_0s(part, ray.time);
    hit.object_class = mover->object_class;
    hit.carries_sensor = mover->carries_sensor;
    hit.object_id = mover->object_id;
  }
  const Mesh& mesh = description_.shapes[shape];
  hit.material = mesh.materials[triangle];
  const auto corner = [&](int i) -> Vector3d {
    return mesh.vertices[mesh.triangles[triangle][i]].cast<double>();
  };
  const Vector3d a = T_0s * corner(0);
  const Vector3d n = (T_0s.rotation() * (corner(1) - corner(0)).cross(corner(2) - corner(0))).normalized();
  const double cosine = n.dot(ray.direction_0);
  hit.cos_incidence = std::abs(cosine);
  // Intersection with the plane of the triangle at the instant of the ray, in double precision.
  const double exact = n.dot(a - ray.origin_0) / cosine;
  if (hit.cos_incidence > kMinCosine && std::abs(exact - range_m) < kMaxCorrection_m) hit.range_m = exact;
  if (mover != nullptr) {
    const Vector3d p_s = T_0s.inverse() * (ray.origin_0 + hit.range_m * ray.direction_0);
    const Vector3d after = mover->T_0s(part, ray.time + kHalfVelocityStep) * p_s;
    const Vector3d before = mover->T_0s(part, ray.time - kHalfVelocityStep) * p_s;
    hit.velocity_0 = (after - before) / (2 * kHalfVelocityStep.seconds());
  }
  return hit;
}

void SimulatedWorld::cast(std::span<const TimedRay> rays, double max_range_m,
                          std::span<std::optional<RayHit>> hits) const {
  constexpr std::size_t kLanes = 8;  // of rtcIntersect8
  require_between("SimulatedWorld::cast", "hits.size()", static_cast<double>(hits.size()),
                  static_cast<double>(rays.size()), static_cast<double>(rays.size()));
  require_between("SimulatedWorld::cast", "max_range_m", max_range_m, std::numeric_limits<double>::min(),
                  kMaxReach_m);
  for (std::size_t first = 0; first < rays.size(); first += kLanes) {
    const std::size_t count = std::min(kLanes, rays.size() - first);
    alignas(32) RTCRayHit8 query{};
    alignas(32) std::array<int, kLanes> valid{};
    for (std::size_t k = 0; k < count; ++k) {
      const TimedRay& ray = rays[first + k];
      valid[k] = -1;
      query.ray.org_x[k] = static_cast<float>(ray.origin_0.x());
      query.ray.org_y[k] = static_cast<float>(ray.origin_0.y());
      query.ray.org_z[k] = static_cast<float>(ray.origin_0.z());
      query.ray.dir_x[k] = static_cast<float>(ray.direction_0.x());
      query.ray.dir_y[k] = static_cast<float>(ray.direction_0.y());
      query.ray.dir_z[k] = static_cast<float>(ray.direction_0.z());
      query.ray.tfar[k] = static_cast<float>(max_range_m);
      query.ray.time[k] = scenes_->ray_time(ray.time);
      query.ray.mask[k] = ~0u;
      query.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
      query.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    intersect(valid.data(), scenes_->top(), query);
    for (std::size_t k = 0; k < count; ++k) {
      hits[first + k].reset();
      if (query.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
      hits[first + k] =
          exact_hit(rays[first + k], query.ray.tfar[k], query.hit.instID[0][k], query.hit.primID[k]);
    }
  }
}

}  // namespace mapless
