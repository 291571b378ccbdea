#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>
#include <mapless/simulation/mesh.hpp>

namespace mapless::inline v1 {

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

/// A pose as a function of time; must be the same whenever it is asked, from any thread.
using Motion = std::function<SE3(Time)>;

/// A shape that stands still. Frame s is the shape's own.
struct StaticObject {
  std::size_t shape = 0;
  SE3 T_0s;
  ObjectClass object_class = ObjectClass::building;
  int object_id = 0;  ///< 0: none of its own
};

/// Something that can move, of one or more rigid parts. Frame b is its body, s the shape of a part.
struct Mover {
  struct Part {
    std::size_t shape = 0;
    Motion T_bs;  ///< empty: identity
  };
  int object_id = 0;  ///< above 0, at most 65535
  ObjectClass object_class = ObjectClass::car;
  Motion T_0b;
  double radius_m = 3;  ///< of a sphere about the body's origin that holds all parts
  std::vector<Part> parts;

  [[nodiscard]] SE3 T_0s(std::size_t part, Time t) const {
    return parts[part].T_bs ? T_0b(t) * parts[part].T_bs(t) : T_0b(t);
  }
};

struct WorldDescription {
  std::vector<Mesh> shapes;
  std::vector<StaticObject> statics;
  std::vector<Mover> movers;
};

/// One beam at its own instant; `direction_0` of unit length.
struct TimedRay {
  Eigen::Vector3d origin_0;
  Eigen::Vector3d direction_0;
  Time time;
};

struct RayHit {
  double range_m = 0;
  Eigen::Vector3d velocity_0 = Eigen::Vector3d::Zero();  ///< of the surface at that point and instant [m/s]
  double cos_incidence = 1;                              ///< of the angle between beam and normal, 0 to 1
  int object_id = 0;
  ObjectClass object_class = ObjectClass::ground;
  Material material = Material::asphalt;
};

/// A world to cast rays into (Embree). Everything is instanced: what moves as instances blurred over the
/// interval of time that is prepared, so that one structure answers rays of every instant in it.
class SimulatedWorld {
 public:
  /// Throws InputError for shape numbers out of range or triangles of absent vertices.
  explicit SimulatedWorld(WorldDescription description);
  ~SimulatedWorld();
  SimulatedWorld(const SimulatedWorld&) = delete;
  SimulatedWorld& operator=(const SimulatedWorld&) = delete;

  /// Readies the world for rays of [begin, end] that start within `reach_m` of `centre_0` or end there;
  /// movers that stay outside are left out. Nine poses of every part are taken; between them the search moves
  /// vertices on straight lines, and the hit is then computed exactly.
  void prepare(Time begin, Time end, const Eigen::Vector3d& centre_0, double reach_m);

  /// The first surface each ray meets within `max_range_m`; hits[i] is of rays[i]. Times must lie in the
  /// interval prepared. Thread-safe after prepare().
  void cast(std::span<const TimedRay> rays, double max_range_m, std::span<std::optional<RayHit>> hits) const;

  [[nodiscard]] const WorldDescription& description() const { return description_; }

 private:
  class Scenes;
  [[nodiscard]] RayHit exact_hit(const TimedRay& ray, double range_m, unsigned instance,
                                 unsigned triangle) const;

  WorldDescription description_;
  std::unique_ptr<Scenes> scenes_;
};

}  // namespace mapless
