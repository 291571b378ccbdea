#include <cmath>
#include <numbers>

#include "support/toy_scene.hpp"

namespace mapless::test {
namespace {

using Eigen::Vector3d;

constexpr double kGround = -1.73;  // below the sensor on a car's roof [m]
constexpr double kDegree_rad = std::numbers::pi / 180;

class StreetBuilder {
 public:
  void still(const ToyBody& body) { world_.push_back(body); }
  void moving(ToyBody body, const Vector3d& velocity, double yaw_rate = 0) {
    body.velocity_0 = velocity;
    body.yaw_rate = yaw_rate;
    body.object = ++objects_;
    world_.push_back(body);
  }
  [[nodiscard]] ToyWorld world() const { return world_; }

 private:
  ToyWorld world_;
  std::uint16_t objects_ = 0;
};

ToyBody car(double x, double y, double heading_rad) {
  return toy_box({x, y, kGround + 0.85}, {2.2, 0.9, 0.75}, heading_rad);
}
ToyBody person(double x, double y) { return toy_cylinder({x, y, kGround + 0.88}, 0.28, 0.875); }

void add_houses(StreetBuilder& street) {
  street.still(toy_box({-15, 12, 2}, {40, 2, 4}));
  street.still(toy_box({-15, -12, 2.5}, {40, 2, 5}));
  street.still(toy_box({70, 13, 3}, {30, 2, 5}));
  street.still(toy_box({70, -12, 2}, {30, 2, 4}));
  street.still(toy_box({23, 50, 2}, {2, 36, 5}));
  street.still(toy_box({42, 50, 2}, {2, 35, 4}));
}

void add_street_furniture(StreetBuilder& street) {
  for (const double x : {-14.0, -7.5, 4.0, 10.5, 17.0}) street.still(car(x, -5.2, 0));
  street.still(car(9, 7.4, 3 * kDegree_rad));
  street.still(car(50, 7.4, 0));
  for (const double x : {-6.0, 14.0, 47.0}) street.still(toy_cylinder({x, -8, 0}, 0.2, 2.5));
  street.still(toy_sphere({14, -8, 3.2}, 1.4));
  street.still(toy_sphere({47, -8, 3.4}, 1.6));
}

void add_traffic(StreetBuilder& street) {
  street.moving(car(40, 3.2, 0), {-9, 0, 0});
  street.moving(car(95, 3.2, 0), {-8, 0, 0});
  street.moving(car(34, -30, kDegree_rad * 90), {0, 7, 0});
  street.moving(car(30.5, 62, kDegree_rad * 90), {0, -10, 0});
  street.moving(car(22, -1, 0), {8.5, 0, 0});
  street.moving(person(12, -7), {1.4, 0, 0});
  street.moving(person(26, 9), {-1.3, 0, 0});
  street.moving(person(27, -6), {0.1, 1.2, 0});
  street.moving(toy_box({31, -9, kGround + 0.9}, {0.9, 0.3, 0.85}), {0, 0, 0}, 60 * kDegree_rad);
}

/// 8 m/s straight on for 2.5 s, then a left turn at 30 degrees/s for 3 s, straight on again.
std::shared_ptr<const Trajectory> street_drive() {
  const double step_s = 0.01;
  std::vector<TimedPose> poses;
  SE3 T_v0;
  for (int i = 0; i <= 650; ++i) {
    const Time t = Time::from_seconds(step_s * i);
    poses.push_back({t, T_v0});
    const bool turning = i >= 250 && i < 550;
    Vector6d varpi;
    varpi << -8, 0, 0, 0, 0, turning ? -30 * kDegree_rad : 0;
    T_v0 = SE3::exp(step_s * varpi) * T_v0;
  }
  // Some lasers fire a little before their column's instant.
  return std::make_shared<SampledTrajectory>(std::move(poses), Duration::from_seconds(step_s), "toy street");
}

}  // namespace

ToyScene toy_street(std::string_view sensor) {
  StreetBuilder street;
  street.still(toy_ground(kGround));
  add_houses(street);
  add_street_furniture(street);
  add_traffic(street);
  ToyScene scene;
  scene.model = std::make_shared<const LidarModel>(named_model(sensor));
  scene.trajectory = street_drive();
  scene.world = street.world();
  scene.range_noise_m = 0.02;
  return scene;
}

ToyScene with_columns(ToyScene scene, int columns) {
  LidarModel model = *scene.model;
  model.columns = columns;
  scene.model = std::make_shared<const LidarModel>(std::move(model));
  return scene;
}

ToyScene toy_room(std::string_view sensor, std::shared_ptr<const Trajectory> trajectory) {
  ToyScene scene;
  scene.model = std::make_shared<const LidarModel>(named_model(sensor));
  scene.trajectory = std::move(trajectory);
  scene.range_noise_m = 0.02;
  const double half_length = 9, half_width = 6, half_height = 2.2, thickness = 0.2;
  for (const double side : {-1.0, 1.0}) {
    scene.world.push_back(toy_box({side * (half_length + thickness), 0, 0}, {thickness, 12, 5}));
    scene.world.push_back(toy_box({0, side * (half_width + thickness), 0}, {12, thickness, 5}));
    scene.world.push_back(toy_box({0, 0, side * (half_height + thickness)}, {12, 12, thickness}));
  }
  scene.world.push_back(toy_box({4, 2.5, -1.4}, {0.8, 0.5, 0.8}, 0.4));
  scene.world.push_back(toy_box({-5, -3, -1.2}, {0.4, 1.2, 1.0}, -0.7));
  scene.world.push_back(toy_cylinder({2.5, -4, 0}, 0.3, 3));
  scene.world.push_back(toy_sphere({-3, 4, -1.5}, 0.7));
  return scene;
}

}  // namespace mapless::test
